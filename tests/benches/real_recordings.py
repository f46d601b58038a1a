"""Runs `palpate` on recordings by others, from the files as published to the answer, and prints the first table of
docs/real-recordings.md.

    python3 tests/benches/real_recordings.py FOLDER [NAME ...]

FOLDER holds the recordings in the folders of SETS; where each comes from stands in docs/real-recordings.md. What is not there is left
out and said. PALPATE names the program [target/release/palpate].
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PALPATE = os.environ.get("PALPATE", str(ROOT / "target/release/palpate"))
MAPPINGS = ROOT / "tests/mappings"

# Name, how the contact ends, mapping, and the files of each trace: several files of one trace are joined by time.
SETS = [
    ("Ecoflex pads", "clamp", "adhesive-pad", [f"ecoflex-adhesive/retract-{v}-um-s/*.csv" for v in (30, 300, 1000, 3000)]),
    ("titin", "bonded", "titin-ramp-hold", [f"titin-ramp-hold/AvgRelaxed_{t}.csv" for t in ("100s", "10s", "1s", "0.1s")]),
    ("titin, mavacamten", "bonded", "titin-ramp-hold", [f"titin-ramp-hold/AvgRelaxedMavaSet_{t}.csv" for t in ("100s", "10s", "1s", "0.1s")]),
    ("titin, activated", "bonded", "titin-ramp-hold", [f"titin-ramp-hold/AvgpCa4.4_{t}.csv" for t in ("100s", "10s", "1s", "0.1s")]),
    ("VHB to 1.5", "bonded", "tape-tension", [f"vhb4910/{n}.csv" for n in ("0d01_1d5", "0d03_1d5_1", "0d03_1d5_2", "0d05_1d5_1")]),
    ("VHB to 2.5", "bonded", "tape-tension", [f"vhb4910/{n}.csv" for n in ("0d01_2d5", "0d03_2d5", "0d05_2d5_1", "0d05_2d5_2")]),
    ("VHB holds", "bonded", "tape-tension", [f"vhb4910/holds/{n}.csv" for n in ("1d5", "2d0", "3d0")]),
    ("VHB hold at 1.5", "bonded", "tape-tension", ["vhb4910/holds/1d5.csv"]),
    ("adhesive in shear", "bonded", "oca-shear", [f"oca-shear-cyclic/shear_relaxation_{n}.csv" for n in (1, 2, 5)]),
    ("adhesive in shear, up and down", "bonded", "oca-shear", ["oca-shear-cyclic/shear_relaxation.csv"]),
    ("latex", "bonded", "rubber-tension", ["rubber-membrane-24h/rubber_stress_relaxation.csv"]),
]


def run(*arguments):
    """What the program prints; where it refuses, its words."""
    return subprocess.run([PALPATE, *map(str, arguments)], capture_output=True, text=True)


def imported(folder, pattern, mapping, out):
    """A trace from the files of a pattern; none where there are none."""
    files = sorted(folder.glob(pattern))
    if not files:
        return None
    told = run("import", *files, "--map", MAPPINGS / f"{mapping}.toml", "-o", out)
    # The same instrument writes its words in another encoding on another day.
    if told.returncode and (MAPPINGS / f"{mapping}-utf8.toml").exists():
        told = run("import", *files, "--map", MAPPINGS / f"{mapping}-utf8.toml", "-o", out)
    if told.returncode:
        sys.exit(f"{pattern}: {told.stderr}")
    if mapping == "titin-ramp-hold":
        in_length_units(out)
    return out


def in_length_units(path):
    """The same trace with the stretch from its beginning as displacement and the stress as force: a factor changes no answer."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    table = [dict(zip(names, map(float, line.split(",")))) for line in lines[1:]]
    begin = table[0]["stretch_L0"]
    rows = [f"{row['time_s']!r},{row['stretch_L0'] - begin!r},{row['stress_kPa']!r}" for row in table]
    path.write_text("\n".join(["time_s,displacement_mm,force_N", *rows, ""]))


def rows(name, answer, seconds):
    """The rungs of an answer as rows of a table."""
    number = lambda value: "–" if value is None else f"{value:.4g}"
    first = [("base law", answer["base_rms"], (answer["steps"] or [{}])[0].get("heldout_rms_before"))]
    steps = [(" or ".join(s["credible_set"]), s["rms_after"], s["heldout_rms_after"]) for s in answer["steps"]]
    for k, (rung, fitted, held_out) in enumerate(first + steps):
        head = (name, answer["verdict"], f"{seconds:.1f}") if k == 0 else ("", "", "")
        print(f"| {' | '.join(head)} | {rung} | {number(fitted)} | {number(held_out)} |", flush=True)
    return [held_out for _, _, held_out in first + steps if held_out is not None]


def main(folder, wanted):
    print("| recording | verdict | CPU (s) | rung | fitted (N) | held out (N) |\n|-|-|-|-|-|-|")
    rises = []
    with tempfile.TemporaryDirectory() as place:
        for index, (name, separation, mapping, patterns) in enumerate(SETS):
            if wanted and name not in wanted:
                continue
            outs = [Path(place) / f"{index}-{k}.csv" for k in range(len(patterns))]
            traces = [imported(folder, pattern, mapping, out) for pattern, out in zip(patterns, outs)]
            if None in traces:
                print(f"| {name} | not in {folder} | | | | |")
                continue
            model = Path(place) / f"{index}.toml"
            fitted = run("fit", "fung", "--separation", separation, *traces, "-o", model)
            if fitted.returncode:
                sys.exit(f"{name}: {fitted.stderr}")
            used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
            before = used()
            told = run("diagnose", "--model", model, *traces, "--json")
            if told.returncode:
                sys.exit(f"{name}: {told.stderr}")
            held_out = rows(name, json.loads(told.stdout), used() - before)
            rises += [name] if any(b > a for a, b in zip(held_out, held_out[1:])) else []
    print(f"\nRecordings on which a rung raises the error on traces left out: {', '.join(rises) or 'none'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
