// Files from this computer: dropped on the room or picked; foreign recordings with their mapping.

import { counted, h, number } from "../dom.js";

/** Most files of one drop, and most bytes of one, as the server has it. */
const [MOST, LARGEST] = [1_000, 64 * 1024 * 1024];

/** Buttons and what they open. `on`: `opened(set, model)`, `say(words)`, `fail(error)`. `listen(room)`: files may be dropped there. */
export function dropped(api, on) {
  const foreign = h("div", {});
  const input = (more) => {
    const made = h("input", { type: "file", multiple: true, tabindex: "-1", "aria-hidden": "true", ...more, onchange: () => {
      take([...made.files]);
      made.value = "";
    } });
    return made;
  };
  const [files, folder] = [input({ class: "lab-pick-files" }), input({ class: "lab-pick-folder", webkitdirectory: true })];
  const root = h("div", { class: "lab-files" },
    h("div", { class: "tools" },
      h("button", { type: "button", onclick: () => files.click() }, "Open files …"),
      h("button", { type: "button", onclick: () => folder.click() }, "Open a folder …"),
      h("span", { class: "lab-note" }, "or drop them here: traces, recordings, models, and files of other programs. They are kept in a new folder in the one opened."),
      files, folder), foreign);

  async function take(list) {
    const wanted = list.filter((file) => !file.name.startsWith("."));
    if (wanted.length > MOST) return on.fail({ message: `at most ${MOST} files at once; open their folder with \`palpate serve\`` });
    const large = wanted.find((file) => file.size > LARGEST);
    if (large) return on.fail({ message: `${large.name} is larger than 64 MiB; open its folder with \`palpate serve\`` });
    const told = [];
    try {
      for (const file of wanted) {
        on.say(`Taking ${told.length + 1} of ${counted(wanted.length, "file")}: ${file.name}`);
        const into = told[0]?.set ?? "";
        told.push(await api.upload(`/lab/drop?name=${encodeURIComponent(file.name)}&into=${encodeURIComponent(into)}`, file));
      }
    } catch (error) {
      on.fail(error);
    }
    if (told.length) await open(told);
  }

  async function open(told) {
    const of = (kind) => told.filter((file) => file.kind === kind);
    const { set } = told[0];
    const [recording] = of("recording");
    const model = of("model")[0];
    foreign.replaceChildren(...forms(set, of("foreign")));
    const opened = of("trace").length ? set : recording ? `${set}/${recording.file}` : null;
    on.say(`${counted(told.length, "file")} in ${set}/.`);
    await on.opened(opened, model ? `${set}/${model.file}` : null);
    if (of("foreign").length) foreign.scrollIntoView({ block: "nearest" });
  }

  /** One form for each foreign file. */
  function forms(set, list) {
    const all = list.map((file) => form(set, file, () => all));
    return all.map(({ place }) => place);
  }

  function form(set, { file, mapping, why }, others) {
    const text = h("textarea", { "aria-label": `Mapping of ${file}`, spellcheck: "false", value: mapping ?? `palpate-map = 1\n` });
    const seen = h("div", { role: "status" });
    const ask = (keep) => api.post("/lab/import", { set, file, mapping: text.value, keep });
    const place = h("section", { class: "lab-foreign", "aria-label": `Import ${file}` },
      h("h3", {}, `${file}: a file of another program`),
      h("p", { class: "lab-note" }, why ? `No mapping can be proposed: ${why}` : "The mapping below is a proposal from its first lines. Check every line, units above all; Preview shows what it makes of the file."),
      text,
      h("div", { class: "tools" },
        h("button", { type: "button", class: "lab-preview", onclick: preview }, "Preview"),
        h("button", { type: "button", class: "lab-import", onclick: () => keep([self]) }, "Import"),
        h("button", { type: "button", onclick: () => keep(others()) }, "Import all of these files so"),
        h("button", { type: "button", onclick: () => place.remove() }, "Leave it out")),
      seen);
    const self = { place, file, seen };

    async function preview() {
      try {
        seen.replaceChildren(...table(await ask(false)));
      } catch (error) {
        refuse(seen, error);
      }
    }

    /** Imports files with this mapping; what it does not fit stays. */
    async function keep(wanted) {
      let done = 0;
      for (const other of wanted.filter((other) => other.place.isConnected)) {
        try {
          await api.post("/lab/import", { set, file: other.file, mapping: text.value, keep: true });
          other.place.remove();
          done++;
        } catch (error) {
          refuse(other.seen, error);
        }
      }
      if (done) await on.opened(set, null);
    }

    return self;
  }

  const refuse = (seen, error) => seen.replaceChildren(h("p", { class: "lab-fault" }, error.message));

  function table({ tests, rows, missing, samples, gaps, columns, left_out: out, names, head }) {
    const several = tests > 1 ? `${counted(tests, "test")}, a trace each; the first is shown. ` : "";
    const lacking = missing > 0 ? ` ${counted(missing, "row")} left out that lack a value.` : "";
    const words = `${several}${counted(rows, "row")}, ${counted(samples, "sample")}, ${counted(gaps, "gap")} in time.${lacking}`;
    return [
      h("p", {}, words, out.length ? ` Left out: ${out.map(({ name, why }) => `${name} (${why})`).join(", ")}.` : ""),
      h("div", { class: "lab-scroll", tabindex: "0" }, h("table", {},
        h("thead", {}, h("tr", {}, names.map((name) => h("th", { scope: "col" }, name, h("br"), h("span", { class: "muted" }, `from ${columns.find(({ to }) => to === name)?.from ?? "the rate"}`))))),
        h("tbody", {}, head.map((row) => h("tr", {}, row.map((value) => h("td", {}, number(value, 5)))))))),
    ];
  }

  /** All files of what was dropped, folders opened. */
  async function filesOf(items) {
    const entries = [...items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
    const found = [];
    while (entries.length && found.length <= MOST) {
      const entry = entries.shift();
      if (entry.isFile) found.push(await new Promise((done, failed) => entry.file(done, failed)));
      else {
        const reader = entry.createReader();
        // A folder is told in parts, the last of them empty.
        for (let part = [null]; part.length; ) {
          part = await new Promise((done, failed) => reader.readEntries(done, failed));
          entries.push(...part);
        }
      }
    }
    return found;
  }

  function listen(room) {
    let depth = 0;
    const isOver = (by) => {
      depth = Math.max(depth + by, 0);
      root.classList.toggle("lab-over-drop", depth > 0);
    };
    const holdsFiles = (event) => event.dataTransfer?.types.includes("Files");
    room.addEventListener("dragenter", (event) => holdsFiles(event) && isOver(1));
    room.addEventListener("dragleave", (event) => holdsFiles(event) && isOver(-1));
    room.addEventListener("dragover", (event) => holdsFiles(event) && event.preventDefault());
    room.addEventListener("drop", async (event) => {
      if (!holdsFiles(event)) return;
      event.preventDefault();
      isOver(-depth);
      const { items, files: plain } = event.dataTransfer;
      const all = [...plain];
      try {
        const found = await filesOf(items);
        await take(found.length ? found : all);
      } catch (error) {
        on.fail(error);
      }
    });
  }

  return { root, listen };
}
