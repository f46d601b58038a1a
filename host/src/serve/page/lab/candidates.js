// What could be missing, with what speaks for it.

import { fold, h, number } from "../dom.js";
import { reach, sparkline } from "./sparkline.js";

/**
 * The verdict and the candidates of a diagnosis. `act` has `add(effect)`, `hover(effect or null)` and
 * `copy(task)`.
 */
export function candidates(answers, unit, act) {
  const diagnosis = answers.diagnosis;
  const children = [verdict(diagnosis)];
  const found = answers.candidates;
  if (found) {
    const scale = Math.max(reach(found.now), ...found.list.map((of) => reach(of.picture)));
    children.push(
      h("p", { class: "lab-note" }, `Pictures: what would be left of ${found.trace}, on one scale. Now: `, sparkline(found.now, scale, `the residual of ${found.trace} now`)),
      h("ol", { class: "lab-candidates" }, found.list.filter((of) => !of.untestable).map((of) => candidate(of, diagnosis, scale, unit, act))),
      untestable(found.list.filter((of) => of.untestable)),
    );
  }
  return h("div", {}, children);
}

function verdict(diagnosis) {
  const sets = diagnosis.steps.filter((step) => step.credible_set.length > 1).map((step) => step.credible_set.join(", "));
  return h(
    "div",
    { class: `lab-verdict lab-verdict-${diagnosis.verdict}` },
    h("p", {}, h("strong", {}, capital(diagnosis.verdict)), ". ", diagnosis.in_words),
    sets.length ? h("p", {}, "These traces do not tell apart: ", sets.join("; "), ".") : null,
    diagnosis.next_experiment ? h("p", {}, "Next experiment: ", words(diagnosis.next_experiment)) : null,
    diagnosis.notes.map((note) => h("p", { class: "lab-note" }, note)),
  );
}

function candidate(of, diagnosis, scale, unit, act) {
  const named = diagnosis.steps.some((step) => step.effect === of.effect);
  const rival = diagnosis.steps.flatMap((step) => step.rivals).find((other) => other.effect === of.effect);
  const credible = diagnosis.steps.some((step) => step.credible_set.includes(of.effect));
  const evidence = [
    named ? "named" : credible ? "cannot be told apart" : null,
    of.gain_foretold > 0 ? (of.rms_foretold ? `would leave ${number(of.rms_foretold)} ${unit} RMS` : null) : "explains nothing here",
    of.gain_foretold > 0 ? `Δχ² ${number(of.gain_foretold)}` : null,
    of.gain_foretold > 0 ? `chance alone p = ${number(of.chance, 2)}` : null,
    rival ? `refitted it leaves ${number(rival.rms)} ${unit}` : null,
    rival?.delta_bic_to_best > 0 ? `${number(rival.delta_bic_to_best)} BIC behind the best` : null,
  ];
  const leave = () => act.hover(null);
  const enter = () => act.hover(of.gain_foretold > 0 ? of.effect : null);
  return h(
    "li",
    { class: credible ? "lab-candidate lab-credible" : "lab-candidate", "data-effect": of.effect, onmouseenter: enter, onmouseleave: leave, onfocusin: enter, onfocusout: leave },
    h(
      "div",
      { class: "lab-candidate-head" },
      h("strong", {}, of.effect),
      of.picture ? sparkline(of.picture, scale, `what ${of.effect} would leave: ${number(of.rms_foretold)} ${unit} RMS`) : null,
      h("button", { class: "lab-add", onclick: () => act.add(of.effect) }, "Add", h("span", { class: "spoken" }, ` ${of.effect}`)),
      act.copy({ add: { effect: of.effect } }),
    ),
    h("p", { class: "lab-evidence" }, evidence.filter(Boolean).join(" · ")),
    details(of),
  );
}

/** What is known of an effect, whatever the data. */
function details(of) {
  const rows = [
    ["Meaning", of.meaning],
    ["Leaves", of.signature],
    ["Mistaken for", of.confused_with?.join(", ")],
    ["Told apart by", of.experiment],
    ["Laws", of.laws?.map((law) => `${law.name}: ${law.formula}`).join("; ") || of.expression],
  ];
  return fold(
    `candidate ${of.effect}`,
    "what it is",
    h("dl", {}, rows.filter(([, text]) => text).flatMap(([name, text]) => [h("dt", {}, name), h("dd", {}, text)])),
  );
}

function untestable(list) {
  if (!list.length) return null;
  return fold("untestable", `${list.length} cannot be tested on these traces`, h("ul", {}, list.map((of) => h("li", {}, `${of.effect}: ${of.untestable}`))));
}

const capital = (text) => text[0].toUpperCase() + text.slice(1);
const words = (experiment) => (typeof experiment === "string" ? experiment : (experiment.text ?? JSON.stringify(experiment)));
