// Rate, gain, filter and thresholds: as they are, and as they shall be.

import { answer } from "../command.js";
import { field, h } from "../dom.js";
import { inputs } from "../settings.js";
import { panel } from "./parts.js";

const GAUGES = [1, 2, 3, 4];
const GAINS = [1, 2, 4, 8, 16, 32, 64, 128];

export function settingsPanel(desk) {
  const { root, body, linked } = panel("Settings");
  const said = answer();
  const settings = inputs();
  const gain = (gauge) => settings.add(`gain${gauge}`, h("select", {}, GAINS.map((value) => h("option", { value: String(value) }, String(value)))));
  const group = (words, ...children) => h("fieldset", { class: "device-group" }, h("legend", {}, words), ...children);
  const fields = (...children) => h("div", { class: "fields" }, ...children);

  const form = h("form", { onsubmit: (event) => { event.preventDefault(); set(event.submitter?.value === "save"); } },
    group("Sampling", fields(field("rate", "Hz", settings.number("rate")))),
    group("Gain of the converter", fields(...GAUGES.map((gauge) => field(`gauge ${gauge}`, "", gain(gauge))))),
    group("Filter: relaxation function", settings.filter(),
      desk.hasLab ? h("button", { type: "button", class: "device-from-lab", onclick: fromLab }, "From the model in the Lab") : null),
    group("Thresholds of the regions", settings.thresholds()),
    h("div", { class: "tools" },
      h("button", { value: "set" }, "Set"), h("button", { value: "save", class: "device-main" }, "Set and save"),
      h("button", { type: "button", onclick: revert }, "As it is"),
      h("button", { type: "button", onclick: () => send({ defaults: true }, "As the device was made; not saved.") }, "As it was made")));
  body.append(
    h("p", { class: "muted" }, "The nearest possible rate is taken. The calibration follows the gain. What is only set is lost with the power."),
    form, said.root);

  async function fromLab() {
    try {
      for (const [name, value] of Object.entries(await desk.relaxation())) settings.type(name, value);
      said.say("The relaxation function of the model is filled in; Set gives it to the device.");
    } catch (error) {
      said.fail(error.message);
    }
  }

  async function set(save) {
    const what = settings.asked();
    const { changed, value } = settings;
    if (changed("rate")) what.rate_hz = value("rate");
    if (GAUGES.some((gauge) => changed(`gain${gauge}`))) what.gain = GAUGES.map((gauge) => value(`gain${gauge}`));
    const isNothing = Object.keys(what).length === 1 && Object.keys(what.thresholds).length === 0;
    if (isNothing && !save) return said.say("Nothing was changed.");
    await send(save ? { ...what, save } : what, save ? "Set and saved." : "Set, until the power goes.");
  }

  async function send(what, words) {
    try {
      const { command, result } = await desk.wish({ set: what });
      said.say([words, result.note ? `Note: ${result.note}.` : ""].filter(Boolean).join(" "), command);
      revert();
      show(result.settings);
    } catch (error) {
      said.fail(error.message);
    }
  }

  let last = null;
  function revert() {
    settings.revert();
    show(last);
  }

  function show(device) {
    last = device;
    if (!device) return;
    const gains = device.gauges.map((gauge, k) => [`gain${k + 1}`, gauge.gain]);
    settings.show({ rate: device.rate_hz, ...device.relaxation, ...device.thresholds, ...Object.fromEntries(gains) });
  }

  return {
    root,
    show(state) {
      linked(state.linked);
      show(state.settings);
    },
  };
}
