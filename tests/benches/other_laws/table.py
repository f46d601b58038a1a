#!/usr/bin/env python3
"""How often `palpate diagnose` names what is hidden in specimens of other base laws, some of them moved to either side, as a table.

    cargo build --release -p palpate
    python3 tests/benches/other_laws/table.py [--palpate FILE] [--seed N] [--only WORD]

The recordings are made by `specimens.py`, in an environment of its own under `target/`; each specimen has each effect in turn, and none.
"""

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "speed"))

import table as speed
from cases import EFFECTS, LAWS, MOTIONS

WORK = speed.TARGET / "other-laws"


def diagnosed(palpate, law, folder, model):
    """The answer of a diagnosis of the fitted law."""
    fit = [palpate, "fit", *law, folder, "-o", model, "--force"]
    subprocess.run(fit, check=True, capture_output=True)
    told = subprocess.run([palpate, "diagnose", "--model", model, "--json", folder], check=True, capture_output=True)
    return json.loads(told.stdout)


def judged(effect, answer):
    """In which column an answer belongs."""
    steps = answer["steps"]
    if effect == "none":
        return "right" if answer["verdict"] == "adequate" else "wrong"
    if not steps:
        return answer["verdict"]
    if steps[0]["effect"] == effect:
        return "right" if len(steps) == 1 else "more"
    return "in the set" if effect in steps[0]["credible_set"] else "wrong"


COLUMNS = ["right", "more", "in the set", "adequate", "unknown", "wrong"]


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--palpate", default=speed.TARGET / "release" / "palpate")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--only", default="", help="a specimen or a motion")
    given = options.parse_args()
    python = speed.environment(WORK / "python", ["numpy", "scipy"])
    print(f"seed {given.seed}\n\n| specimen | motion | {' | '.join(COLUMNS)} |\n|-|-|{'-|' * len(COLUMNS)}")
    others = []
    for kind, law in LAWS.items():
        for motion in MOTIONS[kind]:
            if given.only not in f"{kind} {motion}":
                continue
            counts = dict.fromkeys(COLUMNS, 0)
            for effect in EFFECTS:
                folder = WORK / f"{kind}-{motion}-{effect}-{given.seed}"
                shutil.rmtree(folder, ignore_errors=True)
                make = [python, HERE / "specimens.py", kind, motion, effect, str(given.seed), folder]
                subprocess.run(make, check=True)
                answer = diagnosed(given.palpate, law, folder, folder.with_suffix(".toml"))
                column = judged(effect, answer)
                counts[column] += 1
                if column != "right":
                    steps = [" or ".join(step["credible_set"]) for step in answer["steps"]]
                    others.append(f"{kind}, {motion}, {effect}: {answer['verdict']}, {' + '.join(steps) or 'nothing named'}")
            print(f"| `{' '.join(law)}` | {motion} | {' | '.join(str(counts[c]) for c in COLUMNS)} |", flush=True)
    print("\n" + "\n".join(others))


if __name__ == "__main__":
    main()
