// The next experiment as a motion, with what each effect predicts for it.

import { h, number } from "../dom.js";
import { download } from "../save.js";
import { chart } from "./chart.js";

/** Keys of the legend, in the order of the colours of lines. */
const KEYS = ["fitted", "heldout", "foretold", "other"];
const SIZE = [420, 190];

/** What `palpate diagnose --next` proposes. */
export function motion(found) {
  if (!found.file) return h("div", {}, h("p", {}, `None is proposed: ${found.why}.`));
  const { columns, time_s: time, rig } = found;
  const [displacement, ...rest] = columns.filter(({ name }) => name === "displacement_mm").concat(columns.filter(({ name }) => name !== "displacement_mm"));
  const predicted = rest.filter(({ name }) => found.tells_apart.some((member) => name.startsWith(`${member.replaceAll("-", "_")}_`)));
  const unit = predicted[0]?.name.split("_").at(-1) ?? "";
  const told = found.pairs_told < found.pairs ? ` Of ${found.pairs} pairs it distinguishes ${found.pairs_told}.` : "";
  const lines = predicted.map(({ values }, index) => ({ kind: `trace-${index % KEYS.length}`, x: time, y: values, name: found.tells_apart[index] }));
  return h(
    "div",
    {},
    h("p", {}, `${number(found.duration_s)} s of motion that distinguish ${found.tells_apart.join(", ")}: if one is right, each other, refitted, leaves at least ${number(found.separates)} squares of the noise (more than 10 distinguish them).${told}`),
    h(
      "div",
      { class: "lab-charts" },
      chart({ label: "The motion: displacement over time", x: "time, s", lines: [{ kind: "measured", x: time, y: displacement.values }], caption: "Displacement, mm.", size: SIZE }),
      chart({ label: `What each effect predicts for it, ${unit}`, x: "time, s", lines, caption: legend(found.tells_apart, `Predicted, ${unit}:`), size: SIZE }),
      chart({ label: `How the predictions differ from that with ${found.tells_apart[0]}`, x: "time, s", lines: lines.slice(1).map((line) => ({ ...line, y: line.y.map((value, k) => value - lines[0].y[k]) })), caption: `Predicted less what ${found.tells_apart[0]} predicts, ${unit}.`, size: SIZE }),
    ),
    h("p", { class: "lab-note" }, `Within what these traces went through: from ${number(rig.off_mm)} mm off to ${number(rig.displacement_mm)} mm deep, at most ${number(rig.speed_mm_per_s)} mm/s. Record it after a minute of rest, put the recording beside the others, and diagnose all together.`),
    h("div", { class: "tools" }, h("button", { class: "lab-motion-save", onclick: () => download(found.file, new Blob([found.csv], { type: "text/csv" })) }, `Save ${found.file}`)),
  );
}

const legend = (names, words) => h("span", { class: "lab-legend" }, words, names.map((name, index) => h("span", { class: `lab-key lab-key-${KEYS[index % KEYS.length]}` }, name)));
