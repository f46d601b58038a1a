// The model at hand: its parameters, its effects, how it came about.

import { fold, h, number } from "../dom.js";
import { symbols } from "../symbols.js";

/** The panel. `act` has `drop(effect)`, `add(effect)`, `undo()`, `save()`, `export(kind)` and `copy(task or text)`. */
export function model(state, choices, act) {
  const { model: of, versions } = state;
  const last = versions.at(-1);
  return h(
    "div",
    {},
    h(
      "div",
      { class: "tools" },
      h("button", { class: "lab-undo", disabled: versions.length < 2, onclick: act.undo }, "Undo"),
      h("button", { class: "lab-save", onclick: act.save }, last.saved ? `Saved: ${last.file}` : `Save ${last.file}`),
      state.reports.map((kind) => h("button", { title: "Download the report that --report writes: one HTML file", onclick: () => act.export(kind) }, `Report: ${kind}`)),
    ),
    parameters(of, choices),
    of.effect?.length ? h("ul", { class: "lab-effects" }, of.effect.map((effect) => inModel(effect, choices, act))) : null,
    of.candidate?.length ? h("ul", { class: "lab-effects" }, of.candidate.map((own) => candidate(own, act))) : null,
    fold("history", "how it came about", h("ol", {}, versions.map((version) => came(version, state.comparison?.unit ?? state.unit, act)))),
  );
}

/** What the base law says, with its elastic response and its relaxation function where the file names no others. */
function formula(base, choices) {
  const law = choices.laws.find((known) => known.name === base.law)?.formula;
  if (!law) return null;
  const elastic = /N\(/.test(law) && !base.elastic ? ", N(x) = p/(q + 1) x^(q + 1)" : "";
  const relaxing = /g\(/.test(law) && !base.relaxation ? ", g(t) = c0 + Σ ci e^(−vi t), c0 = 1 − Σ ci" : "";
  return law + elastic + relaxing;
}

function parameters(of, choices) {
  const rows = [[of.base.law, of.base.parameters], ...(of.effect ?? []).map((effect) => [effect.name, effect.parameters])];
  const row = (name) => ([parameter, value]) =>
    h(
      "tr",
      {},
      h("th", { scope: "row" }, name),
      h("td", {}, symbols(parameter)),
      h("td", { class: "lab-number" }, number(value.value, 4)),
      h("td", { class: "lab-number" }, value.standard_error === undefined ? "" : `± ${number(value.standard_error, 2)}`),
      h("td", {}, symbols(value.unit ?? "")),
    );
  const head = h("tr", {}, ["of", "parameter", "value", "standard error", "unit"].map((name, k) => h("th", { scope: "col", class: k === 2 || k === 3 ? "lab-number" : null }, name)));
  const body = rows.flatMap(([name, list]) => Object.entries(list).map(row(name)));
  const law = formula(of.base, choices);
  const drawing = choices.laws.find((known) => known.name === of.base.law)?.drawing;
  return h(
    "div",
    { class: "lab-scroll" },
    law ? h("p", { class: "lab-formula" }, h("strong", {}, of.base.law), " ", h("span", {}, symbols(law))) : null,
    drawing ? h("pre", { class: "lab-drawing", "aria-hidden": "true" }, drawing) : null,
    h("table", { class: "lab-parameters" }, h("thead", {}, head), h("tbody", {}, body)),
  );
}

function inModel(effect, choices, act) {
  const task = { drop: { effect: effect.name } };
  return h("li", {}, h("strong", {}, effect.name), effect.expression ? h("code", {}, effect.expression) : [` (${effect.law}) `, ...symbols(choices.formulas[effect.name]?.[effect.law] ?? "")], h("button", { class: "lab-drop", onclick: () => act.start(task) }, "Drop", h("span", { class: "spoken" }, ` ${effect.name}`)), act.copy(task));
}

function candidate(own, act) {
  const task = { add: { effect: own.name } };
  return h("li", {}, own.name, " ", h("code", {}, own.expression), " is not in the model ", h("button", { onclick: () => act.start(task) }, "Add", h("span", { class: "spoken" }, ` ${own.name}`)), act.copy(task));
}

function came(version, unit, act) {
  const text = version.command;
  return h("li", {}, version.said, version.rms ? `, ${number(version.rms)}${unit ? ` ${unit}` : ""} RMS` : "", text ? [h("br"), h("code", {}, text), act.copy(text)] : null);
}
