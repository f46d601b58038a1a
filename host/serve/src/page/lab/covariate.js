// The residual against anything it could depend on: means in bins with their standard errors.

import { choice, h, number, percent, s } from "../dom.js";

const [WIDTH, HEIGHT, LEFT, BOTTOM, TOP] = [520, 210, 62, 38, 10];

/** The plot with the list of what to draw against; `symbol` is drawn, `onchoice` gets another. */
export function covariate(comparison, symbol, onchoice) {
  const drawn = comparison.drawn;
  if (!drawn.length) return h("p", {}, "Nothing that the residual could depend on changes in these traces.");
  const told = (of) => comparison.depends_on.find((other) => other.covariate === of.covariate);
  const name = (of) => `${of.name}, explains ${percent(told(of).explained)}`;
  const one = drawn.find((of) => of.covariate === symbol) ?? drawn[0];
  return h(
    "div",
    {},
    choice("Residual against", drawn.map((of) => [of.covariate, name(of)]), one.covariate, onchoice),
    figure(one, told(one), comparison.unit),
  );
}

function figure(of, told, unit) {
  const xs = of.bins.map((bin) => bin[0]);
  const [least, greatest] = [Math.min(...xs), Math.max(...xs)];
  const most = Math.max(...of.bins.map(([, mean, error]) => Math.abs(mean) + error)) || 1;
  const x = (value) => LEFT + ((WIDTH - LEFT - 14) * (value - least)) / (greatest - least || 1);
  const y = (value) => TOP + ((HEIGHT - TOP - BOTTOM) / 2) * (1 - value / most);
  const point = ([at, mean, error]) => [
    s("path", { class: "lab-error", d: `M${x(at)} ${y(mean - error)}V${y(mean + error)}` }),
    s("circle", { class: "lab-point", cx: x(at), cy: y(mean), r: 3 }),
  ];
  const tick = (value) => [
    s("path", { class: "lab-grid", d: `M${LEFT} ${y(value)}H${WIDTH - 14}` }),
    s("text", { x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, number(value, 2)),
  ];
  const foot = (value, anchor) => s("text", { x: x(value), y: HEIGHT - BOTTOM + 17, "text-anchor": anchor }, number(value));
  const words = `Mean residual against ${of.name}: explains ${percent(told.explained)}, p value ${told.p_value.toFixed(3)}`;
  return h(
    "figure",
    { class: "lab-covariate" },
    s(
      "svg",
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": words },
      [most, 0, -most].flatMap(tick),
      of.bins.flatMap(point),
      foot(least, "start"),
      foot(greatest, "end"),
      s("text", { x: (LEFT + WIDTH) / 2, y: HEIGHT - 5, "text-anchor": "middle" }, of.unit ? `${of.name}, ${of.unit}` : of.name),
    ),
    h("figcaption", {}, `Mean residual, ${unit}. Explains ${percent(told.explained)} (p = ${told.p_value.toFixed(3)}).`),
  );
}
