// How a held press must go on by a model, what is left of it, and whether that is more than noise.

import { h, put } from "../dom.js";
import { plot } from "../plot.js";

const GAUGES = 4;
/** Gauges have no colours of their own on this page: these are told in the legend. */
const COLOURS = ["c0", "c1", "c2", "c3"];
/** Every so many points of the stream's columns one is drawn: the last of each bin. */
const EACH = 4;

/** The signal that a hold foretells at a time, µε. */
const at = ({ level, parts, from_s }, time) => parts.reduce((sum, [part, rate]) => sum + part * Math.exp(-rate * (time - from_s)), level);

/** The first place in sorted numbers that is not below a value. */
function place(x, value) {
  let [low, high] = [0, x.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** What is foretold of a gauge at the times `x`, null where nothing is. */
export function foretold(x, holds, gauge) {
  const values = new Array(x.length).fill(null);
  for (const hold of holds) {
    if (hold.gauge !== gauge) continue;
    // One that goes on was last told of some rows ago.
    const end = hold.goes_on ? x.length : place(x, hold.to_s + 1e-9);
    for (let point = place(x, hold.from_s); point < end; point++) values[point] = at(hold, x[point]);
  }
  return values;
}

/** A panel; `show(linked, bench)` tells what came, `draw(columns, holds, from, to)` what is seen. */
export function foretoldPanel(root) {
  const words = h("p", { class: "margin-words foretold-words", role: "status" }, "Waiting for the device.");
  const law = h("p", { class: "muted foretold-law" });
  const figure = h("div");
  const legend = h("p", { class: "muted foretold-legend" }, "gauge ", COLOURS.flatMap((colour, gauge) => [h("span", { class: `key ${colour}` }), `${gauge + 1} `]));
  root.append(h("section", { class: "panel foretold", "aria-label": "The model now" },
    h("h2", {}, "The model now"), words, law, figure, legend,
    h("details", {}, h("summary", {}, "What is predicted from what"), h("p", { class: "muted" },
      "A fingertip does not measure how the finger moves. While it stands in contact, in region CD, the model's relaxation alone says how each signal must go on from what was felt before it stood: the dashed line beside the signal. What is left of the signal is drawn here. A mean of it over 0.2 s that is six standard errors of the noise away from zero, twice in a row, is more than noise. Then the model's relaxation is not that of this silicone, or the finger did not stand: from the signal alone these two cannot be distinguished."))));
  let drawn = null;

  return {
    show(linked, bench) {
      const told = bench?.foretold;
      words.dataset.state = "";
      if (!linked || !told?.law) {
        put(words, linked ? "Waiting for the stream." : "The device is gone; waiting for it.");
        return;
      }
      put(words, told.words);
      if (told.gauges.includes("fails")) words.dataset.state = "slips";
      else if (told.gauges.includes("agrees")) words.dataset.state = "holds";
      const { file, formula, left_out } = told.law;
      const without = left_out.length ? `, without its ${left_out.join(", ")}` : "";
      put(law, `${file ? `${file}${without}` : "The device's filter"}: ${formula}`);
    },
    draw({ x, values }, holds, from, to) {
      const times = new Float64Array(Math.floor(x.length / EACH));
      for (let point = 0; point < times.length; point++) times[point] = x[EACH * point + EACH - 1];
      const left = Array.from({ length: GAUGES }, (_, gauge) => foretold(times, holds, gauge)
        .map((value, point) => (value === null ? null : values[gauge][EACH * point + EACH - 1] - value)));
      drawn ??= plot(figure, {
        x: times, label: "What the model leaves of each gauge's signal while a press is held, over time", axes: { x: "time, s", y: "residual, µε" },
        units: { unit: "µε", decimals: 2 }, height: 150, zero: true,
        series: left.map((of, gauge) => ({ label: `gauge ${gauge + 1}`, colour: COLOURS[gauge], width: 1, values: of })),
      });
      drawn.range(from, to);
      drawn.set({ x: times, values: left });
    },
    close: () => drawn?.close(),
  };
}
