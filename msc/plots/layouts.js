// Has a choice among small worlds change the picture; the address tells it, and chooses.
(function (root, worlds, drag) {
  "use strict";
  const boxes = Array.from(root.querySelectorAll("input[type=radio]"));
  const told = root.querySelector(":scope > p span");
  const more = root.querySelector(":scope > p a");
  const load = drag(root.querySelector(".msc-reach"), worlds[0]);

  function choose(k) {
    const world = worlds[k];
    boxes[k].checked = true;
    told.textContent = `${world.name}: ${world.told}`;
    more.href = "#" + world.name;
    load(world);
  }

  function follow() {
    const name = location.hash.slice(1).replace(/^drag-/, "");
    const k = worlds.findIndex((world) => world.name === name);
    if (k >= 0) { choose(k); }
  }

  boxes.forEach((box, k) => box.addEventListener("change", () => {
    choose(k);
    history.replaceState(null, "", "#drag-" + worlds[k].name);
  }));
  window.addEventListener("hashchange", follow);
  follow();
  root.classList.add("msc-live");
})
