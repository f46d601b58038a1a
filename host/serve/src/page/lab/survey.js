// A survey: what is missing in how many groups, and each group one click away.

import { choice, h, number } from "../dom.js";

/** Rows that are drawn; the choice above the table narrows them down. */
const DRAWN = 100;

/** The panel. `draft` has the `which` and `text` that narrow the groups down; `act` has `start(task)`, `copy(task)` and `redraw()`. */
export function survey(state, draft, act) {
  const { survey: found, surveys } = state;
  const open = (name) => act.start({ survey: name });
  const names = surveys.map((name) => [name, name || state.folder]);
  const picked = found?.name ?? surveys[0];
  return h(
    "div",
    {},
    h("div", { class: "tools" },
      choice("Results", names, picked, open),
      found ? null : h("button", { class: "lab-survey-open", onclick: () => open(picked) }, "Open the survey"),
      act.copy({ survey: picked })),
    found ? groups(found, draft, act) : null,
  );
}

function groups(found, draft, act) {
  const said = Object.entries(found.verdicts ?? {}).map(([verdict, count]) => `${count} ${verdict}`).join(", ");
  const failed = found.refused + found.failed;
  const effects = [...new Set(found.listed.flatMap((of) => of.effects))].sort();
  const verdicts = [...new Set(found.listed.map((of) => of.verdict).filter(Boolean))].sort();
  const which = [["", "all groups"], ...effects.map((name) => [`effect ${name}`, `${name} is missing`]), ...verdicts.map((name) => [`verdict ${name}`, name]), ...(failed ? [["failed", "without an answer"]] : [])];
  const text = h("input", { type: "search", value: draft.text ?? "", "aria-label": "Groups whose name has", placeholder: "part of a name" });
  text.addEventListener("change", () => {
    draft.text = text.value;
    act.redraw();
  });
  const wanted = found.listed.filter((of) => fits(of, draft.which ?? "") && of.key.includes(draft.text ?? ""));
  const numeric = found.listed.some((of) => of.rms !== null);
  return h(
    "div",
    {},
    h("p", {}, `${found.groups_in_all} groups by ${found.by.join(", ")}${said ? `: ${said}` : ""}${failed ? `; ${failed} without an answer` : ""}.${found.finished ? "" : " The survey is not finished."}`),
    h("div", { class: "tools" }, choice("Show", which, draft.which ?? "", (value) => {
      draft.which = value;
      act.redraw();
    }), text),
    h("div", { class: "lab-scroll" }, h(
      "table",
      { class: "lab-figures" },
      h("caption", {}, wanted.length > DRAWN ? `The first ${DRAWN} of ${wanted.length}` : `${wanted.length} of ${found.groups_in_all}`),
      h("thead", {}, h("tr", {}, ["group", "answer", numeric ? "RMS" : null, "traces", ""].filter((name) => name !== null).map((name) => h("th", { scope: "col", class: ["RMS", "traces"].includes(name) ? "lab-number" : null }, name || h("span", { class: "spoken" }, "open"))))),
      h("tbody", {}, wanted.slice(0, DRAWN).map((of) => row(of, found, numeric, act))),
    )),
  );
}

function fits(of, which) {
  if (which === "") return true;
  if (which === "failed") return of.status !== "done";
  const [kind, ...name] = which.split(" ");
  return kind === "effect" ? of.effects.includes(name.join(" ")) : of.verdict === name.join(" ");
}

function row(of, found, numeric, act) {
  const answer = of.effects.length ? `${of.verdict}: ${of.effects.join(", ")}` : (of.verdict ?? of.reason ?? of.status);
  const task = { group: { survey: found.name, group: of.group } };
  return h(
    "tr",
    {},
    h("th", { scope: "row" }, of.key),
    h("td", {}, answer),
    numeric ? h("td", { class: "lab-number" }, of.rms === null ? "–" : `${number(of.rms)} ${of.unit ?? ""}`) : null,
    h("td", { class: "lab-number" }, String(of.traces)),
    h("td", {}, of.traces ? h("span", { class: "command" }, h("button", { class: "lab-group", onclick: () => act.start(task) }, "Open", h("span", { class: "spoken" }, ` ${of.key}`)), act.copy(task)) : null),
  );
}
