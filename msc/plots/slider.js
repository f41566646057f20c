// Draws what `Slider` describes: panels whose moving parts follow a slider.
(function (root, data) {
  "use strict";
  const slider = root.querySelector("input[name=step]");
  const output = root.querySelector("output");
  const play = root.querySelector("button");
  const names = Array.from(root.querySelectorAll(".msc-legend i"));
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const views = Array.from(root.querySelectorAll("canvas")).map((canvas, k) => ({
    canvas: canvas, panel: data.panels[k], pen: canvas.getContext("2d"),
  }));
  const lastTime = Math.max(1, data.n_times) - 1;
  let time = lastTime;
  let started = null;

  function decode(flat, panel) {
    const points = [];
    for (let k = 0; k < flat.length; k += 2) {
      points.push([flat[k] / panel.scale, flat[k + 1] / panel.scale]);
    }
    return points;
  }

  function luminance(rgb) {
    const [r, g, b] = rgb.map((part) => {
      const share = part / 255;
      return share <= 0.04045 ? share / 12.92 : Math.pow((share + 0.055) / 1.055, 2.4);
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  }

  // On a dark page colours that would drown in it are mixed with white.
  function shade(colour) {
    const ink = getComputedStyle(root).color;
    if (colour === "ink") { return ink; }
    const hex = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(colour);
    if (!hex || luminance(ink.match(/[\d.]+/g).slice(0, 3).map(Number)) < 0.4) {
      return colour;
    }
    let rgb = hex.slice(1).map((part) => parseInt(part, 16));
    while (luminance(rgb) < 0.2) {
      rgb = rgb.map((part) => Math.round(part + (255 - part) / 10));
    }
    return "rgb(" + rgb.join(",") + ")";
  }

  function frame(view) {
    const panel = view.panel;
    const ratio = window.devicePixelRatio || 1;
    const width = view.canvas.clientWidth;
    const height = Math.round(width * panel.aspect);
    if (view.canvas.width !== Math.round(width * ratio)) {
      view.canvas.width = Math.round(width * ratio);
      view.canvas.height = Math.round(height * ratio);
      view.canvas.style.height = height + "px";
    }
    view.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    view.pen.clearRect(0, 0, width, height);
    const axes = Boolean(panel.x_label);
    const box = axes ? [48, 8, width - 14, height - 34] : [4, 4, width - 4, height - 4];
    const [x0, x1] = panel.x, [y0, y1] = panel.y;
    view.at = (point) => [
      box[0] + ((point[0] - x0) / (x1 - x0)) * (box[2] - box[0]),
      box[3] - ((point[1] - y0) / (y1 - y0)) * (box[3] - box[1]),
    ];
    view.unit = (box[2] - box[0]) / (x1 - x0);
    view.box = box;
    if (axes) { drawAxes(view, box); }
  }

  function drawAxes(view, box) {
    const pen = view.pen, panel = view.panel;
    pen.globalAlpha = 1;
    pen.strokeStyle = pen.fillStyle = getComputedStyle(root).color;
    pen.lineWidth = 1;
    pen.setLineDash([]);
    pen.beginPath();
    pen.moveTo(box[0], box[1]);
    pen.lineTo(box[0], box[3]);
    pen.lineTo(box[2], box[3]);
    pen.stroke();
    pen.font = "12px sans-serif";
    pen.textAlign = "center";
    panel.x_ticks.forEach((x) => {
      pen.fillText(String(x), view.at([x, panel.y[0]])[0], box[3] + 14);
    });
    pen.fillText(panel.x_label, (box[0] + box[2]) / 2, box[3] + 29);
    pen.textAlign = "right";
    panel.y_ticks.forEach((y, k) => {
      pen.fillText(panel.y_names[k], box[0] - 4, view.at([panel.x[0], y])[1] + 4);
    });
    pen.save();
    pen.translate(11, (box[1] + box[3]) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(panel.y_label, 0, 0);
    pen.restore();
  }

  function draw(view, mark, flat) {
    const pen = view.pen;
    const points = decode(flat, view.panel).map(view.at);
    pen.strokeStyle = pen.fillStyle = shade(mark.colour);
    pen.globalAlpha = mark.opacity;
    pen.lineWidth = mark.width;
    pen.lineCap = pen.lineJoin = "round";
    pen.setLineDash(mark.dash);
    if (mark.kind === "disc" || mark.kind === "ring") {
      points.forEach((point) => {
        pen.beginPath();
        pen.arc(point[0], point[1], mark.radius * view.unit, 0, 7);
        if (mark.kind === "disc") { pen.fill(); } else { pen.stroke(); }
      });
    } else if (mark.kind === "dots") {
      points.forEach((point) => {
        pen.beginPath();
        pen.arc(point[0], point[1], mark.width, 0, 7);
        pen.fill();
      });
    } else if (mark.kind === "upright") {
      points.forEach((point) => {
        pen.beginPath();
        pen.moveTo(point[0], view.box[1]);
        pen.lineTo(point[0], view.box[3]);
        pen.stroke();
      });
    } else if (mark.kind === "segments") {
      for (let k = 0; k + 1 < points.length; k += 2) {
        pen.beginPath();
        pen.moveTo(points[k][0], points[k][1]);
        pen.lineTo(points[k + 1][0], points[k + 1][1]);
        pen.stroke();
      }
    } else {
      pen.beginPath();
      points.forEach((point, k) => {
        if (k) { pen.lineTo(point[0], point[1]); } else { pen.moveTo(point[0], point[1]); }
      });
      pen.stroke();
    }
  }

  function show() {
    const step = Number(slider.value);
    names.forEach((name) => { name.style.background = shade(name.dataset.colour); });
    views.filter((view) => view.canvas.clientWidth > 60).forEach((view) => {
      frame(view);
      view.panel.marks.forEach((mark) => {
        if (mark.varies === "never") {
          draw(view, mark, mark.points);
        } else if (mark.varies === "step") {
          draw(view, mark, mark.points[step]);
        } else {
          const now = Math.min(time, lastTime);
          if (mark.trail) {
            const ends = mark.points[step].slice(0, now + 1).map((pose) => pose.slice(-2));
            draw(view, Object.assign({}, mark, mark.trail), ends.flat());
          }
          draw(view, mark, mark.points[step][now]);
        }
      });
    });
    output.textContent = data.captions[step];
    slider.setAttribute("aria-valuetext", data.labels[step]);
  }

  function tick(now) {
    if (started === null) { return; }
    const share = Math.min(1, Math.max(0, (now - started) / 1000 / data.seconds));
    if (data.walks) {
      slider.value = Math.round(share * Number(slider.max));
    } else {
      time = Math.floor(share * lastTime);
    }
    show();
    if (share < 1) { requestAnimationFrame(tick); } else { started = null; }
  }

  function run() {
    if (still.matches) {
      if (data.walks) { slider.value = slider.max; }
      time = lastTime;
      show();
      return;
    }
    const running = started !== null;
    started = performance.now();
    if (!running) { requestAnimationFrame(tick); }
  }

  slider.addEventListener("input", () => { time = lastTime; started = null; show(); });
  if (play) { play.addEventListener("click", run); }
  new ResizeObserver(show).observe(root);
  new MutationObserver(show).observe(document.documentElement, {
    attributes: true, attributeFilter: ["data-theme"],
  });
  root.classList.add("msc-live");
  show();
})
