#!/usr/bin/env python3
"""The inner speed of fits beside Python's tools on the same work, as a Markdown table.

    python3 tests/benches/speed/inner.py [--inner BINARY]

palpate's rows are those of `cargo bench -p palpate-tests --bench inner`, or of that bench built before. All is processor time, the least of
many rounds, and measured in turn.
"""

import argparse
import subprocess

import table


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--inner", help="the bench, built before")
    given = options.parse_args()
    table.WORK.mkdir(parents=True, exist_ok=True)
    bench = [given.inner] if given.inner else ["cargo", "bench", "-q", "-p", "palpate-tests", "--bench", "inner"]
    ours = subprocess.run(bench, check=True, capture_output=True, text=True).stdout
    print("| work | palpate |\n|-|-|")
    for line in ours.splitlines():
        name, value = line.rsplit(maxsplit=1)
        print(f"| {name} | {value} |")
    python, folder = table.environment(), table.presses(10, 1_400, 200.0)
    print("\n| a rival, a start given | the fit | sum of squares |\n|-|-|-|")
    works = [("10 x 1,400 samples", [rival, folder]) for rival in table.FUNG]
    works += [("one hold of 860 samples", [rival]) for rival in ("curve_fit", "curve_fit-jacobian")]
    for work, arguments in works:
        command = [python, table.HERE / "rivals.py", *arguments]
        seconds, cost = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        print(f"| {work}, {arguments[0]} | {1000 * float(seconds):.3g} ms | {cost} |", flush=True)


if __name__ == "__main__":
    main()
