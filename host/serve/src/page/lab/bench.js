// What is on the bench: data set, traces, signal, base law, model file.

import { choice, counted, fold, h, number } from "../dom.js";

const PARTING = { clamp: "clamp: no pull", free: "free: recovers by itself", bonded: "bonded: it pulls" };

/** The panel. `act` has `choose(what)`, `fit(task)` and `copy(task)`. `draft` is the law that is picked. */
export function bench(choices, state, draft, act) {
  return h("div", {}, data(state, draft, act), law(choices, draft, act));
}

function data(state, draft, act) {
  const taken = state.traces.filter((trace) => trace.chosen).length;
  const ticks = ticksOf(state, draft);
  const box = (k) => h("input", { type: "checkbox", checked: ticks[k], value: String(k), onchange: (event) => (ticks[k] = event.target.checked) });
  const pick = () => act.choose({ traces: ticks.flatMap((ticked, k) => (ticked ? [k] : [])) });
  // One that was opened from elsewhere, as a recording that was dropped, is no folder of traces.
  const known = state.set === "" || state.sets.includes(state.set) ? state.sets : [...state.sets, state.set];
  const sets = known.map((set) => [set, set || state.folder]);
  return h(
    "div",
    { class: "tools" },
    sets.length ? choice("Data set", sets, state.set, (set) => act.choose({ set })) : null,
    state.signals.length ? choice("Signal", state.signals, state.signal, (signal) => act.choose({ signal })) : null,
    state.traces.length
      ? traces(
          `${taken} of ${counted(state.traces.length, "trace")}`,
          h("ul", {}, state.traces.map((trace, k) => h("li", {}, h("label", {}, box(k), `${trace.name}, ${trace.samples} samples, ${number(trace.duration_s)} s`)))),
          h("button", { class: "lab-take", onclick: pick }, "Take these"),
        )
      : h("p", {}, "No traces in this folder. Hide an effect below, and find it."),
    state.left_out.length ? leftOut(state.left_out) : null,
    state.models.length ? choice("Model file", [["", "open …"], ...state.models], "", (model) => model && act.choose({ model })) : null,
  );
}

/** Which traces are ticked: those that were taken, until that changes; a panel that is drawn anew keeps what the user ticked. */
function ticksOf(state, draft) {
  const taken = JSON.stringify(state.traces.map(({ name, chosen }) => [name, chosen]));
  if (draft.taken !== taken) Object.assign(draft, { taken, ticks: state.traces.map((trace) => trace.chosen) });
  return draft.ticks;
}

function leftOut(files) {
  const count = files.length === 1 ? "1 file is left out" : `${files.length} files are left out`;
  return fold("left out", count, h("ul", {}, files.map(({ name, why }) => h("li", {}, `${name}: ${why}`))));
}

function traces(...children) {
  const details = fold("traces", ...children);
  details.classList.add("lab-traces");
  return details;
}

function law(choices, draft, act) {
  const of = lawOf(choices, draft);
  const separations = separationsOf(choices, of);
  const task = () => fitTask(choices, draft);
  const counts = Array.from({ length: choices.most_terms }, (_, k) => [String(k + 1), String(k + 1)]);
  const set = (name) => (value) => {
    draft[name] = value;
    act.redraw();
  };
  const optional = (name) => {
    const input = h("input", { type: "number", min: "0", step: "any", value: draft[name] ?? "", placeholder: "free", onchange: () => (draft[name] = input.value) });
    return input;
  };
  return h(
    "div",
    {},
    h("div", { class: "tools" }, options()),
    h("p", { class: "lab-note" }, `${of.name}: ${of.meaning}.`),
  );

  function exponentials() {
    return !of.relaxation || (draft.relaxation ?? choices.relaxations[0]) === choices.relaxations[0];
  }

  function options() {
    return [
      choice("Base law", choices.laws.map((one) => one.name), draft.law, set("law")),
      of.relaxation ? choice("Relaxation", choices.relaxations, draft.relaxation ?? choices.relaxations[0], set("relaxation")) : null,
      of.terms && exponentials() ? choice("Exponentials", [...counts, ["0", "auto"]], draft.terms, set("terms")) : null,
      of.segments ? h("label", { class: "lab-field" }, h("span", {}, "Segments m"), optional("segments")) : null,
      of.exponent ? h("label", { class: "lab-field" }, h("span", {}, "Exponent n, 0 for auto"), optional("exponent")) : null,
      choice("Where contact breaks", separations.map((name) => [name, PARTING[name] ?? name]), draft.separation, set("separation")),
      h("button", { class: "lab-fit", onclick: () => act.start(task()) }, "Fit"),
      act.copy(task),
    ];
  }
}

const lawOf = (choices, draft) => choices.laws.find((one) => one.name === draft.law);
const separationsOf = (choices, of) => choices.separations.filter((name) => of.bonded || name !== "bonded");

/** The fit of the law that is picked. */
export function fitTask(choices, draft) {
  const of = lawOf(choices, draft);
  const separations = separationsOf(choices, of);
  const given = (value) => value !== "" && value !== undefined;
  return {
    fit: {
      law: draft.law,
      ...(of.terms ? { terms: Number(draft.terms) } : {}),
      ...(of.relaxation && given(draft.relaxation) ? { relaxation: draft.relaxation } : {}),
      separation: separations.includes(draft.separation) ? draft.separation : separations[0],
      ...(of.segments && given(draft.segments) ? { segments: Number(draft.segments) } : {}),
      ...(of.exponent && given(draft.exponent) ? { exponent: Number(draft.exponent) } : {}),
    },
  };
}
