// Practice: an effect is hidden, found, and revealed.

import { choice, h, number } from "../dom.js";

/** The panel. `act` has `hide(task)`, `reveal()` and `copy(task)`. */
export function practice(choices, state, draft, act) {
  const named = ["", ...choices.effects].map((name) => [name, name || "any: chosen by lot"]);
  const task = () => ({
    hide: {
      ...(draft.effect ? { effects: [draft.effect] } : { any: 1 }),
      ...(draft.size === 1 ? {} : { size: draft.size }),
    },
  });
  const truth = h("div", { class: "lab-truth", role: "status", "aria-live": "polite" });
  const reveal = async () => {
    draft.truth = { set: state.set, found: await act.reveal() };
    tell();
  };
  const tell = () => {
    if (draft.truth?.set !== state.set) return;
    const { found } = draft.truth;
    const effect = (of) => h("li", {}, h("strong", {}, of.effect), ` (${of.law}): `, Object.entries(of.parameters).map(([name, value]) => `${name} = ${number(value.value)} ${value.unit}`.trim()).join(", "));
    truth.replaceChildren(
      h("p", {}, `Hidden was, at ${number(found.misfit_over_noise, 2)} times the noise:`),
      h("ul", {}, found.effects.map(effect)),
      h("p", { class: "lab-note" }, h("code", {}, found.command)),
    );
  };
  tell();
  const size = h("input", { type: "number", min: "0.1", max: "100", step: "0.1", value: draft.size, onchange: () => (draft.size = Number(size.value) || 1) });
  return h(
    "div",
    {},
    h("p", { class: "lab-note" }, state.practice ? "These traces are a practice set. Fit a base law, diagnose, add what is missing; then reveal what was hidden." : "Makes ten traces of a made-up specimen in which one effect is hidden. Find it, then have it revealed."),
    h(
      "div",
      { class: "tools" },
      choice("Hide", named, draft.effect, (effect) => (draft.effect = effect)),
      h("label", { class: "lab-field" }, h("span", {}, "Misfit over the noise"), size),
      h("button", { class: "lab-hide", onclick: () => act.hide(task()) }, "Hide one"),
      act.copy(task),
      state.practice ? h("button", { class: "lab-reveal", onclick: () => reveal().catch((error) => truth.replaceChildren(h("p", {}, error.message))) }, "Reveal what is hidden") : null,
    ),
    truth,
  );
}
