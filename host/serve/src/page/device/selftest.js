// The device's test of itself.

import { answer } from "../command.js";
import { h } from "../dom.js";
import { figure, panel, table } from "./parts.js";

export function selftestPanel(desk) {
  const { root, body, linked } = panel("Self-test");
  const said = answer();
  const found = h("div");
  const run = h("button", { type: "button", class: "device-main", onclick: test }, "Run the self-test");
  body.append(
    h("p", { class: "muted" }, "Converter, bridges and rate. Leave the fingertip alone meanwhile; the stream stops for a moment."),
    h("div", { class: "tools" }, run), said.root, found);

  async function test() {
    run.disabled = true;
    said.say("Testing …");
    try {
      const { command, result } = await desk.wish("self-test");
      const faults = result.faults.length;
      said.say(result.passed ? "Passed." : `${faults} ${faults === 1 ? "fault" : "faults"}.`, command);
      found.replaceChildren(
        table("What was tested", ["Item", "Result", "Measured", "Limits"], result.checks.map((check) => [
          check.name, verdict(check), check.measured, check.limits,
        ])),
        table(`Noise over ${result.samples} samples; it has no limit, for a touch is in it`, ["Gauge", "Mean (counts)", "Noise (counts)", "Noise (µε)"],
          result.mean_counts.map((mean, k) => [String(k + 1), figure(mean), figure(result.noise_counts[k], 1), figure(result.noise_ustrain[k], 3)])));
    } catch (error) {
      said.fail(error.message);
      found.replaceChildren();
    }
    run.disabled = false;
  }

  const verdict = ({ passed, fault }) => h("span", { class: passed ? "device-passed" : "device-failed" }, passed ? "✓ passed" : `✗ failed: ${fault}`);

  return { root, show: (state) => linked(state.linked) };
}
