// Which serial ports there are, and what answers on them.

import { answer, copyButton } from "../command.js";
import { h } from "../dom.js";
import { panel, table } from "./parts.js";

export function portsPanel(desk) {
  const { root, body, linked } = panel("Devices on this computer", { live: false });
  const said = answer();
  const found = h("div", { class: "device-ports" });
  const look = h("button", { type: "button", onclick: search }, "Look again");
  body.append(
    h("p", { class: "muted" }, "Every serial port is asked who is there; the one that is open stays as it is."),
    found, h("div", { class: "tools" }, look, copyButton("palpate device list")), said.root);

  async function search() {
    look.disabled = true;
    said.say("Asking the ports …");
    try {
      const { ports } = await desk.api.get("/device/ports");
      found.replaceChildren(table("Ports", ["Port", "What answers", "Firmware"], ports.map(row)));
      said.say(ports.length === 1 ? "There is no other serial port." : `${ports.length} ports.`);
    } catch (error) {
      said.fail(error.message);
    }
    look.disabled = false;
  }

  const row = ({ port, device, error, release, ours }) => [
    h("span", {}, h("code", {}, port), ours ? " (this one)" : ""),
    device ? `${device.board}, firmware ${device.version}, serial ${device.serial}` : error ?? "nothing has answered yet",
    release ? `${release.words} ${release.advice}` : "–",
  ];

  let before = null;
  search();
  return {
    root,
    show({ linked: is }) {
      linked(is);
      if (before !== null && before !== is) search();
      before = is;
    },
  };
}
