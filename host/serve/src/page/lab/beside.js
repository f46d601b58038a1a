// Two models beside the same traces: their figures side by side.

import { choice, fold, h, number } from "../dom.js";

/** The panel. `act` has `start(task)`, `alone()` and `copy(task or text)`; `draft.other` is the model that is picked. */
export function beside(state, draft, act) {
  const now = state.versions.at(-1);
  const before = state.versions.slice(0, -1).map((version, k) => [`version ${k}`, `${version.said} (${version.file})`]);
  const files = state.models.filter((name) => !state.versions.some((version) => version.saved && version.file.endsWith(name)));
  const others = [...before.reverse(), ...files.map((name) => [`file ${name}`, name])];
  if (!others.length) return h("p", { class: "lab-note" }, "There is no other model yet: change this one, or put a model file into the folder.");
  if (!others.some(([value]) => value === draft.other)) draft.other = others[0][0];
  const task = () => {
    const [kind, name] = [draft.other.slice(0, draft.other.indexOf(" ")), draft.other.slice(draft.other.indexOf(" ") + 1)];
    return { beside: kind === "version" ? { version: Number(name) } : { file: name } };
  };
  return h(
    "div",
    {},
    h(
      "div",
      { class: "tools" },
      choice("Compare with", others, draft.other, (other) => (draft.other = other)),
      h("button", { class: "lab-beside", onclick: () => act.start(task()) }, "Compare the two"),
      act.copy(task),
      state.beside ? h("button", { class: "lab-alone", onclick: act.alone }, "Take it away") : null,
    ),
    state.beside ? table(state, now, state.beside) : null,
  );
}

function table(state, now, other) {
  const models = [
    { model: state.model, comparison: state.comparison },
    { model: other.model, comparison: other.comparison },
  ];
  const { unit } = state.comparison;
  const row = (name, value) => h("tr", {}, h("th", { scope: "row" }, name), models.map((of) => h("td", { class: "lab-number" }, value(of))));
  const times = ({ comparison }) => (comparison.noise_rms ? number(comparison.rms / comparison.noise_rms) : "–");
  const heldOut = ({ model }) => number(model.ladder?.at(-1)?.heldout_rms);
  const traces = state.comparison.labels.map((label, k) => row(label, ({ comparison }) => number(comparison.trace_rms[k])));
  return h(
    "div",
    { class: "lab-scroll" },
    h(
      "table",
      { class: "lab-figures" },
      h("caption", {}, "What each leaves of the same traces; less is better"),
      h("thead", {}, h("tr", {}, h("td", {}), h("th", { scope: "col", class: "lab-number" }, `now: ${now.file}`), h("th", { scope: "col", class: "lab-number" }, other.file))),
      h(
        "tbody",
        {},
        row(`left over, ${unit} RMS`, ({ comparison }) => number(comparison.rms)),
        row("times the noise", times),
        row(`held out, ${unit} RMS`, heldOut),
        row("nothing but noise left", ({ comparison }) => (comparison.only_noise ? "yes" : "no")),
        row("parameters", ({ model }) => String(count(model))),
        row("effects", ({ model }) => (model.effect ?? []).map((effect) => effect.name).join(", ") || "none"),
      ),
    ),
    h("p", { class: "lab-note" }, `The other: ${other.comparison.in_words}`),
    fold("two models by trace", `each trace, ${unit} RMS`, h("table", { class: "lab-figures" }, h("tbody", {}, traces))),
  );
}

const count = (model) => [model.base, ...(model.effect ?? [])].reduce((sum, of) => sum + Object.keys(of.parameters ?? {}).length, 0);
