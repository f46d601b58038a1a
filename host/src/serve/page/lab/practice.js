// Practice: an effect is hidden, found, and revealed.

import { choice, h, number } from "./dom.js";

/** The panel. `act` has `hide(task)`, `reveal()` and `copy(task)`. */
export function practice(choices, state, draft, act) {
  const named = ["", ...choices.effects].map((name) => [name, name || "any, nobody knows which"]);
  const task = () => ({
    hide: {
      ...(draft.effect ? { effects: [draft.effect] } : { any: 1 }),
      ...(draft.size === 1 ? {} : { size: draft.size }),
    },
  });
  const truth = h("div", { role: "status", "aria-live": "polite" });
  const reveal = async () => {
    const found = await act.reveal();
    const effect = (of) => h("li", {}, h("strong", {}, of.effect), ` (${of.law}): `, Object.entries(of.parameters).map(([name, value]) => `${name} = ${number(value.value)} ${value.unit}`).join(", "));
    truth.replaceChildren(
      h("p", {}, `Hidden was, at ${number(found.misfit_over_noise, 2)} times the noise:`),
      h("ul", {}, found.effects.map(effect)),
      h("p", { class: "lab-note" }, h("code", {}, found.command)),
    );
  };
  const size = h("input", { type: "number", min: "0.1", max: "100", step: "0.1", value: draft.size, onchange: () => (draft.size = Number(size.value) || 1) });
  return h(
    "div",
    {},
    h("p", { class: "lab-note" }, "Ten traces of a made-up specimen in which one effect is hidden. Find it, then have it revealed."),
    h(
      "div",
      { class: "tools" },
      choice("Hide", named, draft.effect, (effect) => (draft.effect = effect)),
      h("label", { class: "lab-field" }, h("span", {}, "Misfit over the noise"), size),
      h("button", { class: "lab-hide", onclick: () => act.hide(task()) }, "Hide one"),
      act.copy(task),
      state.practice ? h("button", { class: "lab-reveal", onclick: reveal }, "Reveal") : null,
    ),
    truth,
  );
}
