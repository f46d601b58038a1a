// Elements of the page, made in one place.

const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "disabled" || name === "checked" || name === "selected") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** An HTML element; attributes that begin with "on" are listeners. */
export const h = (tag, attributes = {}, ...children) => fill(document.createElement(tag), attributes, children);

/** An SVG element. */
export const s = (tag, attributes = {}, ...children) => fill(document.createElementNS(SVG, tag), attributes, children);

const open = new Set();

/** A fold-out that stays as it was put when it is drawn anew; `name` tells it from all others. */
export function fold(name, summary, ...children) {
  const put = (is) => (is ? open.add(name) : open.delete(name));
  // At the click itself too: what draws it anew may come before the toggle.
  const title = h("summary", { onclick: () => put(!details.open) }, summary);
  const details = h("details", { open: open.has(name) }, title, ...children);
  details.addEventListener("toggle", () => put(details.open));
  return details;
}

const CONTROLS = "button,input,select,summary";
const wordsOf = (control) => `${control.tagName} ${control.getAttribute("aria-label") ?? (control.labels?.[0] ?? control).textContent}`;
const within = (panel) => [...panel.querySelectorAll(CONTROLS)];
const usable = (control) => control && !control.disabled && control.checkVisibility();

/** Gives the keyboard to the first control of a panel that can be used, or to the panel itself. */
export function enter(panel, wanted = []) {
  const control = [...wanted, ...within(panel)].find(usable);
  if (!control) panel.tabIndex = -1;
  (control ?? panel).focus({ preventScroll: true });
}

/** Draws anew without taking the keyboard away: the control of the same words in the same panel has it again, or the first of the
 *  panel where there is none. */
export function keepingFocus(root, draw) {
  const before = document.activeElement;
  const panel = root.contains(before) ? before.closest("section") : null;
  const words = panel && before !== panel && wordsOf(before);
  const alike = (control) => wordsOf(control) === words;
  const place = panel ? within(panel).filter(alike).indexOf(before) : -1;
  draw();
  if (!panel || (before.isConnected && usable(before))) return;
  const name = panel.getAttribute("aria-label");
  const now = panel.isConnected ? panel : [...root.querySelectorAll("section")].find((of) => of.getAttribute("aria-label") === name);
  if (!now) return;
  const same = within(now).filter(alike);
  enter(now, [same[place], same[0]]);
}

/** A whole number as a power. */
export const raised = (value) => String(value).replace("-", "⁻").replace(/[0-9]/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);

/** A column of a trace with its unit, as an axis has it: `force, N` for `force_N`. */
export function quantity(name, unit) {
  const of = name.replace(unit === "µε" ? /_ustrain$/ : `_${unit}`, "").replaceAll("_", " ");
  return unit ? `${of}, ${unit}` : of;
}

/** A number as it is read, to so many significant digits, zeros at its end included; whole numbers as they are. */
export function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const written = () => {
    if (Number.isInteger(value) && size < 1e5) return String(value);
    if (size < 1e-3 || size >= 1e5) return value.toExponential(digits - 1).replace(/e\+?(-?\d+)/, (_, power) => `×10${raised(power)}`);
    return size >= 10 ** digits ? String(Math.round(value)) : value.toPrecision(digits);
  };
  return written().replace("-", "−");
}

/** `1 refit`, `2 refits`. */
export const counted = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

/** A share in percent. */
export const percent = (value) => `${Math.round(100 * value)} %`;

/** A labelled input; `unit` stands behind its name. */
export const field = (name, unit, input) => h("label", { class: "field" }, h("span", {}, name, unit ? h("span", { class: "unit" }, ` ${unit}`) : null), input);

/** Changes what an element says only where it would change, so that a screen reader is not told twice. */
export function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** A drop-down list; options are names, or pairs of value and text. */
export function choice(label, options, value, onchange) {
  const option = (of) => {
    const [own, text] = Array.isArray(of) ? of : [of, of];
    return h("option", { value: own, selected: own === value }, text);
  };
  const select = h("select", { onchange: () => onchange(select.value) }, options.map(option));
  return h("label", { class: "lab-field" }, h("span", {}, label), select);
}

/** Whether a key is for the page: no shortcut of the browser's, and not pressed in a field or in an open dialog. */
export function isForPage(event) {
  return !event.ctrlKey && !event.metaKey && !event.altKey && !event.target.closest?.("input,select,textarea,dialog[open]");
}
