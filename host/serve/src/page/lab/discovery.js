// A formula for what no effect of the library explains, and what the rest depends on without any law.

import { choice, fold, h, number, percent, s } from "../dom.js";

const OUTCOME = {
  adequate: "Only noise is left: there is nothing to find a formula for.",
  library: "The library explains what is missing: add its effect.",
  nothing: "No term of the grammar lowers the error on what it was not fitted to. Below stands what the rest depends on without any law.",
};
const [WIDTH, HEIGHT, LEFT, BOTTOM] = [420, 230, 62, 40];
/** Steps of colour of a surface, on each side of zero. */
const STEPS = 5;

/** What `palpate discover` found. `draft` remembers the surface that is looked at; `act` has `add(name)`, `copy(task)` and `redraw()`. */
export function discovery(found, draft, act) {
  return h(
    "div",
    { class: "lab-discovery" },
    found.outcome === "formula" ? h("p", {}, fall(found)) : h("p", {}, OUTCOME[found.outcome]),
    h("ol", { class: "lab-candidates" }, found.formulas.map((of) => formula(of, act))),
    surfaces(found, draft, act),
  );
}

function fall({ ladder, unit, noise_rms: noise }) {
  const [first, last] = [ladder[0], ladder.at(-1)];
  if (!first) return "";
  const held = last.heldout_rms ? `, held out ${number(first.heldout_rms)} → ${number(last.heldout_rms)}` : "";
  return `With ${ladder.length === 2 ? "it" : "them"} the error falls ${number(first.fitted_rms)} → ${number(last.fitted_rms)} ${unit} RMS${held}; the noise is ${number(noise)} ${unit}.`;
}

function formula(of, act) {
  const values = Object.entries(of.parameters).map(([name, { value, standard_error: error, unit }]) => `${name} = ${number(value, 4)}${error ? ` ± ${number(error, 2)}` : ""} ${unit}`.trim());
  const alike = of.resembles.map(({ effect, cosine }) => `${effect} (${number(Math.abs(cosine), 2)})`);
  const rows = [
    ["Can come from", of.cause],
    ["Would confirm it", of.experiment],
    ["Not distinguished", of.alternatives.map((other) => `${other.expression} (Δ BIC ${number(other.delta_bic, 2)})`).join("; ")],
    ["Resembles", alike.join(", ")],
    ["p value", number(of.p_value, 2)],
  ];
  return h(
    "li",
    { class: "lab-candidate", "data-effect": of.name },
    h("div", { class: "lab-candidate-head" }, h("strong", {}, of.name), h("code", {}, `${of.stage}: ${of.expression}`), h("button", { class: "lab-add", onclick: () => act.add(of.name) }, "Add", h("span", { class: "spoken" }, ` ${of.name}`)), act.copy({ add: { effect: of.name } })),
    h("p", { class: "lab-evidence" }, values.join(" · ")),
    h("dl", {}, rows.filter(([, text]) => text).flatMap(([name, text]) => [h("dt", {}, name), h("dd", {}, text)])),
  );
}

/** Free surfaces over pairs of quantities, the one that predicts best first. */
function surfaces(found, draft, act) {
  if (!found.surfaces.length) return null;
  const name = (of) => of.quantities.join(" and ");
  const told = (of) => `${name(of)}: ${percent(of.explained)} explained, ${percent(of.held_out)} of what was left out`;
  const sorted = [...found.surfaces].sort((a, b) => b.held_out - a.held_out);
  const one = sorted.find((of) => name(of) === draft.surface) ?? sorted[0];
  return fold(
    "surfaces",
    "what the rest depends on, without a law",
    choice("Surface over", sorted.map((of) => [name(of), told(of)]), name(one), (surface) => {
      draft.surface = surface;
      act.redraw();
    }),
    surface(one, found.unit),
    h("p", { class: "lab-note" }, `Of what is left ${percent(one.explained)} goes with both (p = ${number(one.p_value, 2)}), ${percent(one.additive)} with the sum of what goes with each alone; of traces left out it predicts ${percent(one.held_out)}.`),
  );
}

/** Mean residual over two quantities, as colours: one hue above zero, another below. */
function surface(of, unit) {
  const [across, down] = of.at;
  const most = Math.max(...of.means.flat().filter((value) => value !== null).map(Math.abs)) || 1;
  const [wide, high] = [(WIDTH - LEFT - 10) / across.length, (HEIGHT - BOTTOM - 8) / down.length];
  const cells = of.means.flatMap((row, i) => row.map((mean, j) => {
    if (mean === null) return null;
    const level = Math.round((STEPS * Math.abs(mean)) / most);
    const [x, y] = [LEFT + wide * i, 8 + high * (down.length - 1 - j)];
    return s("rect", { class: `lab-surface lab-surface-${mean < 0 ? "below" : "above"}-${level}`, x: x.toFixed(1), y: y.toFixed(1), width: wide.toFixed(1), height: high.toFixed(1) }, s("title", {}, `${of.quantities[0]} ${number(across[i])}, ${of.quantities[1]} ${number(down[j])}: ${number(mean)} ${unit}`));
  }));
  const ends = (values, x, y, anchor) => s("text", { x, y, "text-anchor": anchor }, number(values));
  return h(
    "figure",
    { class: "lab-chart" },
    s(
      "svg",
      { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `Mean residual over ${of.quantities.join(" and ")}, from ${number(-most)} to ${number(most)} ${unit}` },
      cells.filter(Boolean),
      ends(across[0], LEFT, HEIGHT - BOTTOM + 16, "start"), ends(across.at(-1), WIDTH - 10, HEIGHT - BOTTOM + 16, "end"),
      ends(down[0], LEFT - 6, HEIGHT - BOTTOM, "end"), ends(down.at(-1), LEFT - 6, 20, "end"),
      s("text", { x: (LEFT + WIDTH) / 2, y: HEIGHT - 6, "text-anchor": "middle" }, of.quantities[0]),
      s("text", { x: 14, y: (HEIGHT - BOTTOM) / 2, "text-anchor": "middle" }, of.quantities[1]),
    ),
    h("figcaption", {}, `Mean of what is left, ${unit}: `, h("span", { class: "lab-surface-key lab-surface-key-above" }), `above the model, up to ${number(most)}; `, h("span", { class: "lab-surface-key lab-surface-key-below" }), "below it."),
  );
}

