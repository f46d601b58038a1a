// One trace looked at more closely: force over displacement, and what its residual is like beside the noise.

import { h, s } from "../dom.js";

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [360, 230, 50, 18, 10, 40];

/** Four charts of what `/lab/closer` gives. */
export function closer({ loop, residual }, { unit, signal }) {
  const charts = [force(loop, signal, unit)];
  if (residual) charts.push(correlation(residual), spectrum(residual, unit), distribution(residual, unit));
  return h("div", { class: "lab-charts" }, charts);
}

function force(loop, signal, unit) {
  if (!loop.length) return h("p", { class: "lab-note" }, "Without a displacement there is no loop.");
  const lines = (name) => loop.map((of) => ({ kind: name === "measured" ? "measured" : "model", x: of.displacement, y: of[name] }));
  return chart({
    label: `${signal} over displacement, measured and model`,
    x: "displacement, mm",
    lines: [...lines("measured"), ...lines("predicted")],
    caption: `${signal}, ${unit}, over displacement: measured, and the model in colour.`,
  });
}

function correlation(of) {
  return chart({
    label: "Correlation of the residual with itself, later",
    x: "later by, s",
    least: Math.min(0, ...of.correlation),
    lines: [{ kind: "residual", x: of.lag_s, y: of.correlation }, noise(of.lag_s, of.noise_correlation)],
    caption: "Autocorrelation of what is left: the longer it lasts, the slower is what is missing.",
  });
}

function spectrum(of, unit) {
  const decades = (values) => values?.map((value) => (value > 0 ? Math.log10(value) : null));
  return chart({
    label: "Power of the residual over frequency",
    x: "frequency, Hz",
    lines: [{ kind: "residual", x: of.frequency_hz, y: decades(of.density) }, noise(of.frequency_hz, decades(of.noise_density))],
    written: (value) => `10${raised(value)}`,
    whole: true,
    caption: `Spectrum of what is left, ${unit}²/Hz: a peak is hum or a resonance, a rise to the left something slow.`,
  });
}

function distribution(of, unit) {
  const bars = of.shares.map((share, k) => ({ from: of.edges[k], to: of.edges[k + 1], share }));
  return chart({
    label: "Distribution of the residual",
    x: `residual, ${unit}`,
    bars,
    least: 0,
    lines: [noise(of.noise_values, of.noise_shares)],
    caption: "How often each size is left: wider than the noise, or to one side, is a misfit.",
  });
}

const noise = (x, y) => ({ kind: "noise", x, y: y ?? [] });

/** Even steps over a range: three to six of them; whole ones where asked. */
function ticks(least, most, whole) {
  const rough = (most - least) / 4;
  const decade = 10 ** Math.floor(Math.log10(rough));
  const fine = [1, 2, 5, 10].map((of) => of * decade).find((of) => of >= rough);
  const step = whole ? Math.max(1, Math.round(fine)) : fine;
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.max(Math.floor(most / step) - first + 1, 0) }, (_, k) => (first + k) * step);
}

const raised = (value) => String(value).replace("-", "⁻").replace(/[0-9]/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);

const plain = new Intl.NumberFormat("en", { maximumSignificantDigits: 4, useGrouping: false });
const decimal = (value) => plain.format(value).replace("-", "−");

function chart({ label, x: under, lines, bars = [], least, written = decimal, whole = false, caption }) {
  const known = (value) => value !== null && Number.isFinite(value);
  const xs = [...lines.flatMap((line) => (line.y.length ? line.x : [])), ...bars.flatMap((bar) => [bar.from, bar.to])].filter(known);
  const ys = [...lines.flatMap((line) => line.y), ...bars.map((bar) => bar.share)].filter(known);
  const extent = (of) => of.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
  const [left, right] = extent(xs);
  const [low, high] = extent(least === undefined ? ys : [...ys, least]);
  const room = 0.05 * (high - low || 1);
  const [bottom, top] = [least === low ? low : low - room, high + room];
  const x = (value) => LEFT + ((WIDTH - LEFT - RIGHT) * (value - left)) / (right - left || 1);
  const y = (value) => HEIGHT - BOTTOM - ((HEIGHT - TOP - BOTTOM) * (value - bottom)) / (top - bottom || 1);
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
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label },
      ticks(bottom, top, whole).flatMap((value) => [
        s("path", { class: "lab-grid", d: `M${LEFT} ${at(y(value))}H${WIDTH - RIGHT}` }),
        s("text", { x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, written(value)),
      ]),
      ticks(left, right).map((value) => s("text", { x: x(value), y: HEIGHT - BOTTOM + 16, "text-anchor": "middle" }, decimal(value))),
      s("path", { class: "lab-chart-axis", d: `M${LEFT} ${HEIGHT - BOTTOM}H${WIDTH - RIGHT}` }),
      bars.map((bar) => s("rect", { class: "lab-chart-bar", x: at(x(bar.from)), y: at(y(bar.share)), width: at(x(bar.to) - x(bar.from)), height: at(y(bottom) - y(bar.share)) })),
      lines.map((line) => s("path", { class: `lab-chart-line lab-chart-${line.kind}`, d: path(line) })),
      s("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 6, "text-anchor": "middle" }, under),
    ),
    h("figcaption", {}, caption),
  );
}
