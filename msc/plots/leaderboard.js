// Sorts and filters what `Leaderboard` lists, without a kernel.
(function (root, data) {
  "use strict";
  const body = root.querySelector("tbody");
  const choices = Array.from(root.querySelectorAll("select"));
  const groups = Array.from(root.querySelectorAll("input[type=checkbox]"));
  const heads = Array.from(root.querySelectorAll("th button"));
  let sorted = { key: "mean", falls: false };

  function cell(text, kind) {
    const found = document.createElement(kind || "td");
    found.textContent = text;
    return found;
  }

  // Where a number lies on a logarithmic axis from the least to the largest, 0 to 100.
  function place(value, ends) {
    const share = (Math.log(value) - ends[0]) / (ends[1] - ends[0]);
    return 100 * Math.min(1, Math.max(0, share));
  }

  function bar(row, ends) {
    const found = document.createElement("td");
    const low = place(row.low, ends);
    found.innerHTML = '<div class="msc-bar"><i></i><b></b></div>';
    found.querySelector("i").style.left = low + "%";
    found.querySelector("i").style.width = place(row.high, ends) - low + "%";
    found.querySelector("b").style.left = place(row.mean, ends) + "%";
    return found;
  }

  function compare(one, other) {
    const [a, b] = [one[sorted.key], other[sorted.key]];
    if (a === null || b === null) { return (a === null) - (b === null); }
    const order = typeof a === "string" ? a.localeCompare(b) : a - b;
    return sorted.falls ? -order : order;
  }

  function show() {
    const key = choices.map((choice) => choice.value).join("/");
    const wanted = new Set(groups.filter((one) => one.checked).map((one) => one.value));
    const rows = (data[key] || []).filter((row) => wanted.has(row.group)).sort(compare);
    const known = rows.filter((row) => row.mean > 0);
    const ends = [
      Math.log(Math.min(...known.map((row) => row.mean))) - 0.7,
      Math.log(Math.max(...known.map((row) => row.mean))) + 0.7,
    ];
    body.replaceChildren(...rows.map((row) => {
      const line = document.createElement("tr");
      line.append(cell(row.name, "th"), cell(row.group));
      line.append(row.mean > 0 ? bar(row, ends) : cell(""));
      line.append(cell(row.told), cell(row.against));
      return line;
    }));
    heads.forEach((head) => {
      const here = head.value === sorted.key;
      const order = sorted.falls ? "descending" : "ascending";
      head.parentElement.setAttribute("aria-sort", here ? order : "none");
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
