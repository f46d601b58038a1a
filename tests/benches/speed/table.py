#!/usr/bin/env python3
"""CPU seconds of whole commands beside Python programs that do the same work, as a Markdown table.

    cargo build --release -p palpate
    python3 tests/benches/speed/table.py [--before OTHER/palpate] [--large] [--huge] [--only WORD]

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
from math import exp, pi, sin
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
WORK = TARGET / "speed"
PACKAGES = ["numpy", "scipy", "lmfit", "numba", "jax"]
# Rivals that fit Fung's law.
FUNG = ["lmfit", "scipy-lm", "scipy-trf", "numba", "jax"]
# p, q, c1, c2, v1, v2 of Fung's law.
LAW = (0.08, 0.8, 0.25, 0.24, 4.0, 0.55)
# Longest run of a command that is waited for, s of CPU.
PATIENCE = 200


def force_of(samples, step, course, rates, shares):
    """Force of Fung's law along a course of compressions, sample by sample."""
    p, q = LAW[:2]
    decay = [exp(-v * step) for v in rates]
    gain = [(1 - a) / (v * step) for a, v in zip(decay, rates)]
    states, before = [0.0] * len(rates), 0.0
    for k in range(samples):
        x = course(k * step)
        elastic = p / (q + 1) * max(x, 0.0) ** (q + 1)
        states = [a * s + b * (elastic - before) for s, a, b in zip(states, decay, gain)]
        before = elastic
        yield k * step, x, max(elastic + sum(c * (s - elastic) for c, s in zip(shares, states)), 0.0)


def table(rows, seed, noise, extra=lambda x: 0.0):
    """Rows as CSV with white noise, and with a force that the law lacks."""
    normal = random.Random(seed).gauss
    lines = ["time_s,displacement_mm,force_N"]
    lines += [f"{t:.6g},{x:.6f},{f + extra(x) + normal(0.0, noise):.6f}" for t, x, f in rows]
    return "\n".join(lines) + "\n"


def press(samples, rate, k, extra):
    """The k-th press with a hold, as CSV."""
    step = 1.0 / rate
    lasts = samples * step
    deep, speed, down, up = 4.0 + k % 10, 10.0 + 5.0 * (k % 10), 0.1 * lasts, 0.75 * lasts
    course = lambda t: min(deep, speed * (t - down), deep - speed * (t - up))
    return table(force_of(samples, step, course, LAW[4:], LAW[2:4]), k, 0.02, extra)


def hold(samples, rate, k):
    """The k-th of long holds: relaxation over four decades, which two exponentials cannot follow."""
    course = lambda t: min(4.0 + k, 20.0 * t - 1.0)
    rates, shares = (20.0, 2.0, 0.2, 0.02), (0.1, 0.12, 0.1, 0.08)
    return table(force_of(samples, 1.0 / rate, course, rates, shares), k, 0.005)


def folder(name, traces, make):
    """A folder of traces, made once."""
    made = WORK / name
    if not made.exists():
        making = made.with_suffix(".making")
        shutil.rmtree(making, ignore_errors=True)
        making.mkdir(parents=True)
        for k in range(traces):
            (making / f"t{k:03}.csv").write_text(make(k))
        making.rename(made)
    return made


def presses(traces, samples, rate, extra=lambda x: 0.0, name=""):
    return folder(f"{traces}x{samples}{name}", traces, lambda k: press(samples, rate, k, extra))


def practice(palpate, name, *arguments):
    """A practice set of ten traces with something hidden, made once."""
    made = WORK / name
    if not made.exists():
        subprocess.run([palpate, "hide", *arguments, "-o", made], check=True, stdout=subprocess.DEVNULL)
    return made


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


