// The Lab: a model beside recordings, what it lacks, and putting it right.

import { copyButton } from "./command.js";
import { choice, counted, enter, h, isForPage, keepingFocus, number } from "./dom.js";
import { bench, fitTask } from "./lab/bench.js";
import { allTraces } from "./lab/alltraces.js";
import { beside } from "./lab/beside.js";
import { candidates } from "./lab/candidates.js";
import { closer } from "./lab/closer.js";
import { covariate } from "./lab/covariate.js";
import { discovery } from "./lab/discovery.js";
import { dropped } from "./lab/dropped.js";
import { guide } from "./lab/guide.js";
import { heatmap } from "./lab/heatmap.js";
import { ladder } from "./lab/bars.js";
import { model } from "./lab/model.js";
import { motion } from "./lab/motion.js";
import { overlay } from "./lab/overlay.js";
import { ownLaw } from "./lab/ownlaw.js";
import { practice } from "./lab/practice.js";
import { survey } from "./lab/survey.js";
import { download } from "./save.js";

export const keys = [
  ["Ctrl wheel", "zoom about the pointer; with Alt in y"],
  ["Shift drag", "move along; with the wheel too"],
  ["click", "mark a place to measure from"],
  ["+ / −", "zoom in, zoom out"],
  ["← / →", "earlier, later"],
  ["[ / ]", "trace before, trace after"],
  ["Esc", "cancel what is being worked out"],
];

/** How often to ask how far the work is, ms. */
const ASK = 250;

