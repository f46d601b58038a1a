#!/usr/bin/env python3
"""CPU seconds and memory of `palpate survey fit` over many grasps, beside pandas and joblib over scipy, as a table.

    cargo build --release -p palpate
    python3 tests/benches/fleet/table.py [--grasps 10000,100000] [--rival 500] [--work DIR]

A grasp is a press with a hold: 5 s at 200 Hz, of a specimen and a depth of its own. All of a size lie in one Parquet file in
long format, which is made here with fixed seeds and takes some 8 MB for a thousand grasps. The rival fits the same law to the
same samples from a start 20 % off the truth, without a search; palpate is given no start. Rows of one table are measured in
turn, in CPU seconds of the process and its children.
"""

import argparse
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "speed"))

import table as speed

PACKAGES = ["numpy", "scipy", "pandas", "pyarrow", "joblib"]


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--palpate", default=speed.TARGET / "release" / "palpate")
    options.add_argument("--grasps", default="10000,100000")
    options.add_argument("--rival", type=int, default=500, help="grasps that the rival fits")
    options.add_argument("--work", type=Path, help="folder for data and results")
    given = options.parse_args()
    work = given.work or speed.WORK / "fleet"
    work.mkdir(parents=True, exist_ok=True)
    speed.WORK.mkdir(parents=True, exist_ok=True)
    speed.PATIENCE = 100_000
    python = speed.environment(speed.WORK / "fleet-python", PACKAGES)

    def data(grasps):
        path = work / f"{grasps}.parquet"
        if not path.exists():
            subprocess.run([python, HERE / "grasps.py", str(grasps), path], check=True)
        return path

    print("| grasps of 1,000 samples | CPU | memory | a grasp |")
    print("|-|-|-|-|")

    def row(name, grasps, command):
        seconds, memory, output = speed.cpu(command)
        each = f"{1000 * seconds / grasps:.2f} ms"
        print(f"| {name} | {seconds:.4g} s | {memory:.0f} MB | {each} |", flush=True)
        return seconds / grasps, output

    for grasps in [int(count) for count in given.grasps.split(",")]:
        results = work / f"results-{grasps}"
        command = [given.palpate, "survey", "fit", "fung", data(grasps), "--by", "trace_id"]
        ours, _ = row(f"palpate, {grasps:,}", grasps, [*command, "-o", results, "--force", "--json"])
    theirs, output = row(
        f"pandas, joblib, scipy, {given.rival:,}",
        given.rival,
        [python, HERE / "rival.py", data(given.rival), str(work / "rival.parquet")],
    )
    print(f"\n{theirs / ours:.0f} times the throughput on the same work. The rival: {output.decode().strip()}")


if __name__ == "__main__":
    main()
