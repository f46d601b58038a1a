// The margin of the grasp against slip, as `palpate grasp watch` tells it.

import { answer } from "../command.js";
import { field, h, put } from "../dom.js";
import { plot } from "../plot.js";

/** Name in the request, label, unit, whether it is text, example. The first three must be known. */
const FIELDS = [
  ["contact", "Contact, sizes in mm", "", true, "circle:5"], ["friction", "Friction coefficient", "", false, "0.7"],
  ["normal", "Normal force per strain", "N/µε", true, "0.001"], ["tangential", "Tangential force, always there", "N", false, ""],
  ["tangential_gauges", "Tangential force per strain", "N/µε", true, ""], ["moment", "Moment, always there", "N mm", false, ""],
  ["moment_gauges", "Moment per strain", "N mm/µε", true, ""], ["compression", "Compression, where the contact grows", "mm", false, ""],
  ["exponent", "Exponent of the pressure", "", true, "2"], ["contact_above", "Held above", "N", false, "0.05"],
  ["rest", "Zero from the next", "s, without a grasp", false, ""],
];
const WORDS = { none: "Nothing is held.", holds: "It holds.", "will-slip": "It holds now, but will slip once it has settled.", slips: "It slips." };
const UNKNOWN = "Not known yet: the contact and its size, the friction coefficient, and the normal force per strain. The device cannot tell them.";
/** A share of the grip beyond this is drawn as this. */
const LARGEST = 2;
const SHOWN_S = 60;
const MOST = 600;

/** A panel in the side of the Live room; `show(linked, bench)` tells what came, five times a second. */
export function marginPanel(root, api) {
  const words = h("p", { class: "margin-words", role: "status" }, UNKNOWN);
  const factor = h("p", { class: "margin-factor" });
  const forces = h("p", { class: "margin-forces muted" });
  const figure = h("div", { hidden: true });
  const said = answer();
  const inputs = new Map();
  const form = h("form", { onsubmit: watch }, h("div", { class: "fields" }, ...FIELDS.map(input)),
    h("div", { class: "tools" }, h("button", {}, "Show the margin"), h("button", { type: "button", onclick: stop }, "No longer")));
  root.append(h("section", { class: "panel margin", "aria-label": "Margin against slip" },
    h("h2", {}, "Margin against slip"), words, factor, forces, figure,
    h("details", {}, h("summary", {}, "What is held, and how"), form), said.root));

  function input([name, label, unit, isText, example]) {
    const made = h("input", { type: isText ? "text" : "number", step: isText ? null : "any", placeholder: example || null, spellcheck: "false" });
    inputs.set(name, made);
    return field(label, unit, made);
  }

  async function watch(event) {
    event.preventDefault();
    const what = {};
    for (const [name, , , isText] of FIELDS) {
      const { value } = inputs.get(name);
      if (value.trim() !== "") what[name] = isText ? value.trim() : Number(value);
    }
    await wish(what, "The margin is watched.");
  }

  function stop() {
    return wish(null, "The margin is no longer watched.");
  }

  async function wish(what, done) {
    try {
      const { command } = await api.post("/live/wish", { grasp: what });
      said.say(done, command);
    } catch (error) {
      said.fail(error.message);
    }
  }

  // What comes. The share of the grip in use is one over the margin: at 1 it slips.
  let [times, now, settled] = [[], [], []];
  let drawn = null;
  let held = "";

  /** What came of the device, or nothing while it is away. */
  function told(linked, bench) {
    if (!bench) return show(false, null);
    const holding = JSON.stringify(bench.holding);
    if (holding !== held) {
      held = holding;
      [times, now, settled] = [[], [], []];
      fill(bench.holding);
    }
    for (const reading of bench.readings) take(reading);
    show(linked, bench);
  }

  function fill(holding) {
    if (!holding) return;
    for (const [name, made] of inputs) if (document.activeElement !== made) made.value = holding[name] ?? "";
  }

  function take({ session_s, now: at, settled: then }) {
    if (session_s <= times.at(-1)) return;
    times.push(session_s);
    const share = ({ used }) => (used === null ? null : Math.min(used, LARGEST));
    now.push(share(at));
    settled.push(share(then));
    if (times.length > MOST) [times, now, settled].forEach((all) => all.shift());
  }

  function show(linked, bench) {
    const last = bench?.readings.at(-1);
    const isWatched = Boolean(bench?.holding);
    figure.hidden = times.length < 2;
    if (!linked) {
      put(words, "The device is gone; waiting for it.");
      words.dataset.state = "";
      return put(factor, "");
    }
    if (!isWatched || bench.resting || !last) {
      if (!isWatched) put(words, UNKNOWN);
      else if (bench.resting) put(words, "The zero is being taken; hold nothing.");
      if (!isWatched || bench.resting) {
        words.dataset.state = "";
        [factor, forces].forEach((where) => put(where, ""));
      }
      return;
    }
    words.dataset.state = last.state;
    const times_ = (hold) => (hold.margin === null ? "–" : `${hold.margin > 99 ? "above 99" : hold.margin.toFixed(2)} times`);
    const pulls = last.now.force_N !== 0 || last.now.moment_Nmm !== 0;
    put(words, WORDS[last.state] + (pulls ? "" : " Nothing pulls at it: without a tangential force or moment there is no margin."));
    put(factor, last.state === "none" || !pulls ? "–" : `${times_(last.now)} the load`);
    put(forces, `once settled ${times_(last.settled)} · normal ${last.now.normal_N.toFixed(3)} N, tangential ${last.now.force_N.toFixed(3)} N, moment ${last.now.moment_Nmm.toFixed(2)} N mm`.replaceAll("-", "−"));
    draw();
  }

  function draw() {
    if (times.length < 2) return;
    const x = Float64Array.from(times);
    const values = [now, settled, times.map(() => 1)];
    drawn ??= plot(figure, {
      x, label: "Share of the grip in use over time, now and once settled; at 1 it slips", axes: { x: "time, s", y: "1/margin" }, height: 130, zero: true,
      series: [
        { label: "now", colour: "c0", values: now }, { label: "once settled", colour: "c2", dash: [8, 4], values: settled },
        { label: "slip", colour: "c1", dash: [2, 3], values: values[2] },
      ],
    });
    const to = times.at(-1);
    drawn.range(Math.max(times[0], to - SHOWN_S), to);
    drawn.set({ x, values });
  }

  return { show: told, close: () => drawn?.close() };
}
