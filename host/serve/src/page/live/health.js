// How the device is: what came and what did not, in words and numbers.

import { h, put } from "../dom.js";

const COUNTERS = {
  conversions_missed: "conversions missed", conversions_damaged: "conversions damaged", queue_full: "rows: queue full",
  link_full: "rows: link full", log_full: "log bytes lost", bytes_lost: "bytes from here lost",
  frames_damaged: "frames from here damaged", frames_missed: "frames from here missed",
};

const number = (value) => (value ?? 0).toLocaleString("en");

/** A panel; `show(health)` and `log(seconds, words)` change it, `frames(rate, delay)` tells of the page itself. */
export function healthPanel(root) {
  const state = h("p", { class: "state", role: "status" });
  const list = h("dl");
  const lost = h("dl");
  const device = h("p", { class: "muted device-log" });
  const log = h("ol", { class: "log", tabindex: 0, "aria-label": "Log of the session" });
  root.append(h("section", { class: "panel health", "aria-label": "Device" },
    h("h2", {}, "Device"), state, list,
    h("details", {}, h("summary", {}, "Lost in the device"), lost),
    h("h3", {}, "Log"), device, log));

  const cells = new Map();
  const line = (where, name, text, bad = false) => {
    if (!cells.has(name)) {
      const cell = h("dd");
      where.append(h("dt", {}, name), cell);
      cells.set(name, cell);
    }
    const cell = cells.get(name);
    put(cell, text);
    cell.classList.toggle("bad", bad);
  };
  const announce = (text, kind) => {
    put(state, text);
    state.dataset.kind = kind;
  };

  return {
    show(health) {
      const { status } = health;
      const words = health.log ? `The device's own log: ${health.log[0].toLowerCase()}${health.log.slice(1)}` : "";
      put(device, words);
      if (!health.linked) announce(`The device is gone; waiting for it. ${health.trouble ?? ""}`, "bad");
      else if (health.recording) announce(`Recording ${health.recording.file}, ${number(health.recording.rows)} rows`, "recording");
      else if (health.streaming) announce("Streaming", "good");
      else announce("Connected; the stream is stopped", "still");
      line(list, "rate", `${health.rate_hz.toFixed(1)} Hz`);
      line(list, "rows", number(health.rows));
      line(list, "rows lost", number(health.rows_lost), health.rows_lost > 0);
      line(list, "gaps", number(health.gaps), health.gaps > 0);
      line(list, "frames lost, damaged", `${number(health.frames_lost)}, ${number(health.frames_damaged)}`, health.frames_lost + health.frames_damaged > 0);
      line(list, "not shown in time", `${number(health.frames_dropped)} frames, ${number(health.rows_dropped)} rows`, health.frames_dropped > 0);
      line(list, "waiting", `${number(health.backlog_frames)} frames, at most ${number(health.backlog_frames_most)}`);
      if (health.replayed !== null) line(list, "replayed", `${(100 * health.replayed).toFixed(0)} %`);
      if (status) {
        const celsius = status.temperature_celsius;
        line(list, "temperature", celsius === null ? "no sensor" : `${celsius.toFixed(1)} °C`);
        line(list, "converter", status.converter ?? "OK", Boolean(status.converter));
        for (const [key, words] of Object.entries(COUNTERS)) line(lost, words, number(status.counters[key]), status.counters[key] > 0);
      }
      const who = health.device;
      if (who) line(list, "device", `${who.board}, firmware ${who.version}, serial ${who.serial}`);
    },
    frames(rate, delay) {
      line(list, "display", `${rate.toFixed(0)} frames/s, ${delay.toFixed(0)} ms behind`);
    },
    log(seconds, words) {
      const said = h("li", {}, h("span", { class: "muted" }, `${seconds.toFixed(1)} s `), words);
      log.prepend(said);
      if (log.children.length > 100) log.lastElementChild.remove();
    },
  };
}
