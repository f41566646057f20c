// A link to what is folded, or to the name above it, opens it; on paper all is open.
(function () {
  "use strict";
  const folds = ".msc-sheets details, details.sd-dropdown, details.msc-fold";
  const sections = () => Array.from(document.querySelectorAll(folds));
  let folded = [];

  function open() {
    const target = document.getElementById(location.hash.slice(1));
    const below = target?.matches("dt") && target.nextElementSibling;
    const around = sections().filter((section) => section.contains(target));
    const own = below ? below.querySelector(":scope > details.msc-fold") : null;
    const found = own ? [...around, own] : around;
    found.forEach((section) => { section.open = true; });
    if (found.length) { target.scrollIntoView(); }
  }

  window.addEventListener("load", open);
  window.addEventListener("hashchange", open);
  window.addEventListener("beforeprint", () => {
    folded = sections().filter((section) => !section.open);
    folded.forEach((section) => { section.open = true; });
  });
  window.addEventListener("afterprint", () => {
    folded.forEach((section) => { section.open = false; });
  });
})();
