// A residual as a picture beside a candidate.

import { s } from "../dom.js";

const WIDTH = 120;
const HEIGHT = 30;

/** The largest size in a picture: pairs of least and greatest value. */
export const reach = (picture) =>
  (picture ?? []).flat().reduce((most, value) => (value === null ? most : Math.max(most, Math.abs(value))), 0);

/** A picture on a scale that others share. */
export function sparkline(picture, most, label) {
  const y = (value) => (HEIGHT / 2) * (1 - value / (most || 1));
  const step = WIDTH / Math.max(picture.length, 1);
  const bars = picture
    .map(([a, b], k) => (a === null ? "" : `M${(k * step).toFixed(1)} ${y(Math.max(a, b)).toFixed(1)}V${(y(Math.min(a, b)) + 0.6).toFixed(1)}`))
    .join("");
  return s(
    "svg",
    { class: "lab-spark", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label },
    s("path", { class: "lab-spark-zero", d: `M0 ${HEIGHT / 2}H${WIDTH}` }),
    s("path", { class: "lab-spark-line", d: bars }),
  );
}