/** Opens the room; gives the function that closes it. */
export function open(root, api) {
  const drafts = {
    fit: { law: "fung", terms: "2", separation: "clamp" },
    law: { name: "mine", stage: "contact", expression: "k * tanh(v / w)", parameters: "k = 0 N, w = 1 mm/s" },
    practice: { effect: "", size: 1 },
    beside: {},
    survey: {},
    discovery: {},
  };
  let choices = null;
  let state = null;
  let trace = 0;
  let symbolDrawn = null;
  let timer = null;
  let closed = false;
  let busy = false;

  const panel = (title, name, note) => {
    const body = h("div", {});
    const told = note ? h("p", { class: "lab-note" }, note) : null;
    const place = h("section", { class: `panel lab-${name}`, "aria-label": title }, h("h2", {}, title), told, body);
    return { place, show: (...children) => body.replaceChildren(...children), hide: (hidden) => (place.hidden = hidden), body };
  };
  const panels = {
    bench: panel("Traces and base law", "bench"),
    trace: panel("Measurement and model", "trace", "The values under the pointer stand beside it; a click marks a place to measure from. Drag over a stretch to zoom, double click for the whole trace."),
    heat: panel("Where it fails", "where", "How the error beyond the noise is shared among traces and parts of the press. A click shows the place."),
    against: panel("What the failure depends on", "against", "A model that lacks nothing leaves the same, zero, everywhere. A slope or a step here is a hint."),
    closer: panel("A closer look at the trace", "closer", "Left over is measured minus model. What nothing but noise would show is dashed: where the two part, the model lacks something."),
    ladder: panel("Ladder", "rungs", "The error (RMS, root mean square) after each addition. Fitted: of these traces. Held out: of each trace, predicted by a fit to the others. No model gets below the noise."),
    missing: panel("What is missing", "missing", "Diagnose looks for physical effects that the model lacks. Then add the one you believe."),
    formula: panel("A formula", "formula", "For what no effect of the library explains: terms of a grammar, kept where they lower the error on what they were not fitted to."),
    motion: panel("The next experiment as a motion", "motion"),
    model: panel("Model", "model"),
    beside: panel("Two models", "two", "Another model over the same traces, and both drawn."),
    law: panel("A law of one's own", "own", "An expression of force, N, or of whatever acts at its place in the chain. Try it like an effect."),
    practice: panel("Practice", "practice"),
    survey: panel("Survey", "survey", "The answers of the command survey to every group of a large data set. Open puts the traces of a group on the bench, in a folder of their own."),
  };
  const work = h("div", { class: "lab-work", role: "status", "aria-live": "polite" });
  const way = h("div", {});
  const left = [panels.trace, panels.heat, panels.against, panels.closer].map((of) => of.place);
  const right = [panels.ladder, panels.missing, panels.formula, panels.motion, panels.model, panels.beside, panels.law, panels.survey, panels.practice].map((of) => of.place);
  const files = dropped(api, { opened: openDropped, say: (text) => say(text), fail: (error) => say(error.message, true) });
  panels.bench.place.append(files.root);
  const columns = h("div", { class: "lab-columns" }, h("div", { class: "lab-column" }, left), h("div", { class: "lab-column" }, right));
  // Shown when all of it is drawn, so that nothing jumps.
  const lab = h("div", { class: "lab", hidden: true }, panels.bench.place, way, work, columns);
  root.append(lab);
  files.listen(lab);
  const picker = h("span", {});
  const failed = (error) => say(error.message, true);
  const plots = overlay(panels.trace.body, picker, api.get, failed);
  const every = allTraces(api.get, failed, (k) => show(k));
  panels.trace.body.append(every.root);

  // ── What can be done ──

  const say = (text, warning = false) => work.replaceChildren(h("p", { class: warning ? "lab-said warning" : "lab-said" }, text));
  const guarded = (act) => async (...given) => {
    try {
      return await act(...given);
    } catch (error) {
      say(error.message, true);
      return null;
    }
  };
  const start = guarded(async (task) => {
    await api.post("/lab/start", task);
    watch();
  });
  const choose = guarded(async (what) => {
    if ("set" in what) [trace, symbolDrawn] = [0, null];
    await api.post("/lab/choose", what);
    watch();
  });
  const cancel = guarded(async () => {
    if (!busy) return;
    await api.post("/lab/cancel", {});
    watch();
  });

  /** A data set that was dropped, then a model that was. */
  async function openDropped(set, model) {
    if (set !== null) await choose({ set });
    // One piece of work at a time.
    while (!closed && model && (await api.get("/lab/progress")).job) await new Promise((done) => setTimeout(done, ASK));
    if (model && !closed) await choose({ model });
  }

  /** A button that copies the command of a task, or a text. */
  function copy(of) {
    return copyButton(guarded(async () => {
      const task = typeof of === "function" ? of() : of;
      const text = typeof task === "string" ? task : (await api.post("/lab/command", task)).command;
      work.replaceChildren(h("p", { class: "lab-said" }, h("code", {}, text)));
      return text;
    }));
  }

  const act = {
    start,
    choose,
    copy,
    redraw: () => drawBench(),
    redrawAll: () => keepingFocus(root, draw),
    add: (effect) => start({ add: { effect } }),
    hover: (effect) => plots.hover(effect),
    hide: start,
    reveal: () => api.post("/lab/reveal", {}),
    check: (law) => api.post("/lab/check", law),
    submit: async (law) => {
      await api.post("/lab/law", law);
      await start({ add: { effect: law.name } });
    },
    alone: guarded(async () => {
      await api.post("/lab/alone", {});
      await refresh();
    }),
    undo: guarded(async () => {
      await api.post("/lab/undo", {});
      watch();
    }),
    save: guarded(async () => {
      const { file } = await api.post("/lab/save", {});
      await refresh();
      say(`Written: ${file}`);
    }),
    export: guarded(async (kind) => {
      const { file, html } = await api.get(`/lab/report?kind=${kind}`);
      download(file, new Blob([html], { type: "text/html" }));
    }),
  };

  // ── Progress ──

  async function watch() {
    clearTimeout(timer);
    if (closed) return;
    const { job, failed: why } = await api.get("/lab/progress").catch((error) => ({ job: null, failed: error.message }));
    if (closed) return;
    busy = Boolean(job);
    lab.classList.toggle("lab-busy", busy);
    if (job) {
      if (!state) await refresh();
      atWork(job);
      timer = setTimeout(watch, ASK);
      return;
    }
    const held = work.contains(document.activeElement);
    work.replaceChildren();
    if (why) say(why === "cancelled" ? "Cancelled. The model is as it was." : why, true);
    await refresh();
    if (held) enter(way.firstElementChild);
  }

  /** How far it is: a share of a stage where its length is known, else what was done so far. */
  function atWork(job) {
    const { stage } = job;
    const part = stage ? `${stage.what}: ${stage.done} of ${stage.of}` : "";
    const done = job.searches ? `${counted(job.searches, "refit")}, ${counted(job.steps, "step")}` : "";
    const far = [part, done, `${number(job.seconds, 2)} s`].filter(Boolean).join(" · ");
    if (work.dataset.at !== job.what || !work.querySelector(".lab-far")) {
      work.dataset.at = job.what;
      work.replaceChildren(
        h("progress", { "aria-label": job.what }),
        h("button", { class: "lab-cancel", onclick: cancel }, "Cancel"),
        h("span", { class: "lab-doing" }, `${job.what} … `, h("span", { class: "lab-far muted", "aria-hidden": "true" }, far)),
        h("code", { title: job.command }, job.command),
        copy(job.command),
      );
    } else work.querySelector(".lab-far").textContent = far;
    const bar = work.querySelector("progress");
    if (stage) [bar.max, bar.value] = [stage.of, stage.done];
    else bar.removeAttribute("value");
  }

  // ── Drawing ──

  const refresh = guarded(async () => {
    state = await api.get("/lab/state");
    if (closed) return;
    lab.hidden = false;
    keepingFocus(root, draw);
  });

  function drawBench() {
    keepingFocus(root, () => {
      panels.bench.show(bench(choices, state, drafts.fit, act));
      way.replaceChildren(guide(state, () => fitTask(choices, drafts.fit), act));
    });
  }

  /** What a panel shows; until there is something, why there is not. */
  function fill(panel, is, not, shown) {
    panel.place.classList.toggle("lab-later", !is);
    panel.show(...(is ? shown() : [h("p", { class: "lab-note" }, not)]));
  }

  function draw() {
    const { comparison, model: now } = state;
    const unfitted = "Once a base law is fitted.";
    columns.classList.toggle("lab-empty", !state.traces.length);
    // Elements that go say nothing of the pointer or the focus on them; those that come do.
    plots.hover(null);
    drawBench();
    drawTrace();
    // The map has room for its rows from the first.
    panels.heat.body.style.minHeight = `${1.75 * taken().length + 7}rem`;
    fill(panels.heat, comparison, unfitted, () => [
      h("p", {}, comparison.in_words),
      h("div", { class: "lab-scroll" }, heatmap(comparison, choices.regions, goTo)),
      h("div", { class: "tools" }, copy({ compare: null })),
    ]);
    fill(panels.against, comparison, unfitted, against);
    panels.closer.place.classList.toggle("lab-later", !comparison);
    if (!comparison) panels.closer.show(h("p", { class: "lab-note" }, unfitted));
    fill(panels.ladder, now?.ladder, "Its first rung is the base law.", rungs);
    fill(panels.missing, now, unfitted, missing);
    const { discovery: formulas, motion: next } = state.answers;
    panels.formula.hide(!formulas);
    if (formulas) panels.formula.show(discovery(formulas, drafts.discovery, { ...act, redraw: act.redrawAll }));
    panels.motion.hide(!next);
    if (next) panels.motion.show(motion(next));
    fill(panels.model, now, "Its parameters, once a base law is fitted.", () => [model(state, choices, act)]);
    panels.beside.hide(!comparison);
    if (comparison) panels.beside.show(beside(state, drafts.beside, act));
    panels.law.hide(!now);
    if (now && !panels.law.body.hasChildNodes()) panels.law.show(ownLaw(choices, drafts.law, act));
    panels.survey.hide(!state.surveys.length);
    if (state.surveys.length) panels.survey.show(survey(state, drafts.survey, { ...act, redraw: act.redrawAll }));
    panels.practice.show(practice(choices, state, drafts.practice, act));
  }

  function rungs() {
    const { comparison, answers } = state;
    const floor = comparison?.only_noise ? [h("p", { class: "lab-floor-reached" }, "At the noise floor: nothing but noise is left.")] : [];
    return [ladder(state.model, comparison?.noise_rms, comparison?.unit ?? state.unit), change(answers.change), ...floor, ...beware()];
  }

  /** What to know before trusting the fit, as the command tells it. */
  function beware() {
    const { comparison, answers } = state;
    const steps = comparison?.displacement_steps?.[0];
    const held = steps && `the displacement of ${steps.trace} goes in steps of ${number(steps.step_mm, 2)} mm, which a law takes for sudden presses`;
    const slow = comparison?.signal_repeats?.[0];
    const repeats = slow && `each value of the signal stays for ${number(slow.rows, 2)} rows, which looks like a lag`;
    return [held, repeats, ...(answers.fit?.warnings ?? [])].filter(Boolean).map((text) => h("p", { class: "lab-note lab-beware" }, `Beware: ${text}.`));
  }

  function change(of) {
    if (!of) return "";
    const words = `${of.effect} ${of.added ? "added" : "taken out"}: ${number(of.rms_before)} → ${number(of.rms_after)} ${of.unit} RMS`;
    const held = of.heldout_rms_after ? `, held out ${number(of.heldout_rms_before)} → ${number(of.heldout_rms_after)}` : "";
    return h("div", {}, h("p", {}, `${words}${held}.`), of.warnings.map((text) => h("p", { class: "lab-note" }, `Beware: ${text}.`)));
  }

  function missing() {
    const diagnose = h("button", { class: "lab-diagnose", onclick: () => start({ diagnose: null }) }, "Diagnose");
    const explore = h("button", { class: "lab-explore", onclick: () => start({ explore: null }) }, "Add all that is missing");
    const tools = h("div", { class: "tools" }, diagnose, copy({ diagnose: null }), explore, copy({ explore: null }));
    const { diagnosis: known, discovery: formulas, motion: next } = state.answers;
    const further = [
      known?.verdict === "unknown" || formulas ? [h("button", { class: "lab-discover", onclick: () => start({ discover: null }) }, "Look for a formula"), copy({ discover: null })] : [],
      known?.steps.some((step) => step.credible_set.length > 1) || next ? [h("button", { class: "lab-next-motion", onclick: () => start({ motion: null }) }, "Propose the next motion"), copy({ motion: null })] : [],
    ].flat();
    tools.append(...further);
    return [tools, known ? candidates(state.answers, known.unit, act) : ""];
  }

  function against() {
    const show = (symbol) => {
      symbolDrawn = symbol;
      keepingFocus(root, () => panels.against.show(...against()));
    };
    return [covariate(state.comparison, symbolDrawn, show)];
  }

  const taken = () => state.traces.filter((of) => of.chosen);

  function drawTrace() {
    const labels = taken().map((of) => of.name);
    panels.trace.hide(labels.length === 0);
    if (!labels.length) return;
    trace = Math.min(trace, labels.length - 1);
    picker.replaceChildren(choice("Trace", labels.map((label, k) => [String(k), label]), String(trace), (k) => show(Number(k))));
    plots.update(drawn());
    const { signal, unit, noise } = drawn();
    every.update({ labels, signal, unit, noise, fits: Boolean(state.comparison), of: state.comparison?.rms ?? null });
    drawCloser();
  }

  /** Of a comparison and a trace that are still the ones at hand when they are answered. */
  const drawCloser = guarded(async () => {
    const { comparison } = state;
    if (!comparison) return;
    const mine = trace;
    const found = await api.get(`/lab/closer?trace=${mine}`);
    if (closed || !found || mine !== trace || comparison !== state.comparison) return;
    panels.closer.show(closer(found, comparison));
  });

  /** What is drawn: of the signal of the model where it was compared. */
  function drawn() {
    const { comparison, beside: other } = state;
    const { signal, unit } = comparison ?? state;
    return { trace, label: taken()[trace].name, signal, unit, noise: comparison?.noise_rms, beside: other?.file };
  }

  function show(k) {
    trace = k;
    keepingFocus(root, drawTrace);
  }

  const goTo = guarded(async (k, region) => {
    trace = k;
    picker.querySelector("select").value = String(k);
    drawCloser();
    await plots.update(drawn());
    const found = plots.extent(region);
    if (found) {
      const [from, to] = found;
      const room = 0.1 * (to - from);
      await plots.go(from - room, to + room);
    }
    panels.trace.place.scrollIntoView({ block: "nearest" });
  });

  function pressed(event) {
    if (!isForPage(event)) return;
    const acts = {
      "+": () => plots.scale(0.5),
      "-": () => plots.scale(2),
      ArrowLeft: () => plots.pan(-0.5),
      ArrowRight: () => plots.pan(0.5),
      "[": () => show(Math.max(trace - 1, 0)),
      "]": () => show(trace + 1),
      Escape: cancel,
    };
    if (!acts[event.key] || !state) return;
    acts[event.key]();
    event.preventDefault();
  }
  document.addEventListener("keydown", pressed);

  guarded(async () => {
    choices = await api.get("/lab/choices");
    await watch();
  })();

  return () => {
    closed = true;
    clearTimeout(timer);
    document.removeEventListener("keydown", pressed);
    plots.close();
  };
}
