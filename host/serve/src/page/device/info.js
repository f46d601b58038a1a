// Who the device is, how it is, and whether its firmware goes with this program.

import { copyButton } from "../command.js";
import { h, number, put } from "../dom.js";
import { figure, panel, table } from "./parts.js";

export function infoPanel(desk) {
  const { root, body, linked } = panel("Info");
  const release = h("p", { class: "device-release", role: "status" });
  const list = h("dl");
  const gauges = h("div");
  const lost = h("dl");
  body.append(release, list, gauges,
    h("p", { class: "muted" }, "A device keeps neither the date nor the quality of its calibration: keep the points it came from."),
    h("details", {}, h("summary", {}, "Lost since the reset"), lost),
    h("div", { class: "tools" }, copyButton(desk.command("palpate device info"))));

  const cells = new Map();
  const say = (where, name, text, bad = false) => {
    if (!cells.has(name)) {
      cells.set(name, h("dd"));
      where.append(h("dt", {}, name), cells.get(name));
    }
    put(cells.get(name), text);
    cells.get(name).classList.toggle("bad", bad);
  };
  let shown = null;
  const showGauges = (rows) => {
    if (!shown) {
      const made = table("Gauges", HEADS, rows);
      gauges.replaceChildren(made);
      shown = [...made.querySelectorAll("tbody tr")].map((line) => [...line.children]);
    }
    rows.forEach((texts, k) => texts.forEach((text, at) => put(shown[k][at], text)));
  };

  return {
    root,
    show(state) {
      const { device, status, settings, bench } = state;
      linked(state.linked);
      if (bench.release) {
        put(release, `${bench.release.words} ${bench.release.advice}`);
        release.dataset.kind = bench.release.speaks ? "good" : "bad";
      }
      if (!device || !status || !settings) return;
      say(list, "device", `${device.board}, ${device.channels} gauges, serial ${device.serial}`);
      say(list, "firmware", device.version + (device.git ? ` (${device.git})` : ""));
      say(list, "port", desk.port);
      say(list, "clock", device.clock);
      say(list, "reset cause", device.reset);
      if (device.panic) say(list, "last panic", device.panic, true);
      say(list, "converter", `${status.converter ?? "OK"}, clock ${number(device.converter_clock_hz / 1e6)} MHz`, Boolean(status.converter));
      const now = state.streaming ? `now ${figure(state.rate_hz, 1)} Hz${desk.isReplay ? ", as fast as the trace" : ""}` : "the stream is stopped";
      say(list, "rate", `set ${number(settings.rate_hz, 6)} Hz, ${now}`);
      const celsius = status.temperature_celsius;
      say(list, "temperature", celsius === null ? "no sensor" : `${figure(celsius, 1)} °C`);
      if (status.stack_used_bytes > 0) say(list, "stack used", `${figure(status.stack_used_bytes)} bytes at most`);
      for (const [name, count] of Object.entries(status.counters)) say(lost, name.replaceAll("_", " "), figure(count), count > 0);
      showGauges(settings.gauges.map((gauge, k) => row(gauge, k, bench.counts?.[k])));
    },
  };
}

const HEADS = ["Gauge", "Gain", "µε per 1000 counts", "Offset (counts)", "Tare (µε)", "Temperature (µε/°C)", "Now (counts)", "± scatter"];

const row = (gauge, k, now) => [
  String(k + 1), String(gauge.gain), number(1e3 * gauge.ustrain_per_count, 6), figure(gauge.offset_counts), figure(gauge.tare_ustrain, 1),
  gauge.temperature_coefficient_ustrain_per_celsius === 0 ? "none" : `${number(gauge.temperature_coefficient_ustrain_per_celsius)} from ${number(gauge.reference_celsius)} °C`,
  now ? figure(now.counts) : "–", now ? figure(now.deviation) : "–",
];
