// Plans what `PathInHand` is set to: Eqs. 5 to 8, and the joints that follow.
(function (root, data) {
  "use strict";
  const svg = root.querySelector("svg");
  const output = root.querySelector("output");
  const task = root.querySelector("input[name=task]");
  const weights = Array.from(root.querySelectorAll("input[name=weight]"));
  const nBasis = data.pushes.length;

  function hand(joints) {
    const places = [[0, 0]];
    let turn = 0;
    joints.forEach((joint, k) => {
      turn += joint;
      const [x, y] = places[k], length = data.links[k];
      places.push([x + length * Math.cos(turn), y + length * Math.sin(turn)]);
    });
    return places;
  }

  // One damped least-squares step towards a place: dq = Jᵀ (J Jᵀ + damping²)⁻¹ e.
  function follow(joints, place) {
    const places = hand(joints), end = places[3];
    const columns = [0, 1, 2].map((k) => [places[k][1] - end[1], end[0] - places[k][0]]);
    let xx = data.damping ** 2, xy = 0, yy = data.damping ** 2;
    columns.forEach(([x, y]) => { xx += x * x; xy += x * y; yy += y * y; });
    const off = [place[0] - end[0], place[1] - end[1]], size = xx * yy - xy * xy;
    const pull = [(yy * off[0] - xy * off[1]) / size, (xx * off[1] - xy * off[0]) / size];
    return joints.map((joint, k) => {
      const step = columns[k][0] * pull[0] + columns[k][1] * pull[1];
      return joint + Math.max(-data.limit, Math.min(data.limit, step));
    });
  }

  function plan(goal, policy) {
    const start = hand(data.home)[3];
    return data.pull.map((pull, t) => [0, 1].map((axis) => {
      let share = pull;
      for (let k = 0; k < nBasis; k += 1) {
        share += data.pushes[k][t] * policy[axis * nBasis + k];
      }
      return start[axis] + (goal[axis] - start[axis]) * share;
    }));
  }

  function line(points, kind) {
    const told = points.map((point) => point.map((x) => x.toFixed(4)).join(",")).join(" ");
    return `<polyline class="${kind}" points="${told}"/>`;
  }

  function disc(place, radius, kind) {
    return `<circle class="${kind}" cx="${place[0]}" cy="${place[1]}" r="${radius}"/>`;
  }

  function show() {
    const angle = (Number(task.value) + data.cut) * Math.PI / 180;
    const goal = [data.radius * Math.cos(angle), data.radius * Math.sin(angle)];
    const path = plan(goal, weights.map((one) => Number(one.value)));
    let joints = data.home, energy = 0;
    const poses = path.map((place, t) => {
      if (t) {
        const next = follow(joints, place);
        next.forEach((joint, k) => { energy += (joint - joints[k]) ** 2 / data.step; });
        joints = next;
      }
      return hand(joints);
    });
    const last = poses[poses.length - 1];
    const miss = 100 * Math.hypot(last[3][0] - goal[0], last[3][1] - goal[1]);
    svg.innerHTML = '<g transform="scale(1,-1)">' +
      disc([0, 0], data.radius, "msc-goals") + disc(goal, 0.035, "msc-goal") +
      [0, 20, 40].map((t) => line(poses[t], "msc-pose")).join("") +
      line(path, "msc-path") + line(last, "msc-last") + "</g>";
    task.nextElementSibling.textContent = `${task.value}°`;
    task.setAttribute("aria-valuetext", `${task.value} degrees`);
    weights.forEach((one) => { one.nextElementSibling.textContent = one.value; });
    output.textContent = `Planned to end ${miss.toFixed(1)} cm from the goal; ` +
      `energy ${energy.toFixed(1)} rad²/s.`;
  }

  function set(policy) {
    weights.forEach((one, k) => { one.value = policy[k]; });
    show();
  }

  root.addEventListener("input", show);
  root.querySelector("[name=searched]").addEventListener("click", () => set(data.policy));
  root.querySelector("[name=zero]").addEventListener("click", () => set(data.policy.map(() => 0)));
  root.classList.add("msc-live");
  show();
})
