// What could be missing, with what speaks for it.

import { fold, h, number, percent, s } from "../dom.js";
import { symbols } from "../symbols.js";
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
      h("ol", { class: "lab-candidates" }, found.list.filter(explains).map((of) => candidate(of, diagnosis, scale, unit, act))),
      others(found.list.filter((of) => !of.untestable && !explains(of)), (of) => candidate(of, diagnosis, scale, unit, act)),
      untestable(found.list.filter((of) => of.untestable)),
      terms(),
    );
  }
  return h("div", {}, children);
}

/** Chance of as much under noise alone from which an effect explains nothing. */
const CHANCE = 0.05;
const explains = (of) => !of.untestable && of.gain_foretold > 0 && of.chance <= CHANCE;

/** Share of what is left beyond the noise that an effect would take away, as a bar; none where it is not known. */
function share(of, diagnosis) {
  const [base, noise] = [diagnosis.base_rms ?? diagnosis.base_rms_N, diagnosis.noise_rms ?? diagnosis.noise_rms_N];
  const beyond = base ** 2 - noise ** 2;
  if (!explains(of) || !of.rms_foretold || !(beyond > 0)) return null;
  const part = Math.min(Math.max((base ** 2 - of.rms_foretold ** 2) / beyond, 0), 1);
  return h(
    "span",
    { class: "lab-share" },
    s("svg", { viewBox: "0 0 100 8", preserveAspectRatio: "none", "aria-hidden": "true" }, s("rect", { class: "lab-share-all", width: 100, height: 8 }), s("rect", { class: "lab-share-part", width: 100 * part, height: 8 })),
    `${percent(part)} of the misfit`,
  );
}

function others(list, row) {
  if (!list.length) return null;
  return fold("explain nothing", `${list.length} would explain no more than chance does`, h("ol", { class: "lab-candidates" }, list.map(row)));
}

/** The terms in which the evidence is given. */
function terms() {
  const meaning = [
    ["Misfit", "What the model leaves beyond the noise, as a mean square."],
    ["Δχ²", "How much the sum of squared residuals, in units of the noise, would fall. Noise alone gives about one for each parameter."],
    ["p value", "The chance that noise alone, in traces without this effect, would seem to be explained as well by any of the candidates."],
    ["Refitted", "With all parameters of the model and of the effect fitted again; before that only the effect's."],
    ["BIC", "The Bayesian information criterion: misfit and a price for each parameter. Behind the best by more than 10, an effect is very unlikely."],
  ];
  return fold("terms", "what the terms mean", h("dl", {}, meaning.flatMap(([term, words]) => [h("dt", {}, term), h("dd", {}, words)])));
}

function verdict(diagnosis) {
  const sets = diagnosis.steps.filter((step) => step.credible_set.length > 1).map((step) => step.credible_set.join(", "));
  return h(
    "div",
    { class: `lab-verdict lab-verdict-${diagnosis.verdict}` },
    h("p", {}, h("strong", {}, capital(diagnosis.verdict)), ". ", diagnosis.in_words),
    sets.length ? h("p", {}, "These traces cannot distinguish: ", sets.join("; "), ".") : null,
    diagnosis.next_experiment ? h("p", {}, "Next experiment: ", words(diagnosis.next_experiment)) : null,
    diagnosis.notes.map((note) => h("p", { class: "lab-note" }, note)),
  );
}

function candidate(of, diagnosis, scale, unit, act) {
  const named = diagnosis.steps.some((step) => step.effect === of.effect);
  const rival = diagnosis.steps.flatMap((step) => step.rivals).find((other) => other.effect === of.effect);
  const credible = diagnosis.steps.some((step) => step.credible_set.includes(of.effect));
  const evidence = [
    named ? "named" : credible ? "cannot be distinguished" : null,
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
      share(of, diagnosis),
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
    ["Laws", of.laws?.length ? symbols(of.laws.map((law) => `${law.name}: ${law.formula}`).join("; ")) : of.expression],
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
