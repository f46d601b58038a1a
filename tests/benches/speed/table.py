#!/usr/bin/env python3
"""CPU seconds of whole commands beside Python programs that do the same work, as a Markdown table.

    cargo build --release -p palpate
    python3 tests/benches/speed/table.py [--before OTHER/palpate] [--large] [--only WORD]

Data are made here, with fixed seeds; the rivals run in an environment of their own under `target/`. Everything is
measured in CPU seconds (user and system, of the process and its children), so that other work on the machine
changes little; rows of one table are measured in turn.
"""

import argparse
import os
import random
import resource
import shutil
import subprocess
import sys
from math import exp
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
WORK = TARGET / "speed"
PACKAGES = ["numpy", "scipy", "lmfit", "numba"]
# p, q, c1, c2, v1, v2 of Fung's law.
LAW = (0.08, 0.8, 0.25, 0.24, 4.0, 0.55)
# Longest run of a command that is waited for, s of CPU.
PATIENCE = 600


def press(samples, rate, deep, speed, seed, extra):
    """One press with a hold, as CSV: Fung's law, a force it lacks (`extra`, N at 1 mm), and white noise."""
    p, q, *rest = LAW
    shares, rates = rest[:2], rest[2:]
    step = 1.0 / rate
    decay = [exp(-v * step) for v in rates]
    gain = [(1 - a) / (v * step) for a, v in zip(decay, rates)]
    normal = random.Random(seed).gauss
    lasts = samples * step
    down, up = 0.1 * lasts, 0.75 * lasts
    states, before, lines = [0.0, 0.0], 0.0, ["time_s,displacement_mm,force_N"]
    for k in range(samples):
        time = k * step
        x = min(deep, speed * (time - down), deep - speed * (time - up))
        pressed = max(x, 0.0)
        elastic = p / (q + 1) * pressed ** (q + 1)
        states = [a * s + b * (elastic - before) for s, a, b in zip(states, decay, gain)]
        before = elastic
        force = elastic + sum(c * (s - elastic) for c, s in zip(shares, states))
        force = max(force, 0.0) + extra * pressed**1.5
        lines.append(f"{time:.6g},{x:.6f},{force + normal(0.0, 0.02):.6f}")
    return "\n".join(lines) + "\n"


def data(name, traces, samples, rate, extra=0.0):
    """A folder of traces, made once."""
    folder = WORK / name
    if not folder.exists():
        making = folder.with_suffix(".making")
        shutil.rmtree(making, ignore_errors=True)
        making.mkdir(parents=True)
        for k in range(traces):
            deep, speed = 4.0 + k % 10, 10.0 + 5.0 * (k % 10)
            (making / f"t{k:03}.csv").write_text(press(samples, rate, deep, speed, k, extra))
        making.rename(folder)
    return folder


def cpu(command):
    """CPU seconds, most memory in MB and output of a command; none where it takes too long."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE))
        with open(WORK / "error.txt", "w") as error:
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=error)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        with os.fdopen(write, "wb") as out:
            head = f"{done.returncode} {used.ru_utime + used.ru_stime} {used.ru_maxrss / 1024}\n"
            out.write(head.encode() + done.stdout)
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as out:
        head, _, output = out.read().partition(b"\n")
    os.waitpid(child, 0)
    code, seconds, memory = head.split()
    if int(code) < 0:
        return None, float(memory), b""
    # palpate answers 1 where it did the work and found something amiss.
    if int(code) > 1:
        sys.exit(f"{command}: {(WORK / 'error.txt').read_text()}")
    return float(seconds), float(memory), output


def environment():
    """The Python of the rivals, set up at the first run."""
    python = WORK / "python" / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", WORK / "python"], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
    return python


def shown(measured):
    seconds, memory, _ = measured
    return f"> {PATIENCE}" if seconds is None else f"{seconds:.3g} s, {memory:.0f} MB"


def commands(large):
    """What is measured: its name, and the arguments of palpate."""
    model = WORK / "model.toml"
    small = data("10x1400", 10, 1_400, 200.0)
    many = data("100x1400", 100, 1_400, 200.0)
    middle = data("10x10k", 10, 10_000, 500.0, extra=0.01)
    one = data("1x200k", 1, 200_000, 1000.0)
    rows = [
        ("`fit fung`, 10 × 1,400 rows", ["fit", "fung", small, "-o", model]),
        ("`fit fung`, 100 × 1,400 rows", ["fit", "fung", many]),
        ("`fit fung`, 10 × 10,000 rows", ["fit", "fung", middle]),
        ("`fit --all`, 10 × 1,400 rows", ["fit", "--all", small]),
        ("`compare`, 10 × 1,400 rows", ["compare", model, small]),
        ("`compare`, one trace of 200,000 rows", ["compare", model, one]),
        ("`diagnose`, 10 × 1,400 rows, nothing missing", ["diagnose", "--model", model, small]),
        ("`diagnose`, 10 × 10,000 rows, a force missing", ["diagnose", "--model", model, middle]),
    ]
    if large:
        big = data("10x100k", 10, 100_000, 1000.0)
        long = data("1x1M", 1, 1_000_000, 1000.0)
        rows += [
            ("`fit fung`, 10 × 100,000 rows", ["fit", "fung", big]),
            ("`compare`, one trace of 1,000,000 rows", ["compare", model, long]),
        ]
    return rows


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--palpate", default=TARGET / "release" / "palpate")
    options.add_argument("--before", help="another build, measured beside it")
    options.add_argument("--large", action="store_true", help="also the rows of a million samples")
    options.add_argument("--only", default="", help="rows whose name has this word")
    options.add_argument("--no-rivals", action="store_true")
    given = options.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    builds = [given.before, given.palpate] if given.before else [given.palpate]
    rows = commands(given.large)
    # The model that the others take is that of the first row.
    cpu([given.palpate, *rows[0][1]])
    print("| work | " + " | ".join(["before", "palpate"][-len(builds) :]) + " |")
    print("|-" * (len(builds) + 1) + "|")
    for name, arguments in rows:
        if given.only in name:
            found = [shown(cpu([build, *arguments])) for build in builds]
            print(f"| {name} | " + " | ".join(found) + " |", flush=True)
    if given.no_rivals:
        return
    python, folder = environment(), data("10x1400", 10, 1_400, 200.0)
    print("\n| one fit of Fung's law, 10 × 1,400 rows | the fit | the whole process | sum of squares |")
    print("|-|-|-|-|")
    whole = cpu([given.palpate, "fit", "fung", folder, "--json"])
    print(f"| palpate: no start given, covariance, ten traces left out | | {shown(whole)} | |")
    for rival in ["lmfit", "scipy-lm", "scipy-trf", "numba"]:
        found = cpu([python, HERE / "rivals.py", rival, folder])
        seconds, cost = found[2].decode().split()
        print(f"| {rival}: one start given | {float(seconds):.3g} s | {shown(found)} | {cost} |", flush=True)


if __name__ == "__main__":
    main()
