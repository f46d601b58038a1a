// Calibration of a gauge, step by step. Nothing is written to the device before the last step says so.

import { answer, commandLine } from "../command.js";
import { field, h, number, put, s } from "../dom.js";
import { figure, panel, table } from "./parts.js";

const STEPS = [["choose", "Choose"], ["unload", "Unload"], ["load", "Load"], ["check", "Check"], ["written", "Written"]];

export function calibrationPanel(desk) {
  const { root, body, linked } = panel("Calibration");
  const steps = h("ol", { class: "device-steps", "aria-label": "Steps" }, STEPS.map(([name, title]) => h("li", { "data-step": name }, title)));
  const place = h("div", { class: "device-step" });
  const said = answer();
  body.append(steps, place, said.root);

  let step = "choose";
  let state = null;
  const draft = { gauge: 1, perLoad: "1", unit: "µε", seconds: "2", load: "" };
  let points = [];
  let basis = null; // What is sent: points, the text of a file, or numbers.
  let result = null;
  let live = null; // Where the reading is shown, in the steps that have one.
  let reading = false;

  /** Shows a step, and puts the keyboard where it goes on. */
  function go(to) {
    const isFirst = place.childElementCount === 0;
    step = to;
    for (const item of steps.children) {
      if (item.dataset.step === step) item.setAttribute("aria-current", "step");
      else item.removeAttribute("aria-current");
    }
    live = null;
    place.replaceChildren(...{ choose, unload, load, check, written }[step]());
    if (state) show(state);
    if (!isFirst) place.querySelector("input,select,button")?.focus();
  }

  function cancel() {
    [points, basis, result] = [[], null, null];
    said.say("Cancelled; nothing was written to the device.");
    go("choose");
  }

  const button = (text, onclick, more = {}) => h("button", { type: "button", onclick, ...more }, text);
  const back = (to) => button("Back", () => { said.clear(); go(to); });
  const text = (name, more = {}) => {
    const input = h("input", { type: "number", step: "any", value: draft[name], oninput: () => (draft[name] = input.value), ...more });
    return input;
  };

  // Steps.

  function choose() {
    const gauge = h("select", { onchange: () => (draft.gauge = Number(gauge.value)) },
      [1, 2, 3, 4].map((k) => h("option", { value: String(k), selected: k === draft.gauge }, `gauge ${k}`)));
    const unit = h("input", { type: "text", value: draft.unit, size: "4", oninput: () => (draft.unit = unit.value) });
    const file = h("input", { type: "file", accept: ".csv,text/csv", onchange: async () => file.files[0] && fit({ csv: await file.files[0].text() }) });
    const gain = h("input", { type: "number", step: "any" });
    const offset = h("input", { type: "number", step: "1" });
    const numbers = () => {
      if (gain.value === "" || offset.value === "") return said.fail("Give both gain and offset.");
      return fit({ numbers: { gauge: draft.gauge, gain: Number(gain.value), offset: Number(offset.value) } });
    };
    return [
      h("p", {}, "Known loads make known strains; the counts under them give gain and offset. Two loads are enough, no load being one of them; from three on the errors are known too."),
      h("div", { class: "fields" },
        field("What to calibrate", "", gauge),
        field("Loads are given in", "", unit),
        field("Strain of a load of one", "µε", text("perLoad")),
        field("Each reading takes", "s", text("seconds", { min: "0.1", max: "60" }))),
      h("p", { class: "muted" }, "Where strains are known themselves, leave the unit µε and the strain of one at 1."),
      h("div", { class: "tools" }, button("Begin", begin, { class: "device-main" })),
      h("details", {}, h("summary", {}, "From a file of points, or by numbers"),
        h("p", { class: "muted" }, "A CSV file with the columns gauge, strain_ustrain, counts, such as a bench with a reference writes; it may hold several gauges."),
        h("div", { class: "fields" }, field("File of points", "", file)),
        h("p", { class: "muted" }, "Or gain and offset of the gauge chosen above."),
        h("div", { class: "fields" }, field("Gain", "µε per count", gain), field("Offset", "counts", offset)),
        h("div", { class: "tools" }, button("Take these", numbers))),
    ];
  }

  function begin() {
    if (!(Number(draft.perLoad) !== 0 && draft.perLoad !== "")) return said.fail("The strain of a load of one must be a number other than 0.");
    if (!(Number(draft.seconds) > 0 && Number(draft.seconds) <= 60)) return said.fail("A reading takes above 0 s, up to 60 s.");
    said.clear();
    points = [];
    draft.load = "0";
    return go("unload");
  }

  function unload() {
    return [
      h("p", {}, `Take everything off the fingertip. Wait until gauge ${draft.gauge} stands still, then read.`),
      nowLine(),
      h("div", { class: "tools" }, readButton(), back("choose"), button("Cancel", cancel)),
    ];
  }

  function load() {
    const input = text("load");
    return [
      h("p", {}, `Put a known load on the fingertip, type it, wait until gauge ${draft.gauge} stands still, then read. Then the next.`),
      nowLine(),
      h("div", { class: "fields" }, field("Load", draft.unit, input)),
      h("div", { class: "tools" }, readButton(), button("Fit", () => fit({ points: points.map(({ gauge, strain, counts }) => ({ gauge, strain, counts })) }), { class: "device-main", disabled: points.length < 2 }),
        back("unload"), button("Cancel", cancel)),
      table("Readings", ["Load", "Counts", "± scatter", "Samples", "", ""], points.map((point, k) => [
        `${number(point.load, 6)} ${draft.unit}`, figure(point.counts, 1), figure(point.deviation, 1), figure(point.samples),
        point.settled ? "stood still" : h("span", { class: "bad" }, "moved meanwhile"),
        button("Remove", () => { points.splice(k, 1); go("load"); }, { "aria-label": `Remove the reading of ${point.load} ${draft.unit}` }),
      ])),
    ];
  }

  function check() {
    const gauges = result.gauges;
    const isPoints = Boolean(basis.points);
    return [
      ...gauges.map(outcome),
      isPoints && points.some((point) => !point.settled) ? h("p", { class: "device-doubt" }, "A reading moved while it was taken; go back, remove it and read it again for a better line.") : "",
      h("p", { class: "device-pending" }, "Nothing has been written to the device yet."),
      h("div", { class: "tools" }, button("Write to the device and save", write, { class: "device-main" }), back(isPoints ? "load" : "choose"), isPoints ? keep() : null, button("Cancel", cancel)),
    ];
  }

  function written() {
    return [
      h("p", {}, "Gain and offset are set and saved in the device. The tare of the gauge was taken back."),
      h("div", { class: "tools" }, button("Calibrate another gauge", () => { [points, basis, result] = [[], null, null]; said.clear(); go("choose"); }), basis.points ? keep() : null),
    ];
  }

  // Reading.

  function nowLine() {
    live = { root: h("p", { class: "device-now" }), warn: h("p", { class: "device-warn", role: "status" }) };
    return h("div", {}, live.root, live.warn);
  }

  function showNow() {
    if (!live) return;
    const gauge = draft.gauge - 1;
    const now = state.bench.counts?.[gauge];
    if (!now) {
      put(live.root, `Gauge ${draft.gauge}: no reading.`);
      put(live.warn, state.linked && !state.streaming ? "The stream is stopped; Start in Live begins it." : "");
      return;
    }
    const strain = state.settings.gauges[gauge].ustrain_per_count;
    put(live.root, `Gauge ${draft.gauge}: ${figure(now.counts)} counts, scatter ${figure(now.deviation)} counts (${number(Math.abs(strain) * now.deviation)} µε)`);
    live.root.dataset.settled = now.settled;
    put(live.warn, now.settled ? "It stands still." : "Still moving: it changed by more than its scatter within the last second.");
  }

  function readButton() {
    return button(`Read for ${draft.seconds} s`, read, { class: "device-main device-read" });
  }

  async function read(event) {
    if (reading) return;
    const load = Number(draft.load);
    if (draft.load === "" || !Number.isFinite(load)) return said.fail("Type the load first.");
    reading = true;
    event.target.disabled = true;
    said.say(`Reading for ${draft.seconds} s; leave it alone …`);
    const of = step;
    try {
      const { result: all } = await desk.wish({ average: Number(draft.seconds) });
      if (step !== of) return;
      const mean = all[draft.gauge - 1];
      points.push({ gauge: draft.gauge, load, strain: load * Number(draft.perLoad), ...mean });
      const moved = mean.settled ? "" : ` It moved by ${figure(mean.drift_counts)} counts meanwhile: wait longer, remove it and read again.`;
      said.say(`${figure(mean.counts, 1)} counts ± ${figure(mean.deviation, 1)} over ${figure(mean.samples)} samples.${moved}`);
      draft.load = "";
      go("load");
    } catch (error) {
      said.fail(error.message);
    } finally {
      reading = false;
      event.target.disabled = false;
    }
  }

  // Fit and write.

  async function fit(from) {
    try {
      const { command, result: found } = await desk.wish({ fit: from });
      [basis, result] = [from, found];
      said.say(from.points ? "With the points kept as points.csv." : "", command);
      go("check");
    } catch (error) {
      said.fail(error.message);
    }
  }

  async function write() {
    try {
      const { command } = await desk.wish({ calibrate: basis });
      said.say("Written.", command);
      go("written");
    } catch (error) {
      said.fail(error.message);
    }
  }

  function outcome(of) {
    const error = (value) => (value === null ? "" : ` ± ${number(value)}`);
    const list = [
      ["gain", `${number(1e3 * of.ustrain_per_count, 6)}${error(of.ustrain_per_count_standard_error && 1e3 * of.ustrain_per_count_standard_error)} µε per 1000 counts`],
      ["offset", `${figure(of.offset_counts)}${error(of.offset_counts_standard_error)} counts`],
    ];
    if (of.nonlinearity !== null) list.push(["farthest from the line", `${number(100 * of.nonlinearity)} % of the range of strains`]);
    if (of.before) list.push(["so far", `${number(1e3 * of.before.ustrain_per_count, 6)} µε per 1000 counts, offset ${figure(of.before.offset_counts)} counts`]);
    return h("div", { class: "device-outcome" },
      h("h3", {}, `Gauge ${of.gauge}`),
      h("dl", {}, list.flatMap(([name, words]) => [h("dt", {}, name), h("dd", {}, words)])),
      of.points && of.ustrain_per_count_standard_error === null ? h("p", { class: "muted" }, "Two readings meet every line, so they give no errors; a third one would.") : null,
      of.points ? h("div", { class: "device-fit" }, residuals(of), table("Readings and line", ["Strain (µε)", "Counts", "Residual (µε)"],
        of.points.map((point) => [number(point.strain_ustrain, 6), figure(point.counts, 1), number(point.residual_ustrain)]))) : null);
  }

  function keep() {
    const rows = points.map(({ gauge, strain, counts }) => `${gauge},${strain},${counts}\n`);
    return button("Keep the points as a file", () => {
      const url = URL.createObjectURL(new Blob(["gauge,strain_ustrain,counts\n", ...rows], { type: "text/csv" }));
      h("a", { href: url, download: "points.csv" }).click();
      setTimeout(() => URL.revokeObjectURL(url), 1_000);
    });
  }

  function show(told) {
    state = told;
    linked(state.linked);
    showNow();
  }

  go("choose");
  return { root, show };
}

