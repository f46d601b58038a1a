// A law of one's own, with what is wrong with it shown in place.

import { choice, fold, h } from "../dom.js";

/** The form. `act` has `check(law)` and `submit(law)`, which both give promises; `draft` is kept by the caller. */
export function ownLaw(choices, draft, act) {
  const fault = h("pre", { class: "lab-fault", role: "status", "aria-live": "polite", hidden: true });
  const expression = h("input", { id: "lab-expression", value: draft.expression, spellcheck: "false", autocomplete: "off", "aria-describedby": "lab-law-known", oninput: changed });
  const name = h("input", { value: draft.name, spellcheck: "false", oninput: changed });
  const parameters = h("input", { value: draft.parameters, spellcheck: "false", oninput: changed, placeholder: "k = 0 N, w = 1 mm" });
  const add = h("button", { type: "submit", disabled: true }, "Add this law");
  const lines = h("pre", {});
  let waiting;

  function read() {
    Object.assign(draft, { name: name.value, expression: expression.value, parameters: parameters.value });
    return { name: draft.name.trim(), stage: draft.stage, expression: draft.expression, parameters: parsed(draft.parameters) };
  }

  function changed() {
    read();
    add.disabled = true;
    clearTimeout(waiting);
    waiting = setTimeout(check, 150);
  }

  async function check() {
    if (!draft.expression.trim()) return show(null, "");
    const { fault, toml } = await act.check(read()).catch((error) => ({ fault: { message: error.message }, toml: "" }));
    show(fault, toml);
    add.disabled = Boolean(fault);
  }

  function show(wrong, toml) {
    lines.textContent = toml;
    expression.setAttribute("aria-invalid", wrong ? "true" : "false");
    fault.hidden = !wrong;
    if (!wrong) return;
    const at = wrong.at ?? null;
    const mark = at === null ? "" : `${draft.expression}\n${" ".repeat(at)}${"^".repeat(Math.max(wrong.length, 1))}\n`;
    fault.textContent = mark + wrong.message;
  }

  const form = h(
    "form",
    { class: "lab-law", onsubmit: (event) => (event.preventDefault(), act.submit(read()).catch((error) => show({ message: error.message }, ""))) },
    h("label", { class: "lab-field" }, h("span", {}, "Name"), name),
    choice("Acts on", choices.stages, draft.stage, (stage) => ((draft.stage = stage), changed())),
    h("label", { class: "lab-field lab-wide" }, h("span", {}, "Law"), expression),
    fault,
    h("label", { class: "lab-field lab-wide" }, h("span", {}, "Parameters, strength first"), parameters),
    fold("law variables", "what it may speak of", h("dl", { id: "lab-law-known" }, choices.variables.flatMap((of) => [h("dt", {}, h("code", {}, of.name)), h("dd", {}, of.meaning)]))),
    fold("law lines", "the lines for a model file", lines),
    add,
  );
  check();
  return form;
}

/** `k = 0 N, w = 1 mm` as parameters. */
function parsed(text) {
  const parts = text.split(",").map((part) => part.trim()).filter(Boolean);
  return parts.map((part) => {
    const [name, rest = ""] = part.split("=").map((side) => side.trim());
    const [value = "", unit = ""] = rest.split(/\s+/, 2);
    const start = Number.parseFloat(value);
    return { name, value: Number.isFinite(start) ? start : 0, unit };
  });
}
