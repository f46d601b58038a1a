// Rate, gain, filter and thresholds: as they are, and as they shall be.

import { h } from "../dom.js";
import { answer, field, panel } from "./parts.js";

const FILTER = [["c1", ""], ["v1", "1/s"], ["c2", ""], ["v2", "1/s"]];
const THRESHOLDS = [
  ["touch", "µε"], ["release", "µε"], ["peak-drop", "µε"], ["motion-step", "µε"], ["dead-band", "µε"],
  ["smoothing", "s"], ["dwell", "s"], ["recovery", "s"],
];
const GAINS = [1, 2, 4, 8, 16, 32, 64, 128];

export function settingsPanel(desk) {
  const { root, body, linked } = panel("Settings");
  const said = answer();
  const fields = new Map();
  const touch = (input) => (input.dataset.changed = "yes");
  const numeric = (name) => {
    const input = h("input", { type: "number", step: "any", required: true, oninput: () => touch(input) });
    fields.set(name, input);
    return input;
  };
  const gain = (name) => {
    const input = h("select", { onchange: () => touch(input) }, GAINS.map((value) => h("option", { value: String(value) }, String(value))));
    fields.set(name, input);
    return input;
  };
  const group = (words, ...children) => h("fieldset", { class: "device-group" }, h("legend", {}, words), h("div", { class: "device-fields" }, ...children));

  const form = h("form", { onsubmit: (event) => { event.preventDefault(); set(event.submitter?.value === "save"); } },
    group("Sampling", field("rate", "Hz", numeric("rate"))),
    group("Gain of the converter", ...[1, 2, 3, 4].map((gauge) => field(`gauge ${gauge}`, "", gain(`gain${gauge}`)))),
    group("Filter: relaxation function", ...FILTER.map(([name, unit]) => field(name, unit, numeric(name)))),
    group("Thresholds of the regions", ...THRESHOLDS.map(([name, unit]) => field(name, unit, numeric(name)))),
    h("div", { class: "tools" },
      h("button", { value: "set" }, "Set"), h("button", { value: "save", class: "device-main" }, "Set and save"),
      h("button", { type: "button", onclick: revert }, "As it is"),
      h("button", { type: "button", onclick: () => send({ defaults: true }, "As the device was made; not saved.") }, "As it was made")));
  body.append(
    h("p", { class: "muted" }, "The nearest possible rate is taken. The calibration follows the gain. What is only set is lost with the power."),
    form, said.root);

  const changed = (name) => fields.get(name).dataset.changed;
  const value = (name) => Number(fields.get(name).value);

  function asked() {
    const what = { thresholds: {} };
    if (changed("rate")) what.rate_hz = value("rate");
    if ([1, 2, 3, 4].some((k) => changed(`gain${k}`))) what.gain = [1, 2, 3, 4].map((k) => value(`gain${k}`));
    if (FILTER.some(([name]) => changed(name))) what.filter = FILTER.map(([name]) => value(name));
    for (const [name] of THRESHOLDS) if (changed(name)) what.thresholds[name] = value(name);
    return what;
  }

  async function set(save) {
    const what = asked();
    const isNothing = Object.keys(what).length === 1 && Object.keys(what.thresholds).length === 0;
    if (isNothing && !save) return said.say("Nothing was changed.");
    await send(save ? { ...what, save } : what, save ? "Set and saved." : "Set, until the power goes.");
  }

  async function send(what, words) {
    try {
      const { command, result } = await desk.wish({ set: what });
      said.say([words, result.note ? `Note: ${result.note}.` : ""].filter(Boolean).join(" "), command);
      revert();
      fill(result.settings);
    } catch (error) {
      said.fail(error.message);
    }
  }

  let last = null;
  function revert() {
    for (const input of fields.values()) delete input.dataset.changed;
    fill(last);
  }

  function fill(settings) {
    last = settings;
    if (!settings) return;
    const now = { rate: settings.rate_hz, ...settings.relaxation, ...settings.thresholds };
    settings.gauges.forEach((gauge, k) => (now[`gain${k + 1}`] = gauge.gain));
    for (const [name, input] of fields) {
      if (input.dataset.changed || document.activeElement === input || now[name] === undefined) continue;
      const text = String(Number(now[name].toPrecision(6)));
      if (input.value !== text) input.value = text;
    }
  }

  return {
    root,
    show(state) {
      linked(state.linked);
      fill(state.settings);
    },
  };
}
