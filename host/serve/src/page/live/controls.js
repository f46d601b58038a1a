// What one may ask of the device while looking: stream, tare, recording, filter and thresholds.

import { answer } from "../command.js";
import { h } from "../dom.js";
import { inputs } from "../settings.js";
import { stamp } from "./stamp.js";

export function controls(root, api) {
  const said = answer();
  const wish = async (what, words) => {
    try {
      const { command } = await api.post("/live/wish", what);
      said.say(words, command);
      return true;
    } catch (error) {
      said.fail(error.message);
      return false;
    }
  };
  const button = (words, onclick) => h("button", { type: "button", onclick }, words);
  const start = button("Start", () => wish("start", "Started."));
  const stop = button("Stop", () => wish("stop", "Stopped."));
  const tare = button("Tare", () => wish("tare", "Zero is read from here on."));
  const untare = button("Untare", () => wish("untare", "The tare is taken back."));

  const file = h("input", { type: "text", value: `touch-${stamp()}`, size: 21, spellcheck: "false" });
  const record = button("Record", () => wish({ record: { file: file.value } }, "Recording."));
  const end = button("End", async () => {
    if (await wish("end-recording", "The recording is written.")) file.value = `touch-${stamp()}`;
  });

  const settings = inputs();
  const form = h("form", { onsubmit: set }, settings.filter(), settings.thresholds(),
    h("div", { class: "tools" }, h("button", {}, "Set"), button("As it is", () => { settings.revert(); show(last); })));

  async function set(event) {
    event.preventDefault();
    const what = settings.asked();
    if (!what.filter && Object.keys(what.thresholds).length === 0) return said.say("Nothing was changed.");
    if (await wish({ set: what }, "Set.")) settings.revert();
  }

  root.append(h("section", { class: "panel", "aria-label": "Commands" },
    h("div", { class: "tools" }, start, stop, tare, untare),
    h("div", { class: "tools" }, h("label", {}, "File ", file), record, end),
    h("details", {}, h("summary", {}, "Filter and thresholds"), form), said.root));

  let last = null;
  function show(health) {
    last = health;
    if (!health) return;
    start.disabled = !health.linked || health.streaming;
    stop.disabled = tare.disabled = !health.linked || !health.streaming;
    untare.disabled = !health.linked;
    record.disabled = !health.linked || Boolean(health.recording);
    end.disabled = !health.recording;
    settings.show({ ...health.settings?.relaxation, ...health.settings?.thresholds });
  }
  return { show };
}
