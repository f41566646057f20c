// A term shows its sentence: under the pointer, in focus, at the first touch.
window.addEventListener("load", () => {
  "use strict";
  const terms = Array.from(document.querySelectorAll("a.msc-term[title]"));
  if (!terms.length) { return; }
  const tip = document.createElement("div");
  Object.assign(tip, { id: "msc-tip", className: "msc-tip", hidden: true });
  tip.setAttribute("role", "tooltip");
  document.body.append(tip);
  let shown = null, waiting = 0;

  function show(term, words) {
    hide();
    shown = term;
    tip.textContent = words;
    tip.hidden = false;
    term.setAttribute("aria-describedby", tip.id);
    const at = term.getBoundingClientRect(), width = tip.offsetWidth;
    const right = document.documentElement.clientWidth - width - 8;
    const left = Math.max(8, Math.min(at.left, right));
    const below = at.bottom + tip.offsetHeight + 8 < innerHeight;
    const top = below ? at.bottom + 4 : at.top - tip.offsetHeight - 4;
    tip.style.left = `${left + scrollX}px`;
    tip.style.top = `${top + scrollY}px`;
  }

  function hide() {
    clearTimeout(waiting);
    shown?.removeAttribute("aria-describedby");
    shown = null;
    tip.hidden = true;
  }

  // Not at once: the pointer may be on its way to the sentence.
  function leave() { waiting = setTimeout(hide, 200); }

  terms.forEach((term) => {
    const words = term.title;
    let first = false;
    term.removeAttribute("title");
    term.addEventListener("focus", () => show(term, words));
    term.addEventListener("blur", hide);
    term.addEventListener("mouseenter", () => show(term, words));
    term.addEventListener("mouseleave", leave);
    term.addEventListener("pointerdown", (event) => {
      first = event.pointerType === "touch" && shown !== term;
    });
    term.addEventListener("click", (event) => {
      if (!first) { return; }
      first = false;
      event.preventDefault();
      show(term, words);
    });
  });
  tip.addEventListener("mouseenter", () => clearTimeout(waiting));
  tip.addEventListener("mouseleave", leave);
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") { hide(); }
  });
  document.addEventListener("pointerdown", (event) => {
    if (!event.target.closest("a.msc-term, .msc-tip")) { hide(); }
  });
});
