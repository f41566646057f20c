// On a phone a wide picture scrolls in a box of its own, which the keyboard reaches too.
(function () {
  "use strict";
  const narrow = matchMedia("screen and (max-width: 600px)");
  const readable = 640; // CSS pixels: what text in a figure of full width needs

  function box(image) {
    const frame = document.createElement("div");
    frame.className = "msc-wide";
    frame.setAttribute("role", "group");
    frame.setAttribute("aria-label", "Wide figure, scrolls sideways");
    image.replaceWith(frame);
    frame.append(image);
    return frame;
  }

  window.addEventListener("load", () => {
    const images = Array.from(document.querySelectorAll(".cell_output img"));
    const frames = images.filter((image) => image.naturalWidth > readable).map(box);
    function reach() {
      frames.forEach((frame) => { frame.tabIndex = narrow.matches ? 0 : -1; });
    }
    narrow.addEventListener("change", reach);
    reach();
  });
})();
