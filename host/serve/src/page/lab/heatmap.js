// Where the model fails: trace by region. A click goes there; the keyboard walks over it with arrows.

import { h, number, percent } from "../dom.js";

const STEPS = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };

/** A table of shares of what is left, or of what is left itself where that is noise; `go(trace, region)` shows a cell's place. */
export function heatmap(comparison, regions, go) {
  const { unit, only_noise: onlyNoise } = comparison;
  const cells = new Map(comparison.where.map((cell) => [`${cell.trace}|${cell.phase}`, cell]));
  const most = Math.max(...comparison.where.map((cell) => cell.share_of_excess), 1e-9);
  const cell = (label, trace, region) => {
    const found = cells.get(`${label}|${region}`);
    if (!found) return h("td", {}, "–");
    const level = onlyNoise ? 0 : Math.round((10 * found.share_of_excess) / most);
    const rms = number(found.rms);
    const share = percent(found.share_of_excess);
    const told = onlyNoise ? `${label}, ${region}: noise of ${rms} ${unit} RMS` : `${label}, ${region}: ${share} of what is left, ${rms} ${unit} RMS`;
    return h(
      "td",
      { class: `lab-heat lab-heat-${level}` },
      h("button", { tabindex: "-1", title: told, "aria-label": `${told}. Go there.`, onclick: () => go(trace, region) }, onlyNoise ? rms : share),
    );
  };
  const row = (label, trace) =>
    h("tr", {}, h("th", { scope: "row", title: label }, label), regions.map((region) => cell(label, trace, region)), h("td", { class: "lab-number" }, number(comparison.trace_rms[trace])));
  const table = h(
    "table",
    { class: "lab-heatmap", role: "grid", onkeydown: (event) => walk(table, event), onfocusin: (event) => stopAt(table, event.target) },
    h("caption", {}, onlyNoise ? `Nothing is left beyond the noise: RMS of each part, ${unit}` : "Share of what is left beyond the noise"),
    h("thead", {}, h("tr", {}, h("th", {}, "trace"), regions.map((region) => h("th", { scope: "col" }, region)), h("th", { scope: "col" }, `RMS, ${unit}`))),
    h("tbody", {}, comparison.labels.map(row)),
  );
  stopAt(table, table.querySelector("button"));
  return table;
}

/** The one cell at which the keyboard stops. */
function stopAt(table, button) {
  for (const other of table.querySelectorAll("button")) other.tabIndex = other === button ? 0 : -1;
}

/** Goes to the next cell of that direction that has something to show. */
function walk(table, event) {
  const step = STEPS[event.key];
  const at = event.target.closest("td");
  if (!step || !at) return;
  event.preventDefault();
  event.stopPropagation();
  let [row, column] = [at.parentElement.rowIndex, at.cellIndex];
  do {
    row += step[0];
    column += step[1];
    const button = table.rows[row]?.cells[column]?.querySelector("button");
    if (button) return button.focus();
  } while (table.rows[row]?.cells[column]);
}
