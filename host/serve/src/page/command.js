// The command that does what the page does, to read and to copy, and what became of it.

import { h } from "./dom.js";

/** A button that copies a command; where it is not known before, a function gives it, or null. */
export function copyButton(command) {
  const known = typeof command === "string";
  const words = known ? `Copy the command ${command}` : "Copy the command that does the same";
  const button = h("button", { type: "button", class: "copy", title: words, "aria-label": words, onclick: copy }, "$");
  async function copy() {
    const text = known ? command : await command();
    if (!text) return;
    await navigator.clipboard.writeText(text).catch(() => {});
    button.textContent = "copied";
    setTimeout(() => (button.textContent = "$"), 1200);
  }
  return button;
}

/** A command to read and to copy. */
export const commandLine = (command) => h("span", { class: "command" }, h("code", {}, command), copyButton(command));

/** A line that says what became of something. */
export function answer() {
  const root = h("p", { class: "answer", role: "status" });
  const put = (isBad, ...children) => {
    root.replaceChildren(...children);
    root.classList.toggle("bad", isBad);
  };
  return {
    root,
    say: (words, command) => put(false, words, ...(command ? [" The same: ", commandLine(command)] : [])),
    fail: (words) => put(true, words),
    clear: () => put(false),
  };
}
