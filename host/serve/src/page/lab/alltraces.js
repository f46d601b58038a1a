// All traces that were taken: as small pictures side by side on one scale, or one over the other.

import { choice, h, number, quantity } from "../dom.js";
import { chart, fitted } from "./chart.js";

/** Most traces that are drawn, and points across a picture. */
const [MOST, ACROSS] = [60, 160];
const COLOURS = 6;
const SMALL = [230, 130];
const [WIDEST, HEIGHT] = [820, 300];

/**
 * A fold-out; nothing is asked for while it is shut. `ask(path)` fetches, `fail(error)` hears what went wrong, `show(trace)` opens one.
 * `update({labels, signal, unit, fits, noise, of})` draws anew where `of`, what is compared, or the traces are others.
 */
export function allTraces(ask, fail, show) {
  const how = { layout: "side", what: "signal" };
  const place = h("div", {});
  const details = h("details", { class: "lab-all" }, h("summary", {}, "All traces, side by side or overlaid"), place);
  let info = null;
  let drawings = null;
  let asked = null;
  details.addEventListener("toggle", () => details.open && load());

  async function load() {
    if (!info || asked === info) return drawings && draw();
    const mine = (asked = info);
    drawings = null;
    place.replaceChildren(h("p", { class: "lab-note" }, "Loading …"));
    try {
      const found = [];
      // One after the other: the session answers one question at a time.
      for (let trace = 0; trace < Math.min(mine.labels.length, MOST); trace++) {
        found.push(await ask(`/lab/overlay?trace=${trace}&width=${ACROSS}`));
        if (mine !== info) return;
      }
      drawings = found;
      draw();
    } catch (error) {
      asked = null;
      place.replaceChildren();
      fail(error);
    }
  }

  const residuals = () => how.what === "residual" && info.fits;
  const set = (name) => (value) => {
    how[name] = value;
    draw();
    place.querySelector(`select[data-of=${name}]`)?.focus();
  };

  function picked(label, options, name) {
    const field = choice(label, options, how[name], set(name));
    field.querySelector("select").dataset.of = name;
    return field;
  }

  function draw() {
    const left = info.labels.length - drawings.length;
    place.replaceChildren(
      h("div", { class: "tools" },
        picked("Layout", [["side", "side by side"], ["over", "overlaid"]], "layout"),
        info.fits ? picked("Of", [["signal", "measured and model"], ["residual", "residual"]], "what") : null),
      how.layout === "side" ? side() : over(),
      left > 0 ? h("p", { class: "lab-note" }, `The first ${MOST}; ${left} more are not drawn. Take fewer to see others.`) : "");
  }

  /** Times since the first sample, so that traces can be compared. */
  const since = ({ time, whole }) => time.map((at) => at - whole[0]);

  function lines(of, kinds) {
    const x = since(of);
    return kinds.filter(([name]) => of[name]).map(([name, kind]) => ({ kind, x, y: of[name] }));
  }

  function extents(names) {
    const values = drawings.flatMap((of) => names.flatMap((name) => of[name] ?? [])).filter((value) => value !== null);
    const [low, high] = values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
    return { x: [0, Math.max(...drawings.map(({ whole }) => whole[1] - whole[0]))], y: values.length ? [low, high] : [0, 1] };
  }

  const axis = () => (residuals() ? `residual, ${info.unit}` : quantity(info.signal, info.unit));
  const rms = (values) => Math.sqrt(values.reduce((sum, value) => sum + value * value, 0) / (values.length || 1));

  function side() {
    const kinds = residuals() ? [["residual", "residual"]] : [["measured", "measured"], ["predicted", "model"]];
    const within = extents(kinds.map(([name]) => name));
    const floor = residuals() && info.noise ? [info.noise, -info.noise].map((level) => ({ kind: "noise", x: within.x, y: [level, level] })) : [];
    return h("div", {},
      h("p", { class: "lab-note" }, `${axis()}, over time, s: one scale for all. A click shows the trace above.`),
      h("div", { class: "lab-small" }, drawings.map((of, trace) => h("button", { type: "button", onclick: () => show(trace), "aria-label": `${info.labels[trace]}: show it` },
        chart({ label: info.labels[trace], hidden: true, x: "", lines: [...lines(of, kinds), ...floor], within, size: SMALL, caption: info.labels[trace] })))));
  }

  function over() {
    const name = residuals() ? "residual" : "measured";
    const all = drawings.map((of, trace) => ({ ...lines(of, [[name, `trace-${trace % COLOURS}`]])[0], name: info.labels[trace] }));
    const told = (trace) => (residuals() ? `, ${number(rms(drawings[trace].residual.filter((value) => value !== null)))} ${info.unit}` : "");
    return h("div", {},
      fitted(WIDEST, (width) => chart({ label: `${axis()} of all traces over time`, x: "time since the first sample, s", lines: all, size: [width, HEIGHT], caption: axis() })),
      h("ul", { class: "lab-over" }, drawings.map((_, trace) => h("li", {}, h("button", { type: "button", onclick: () => show(trace), title: "Show it above" },
        h("span", { class: `lab-key lab-key-trace-${trace % COLOURS}` }), `${info.labels[trace]}${told(trace)}`)))));
  }

  return {
    root: details,
    update(next) {
      const same = info && info.of === next.of && info.signal === next.signal && info.labels.join("\n") === next.labels.join("\n");
      if (same) return;
      info = next;
      if (details.open) load();
    },
  };
}
