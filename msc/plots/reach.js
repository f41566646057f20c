// Has what `Reach` drew follow the hand: a goal on its circle, dragged or stepped by keys.
// Gives a function that puts another world into the picture.
(function (root, data) {
  "use strict";
  const [plane, board] = root.querySelectorAll(".msc-plane > svg, .msc-board");
  const goal = plane.querySelector(".msc-goal"), fixed = plane.querySelector("g > g");
  const said = root.querySelector("output");
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const nGoals = data.goals.length;
  const rows = Array.from(root.querySelectorAll("label")).reverse();
  const ways = data.names.map((name, k) => ({
    name: name,
    parts: plane.querySelectorAll(".msc-way")[k],
    aimed: board.querySelectorAll(".msc-way")[k],
    box: rows[k].querySelector("input"),
    told: rows[k].querySelector("b"),
  }));
  let view, nTimes, step;
  let started = null;

  function load(other) {
    data = other;
    view = new DataView(Uint8Array.from(atob(data.joints), (one) => one.charCodeAt(0)).buffer);
    nTimes = view.byteLength / (6 * ways.length * nGoals); // without the pose at home
    step = data.first;
    fixed.innerHTML = data.still;
    plane.setAttribute("aria-label", data.words);
    stop();
    play();
  }

  // The joint angles of a method's movement, and of one pose; 0 is home.
  function pose(k, time) {
    if (!time) { return data.home; }
    const at = 6 * ((k * nGoals + step) * nTimes + time - 1);
    return [0, 2, 4].map((byte) => view.getInt16(at + byte, true) * data.tick);
  }

  function between(k, time) {
    const before = pose(k, Math.floor(time)), after = pose(k, Math.ceil(time));
    return before.map((angle, j) => angle + (time % 1) * (after[j] - angle));
  }

  function place(angles) {
    let heading = 0, x = 0, y = 0;
    return [[0, 0]].concat(angles.map((angle, j) => {
      heading += angle;
      x += data.links[j] * Math.cos(heading);
      y -= data.links[j] * Math.sin(heading);
      return [x, y];
    }));
  }

  function line(points) {
    return "M" + points.map((one) => one.map((v) => v.toFixed(1)).join(" ")).join("L");
  }

  function put(part, x, y, scale) {
    part.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})${scale}`);
  }

  // As `aim` in _reach.py: the rings are powers of ten.
  function aim(x, y) {
    const distance = Math.max(Math.hypot(x, y), 1e-9);
    const radius = 10 * Math.min(Math.max(Math.log10(distance) + 2, 0), 3.5);
    return [radius * x / distance, radius * y / distance];
  }

  function show(time) {
    const [goalX, goalY] = [data.goals[step][0], -data.goals[step][1]];
    put(goal, goalX, goalY, "");
    ways.forEach((way, k) => {
      const off = !way.box.checked;
      [way.parts, way.aimed].forEach((part) => {
        if (off) { part.setAttribute("display", "none"); } else { part.removeAttribute("display"); }
      });
      const touched = data.touched[k][step] ? ", touched" : "";
      way.told.textContent = data.left[k][step].toFixed(2) + " cm" + touched;
      if (off) { return; }
      const arm = place(between(k, time)), end = place(pose(k, nTimes))[3];
      const trail = [];
      for (let t = 0; t < time; t += 0.5) { trail.push(place(between(k, t))[3]); }
      const [path, links, mark] = way.parts.children;
      path.setAttribute("d", line(trail.concat([arm[3]])));
      links.setAttribute("d", line(arm));
      put(mark, arm[3][0], arm[3][1], " scale(2.4)");
      put(way.aimed.firstChild, ...aim(end[0] - goalX, end[1] - goalY), " scale(2.4)");
    });
    const degrees = data.degrees[step];
    const shown = ways.filter((way) => way.box.checked).reverse();
    const ends = shown.map((way) => `${way.name} ${way.told.textContent}`).join(", ");
    const chart = data.charts ? `: chart ${data.charts[step]}` : "";
    said.textContent = `Goal at ${degrees}°${chart}`;
    goal.setAttribute("aria-valuenow", degrees);
    goal.setAttribute(
      "aria-valuetext", `${degrees} degrees${chart}. Left to the goal: ${ends || "nothing shown"}`
    );
  }

  function stop() { started = null; show(nTimes); }

  function go(to) {
    step = (to + nGoals) % nGoals;
    stop();
  }

  function tick(now) {
    if (started === null) { return; }
    const share = Math.min(1, Math.max(0, (now - started) / 1800));
    show(share * nTimes);
    if (share < 1) { requestAnimationFrame(tick); } else { stop(); }
  }

  function play() {
    if (still.matches) { stop(); return; }
    const running = started !== null;
    started = performance.now();
    if (!running) { requestAnimationFrame(tick); }
  }

  // The goal nearest to where a pointer is.
  function follow(event) {
    const inside = new DOMPoint(event.clientX, event.clientY).matrixTransform(
      plane.getScreenCTM().inverse()
    );
    const towards = data.goals.map(([x, y]) => {
      const turn = Math.atan2(y, x) - Math.atan2(-inside.y, inside.x);
      return Math.cos(turn);
    });
    go(towards.indexOf(Math.max(...towards)));
  }

  const KEYS = {
    ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10,
  };

  // A finger on the goal does not scroll the page; beside it, it does.
  goal.addEventListener("touchstart", (event) => event.preventDefault(), { passive: false });
  goal.addEventListener("pointerdown", (event) => {
    goal.focus({ preventScroll: true });
    goal.setPointerCapture(event.pointerId);
    follow(event);
  });
  goal.addEventListener("pointermove", (event) => {
    if (goal.hasPointerCapture(event.pointerId)) { follow(event); }
  });
  plane.addEventListener("click", follow);
  goal.addEventListener("keydown", (event) => {
    if (event.key in KEYS) {
      go(step + KEYS[event.key]);
    } else if (event.key === "Home" || event.key === "End") {
      go(event.key === "Home" ? 0 : nGoals - 1);
    } else {
      return;
    }
    event.preventDefault();
  });
  ways.forEach((way) => way.box.addEventListener("change", stop));
  root.querySelector("button").addEventListener("click", play);
  plane.setAttribute("role", "group");
  Object.entries({
    role: "slider", tabindex: "0", "aria-label": "Goal",
    "aria-valuemin": data.degrees[0], "aria-valuemax": data.degrees[nGoals - 1],
  }).forEach((one) => goal.setAttribute(...one));
  root.classList.add("msc-live");
  load(data);
  return load;
})
