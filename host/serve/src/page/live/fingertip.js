// The fingertip from above: four gauges that light up by what they feel.

import { h, s } from "../dom.js";

/** Places of the gauges, as `palpate sensor` has them: at the corners of a square. */
const PLACES = [[128, 62], [52, 62], [52, 138], [128, 138]];
/** A signal that lights nothing up fully, µε, and the part of the largest that is kept each second. */
const [LEAST, KEPT] = [50, 0.97];

/** The panel of a fingertip; its `show` is that of the picture. */
export function fingertip(root) {
  const picture = tip();
  root.append(h("section", { class: "panel tip-panel", "aria-label": "Fingertip" }, h("h2", {}, "Fingertip"), picture.root, tipLegend()));
  return picture;
}

/** What ring and disc mean. */
export const tipLegend = () => h("p", { class: "muted" }, h("span", { class: "key c1" }), "ring: FA, fast ", h("span", { class: "key c0" }), "disc: SA, slow; full is the largest of the last while");

/** The picture, in `root`; `show(value)` draws `value(part, gauge)`, µε, of the parts FA (1) and SA (2), and returns the strain, µε,
 *  that lights up fully. `full` is a greater one that other pictures beside it light up with. */
export function tip() {
  const gauges = PLACES.map(([x, y], gauge) => ({
    fast: s("circle", { cx: x, cy: y, r: 29, class: "tip-fast", "fill-opacity": 0 }),
    slow: s("circle", { cx: x, cy: y, r: 16, class: "tip-slow", "fill-opacity": 0 }),
    frame: [s("circle", { cx: x, cy: y, r: 29, class: "tip-line" }), s("circle", { cx: x, cy: y, r: 20, class: "tip-line" })],
    name: s("text", { x, y: y < 100 ? y - 34 : y + 44, class: "tip-name" }, String(gauge + 1)),
  }));
  const root = s("svg", { viewBox: "0 0 180 200", class: "tip", role: "img", "aria-label": "The fingertip from above with its four gauges: rings light up with FA, discs with SA" },
    s("path", { class: "tip-silicone", d: "M12 196V92C12 40 46 6 90 6s78 34 78 86v104z" }),
    gauges.flatMap(({ fast, slow, frame, name }) => [fast, s("circle", { cx: fast.getAttribute("cx"), cy: fast.getAttribute("cy"), r: 20, class: "tip-hole" }), slow, ...frame, name]));
  let largest = LEAST;
  let last = performance.now();
  const shown = new Map();

  /** A change that cannot be seen is not drawn. */
  function light(circle, part) {
    const opacity = Math.round(50 * Math.min(part, 1)) / 50;
    if (shown.get(circle) === opacity) return;
    shown.set(circle, opacity);
    circle.setAttribute("fill-opacity", opacity);
  }

  return {
    root,
    show(value, full = 0) {
      const now = performance.now();
      largest = Math.max(LEAST, largest * KEPT ** ((now - last) / 1_000));
      last = now;
      const sizes = gauges.map((_, gauge) => [1, 2].map((part) => Math.abs(value(part, gauge)) || 0));
      largest = Math.max(largest, ...sizes.flat());
      gauges.forEach(({ fast, slow }, gauge) => {
        light(fast, sizes[gauge][0] / Math.max(largest, full));
        light(slow, sizes[gauge][1] / Math.max(largest, full));
      });
      return largest;
    },
  };
}