/** Residuals over strain, as points about a line. */
function residuals({ gauge, points }) {
  const [width, height, left, bottom] = [320, 170, 56, 34];
  const strains = points.map((point) => point.strain_ustrain);
  const [low, high] = [Math.min(...strains), Math.max(...strains)];
  const most = Math.max(...points.map((point) => Math.abs(point.residual_ustrain)), 1e-9);
  const x = (strain) => left + 12 + ((width - left - 24) * (strain - low)) / (high - low || 1);
  const y = (residual) => (height - bottom) / 2 + 4 - (((height - bottom) / 2 - 10) * residual) / most;
  const label = (at, text, more) => s("text", { class: "device-tick", x: at[0], y: at[1], ...more }, text);
  return s("svg", { viewBox: `0 0 ${width} ${height}`, class: "device-residuals", role: "img", "aria-label": `Residuals of gauge ${gauge} over strain, at most ${number(most)} µε` },
    s("line", { class: "device-zero", x1: left, x2: width - 4, y1: y(0), y2: y(0) }),
    points.map((point) => s("line", { class: "device-stem", x1: x(point.strain_ustrain), x2: x(point.strain_ustrain), y1: y(0), y2: y(point.residual_ustrain) })),
    points.map((point) => s("circle", { class: "device-dot", cx: x(point.strain_ustrain), cy: y(point.residual_ustrain), r: 4 })),
    label([left - 6, y(most) + 4], number(most, 2), { "text-anchor": "end" }), label([left - 6, y(0) + 4], "0", { "text-anchor": "end" }), label([left - 6, y(-most) + 4], number(-most, 2), { "text-anchor": "end" }),
    label([x(low), height - 18], number(low), { "text-anchor": "middle" }), label([x(high), height - 18], number(high), { "text-anchor": "end" }),
    label([(left + width) / 2, height - 4], "strain, µε; residual above, µε", { "text-anchor": "middle" }));
}