def environment(folder=WORK / "python", packages=PACKAGES):
    """A Python with these packages, set up at the first run."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *packages], check=True)
    return python


def shown(measured):
    seconds, memory, _ = measured
    return f"> {PATIENCE}" if seconds is None else f"{seconds:.3g} s, {memory:.0f} MB"


def commands(palpate, large, huge):
    """What is measured: its name, the arguments of palpate, and the CPU seconds that it is to take."""
    lacks = lambda x: 0.01 * max(x, 0.0) ** 1.5
    outside = lambda x: 0.05 * sin(2 * pi * x / 0.8) if x > 0 else 0.0
    middle_outside = presses(10, 10_000, 500.0, outside, "-outside")
    small, many = presses(10, 1_400, 200.0), presses(100, 1_400, 200.0)
    middle = presses(10, 10_000, 500.0, lacks, "-lacking")
    one, hour = presses(1, 200_000, 1000.0), folder("hold", 1, lambda k: hold(90_104, 50.0, k))
    holds = folder("holds", 3, lambda k: hold(72_000, 50.0, k))
    hidden = {
        "one effect": practice(palpate, "one-effect", "mullins", "--seed", "7"),
        "two effects": practice(palpate, "two-effects", "--any", "2", "--seed", "11"),
        "outside the library": presses(10, 1_900, 200.0, outside, "-outside"),
    }
    fits = {"small": small, "middle": middle, "hour": hour, "holds": holds, "one": one, **hidden}
    fits |= {"middle-outside": middle_outside}
    models = {name: WORK / f"{name.replace(' ', '-')}.toml" for name in fits}
    for name, traces in fits.items():
        if not models[name].exists():
            cpu([palpate, "fit", "fung", traces, "-o", models[name]])
    diagnose = lambda name: ["diagnose", "--model", models[name], fits[name]]
    wanted = {"one effect": "0.35", "two effects": "0.8", "outside the library": "1.5"}
    rows = [
        (f"`diagnose`, ten traces, 19,000 samples, {name}", diagnose(name), wanted[name])
        for name in hidden
    ]
    rows += [
        ("`diagnose`, 10 × 1,400 rows, nothing missing", diagnose("small"), ""),
        ("`diagnose`, 10 × 10,000 rows, a force missing", diagnose("middle"), "2"),
        ("`diagnose`, 10 × 10,000 rows, outside the library", diagnose("middle-outside"), "2"),
        ("`diagnose`, one hold of 90,104 rows", diagnose("hour"), "6"),
        ("`diagnose`, three holds, 216,000 rows", diagnose("holds"), "12"),
        ("`fit fung`, 10 × 1,400 rows", ["fit", "fung", small], ""),
        ("`fit fung`, 100 × 1,400 rows", ["fit", "fung", many], "0.4"),
        ("`fit fung`, 10 × 10,000 rows", ["fit", "fung", middle], ""),
        ("`fit --all`, 10 × 1,400 rows", ["fit", "--all", small], ""),
        ("`compare`, 10 × 1,400 rows", ["compare", models["small"], small], ""),
        ("`compare`, one trace of 200,000 rows", ["compare", models["one"], one], ""),
        ("`relaxation`, one hold of 90,104 rows", ["relaxation", hour], ""),
    ]
    if large:
        big = presses(10, 100_000, 1000.0, lacks, "-lacking")
        long = presses(1, 1_000_000, 1000.0)
        eight = folder("eight-holds", 8, lambda k: hold(63_250, 50.0, k))
        rows += [
            ("`fit --all`, 10 × 2,350 rows", ["fit", "--all", presses(10, 2_350, 200.0)], "8"),
            ("`fit fung`, 10 × 100,000 rows", ["fit", "fung", big], "2"),
            ("`diagnose`, 10 × 100,000 rows", ["diagnose", "--model", models["middle"], big], "8"),
            ("`compare`, one trace of 1,000,000 rows", ["compare", models["one"], long], "1.5"),
            ("`relaxation`, eight holds, 506,000 rows", ["relaxation", eight], "4"),
        ]
    if huge:
        most = presses(100, 100_000, 1000.0, lacks, "-lacking")
        rows.append(
            ("`diagnose`, 100 × 100,000 rows", ["diagnose", "--model", models["middle"], most], "60, 1 GB")
        )
    return rows


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--palpate", default=TARGET / "release" / "palpate")
    options.add_argument("--before", help="another build, measured beside it")
    options.add_argument("--large", action="store_true", help="also the rows of a million samples")
    options.add_argument("--huge", action="store_true", help="also those of ten million")
    options.add_argument("--only", default="", help="rows whose name has this word")
    options.add_argument("--no-rivals", action="store_true")
    given = options.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    builds = [given.before, given.palpate] if given.before else [given.palpate]
    rows = commands(given.palpate, given.large, given.huge)
    print("| work | " + " | ".join(["before", "palpate"][-len(builds) :]) + " | wanted, s |")
    print("|-" * (len(builds) + 2) + "|")
    for name, arguments, wanted in rows:
        if given.only in name:
            found = [shown(cpu([build, *arguments])) for build in builds]
            print(f"| {name} | " + " | ".join(found) + f" | {wanted} |", flush=True)
    if given.no_rivals:
        return
    python, folder = environment(), presses(10, 1_400, 200.0)
    print("\n| one fit of Fung's law, 10 × 1,400 rows | the fit | the whole process | sum of squares |")
    print("|-|-|-|-|")
    whole = cpu([given.palpate, "fit", "fung", folder, "--json"])
    print(f"| palpate: no start given, covariance, ten traces left out | | {shown(whole)} | |")
    for rival in FUNG:
        found = cpu([python, HERE / "rivals.py", rival, folder])
        seconds, cost = found[2].decode().split()
        print(f"| {rival}: one start given | {float(seconds):.3g} s | {shown(found)} | {cost} |", flush=True)


if __name__ == "__main__":
    main()
