// How the device is: what came and what did not, in words and numbers.

const COUNTERS = {
  conversions_missed: "conversions missed", conversions_damaged: "conversions damaged", queue_full: "rows: queue full",
  link_full: "rows: link full", log_full: "log bytes lost", bytes_lost: "bytes from here lost",
  frames_damaged: "frames from here damaged", frames_missed: "frames from here missed",
};

const number = (value) => (value ?? 0).toLocaleString("en");

export function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key.startsWith("aria-") || key === "role" || key === "for") made.setAttribute(key, value);
    else made[key] = value;
  }
  made.append(...children);
  return made;
}

/** A panel; `show(health)` and `log(seconds, words)` change it, `frames(rate, delay)` tells of the page itself. */
export function healthPanel(root) {
  const state = element("p", { className: "state", role: "status" });
  const list = element("dl");
  const lost = element("dl");
  const device = element("p", { className: "muted device-log" });
  const log = element("ol", { className: "log", tabIndex: 0, "aria-label": "Log of the session" });
  root.append(element("section", { className: "panel health", "aria-label": "Device" },
    element("h2", { textContent: "Device" }), state, list,
    element("details", {}, element("summary", { textContent: "Lost in the device" }), lost),
    element("h3", { textContent: "Log" }), device, log));

  const cells = new Map();
  const put = (where, name, text, bad = false) => {
    if (!cells.has(name)) {
      const cell = element("dd");
      where.append(element("dt", { textContent: name }), cell);
      cells.set(name, cell);
    }
    const cell = cells.get(name);
    if (cell.textContent !== text) cell.textContent = text;
    cell.classList.toggle("bad", bad);
  };
  const announce = (text, kind) => {
    if (state.textContent !== text) state.textContent = text;
    state.dataset.kind = kind;
  };

  return {
    show(health) {
      const { status } = health;
      const words = health.log ? `The device's own log: ${health.log[0].toLowerCase()}${health.log.slice(1)}` : "";
      if (device.textContent !== words) device.textContent = words;
      if (!health.linked) announce(`The device is gone; waiting for it. ${health.trouble ?? ""}`, "bad");
      else if (health.recording) announce(`Recording ${health.recording.file}, ${number(health.recording.rows)} rows`, "recording");
      else if (health.streaming) announce("Streaming", "good");
      else announce("Connected; the stream is stopped", "still");
      put(list, "rate", `${health.rate_hz.toFixed(1)} Hz`);
      put(list, "rows", number(health.rows));
      put(list, "rows lost", number(health.rows_lost), health.rows_lost > 0);
      put(list, "gaps", number(health.gaps), health.gaps > 0);
      put(list, "frames lost, damaged", `${number(health.frames_lost)}, ${number(health.frames_damaged)}`, health.frames_lost + health.frames_damaged > 0);
      put(list, "not shown in time", `${number(health.frames_dropped)} frames, ${number(health.rows_dropped)} rows`, health.frames_dropped > 0);
      put(list, "waiting", `${number(health.backlog_frames)} frames, at most ${number(health.backlog_frames_most)}`);
      if (health.replayed !== null) put(list, "replayed", `${(100 * health.replayed).toFixed(0)} %`);
      if (status) {
        const celsius = status.temperature_celsius;
        put(list, "temperature", celsius === null ? "no sensor" : `${celsius.toFixed(1)} °C`);
        put(list, "converter", status.converter ?? "as it should be", Boolean(status.converter));
        for (const [key, words] of Object.entries(COUNTERS)) put(lost, words, number(status.counters[key]), status.counters[key] > 0);
      }
      const who = health.device;
      if (who) put(list, "device", `${who.board}, firmware ${who.version}, serial ${who.serial}`);
    },
    frames(rate, delay) {
      put(list, "display", `${rate.toFixed(0)} frames/s, ${delay.toFixed(0)} ms behind`);
    },
    log(seconds, words) {
      const line = element("li", {}, element("span", { className: "muted", textContent: `${seconds.toFixed(1)} s ` }), words);
      log.prepend(line);
      if (log.children.length > 100) log.lastElementChild.remove();
    },
  };
}
