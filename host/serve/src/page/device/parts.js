// What the panels of the Device room are made of.

import { h } from "../dom.js";

/** A panel: a heading, what is said when there is no device, and a body that is disabled then. `live` panels need one. */
export function panel(title, { live = true } = {}) {
  const away = h("p", { class: "device-away", role: "status", hidden: true }, "There is no device. This goes on by itself when it is back.");
  const body = h("fieldset", { class: "device-body" });
  const root = h("section", { class: "panel device-panel", "aria-label": title }, h("h2", {}, title), live ? away : null, body);
  return {
    root,
    body,
    linked(is) {
      away.hidden = is;
      body.disabled = live && !is;
    },
  };
}

/** A table; `columns` are its heads, `rows` arrays of cells. */
export function table(caption, columns, rows) {
  return h("div", { class: "device-scroll" }, h("table", {},
    h("caption", {}, caption),
    h("thead", {}, h("tr", {}, columns.map((name) => h("th", { scope: "col" }, name)))),
    h("tbody", {}, rows.map((cells) => h("tr", {}, cells.map((cell, k) => (k === 0 ? h("th", { scope: "row" }, cell) : h("td", {}, cell))))))));
}

/** A number with its sign as it is printed, and groups of three digits. */
export function figure(value, decimals = 0) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return value.toLocaleString("en", { minimumFractionDigits: decimals, maximumFractionDigits: decimals }).replace("-", "−");
}
