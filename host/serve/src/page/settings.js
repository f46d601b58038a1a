// The settings of a device that are numbers, and inputs for them.

import { field, h } from "./dom.js";

/** The relaxation function of the filter: name and unit. */
const FILTER = [["c1", ""], ["v1", "1/s"], ["c2", ""], ["v2", "1/s"]];
/** Thresholds of the regions: name and unit. */
const THRESHOLDS = [
  ["touch", "µε"], ["release", "µε"], ["peak-drop", "µε"], ["motion-step", "µε"], ["dead-band", "µε"],
  ["smoothing", "s"], ["dwell", "s"], ["recovery", "s"],
];

/** Inputs by name. They show what the device has; what is typed stays until it is set or taken back. */
export function inputs() {
  const all = new Map();
  const changed = (name) => Boolean(all.get(name).dataset.changed);
  const value = (name) => Number(all.get(name).value);
  const add = (name, input) => {
    input.addEventListener("input", () => (input.dataset.changed = "yes"));
    all.set(name, input);
    return input;
  };
  const number = (name) => add(name, h("input", { type: "number", step: "any", required: true }));
  const fields = (names) => h("div", { class: "fields" }, names.map(([name, unit]) => field(name, unit, number(name))));

  return {
    add,
    changed,
    value,
    number,
    filter: () => fields(FILTER),
    thresholds: () => fields(THRESHOLDS),
    /** Filter and thresholds that were changed, as a device is asked to set them. */
    asked() {
      const what = { thresholds: {} };
      if (FILTER.some(([name]) => changed(name))) what.filter = FILTER.map(([name]) => value(name));
      for (const [name] of THRESHOLDS) if (changed(name)) what.thresholds[name] = value(name);
      return what;
    },
    /** Puts a number in, as if it were typed. */
    type(name, number) {
      all.get(name).value = read(number);
      all.get(name).dataset.changed = "yes";
    },
    /** What was typed is forgotten. */
    revert() {
      for (const input of all.values()) delete input.dataset.changed;
    },
    /** What the device has, by name. */
    show(values) {
      for (const [name, input] of all) {
        if (input.dataset.changed || document.activeElement === input || values[name] === undefined) continue;
        const text = read(values[name]);
        if (input.value !== text) input.value = text;
      }
    },
  };
}

const read = (number) => String(Number(number.toPrecision(6)));
