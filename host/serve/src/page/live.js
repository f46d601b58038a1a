// The room of a fingertip: four gauges as they feel, what the filter makes of it, and the device behind it.

import { h, isForPage, put } from "./dom.js";
import { plot } from "./plot.js";
import { healthPanel } from "./live/health.js";
import { fingertip } from "./live/fingertip.js";
import { foretold, foretoldPanel } from "./live/foretold.js";
import { GAUGES, SIGNALS, STRETCHES } from "./live/signals.js";
import { follow } from "./live/follow.js";
import { columnsOf, readView } from "./live/window.js";
import { controls } from "./live/controls.js";
import { marginPanel } from "./live/margin.js";
import { picture, table } from "./save.js";

export const keys = [
  ["Ctrl wheel", "zoom about the pointer; with Alt in y"], ["Shift drag", "move along; with the wheel too"],
  ["click", "mark a place to measure from"], ["space", "pause and go on"], ["← →", "back and forth through the session"], ["+ −", "shorter or longer stretch"],
  ["0", "back to now"],
];

/** What is drawn besides, and no signal of the stream. */
const FORETOLD = ["predicted", "c4", [4, 4], true, "how a held press must go on by the model, from what was felt before"];
const DRAWN = [...SIGNALS, FORETOLD];
/** Colour of each region by its number; rest has none. */
const REGION_COLOURS = [undefined, "c4", "c1", "c3", "c0", "c2", "c5"];
/** What letters and colours mean. */
const LEGEND = [
  ["OA", REGION_COLOURS[1], "preloading: the motion has begun, touch is not reached"],
  ["AB", REGION_COLOURS[2], "loading: in contact, the motion advances"],
  ["BC", REGION_COLOURS[3], "transition: the motion advances, the signal already falls"],
  ["CD", REGION_COLOURS[4], "relaxation: the motion stands, in contact"],
  ["DE", REGION_COLOURS[5], "unloading: the motion retreats, in contact"],
  ["EF", REGION_COLOURS[6], "recovery: contact is lost, the material recovers"],
  ["Type I", null, "the signal is farther from zero than where it will settle, and decays: after loading"],
  ["Type II", null, "it is nearer to zero than where it will settle, and recovers: after a partial unloading"],
  ["FA", null, "fast adapting: what answers to a change and fades"],
  ["SA", null, "slowly adapting: what stays while a press is held; FA and SA make the signal"],
];
/** Heights of a plot, px, and of its heading with the space below. */
const [LEAST_HEIGHT, MOST_HEIGHT, HEADING] = [200, 560, 44];
const LONGEST = 86_400;
/** Bins across a plot, at least and at most; between, as many as it is wide in px. */
const COLUMNS = [300, 1_000];

