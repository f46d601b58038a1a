// The residual against anything it could depend on: means in bins with their standard errors.

import { choice, h, percent } from "../dom.js";
import { chart, fitted } from "./chart.js";

/** Most width, and height, px. */
const [WIDEST, HEIGHT] = [640, 240];

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
    fitted(WIDEST, (width) => figure(one, told(one), comparison.unit, width)),
  );
}

function figure(of, told, unit, width) {
  const points = of.bins.map(([x, y, error]) => ({ x, y, error }));
  const most = Math.max(...points.map(({ y, error }) => Math.abs(y) + error)) || 1;
  return chart({
    label: `Mean residual against ${of.name}: explains ${percent(told.explained)}, p value ${told.p_value.toFixed(3)}`,
    x: of.unit ? `${of.name}, ${of.unit}` : of.name,
    beside: `mean residual, ${unit}`,
    points,
    within: { y: [-most, most] },
    size: [width, HEIGHT],
    caption: `Explains ${percent(told.explained)} (p = ${told.p_value.toFixed(3)}). Bars are standard errors.`,
  });
}
