// Lines and bars on axes, drawn once: no zoom, no pointer.

import { h, s } from "../dom.js";

/** Usual size, px, and what axes take of it. */
const SIZE = [360, 230];
const [LEFT, RIGHT, TOP, BOTTOM] = [50, 18, 10, 40];

/** Even steps over a range: about so many, up to half as many more; whole ones where asked. */
function ticks(least, most, whole, steps) {
  const rough = (most - least || 1) / steps;
  const decade = 10 ** Math.floor(Math.log10(rough));
  const fine = [1, 2, 5, 10].map((of) => of * decade).find((of) => of >= rough);
  const step = whole ? Math.max(1, Math.round(fine)) : fine;
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.max(Math.floor(most / step) - first + 1, 0) }, (_, k) => (first + k) * step);
}

/** Least width of a figure that takes the room it has, px. */
const NARROWEST = 300;

/** A place that is as wide as its surroundings let it be, at most `widest` px, and drawn anew when that changes: `draw(width)`. Letters keep their size. */
export function fitted(widest, draw) {
  const place = h("div", {});
  let drawn = 0;
  new ResizeObserver(([{ contentRect }]) => {
    const width = Math.round(Math.min(Math.max(contentRect.width, NARROWEST), widest));
    if (width === drawn) return;
    drawn = width;
    place.replaceChildren(draw(width));
  }).observe(place);
  return place;
}

const plain = new Intl.NumberFormat("en", { maximumSignificantDigits: 4, useGrouping: false });
const decimal = (value) => plain.format(value).replace("-", "−");

/** A figure. `lines`: `[{kind, x, y, name}]`, null for none; `points`: `[{x, y, error}]`; `beside`: what the values are; `within`: `{x, y}`, pairs that the axes cover whatever is drawn; `size`: of the
 *  picture, px; what is `hidden` is told by what stands around it. */
export function chart({ label, x: under, lines = [], bars = [], points = [], beside, least, within = {}, written = decimal, whole = false, caption, size = SIZE, hidden = false }) {
  const [width, height] = size;
  const foot = under ? BOTTOM : BOTTOM - 18;
  const head = beside ? TOP + 18 : TOP;
  const known = (value) => value !== null && Number.isFinite(value);
  const xs = [...lines.flatMap((line) => (line.y.length ? line.x : [])), ...bars.flatMap((bar) => [bar.from, bar.to]), ...points.map((point) => point.x), ...(within.x ?? [])].filter(known);
  const ys = [...lines.flatMap((line) => line.y), ...bars.map((bar) => bar.share), ...points.flatMap(({ y, error }) => [y - error, y + error]), ...(within.y ?? [])].filter(known);
  const extent = (of) => of.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  const [left, right] = extent(xs);
  const [low, high] = extent(least === undefined ? ys : [...ys, least]);
  const room = 0.05 * (high - low || 1);
  const [bottom, top] = [least === low ? low : low - room, high + room];
  const x = (value) => LEFT + ((width - LEFT - RIGHT) * (value - left)) / (right - left || 1);
  const y = (value) => height - foot - ((height - head - foot) * (value - bottom)) / (top - bottom || 1);
  const at = (value) => value.toFixed(1);
  const path = (line) => {
    let pen = "M";
    return line.y.map((value, k) => {
      if (!known(value)) return (pen = "M") && "";
      const step = `${pen}${at(x(line.x[k]))} ${at(y(value))}`;
      pen = "L";
      return step;
    }).join("");
  };
  return h(
    "figure",
    { class: "lab-chart" },
    s(
      "svg",
      { viewBox: `0 0 ${width} ${height}`, role: hidden ? null : "img", "aria-hidden": hidden ? "true" : null, "aria-label": label },
      ticks(bottom, top, whole, height < SIZE[1] ? 2 : 4).flatMap((value) => [
        s("path", { class: "lab-grid", d: `M${LEFT} ${at(y(value))}H${width - RIGHT}` }),
        s("text", { x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, written(value)),
      ]),
      ticks(left, right, false, width < SIZE[0] ? 2 : 4).map((value) => s("text", { x: x(value), y: height - foot + 16, "text-anchor": "middle" }, decimal(value))),
      s("path", { class: "lab-chart-axis", d: `M${LEFT} ${height - foot}H${width - RIGHT}` }),
      bars.map((bar) => s("rect", { class: "lab-chart-bar", x: at(x(bar.from)), y: at(y(bar.share)), width: at(x(bar.to) - x(bar.from)), height: at(y(bottom) - y(bar.share)) })),
      lines.map((line) => s("path", { class: `lab-chart-line lab-chart-${line.kind}`, d: path(line) }, line.name ? s("title", {}, line.name) : null)),
      points.flatMap((point) => [
        s("path", { class: "lab-error", d: `M${at(x(point.x))} ${at(y(point.y - point.error))}V${at(y(point.y + point.error))}` }),
        s("circle", { class: "lab-point", cx: at(x(point.x)), cy: at(y(point.y)), r: 3 }),
      ]),
      beside ? s("text", { x: 6, y: TOP + 4 }, beside) : null,
      under ? s("text", { x: (LEFT + width - RIGHT) / 2, y: height - 6, "text-anchor": "middle" }, under) : null,
    ),
    h("figcaption", {}, caption),
  );
}
