// A link to a folded section opens it; on paper all are open.
(function () {
  "use strict";
  const folds = ".msc-sheets details, details.sd-dropdown";
  const sections = () => Array.from(document.querySelectorAll(folds));
  let folded = [];

  function open() {
    const section = document.getElementById(location.hash.slice(1));
    if (section?.matches(folds)) {
      section.open = true;
      section.scrollIntoView();
    }
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
