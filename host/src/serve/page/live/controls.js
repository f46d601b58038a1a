// What one may ask of the device while looking: stream, tare, recording, filter and thresholds.

import { element } from "./health.js";

const THRESHOLDS = [
  ["touch", "µε"], ["release", "µε"], ["peak-drop", "µε"], ["motion-step", "µε"], ["dead-band", "µε"],
  ["smoothing", "s"], ["dwell", "s"], ["recovery", "s"],
];
const FILTER = [["c1", ""], ["v1", "1/s"], ["c2", ""], ["v2", "1/s"]];

export function controls(root, api) {
  const answer = element("p", { className: "answer", role: "status" });
  const wish = async (what, words) => {
    try {
      const { command } = await api.post("/live/wish", what);
      answer.replaceChildren(words, ...(command ? [" The same as ", element("code", { textContent: command })] : []));
      answer.classList.remove("bad");
      return true;
    } catch (error) {
      answer.textContent = error.message;
      answer.classList.add("bad");
      return false;
    }
  };
  const button = (textContent, onclick) => element("button", { type: "button", textContent, onclick });
  const start = button("Start", () => wish("start", "Started."));
  const stop = button("Stop", () => wish("stop", "Stopped."));
  const tare = button("Tare", () => wish("tare", "Zero is read from here on."));
  const untare = button("Untare", () => wish("untare", "The tare is taken back."));

  const file = element("input", { type: "text", id: "live-file", value: `touch-${stamp()}`, size: 18, spellcheck: false });
  const record = button("Record", () => wish({ record: { file: file.value } }, "Recording."));
  const end = button("End", async () => {
    if (await wish("end-recording", "The recording is written.")) file.value = `touch-${stamp()}`;
  });

  const fields = new Map();
  const field = (name, unit) => {
    const input = element("input", { type: "number", step: "any", id: `live-${name}`, required: true, oninput: () => (input.dataset.changed = "yes") });
    fields.set(name, input);
    return element("div", { className: "field" }, element("label", { for: input.id }, name, unit ? element("span", { className: "unit", textContent: ` ${unit}` }) : ""), input);
  };
  const form = element("form", {
    onsubmit: async (event) => {
      event.preventDefault();
      const changed = (name) => fields.get(name).dataset.changed;
      const number = (name) => Number(fields.get(name).value);
      const what = { thresholds: {} };
      if (FILTER.some(([name]) => changed(name))) what.filter = FILTER.map(([name]) => number(name));
      for (const [name] of THRESHOLDS) if (changed(name)) what.thresholds[name] = number(name);
      if (!what.filter && Object.keys(what.thresholds).length === 0) return;
      if (await wish({ set: what }, "Set.")) for (const input of fields.values()) delete input.dataset.changed;
    },
  },
    element("div", { className: "fields" }, ...FILTER.map(([name, unit]) => field(name, unit))),
    element("div", { className: "fields" }, ...THRESHOLDS.map(([name, unit]) => field(name, unit))),
    element("div", { className: "tools" }, element("button", { textContent: "Set" }),
      button("As it is", () => { for (const input of fields.values()) delete input.dataset.changed; show(last); })));

  root.append(element("section", { className: "panel", "aria-label": "Commands" },
    element("div", { className: "tools" }, start, stop, tare, untare),
    element("div", { className: "tools" }, element("label", { for: file.id, textContent: "File" }), file, record, end),
    element("details", {}, element("summary", { textContent: "Filter and thresholds" }), form), answer));

  let last = null;
  function show(health) {
    last = health;
    if (!health) return;
    start.disabled = !health.linked || health.streaming;
    stop.disabled = tare.disabled = !health.linked || !health.streaming;
    untare.disabled = !health.linked;
    record.disabled = !health.linked || Boolean(health.recording);
    end.disabled = !health.recording;
    const values = { ...health.settings?.relaxation, ...health.settings?.thresholds };
    for (const [name, input] of fields) {
      if (!input.dataset.changed && document.activeElement !== input && values[name] !== undefined) input.value = Number(values[name].toPrecision(6));
    }
  }
  return { show };
}

/** Date and time for a file's name. */
function stamp() {
  const two = (n) => String(n).padStart(2, "0");
  const d = new Date();
  return `${d.getFullYear()}${two(d.getMonth() + 1)}${two(d.getDate())}-${two(d.getHours())}${two(d.getMinutes())}${two(d.getSeconds())}`;
}
