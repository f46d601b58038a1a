// Where the model fails: trace by region. A click goes there.

import { h, number, percent } from "../dom.js";

/** A table of shares; `go(trace, region)` shows a cell's place. */
export function heatmap(comparison, regions, go) {
  const cells = new Map(comparison.where.map((cell) => [`${cell.trace}|${cell.phase}`, cell]));
  // Where nothing but noise is left, no share of it stands out.
  const most = Math.max(...comparison.where.map((cell) => cell.share_of_excess), comparison.only_noise ? 1 : 1e-9);
  const cell = (label, trace, region) => {
    const found = cells.get(`${label}|${region}`);
    if (!found) return h("td", {}, "–");
    const level = Math.round((10 * found.share_of_excess) / most);
    const told = `${label}, ${region}: ${percent(found.share_of_excess)} of what is left, ${number(found.rms)} ${comparison.unit} RMS`;
    return h(
      "td",
      { class: `lab-heat lab-heat-${level}` },
      h("button", { title: told, "aria-label": `${told}. Go there.`, onclick: () => go(trace, region) }, percent(found.share_of_excess)),
    );
  };
  const row = (label, trace) =>
    h("tr", {}, h("th", { scope: "row" }, label), regions.map((region) => cell(label, trace, region)), h("td", { class: "lab-number" }, number(comparison.trace_rms[trace])));
  return h(
    "table",
    { class: "lab-heatmap" },
    h("caption", {}, "Share of what is left beyond the noise"),
    h("thead", {}, h("tr", {}, h("th", {}, "trace"), regions.map((region) => h("th", { scope: "col" }, region)), h("th", { scope: "col" }, `RMS, ${comparison.unit}`))),
    h("tbody", {}, comparison.labels.map(row)),
  );
}