export function open(root, api) {
  const room = h("div", { class: "live" });
  root.append(room);

  let seconds = 10;
  let past = null; // The stretch that is looked at, or null for now.
  let health = { now_s: 0, since_s: 0 };
  let closed = false;
  let pastDrawing = null;
  const measured = { frames: 0, since: performance.now(), delay: 0, arrivedMs: 0, delays: [] };

  // Tools above the plots.
  const pause = h("button", { type: "button", "aria-pressed": "false", onclick: () => (past ? goOn() : pauseNow()) }, "Pause");
  const length = h("select", { "aria-label": "Stretch shown", onchange: () => setSeconds(Number(length.value)) },
    ...STRETCHES.map((s) => h("option", { value: s, selected: s === seconds }, `${s} s`)));
  const back = h("button", { type: "button", "aria-label": "Back in the session", onclick: () => move(-0.5) }, "←");
  const forth = h("button", { type: "button", "aria-label": "Forth in the session", onclick: () => move(0.5) }, "→");
  const shorter = h("button", { type: "button", "aria-label": "Zoom in", onclick: () => zoom(0.5) }, "+");
  const longer = h("button", { type: "button", "aria-label": "Zoom out", onclick: () => zoom(2) }, "−");
  const slider = h("input", { type: "range", min: 0, max: 1000, value: 1000, class: "session", "aria-label": "Place in the session", oninput: slide });
  const where = h("span", { class: "muted where", role: "status" });
  const shown = DRAWN.map(([name, colour, , on, words], signal) => {
    const box = h("input", { type: "checkbox", checked: on, onchange: () => plots.forEach(({ drawn }) => drawn.show(signal, box.checked)) });
    const label = h("label", { title: words }, box, h("span", { class: `key ${colour}` }), name);
    return label;
  });
  const asPicture = h("button", { type: "button", class: "save-picture", title: "What is seen as a picture (PNG)", onclick: () => picture(named(), plots.map(({ drawn }, gauge) => ({ drawn, heading: `Gauge ${gauge + 1}, µε over s` }))) }, "Picture");
  const asData = h("button", { type: "button", class: "save-data", title: "The points of what is seen as a table (CSV)", onclick: saveData }, "Data");
  room.append(
    h("div", { class: "tools" }, pause, length, back, forth, shorter, longer, slider, where, asPicture, asData),
    h("div", { class: "tools", role: "group", "aria-label": "What is drawn" }, ...shown));

  const columns = h("div", { class: "columns" });
  const gauges = h("div", { class: "gauges" });
  const side = h("div", { class: "side" });
  columns.append(gauges, side);
  room.append(columns);

  const plots = Array.from({ length: GAUGES }, (_, gauge) => {
    const reading = h("span", { class: "reading" });
    const place = h("section", { class: "gauge", "aria-label": `Gauge ${gauge + 1}` },
      h("div", { class: "heading" }, h("h2", {}, `Gauge ${gauge + 1}`), reading));
    gauges.append(place);
    const drawn = plot(place, {
      x: [], label: `Strain of gauge ${gauge + 1} over time`, axes: { x: "time, s", y: "strain, µε" }, units: { unit: "µε", decimals: 1 }, height: LEAST_HEIGHT, group: "live",
      // Hairlines: those that are wider are stroked with joins, which without a GPU takes most of a frame.
      series: DRAWN.map(([label, colour, dash, show]) => ({ label, colour, dash, show, width: 1, values: [] })),
      onZoom: (from, to) => (from === null ? goOn() : look(from, to)),
    });
    return { drawn, reading };
  });

  side.append(h("details", { class: "panel live-legend" }, h("summary", {}, "What OA … EF, Type I and II, FA and SA mean"), h("dl", {}, LEGEND.flatMap(([term, colour, words]) => [
    h("dt", {}, colour ? h("span", { class: `shade shade-${colour}` }) : null, term), h("dd", {}, words),
  ]))));
  const model = foretoldPanel(side);
  const tip = fingertip(side);
  const panel = controls(side, api);
  const margin = marginPanel(side, api);
  const healthShown = healthPanel(side);

  const columnsShown = () => Math.min(Math.max(2 * Math.round(gauges.firstElementChild.clientWidth / 2), COLUMNS[0]), COLUMNS[1]);
  /** The plots share the height of the window that is left to them. */
  function fit() {
    const across = getComputedStyle(gauges).gridTemplateColumns.split(" ").length;
    const down = Math.ceil(GAUGES / across);
    const below = innerHeight - gauges.getBoundingClientRect().top - scrollY;
    const height = Math.min(Math.max(Math.floor(below / down) - HEADING, LEAST_HEIGHT), MOST_HEIGHT);
    plots.forEach(({ drawn }) => drawn.resize(height));
  }
  const resized = new ResizeObserver(() => {
    fit();
    finger.refill();
  });
  resized.observe(gauges);
  addEventListener("resize", fit);

  // What comes.
  const finger = follow(api, {
    span: () => [seconds, columnsShown()], told, happened,
    state: (isOpen, why) => {
      room.classList.toggle("away", !isOpen);
      if (!isOpen) where.textContent = why;
    },
    failed: (why) => (where.textContent = why),
  });
  const { now } = finger;

  /** The holds that the model foretold, those of now and those of the stretch that is looked at. */
  let holds = [];
  let modelDrawn = null;
  const closeWatch = api.socket("/device/watch", (data) => {
    const { linked, bench } = JSON.parse(data);
    holds = bench.foretold.holds;
    margin.show(linked, bench);
    model.show(linked, bench);
  }, (isOpen) => {
    if (isOpen) return;
    margin.show(false, null);
    model.show(false, null);
  });

  function told(said) {
    health = said;
    healthShown.show(health);
    panel.show(health);
    room.classList.toggle("gone", !health.linked);
    if (!past) slider.value = 1000;
  }

  function happened(event) {
    if (event.kind === "gap") healthShown.log(event.from_s, event.words);
    else if (event.kind === "said") healthShown.log(event.time_s, event.words);
  }

  // Where one looks.
  function pauseNow() {
    if (Number.isFinite(now.last)) look(now.last - seconds, now.last);
  }

  async function look(from, to) {
    const width = Math.min(Math.max(to - from, 0.02), LONGEST);
    const newest = Math.max(health.now_s, Number.isFinite(now.last) ? now.last : 0);
    const oldest = health.since_s ?? 0;
    const start = Math.min(Math.max(from, oldest - width / 2), newest - width / 2);
    past = { from: start, to: start + width };
    pause.textContent = "Now";
    pause.setAttribute("aria-pressed", "true");
    slider.value = Math.round(1000 * Math.min(1, Math.max(0, (past.to - oldest) / Math.max(newest - oldest, 1e-9))));
    where.textContent = `${past.from.toFixed(2)} … ${past.to.toFixed(2)} s`;
    // What is drawn already goes there at once, so that the next turn of the wheel starts from here.
    plots.forEach(({ drawn }) => drawn.range(past.from, past.to));
    const mine = past;
    try {
      const of = `from=${past.from}&to=${past.to}`;
      const [bytes, events, held] = await Promise.all([
        api.bytes(`/live/view?${of}&bins=1200`), api.get(`/live/events?${of}`), api.get(`/live/foretold?${of}`),
      ]);
      if (past !== mine) return;
      const states = Array.from({ length: GAUGES }, () => []);
      const missing = [];
      for (const event of events) {
        if (event.kind === "state") states[event.gauge].push(event);
        else if (event.kind === "gap") missing.push(event);
      }
      pastDrawing = { ...columnsOf(readView(bytes)), regions: states, gaps: missing, holds: held, fresh: true };
    } catch (error) {
      where.textContent = error.message;
    }
  }

  function goOn() {
    past = pastDrawing = null;
    pause.textContent = "Pause";
    pause.setAttribute("aria-pressed", "false");
    where.textContent = "";
    slider.value = 1000;
  }

  function stretch() {
    return past ?? { from: now.last - seconds, to: now.last };
  }

  function move(by) {
    const { from, to } = stretch();
    if (Number.isFinite(from)) look(from + by * (to - from), to + by * (to - from));
  }

  function zoom(by) {
    const { from, to } = stretch();
    const [middle, half] = [(from + to) / 2, (by * (to - from)) / 2];
    if (Number.isFinite(middle)) look(middle - half, middle + half);
  }

  function slide() {
    const oldest = health.since_s ?? 0;
    const end = oldest + (Number(slider.value) / 1000) * (health.now_s - oldest);
    const width = past ? past.to - past.from : seconds;
    if (Number(slider.value) >= 1000) goOn();
    else look(end - width, end);
  }

  function setSeconds(to) {
    seconds = to;
    now.seconds = to;
    finger.refill();
  }

  // Drawing, once for each frame of the display.
  function draw() {
    if (closed) return;
    requestAnimationFrame(draw);
    drawWhatIsNew();
    measure();
  }

  function drawWhatIsNew() {
    const still = past !== null;
    if (still && !pastDrawing?.fresh) return;
    if (!still && now.bins === 0) return;
    const { from, to } = stretch();
    const { x, values, breaks } = still ? pastDrawing : now.columns();
    const marks = still ? pastDrawing : { regions: finger.regions, gaps: finger.gaps, holds };
    plots.forEach(({ drawn, reading }, gauge) => {
      drawn.range(from, to);
      const bands = spans(marks.regions[gauge], from, to).concat(missing(marks.gaps, from, to));
      const all = SIGNALS.map((_, signal) => values[GAUGES * signal + gauge]);
      drawn.set({ x, values: [...all, foretold(x, marks.holds, gauge)], bands, breaks });
      if (!still) read(reading, gauge);
    });
    // The panel's plot is drawn when there is news of the model, or another stretch is looked at.
    if (still || modelDrawn !== holds) model.draw({ x, values }, marks.holds, from, to);
    modelDrawn = holds;
    if (still) pastDrawing.fresh = false;
    else tip.show((part, gauge) => now.value(GAUGES * part + gauge));
  }

  function read(reading, gauge) {
    const state = finger.regions[gauge].at(-1);
    const value = (signal) => now.value(GAUGES * signal + gauge).toFixed(1).replace("-", "−");
    const region = state ? `${state.points} ${state.name}`.trim() : "";
    const type = state && state.type !== "–" ? ` · Type ${state.type}` : "";
    const text = `${value(0)} µε, settles at ${value(4)} · ${region}${type}`;
    put(reading, text);
  }

  function measure() {
    measured.frames++;
    if (finger.arrivedMs !== measured.arrivedMs) {
      measured.delays.push(performance.timeOrigin + performance.now() - finger.arrivedMs);
      measured.arrivedMs = finger.arrivedMs;
    }
    const passed = performance.now() - measured.since;
    if (passed < 1_000) return;
    const sorted = measured.delays.sort((a, b) => a - b);
    const delay = sorted.length ? sorted[Math.floor(0.99 * (sorted.length - 1))] : 0;
    healthShown.frames((1_000 * measured.frames) / passed, delay);
    Object.assign(measured, { frames: 0, since: performance.now(), delays: [] });
  }

  const named = () => `fingertip-${stretch().from.toFixed(2)}s`;

  function saveData() {
    const { x, values } = past ? pastDrawing : now.columns();
    const columns = SIGNALS.flatMap(([name], signal) => Array.from({ length: GAUGES }, (_, gauge) =>
      [`gauge${gauge + 1}${signal === 0 ? "" : `_${name.replace(" ", "_")}`}_ustrain`, values[GAUGES * signal + gauge]]));
    table(named(), [["time_s", x], ...columns]);
  }

  function pressed(event) {
    // Space presses a button or opens a summary.
    if (!isForPage(event) || event.target.closest?.("button,summary")) return;
    const done = {
      " ": () => (past ? goOn() : pauseNow()), ArrowLeft: () => move(-0.5), ArrowRight: () => move(0.5),
      "+": () => zoom(0.5), "-": () => zoom(2), 0: goOn,
    }[event.key];
    if (!done) return;
    event.preventDefault();
    done();
  }
  document.addEventListener("keydown", pressed);
  requestAnimationFrame(draw);

  return () => {
    closed = true;
    resized.disconnect();
    removeEventListener("resize", fit);
    finger.close();
    closeWatch();
    margin.close();
    model.close();
    document.removeEventListener("keydown", pressed);
    plots.forEach(({ drawn }) => drawn.close());
  };
}

/** Regions as shaded bands, and Type I and II as words at their foot. */
function spans(states, from, to) {
  const shaded = [], types = [];
  let end = to;
  for (let index = states.length - 1; index >= 0; index--) {
    const begin = states[index].time_s;
    if (end > from && begin < end) {
      const { region, points, name, type } = states[index];
      extend(shaded, { from: begin, to: end, key: region, colour: REGION_COLOURS[region], text: points, name: `${points} ${name}`.trim() });
      extend(types, { from: begin, to: end, key: type, foot: type === "–" ? "" : `Type ${type}` });
    }
    // A region that was recognised late begins before what was told ahead of it.
    end = Math.min(end, begin);
    if (begin <= from) break;
  }
  return shaded.concat(types);
}

/** Puts a band before the others, or makes the first one longer if it is the same. */
function extend(bands, band) {
  const later = bands.at(-1);
  if (later?.key === band.key) later.from = band.from;
  else bands.push(band);
}

function missing(gaps, from, to) {
  return gaps.filter((gap) => gap.to_s >= from && gap.from_s <= to)
    .map((gap) => ({ from: gap.from_s, to: Math.max(gap.to_s, gap.from_s + (to - from) / 500), colour: "ink", text: gap.words }));
}
