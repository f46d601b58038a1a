#!/usr/bin/env python3
"""What `palpate discover` finds beside PySINDy on the same residuals, as a table.

    cargo build --release -p palpate
    python3 tests/benches/discover/table.py

Six presses of two speeds and three depths, 100 Hz, with white noise of 0.02 N, for each effect of `cases.py`. The rival gets what the
fitted base law leaves, with displacement, velocity, predicted force and time. The error on traces left out is each trace predicted by a
fit to the others, over the noise; CPU seconds are of the whole command, base fit not included.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "speed"))

import table as speed
from cases import CASES, model

DATA = speed.ROOT / "tests/discover"
PACKAGES = ["numpy", "scipy", "pysindy==2.1.0"]
NOISE = 0.02


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--palpate", default=speed.TARGET / "release" / "palpate")
    palpate = options.parse_args().palpate
    speed.PATIENCE = 1_000
    python = speed.environment(speed.WORK / "discover-python", PACKAGES)

    def call(*words):
        done = subprocess.run([palpate, *map(str, words)], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr)
        return done.stdout

    print("| hidden | | found | error on traces left out / noise | terms | CPU |")
    print("|-|-|-|-|-|-|")
    for number, case in enumerate(CASES):
        folder = speed.WORK / "discover" / str(number)
        (folder / "traces").mkdir(parents=True, exist_ok=True)
        base = (DATA / "geared.toml").read_text().split("\n[[effect]]")[0]
        (folder / "truth.toml").write_text(model(case, base))
        pairs = []
        for depth in (4, 8, 12):
            for velocity in (5, 20):
                motion = (DATA / "press.toml").read_text()
                motion = motion.replace("DEPTH", str(depth)).replace("SPEED", str(velocity))
                (folder / "motion.toml").write_text(motion)
                trace = folder / "traces" / f"{depth}-mm-at-{velocity}.csv"
                trace.unlink(missing_ok=True)
                call("simulate", folder / "truth.toml", "--motion", folder / "motion.toml", "--noise", NOISE,
                     "--seed", f"{number + 1}{depth}{velocity}", "-o", trace)
                pairs.append((trace, folder / f"{depth}-{velocity}.csv"))
        fitted = folder / "fitted.toml"
        call("fit", "fung", folder / "traces", "-o", fitted, "--force")
        for trace, predicted in pairs:
            predicted.unlink(missing_ok=True)
            call("simulate", fitted, "--motion", trace, "-o", predicted)
        left = json.loads(call("compare", fitted, folder / "traces", "--json"))["rms"]
        print(f"| {case[0]} | `fung` alone | | {left / NOISE:.2f} fitted | | |")
        row(case, "palpate", [palpate, "discover", "--model", fitted, folder / "traces", "--json"])
        row(case, "PySINDy", [python, HERE / "rival.py", *(f"{a}={b}" for a, b in pairs)])


def row(case, name, command):
    seconds, _, output = speed.cpu([str(word) for word in command])
    answer = json.loads(output)
    if name == "palpate":
        if answer["outcome"] == "formula":
            words = "; ".join(f"`{it['expression']}`" for it in answer["formulas"])
            error, terms = answer["ladder"][-1]["heldout_rms"], len(answer["formulas"])
        else:
            words, error, terms = answer["outcome"], None, 0
    else:
        error, terms = answer["heldout_rms"], len(answer["terms"])
        words = ", ".join(answer["terms"][:3]) + (" …" if terms > 3 else "")
    told = "–" if error is None else f"{error / NOISE:.2f}"
    print(f"| {case[0]} | {name} | {words} | {told} | {terms} | {seconds:.1f} s |", flush=True)


if __name__ == "__main__":
    main()
