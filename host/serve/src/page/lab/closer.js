// One trace looked at more closely: force over displacement, and what its residual is like beside the noise.

import { h, quantity, raised } from "../dom.js";
import { chart } from "./chart.js";

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
    caption: `${quantity(signal, unit)}, over displacement: measured, and the model in colour.`,
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
