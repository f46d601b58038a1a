// The room of a hand: its fingers side by side, on one clock and one scale.

import { answer } from "./command.js";
import { choice, h, isForPage, put } from "./dom.js";
import { plot } from "./plot.js";
import { follow } from "./live/follow.js";
import { tip, tipLegend } from "./live/fingertip.js";
import { GAUGES, SIGNALS, STRETCHES } from "./live/signals.js";
import { stamp } from "./live/stamp.js";
import { picture } from "./save.js";

export const keys = [["space", "hold the picture and go on"]];

/** Bins across a plot. */
const COLUMNS = 400;
/** Heights of a plot, px, and of the legend below the fingers. */
const [LEAST_HEIGHT, MOST_HEIGHT, BELOW] = [200, 480, 56];
/** Colour and dash of each gauge. */
const LINES = [["c0", undefined], ["c1", [8, 4]], ["c2", [2, 3]], ["c3", [8, 3, 2, 3]]];
/** The clocks of two devices may part by so much of the time that passes. */
const DRIFT = 1e-4;

export function open(root, api, { fingers: devices }) {
  let seconds = 10;
  let signal = 0;
  let held = false;
  let closed = false;
  let extent = null;

  const pause = h("button", { type: "button", "aria-pressed": "false", onclick: hold }, "Pause");
  const oneScale = h("input", { type: "checkbox", checked: true });
  const asPicture = h("button", { type: "button", title: "What is seen as a picture (PNG)", onclick: () => picture("hand", fingers.map(({ drawn }, index) => ({ drawn, heading: `Finger ${index + 1}: ${SIGNALS[signal][0]}, µε over s` }))) }, "Picture");
  const said = answer();
  const file = h("input", { type: "text", value: `grasp-${stamp()}`, size: 21, spellcheck: "false" });
  const button = (words, onclick) => h("button", { type: "button", onclick }, words);
  const commands = {
    start: button("Start all", () => all(() => "start", "Started")),
    stop: button("Stop all", () => all(() => "stop", "Stopped")),
    tare: button("Tare all", () => all(() => "tare", "Zero is read from here on")),
    record: button("Record all", () => all(() => ({ record: { file: file.value, together: true } }), "Recording")),
    end: button("End", async () => {
      if (await all(() => "end-recording", "The recording is written")) file.value = `grasp-${stamp()}`;
    }),
  };
  const place = h("div", { class: "fingers" });
  const room = h("div", { class: "hand" },
    h("div", { class: "tools" }, pause,
      choice("Stretch", STRETCHES.map((s) => [s, `${s} s`]), seconds, (s) => setSeconds(Number(s))),
      choice("Signal", SIGNALS.map(([name], index) => [index, name]), signal, (index) => (signal = Number(index))),
      h("label", {}, oneScale, "one scale"), asPicture,
      h("span", { class: "hand-legend", role: "group", "aria-label": "Gauges" }, LINES.map(([colour], gauge) => [h("span", { class: `key ${colour}` }), `gauge ${gauge + 1} `]).flat())),
    h("div", { class: "tools", role: "group", "aria-label": "All fingers" }, commands.start, commands.stop, commands.tare,
      h("label", {}, "File ", file), commands.record, commands.end), said.root, place, h("div", { class: "hand-legend" }, tipLegend()));
  root.append(room);
  const fingers = devices.map((device, index) => shown(device, index + 1));

  /** The plots share the height of the window that is left to them. */
  function fit() {
    const across = getComputedStyle(place).gridTemplateColumns.split(" ").length;
    const free = (innerHeight - place.getBoundingClientRect().top - scrollY - BELOW) / Math.ceil(fingers.length / across);
    for (const { panel, drawn } of fingers) {
      const rest = panel.clientHeight - panel.lastElementChild.clientHeight;
      drawn.resize(Math.min(Math.max(Math.floor(free - rest), LEAST_HEIGHT), MOST_HEIGHT));
    }
  }
  const resized = new ResizeObserver(fit);
  resized.observe(place);
  addEventListener("resize", fit);

  /** One finger: its picture, the plot of its gauges, where they are, and how its device is. */
  function shown(device, number) {
    const [state, regions] = [h("p", { class: "finger-state", role: "status" }), h("p", { class: "tip-regions" })];
    const tipShown = tip();
    const panel = h("section", { class: "panel finger", "aria-label": `Finger ${number}` },
      h("div", { class: "heading" }, h("h2", {}, `Finger ${number}`), h("p", { class: "muted" }, device.port), h("p", {}, h("a", { href: `#live/${number}` }, "Live"), " · ", h("a", { href: `#device/${number}` }, "Device"))),
      state, tipShown.root, regions);
    place.append(panel);
    const drawn = plot(panel, {
      x: [], label: `The four gauges of finger ${number} over time`, axes: { x: "s before now", y: "µε" }, units: { unit: "µε", decimals: 1 }, height: LEAST_HEIGHT, group: "hand", extent: () => (oneScale.checked ? extent : null),
      series: LINES.map(([colour, dash], gauge) => ({ label: `gauge ${gauge + 1}`, colour, dash, width: 1, values: [] })),
    });
    const finger = { number, api: api.of(number), panel, drawn, tip: tipShown, state, regions, health: null, clock: clock(), full: 0 };
    finger.stream = follow(finger.api, {
      span: () => [seconds, COLUMNS], happened: () => {},
      told: (health) => tell(finger, health),
      state: (isOpen, why) => isOpen || say(finger, why, true),
      failed: (why) => say(finger, why, true),
    });
    return finger;
  }

  function say(finger, words, isBad) {
    put(finger.state, words);
    finger.panel.classList.toggle("gone", isBad);
  }

  function tell(finger, health) {
    finger.health = health;
    const lost = `${health.rate_hz.toFixed(1)} Hz, ${health.rows_lost.toLocaleString("en")} rows lost`;
    if (!health.linked) say(finger, `The device is gone; waiting for it. ${health.trouble ?? ""}`, true);
    else if (health.recording) say(finger, `Recording ${health.recording.file}; ${lost}`, false);
    else say(finger, health.streaming ? `Streaming; ${lost}` : "The stream is stopped", false);
    const every = (is) => fingers.every((one) => one.health && is(one.health));
    commands.start.disabled = every((one) => one.streaming);
    commands.stop.disabled = commands.tare.disabled = every((one) => !one.streaming);
    commands.record.disabled = !every((one) => one.linked && !one.recording);
    commands.end.disabled = every((one) => !one.recording);
  }

  /** Asks the same of every finger; whether all did it. */
  async function all(wish, words) {
    const asked = await Promise.allSettled(fingers.map((finger) => finger.api.post("/live/wish", wish(finger.number))));
    const failed = asked.flatMap(({ reason }, index) => (reason ? [`finger ${index + 1}: ${reason.message}`] : []));
    if (failed.length) said.fail(`Not all of them: ${failed.join("; ")}`);
    else said.say(`${words}: ${fingers.length} fingers.`);
    return failed.length === 0;
  }

  function setSeconds(to) {
    seconds = to;
    fingers.forEach(({ stream }) => {
      stream.now.seconds = to;
      stream.refill();
    });
  }

  function hold() {
    held = !held;
    put(pause, held ? "Now" : "Pause");
    pause.setAttribute("aria-pressed", held);
  }

  function draw() {
    if (closed) return;
    requestAnimationFrame(draw);
    if (!held) drawNow();
  }

  function drawNow() {
    const present = fingers.filter(({ stream }) => stream.now.bins > 0);
    present.forEach(({ stream, clock }) => clock.take(stream));
    const clocked = present.filter(({ clock }) => clock.offset !== null);
    const now = Math.max(...clocked.map(({ stream, clock }) => stream.now.last + clock.offset));
    const stretches = present.map((finger) => {
      const { x, values, breaks } = finger.stream.now.columns();
      // A stream that stood still when the page was opened ends where it ended.
      const zero = finger.clock.offset === null ? finger.stream.now.last : now - finger.clock.offset;
      return { finger, x: x.map((time) => time - zero), values: values.slice(GAUGES * signal, GAUGES * (signal + 1)), breaks };
    });
    extent = bounds(stretches);
    const full = Math.max(0, ...present.map(({ full }) => full));
    for (const { finger, x, values, breaks } of stretches) {
      finger.drawn.range(-seconds, 0);
      finger.drawn.set({ x, values, breaks });
      finger.full = finger.tip.show((part, gauge) => finger.stream.now.value(GAUGES * part + gauge), oneScale.checked ? full : 0);
      put(finger.regions, finger.stream.regions.map((states, gauge) => `${gauge + 1} ${states.at(-1)?.points || "–"}`).join(" · "));
    }
  }

  function pressed(event) {
    if (event.key !== " " || !isForPage(event) || event.target.closest?.("button,summary,a")) return;
    event.preventDefault();
    hold();
  }
  document.addEventListener("keydown", pressed);
  requestAnimationFrame(draw);

  return () => {
    closed = true;
    resized.disconnect();
    removeEventListener("resize", fit);
    document.removeEventListener("keydown", pressed);
    fingers.forEach(({ stream, drawn }) => {
      stream.close();
      drawn.close();
    });
  };
}

/** How far a finger's session time is behind the server's clock, s, null before it is known: the least that was seen, because a row
 *  may come late and never early. */
function clock() {
  let before = 0;
  return {
    offset: null,
    take({ arrived, arrivedMs }) {
      if (!arrivedMs) return;
      const grown = this.offset === null ? Infinity : this.offset + DRIFT * Math.max(0, arrived - before);
      this.offset = Math.min(arrivedMs / 1_000 - arrived, grown);
      before = arrived;
    },
  };
}

/** Least and greatest of all that is drawn; null of nothing. */
function bounds(stretches) {
  let [least, most] = [Infinity, -Infinity];
  for (const { values } of stretches) {
    for (const all of values) {
      for (const value of all) {
        if (value < least) least = value;
        if (value > most) most = value;
      }
    }
  }
  return least <= most ? [least, most] : null;
}
