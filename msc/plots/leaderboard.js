// Sorts and filters what `Leaderboard` lists, without a kernel.
(function (root, data) {
  "use strict";
  const body = root.querySelector("tbody");
  const axis = root.querySelector(".msc-axis");
  const told = root.querySelector(".msc-told");
  const choices = Array.from(root.querySelectorAll("select"));
  const groups = Array.from(root.querySelectorAll("input[type=checkbox]"));
  const heads = Array.from(root.querySelectorAll("th button"));
  let sorted = { key: "mean", falls: false };

  function make(kind, text, name) {
    const found = document.createElement(kind);
    found.textContent = text;
    found.className = name || "";
    return found;
  }

  // The ends of a logarithmic axis that shows all rows, and round numbers on it.
  function measure(rows) {
    const logs = rows.flatMap((row) => row.sets.concat(row.mean))
      .filter((value) => value > 0).map(Math.log10);
    if (!logs.length) { return { low: 0, high: 1, ticks: [] }; }
    const [low, high] = [Math.min(...logs), Math.max(...logs)];
    const more = Math.max(0.06 * (high - low), 0.05);
    const ends = { low: low - more, high: high + more, ticks: [] };
    const stride = Math.ceil((high - low) / 4);
    const steps = high - low > 2 ? [1] : high - low > 0.7 ? [1, 3] : [1, 1.5, 2, 3, 5, 7];
    for (let power = Math.floor(ends.low / stride) * stride; power <= ends.high; power += stride) {
      ends.ticks.push(...steps.map((step) => Number((step * 10 ** power).toPrecision(2))));
    }
    ends.ticks = ends.ticks.filter((tick) => place(tick, ends) >= 0 && place(tick, ends) <= 100);
    return ends;
  }

  function place(value, ends) {
    return 100 * (Math.log10(value) - ends.low) / (ends.high - ends.low);
  }

  function put(found, value, ends) {
    found.style.left = place(value, ends) + "%";
    return found;
  }

  function bar(row, ends) {
    const found = make("div", "", "msc-bar");
    found.setAttribute("aria-hidden", "true"); // the next cell says it
    found.append(
      ...ends.ticks.map((tick) => put(make("s", ""), tick, ends)),
      ...row.sets.filter((one) => one > 0).map((one) => put(make("i", ""), one, ends)),
    );
    if (row.mean > 0) { found.append(put(make("b", ""), row.mean, ends)); }
    return found;
  }

  function cell(kind, text, more) {
    const found = make(kind, text);
    if (more) { found.append(make("small", more)); }
    return found;
  }

  function line(row, ends) {
    const found = make("tr", "", row.name === "charts" ? "msc-charts" : "");
    const [name, plot] = [cell("th", row.name, row.group), make("td", "")];
    name.scope = "row";
    if (row.mean !== null) { plot.append(bar(row, ends)); }
    found.append(name, plot, cell("td", row.told, row.range));
    found.append(cell("td", row.against, row.interval));
    return found;
  }

  // Whoever has no number comes last, whichever way the others go.
  function compare(one, other) {
    const [a, b] = [one[sorted.key], other[sorted.key]];
    if (a === null || b === null) { return (a === null) - (b === null); }
    const order = typeof a === "string" ? a.localeCompare(b, "en") : a - b;
    return sorted.falls ? -order : order;
  }

  function show() {
    const key = choices.map((choice) => choice.value).join("/");
    const wanted = new Set(groups.filter((one) => one.checked).map((one) => one.value));
    const all = data[key] || [];
    const rows = all.filter((row) => wanted.has(row.group)).sort(compare);
    const ends = measure(rows);
    body.replaceChildren(...rows.map((row) => line(row, ends)));
    axis.replaceChildren(...ends.ticks.map((tick) => {
      const text = tick < 0.001 ? tick.toExponential(0) : String(tick);
      return put(make("span", text), tick, ends);
    }));
    const lacking = rows.filter((row) => row.mean === null).length;
    const names = choices.map((choice) => choice.selectedOptions[0].textContent);
    told.textContent = `${names[0]}, ${names[1]}, ${names[2]} training tasks: ` +
      `${rows.length} of ${all.length} methods` +
      (lacking ? `, ${lacking} of them without a result.` : ".");
    heads.forEach((head) => {
      const order = sorted.falls ? "descending" : "ascending";
      head.parentElement.setAttribute("aria-sort", head.value === sorted.key ? order : "none");
    });
  }

  heads.forEach((head) => head.addEventListener("click", () => {
    const again = sorted.key === head.value;
    sorted = { key: head.value, falls: again && !sorted.falls };
    show();
  }));
  [...choices, ...groups].forEach((one) => one.addEventListener("change", show));
  root.classList.add("msc-live");
  show();
})
