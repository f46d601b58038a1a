// The room of the device itself: which there are, who this one is, its settings, its calibration, its test.

import { h, put } from "./dom.js";
import { portsPanel } from "./device/ports.js";
import { infoPanel } from "./device/info.js";
import { settingsPanel } from "./device/settings.js";
import { calibrationPanel } from "./device/calibration.js";
import { selftestPanel } from "./device/selftest.js";

export function open(root, api) {
  let close = () => {};
  let closed = false;
  const state = h("p", { class: "device-state", role: "status" }, "Asking …");
  const room = h("div", { class: "device" }, state);
  root.append(room);

  begin();
  async function begin() {
    let about, rooms;
    try {
      [about, { rooms }] = await Promise.all([api.get("/live/about"), api.get("/rooms")]);
    } catch (error) {
      put(state, error.message);
      if (!closed) setTimeout(begin, 1_000);
      return;
    }
    if (closed) return;
    const desk = {
      api,
      port: about.port,
      isReplay: about.source === "replay",
      command: (call) => `${call} --port ${about.port}`,
      wish: (what) => api.post("/live/wish", what),
      hasLab: rooms.some((room) => room.name === "lab"),
      relaxation: () => api.get("/lab/relaxation"),
    };
    const [calibration, settings, info, selftest, ports] = [calibrationPanel, settingsPanel, infoPanel, selftestPanel, portsPanel].map((panel) => panel(desk));
    room.append(h("div", { class: "device-columns" },
      h("div", { class: "device-column" }, calibration.root, settings.root),
      h("div", { class: "device-column" }, info.root, selftest.root, ports.root)));
    const panels = [calibration, settings, info, selftest, ports];
    let last = null;
    const show = (told) => {
      last = told;
      say(told, about);
      panels.forEach((panel) => panel.show(told));
    };
    close = api.socket("/device/watch", (data) => show(JSON.parse(data)), (isOpen, why) => {
      if (!isOpen && last) show({ ...last, linked: false, streaming: false, trouble: why });
    });
  }

  function say({ linked, streaming, recording, trouble }, { source }) {
    const what = { simulated: "A simulated device", replay: "A replayed trace in a simulated device" }[source] ?? "The device";
    room.classList.toggle("gone", !linked);
    state.dataset.kind = linked ? "good" : "bad";
    if (!linked) put(state, `The device is gone; waiting for it. ${trouble ?? ""}`);
    else if (recording) put(state, `${what} is here and ${recording.file} is being recorded: calibration, self-test and saving wait until it ends.`);
    else put(state, `${what} is here; ${streaming ? "it streams" : "the stream is stopped"}.`);
  }

  return () => {
    closed = true;
    close();
  };
}
