"use strict";
// Without this script the page shows every table and the impact map's last state; nothing else is lost.

// A table as tab-separated text: what a cell shows, or its data-raw with every digit.
function tableText(table) {
  const word = cell => (cell.dataset.raw ?? cell.textContent).replace(/\s+/g, " ").trim() + "\t".repeat(cell.colSpan - 1);
  return [...table.rows].map(row => [...row.cells].map(word).join("\t")).join("\n") + "\n";
}

async function copyText(text) {
  if (navigator.clipboard && window.isSecureContext) {
    try { return await navigator.clipboard.writeText(text); } catch { /* forbidden: the old way */ }
  }
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  if (!done) throw new Error("copying is forbidden here");
}

for (const button of document.querySelectorAll("button.copy")) {
  button.hidden = false;
  button.addEventListener("click", () => {
    const tell = word => { button.textContent = word; setTimeout(() => { button.textContent = "copy"; }, 1500); };
    copyText(tableText(button.closest(".table").querySelector("table"))).then(() => tell("copied"), () => tell("not allowed"));
  });
}

// A click on a head sorts by its column: by number where both cells are numbers, else by text; empty cells last.
for (const head of document.querySelectorAll("th[aria-sort]")) {
  head.querySelector("button").addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending", body = head.closest("table").tBodies[0];
    const word = row => { const cell = row.cells[head.cellIndex]; return cell.dataset.raw ?? cell.textContent; };
    const order = (a, b) => {
      if (!a || !b) return !a - !b;
      const way = isNaN(a) || isNaN(b) ? a.localeCompare(b) : a - b;
      return up ? way : -way;
    };
    body.append(...[...body.rows].sort((a, b) => order(word(a), word(b))));
    for (const other of head.parentElement.cells) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
  });
}

// The impact map: dimples stand in order of time in the picture; data.shown[k] of them were struck by data.time_s[k].
for (const map of document.querySelectorAll(".dimples")) {
  const data = JSON.parse(map.querySelector("script").textContent), last = data.time_s.length - 1;
  const marks = map.querySelector("g.marks").children, slider = map.querySelector("input"), told = map.querySelector("output");
  let before = marks.length;
  const show = k => {
    const now = data.shown[k], earlier = k ? data.shown[k - 1] : 0;
    for (let i = Math.min(now, before); i < Math.max(now, before); i++) marks[i].style.display = i < now ? "" : "none";
    for (const mark of map.querySelectorAll(".now")) mark.classList.remove("now");
    if (k < last) for (let i = earlier; i < now; i++) marks[i].classList.add("now");
    before = now;
    const share = data.coverage ? `coverage ${(100 * data.coverage[k]).toFixed(1)} %, ` : "";
    told.textContent = `${data.time_s[k].toFixed(3)} s: ${share}${now} dimples`;
    slider.setAttribute("aria-valuetext", told.textContent);
  };
  slider.max = last;
  slider.value = last; // after max, which it is kept below
  for (const control of map.querySelectorAll("[hidden]")) control.hidden = false;
  slider.addEventListener("input", () => show(+slider.value));
  window.addEventListener("beforeprint", () => show(last));
  window.addEventListener("afterprint", () => show(+slider.value));
  show(last);
}
