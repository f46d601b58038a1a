// Where one stands on the way from a recording to a named effect, and the one button that goes on.

import { h, number } from "../dom.js";

const WAY = ["Fit a base law", "Ask what is missing", "Add it", "Nothing but noise is left"];

/**
 * The strip. `act` has `start(task)`, `hover(effect or null)` and `copy(task)`; `fit()` gives the task of the law that is
 * picked.
 */
export function guide(state, fit, act) {
  if (!state.traces.length) return h("section", { class: "lab-guide", "aria-label": "What to do next" }, h("p", {}, state.surveys.length ? "Open a survey below, and one of its groups; or a folder with traces." : "Open a folder with traces, or hide an effect under Practice and find it."));
  const { at, words, task, button, effect } = stand(state, fit);
  const step = (text, k) => h("li", k === at ? { "aria-current": "step" } : { class: k < at ? "lab-step-done" : "" }, text);
  const hover = effect ? { onmouseenter: () => act.hover(effect), onmouseleave: () => act.hover(null), onfocus: () => act.hover(effect), onblur: () => act.hover(null) } : {};
  return h(
    "section",
    { class: "lab-guide", "aria-label": "What to do next" },
    h("ol", { "aria-label": "The way to a better model" }, WAY.map(step)),
    h("p", {}, words),
    task ? h("div", { class: "tools" }, h("button", { class: "lab-next", onclick: () => act.start(task), ...hover }, button), act.copy(task)) : null,
  );
}

function stand(state, fit) {
  const { model, comparison, answers } = state;
  const count = state.traces.filter((of) => of.chosen).length;
  if (!model) {
    const hidden = state.practice ? " In this practice set something acts that no base law knows." : "";
    const words = `${count} ${count === 1 ? "trace" : "traces"} of ${state.signal}.${hidden} First a base law is fitted; what it leaves tells the rest.`;
    return { at: 0, words, task: fit(), button: `Fit ${fit().fit.law}` };
  }
  const noise = comparison?.noise_rms ? `, the noise is ${number(comparison.noise_rms)} ${comparison.unit}` : "";
  const left = comparison ? `The model leaves ${number(comparison.rms)} ${comparison.unit} RMS${noise}.` : "";
  if (comparison?.only_noise) return { at: 3, words: done(state, left) };
  const diagnosis = answers.diagnosis;
  if (!diagnosis) return { at: 1, words: `${left} Where it fails is shaded below the plots.`, task: { diagnose: null }, button: "Diagnose" };
  return found(answers, model, left);
}

/** After a diagnosis: the effect or formula to add, or why there is none. */
function found({ diagnosis, discovery }, model, left) {
  const known = new Set((model.effect ?? []).map((of) => of.name));
  const next = diagnosis.steps.find((step) => !known.has(step.effect));
  if (diagnosis.verdict === "unknown") return unknown(discovery, next, left);
  if (!next) return { at: 2, words: `${left} Nothing is missing.` };
  const effect = next.effect;
  const others = next.credible_set.filter((name) => name !== effect);
  const doubt = others.length ? ` These traces cannot distinguish it from ${others.join(", ")}.` : "";
  const words = `${left} What is missing looks like ${effect}.${doubt} The pointer on the button lays over the plots what it would change.`;
  return { at: 2, words, task: { add: { effect } }, button: `Add ${effect}`, effect };
}

/** Where the library does not explain it to the end a formula may. */
function unknown(discovery, next, left) {
  const most = next ? ` (${next.effect} explains the most)` : "";
  const words = `${left} No effect of the library explains it to the end${most}.`;
  if (!discovery) return { at: 2, words: `${words} A formula may.`, task: { discover: null }, button: "Look for a formula" };
  const formula = discovery.formulas[0]?.name;
  if (!formula) return { at: 2, words: `${words} No formula does either; a law of one's own may.` };
  return { at: 2, words: `${words} The formula ${formula} does better.`, task: { add: { effect: formula } }, button: `Add ${formula}` };
}

function done(state, left) {
  const ladder = state.model.ladder ?? [];
  const [first, last] = [ladder[0], ladder.at(-1)];
  const fell = ladder.length > 1 ? ` The error fell from ${number(first.fitted_rms)} to ${number(last.fitted_rms)} ${state.unit} with ${ladder.slice(1).map((rung) => rung.add).join(", ")}.` : "";
  return `${left}${fell} Nothing but noise is left.${state.practice ? " Under Practice it can be revealed what was hidden." : ""}`;
}
