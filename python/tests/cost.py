"""What a fit from Python costs over the library's own call, on the same traces and in the same run.

    python tests/cost.py PATH_OF_library_call TRACE...

takes turns, so that both see the same machine, and prints the least of each.
"""

from __future__ import annotations

import subprocess
import sys
import time

import palpate


def once(arrays: list[tuple[dict, dict]]) -> float:
    """One fit of arrays to its answer, ms."""
    began = time.perf_counter()
    sets = [
        palpate.DataSet.from_arrays(columns["time_s"], columns={k: v for k, v in columns.items() if k != "time_s"}, head=head)
        for columns, head in arrays
    ]
    data = sum(sets[1:], sets[0])
    found = palpate.fit(data, "fung")
    assert found.rms > 0
    return (time.perf_counter() - began) * 1e3


def main() -> None:
    library, *paths = sys.argv[1:]
    arrays = [({k: v.copy() for k, v in trace.to_dict().items()}, trace.head) for trace in palpate.read(paths)]
    ours, theirs = [], []
    for _ in range(5):
        ours.append(min(once(arrays) for _ in range(40)))
        theirs.append(float(subprocess.run([library, *paths], capture_output=True, text=True, check=True).stdout))
    mine, yardstick = min(ours), min(theirs)
    samples = sum(len(columns["time_s"]) for columns, _ in arrays)
    print(f"{len(arrays)} traces, {samples} samples: Python {mine:.2f} ms, library {yardstick:.2f} ms, {mine / yardstick - 1:+.1%}")


main()
