// Elements of the Lab, made in one place.

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

/** A number as it is read, to so many significant digits. */
export function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}

/** A share in percent. */
export const percent = (value) => `${Math.round(100 * value)} %`;

/** A drop-down list; options are names, or pairs of value and text. */
export function choice(label, options, value, onchange) {
  const option = (of) => {
    const [own, text] = Array.isArray(of) ? of : [of, of];
    return h("option", { value: own, selected: own === value }, text);
  };
  const select = h("select", { onchange: () => onchange(select.value) }, options.map(option));
  return h("label", { class: "lab-field" }, h("span", {}, label), select);
}
