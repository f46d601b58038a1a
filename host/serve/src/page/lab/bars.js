// The ladder: error after each addition, down to the noise floor.

import { h, number, s } from "../dom.js";

const WIDTH = 440;
const ROW = 46;
const LEFT = 160;

/** The ladder of a model, on one scale with the noise. */
export function ladder(model, noise, unit) {
  const rungs = model.ladder;
  const most = Math.max(...rungs.flatMap((rung) => [rung.fitted_rms, rung.heldout_rms ?? 0]), noise ?? 0) || 1;
  const x = (value) => LEFT + ((WIDTH - LEFT - 62) * value) / most;
  const bar = (top, value, name) =>
    value === undefined || value === null
      ? []
      : [
          s("rect", { class: `lab-bar-${name}`, x: LEFT, y: top, width: Math.max(x(value) - LEFT, 1), height: 13 }),
          s("text", { x: x(value) + 5, y: top + 11, class: "lab-bar-value" }, number(value)),
        ];
  const rung = (of, k) => [
    s("text", { x: LEFT - 8, y: k * ROW + 28, "text-anchor": "end", class: "lab-bar-name" }, shortened(k === 0 ? of.add : `+ ${of.add}`)),
    ...bar(k * ROW + 10, of.fitted_rms, "fitted"),
    ...bar(k * ROW + 25, of.heldout_rms, "heldout"),
  ];
  const height = rungs.length * ROW + 8;
  const floor = noise === null || noise === undefined ? [] : [s("path", { class: "lab-floor", d: `M${x(noise)} 4V${height}` })];
  const words = rungs.map((of) => `${of.add}: fitted ${number(of.fitted_rms)}, held out ${number(of.heldout_rms)} ${unit}`).join("; ");
  return h(
    "figure",
    { class: "lab-ladder" },
    s("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": `Ladder of errors. ${words}. Noise ${number(noise)} ${unit}.` }, rungs.flatMap(rung), floor),
    h(
      "figcaption",
      {},
      h("span", { class: "lab-key lab-key-fitted" }, "fitted"),
      h("span", { class: "lab-key lab-key-heldout" }, "held out"),
      floor.length ? h("span", { class: "lab-key lab-key-floor" }, `noise ${number(noise)} ${unit}`) : null,
    ),
  );
}

const shortened = (name) => (name.length > 24 ? `${name.slice(0, 23)}…` : name);
