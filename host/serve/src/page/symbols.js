// Formulas, symbols and units as they are printed: powers stand higher, indices lower.

import { h } from "./dom.js";

/** A symbol of one letter with its index: `c0`, `ci`, `x_max`. */
const INDEXED = /(?<![\p{L}\d_])(?!pi(?![\p{L}\d_]))(\p{L})(\d{1,2}|i|_[\p{L}\d]{1,4})(?![\p{L}\d_])/gu;

/** Where the bracket that opens at a place is closed. */
function closing(text, open) {
  let depth = 0;
  for (let at = open; at < text.length; at++) {
    if (text[at] === "(") depth++;
    else if (text[at] === ")" && --depth === 0) return at;
  }
  return -1;
}

/** The power that begins after a `^`: what stands in its bracket, or the one word; null for none. */
function power(text, from) {
  if (text[from] === "(") {
    const to = closing(text, from);
    return to < 0 ? null : { inside: text.slice(from + 1, to), after: to + 1 };
  }
  const word = /^[−-]?[\p{L}\d.]+/u.exec(text.slice(from));
  return word && { inside: word[0], after: from + word[0].length };
}

function indices(text) {
  const parts = [];
  let last = 0;
  for (const { 0: whole, 1: letter, 2: index, index: at } of text.matchAll(INDEXED)) {
    parts.push(text.slice(last, at), letter, h("sub", {}, index.replace("_", "")));
    last = at + whole.length;
  }
  return [...parts, text.slice(last)].filter((part) => part !== "");
}

/** The text as nodes, for `h`. */
export function symbols(text) {
  const at = text.indexOf("^");
  const raised = at < 0 ? null : power(text, at + 1);
  if (!raised) return indices(text);
  return [...indices(text.slice(0, at)), h("sup", {}, symbols(raised.inside)), ...symbols(text.slice(raised.after))];
}
