"""Recordings of specimens that other base laws than `fung` with two exponentials describe, each with one effect hidden or none.

    python specimens.py SPECIMEN MOTION EFFECT SEED FOLDER

Written apart from the program: every law is computed in steps eight times finer than the samples, over all recordings and the
rests between them in one course. An effect changes the signal by six standard deviations of the noise, before any refit.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from scipy.special import gamma

RATE, FINE = 200, 8
STEP = 1 / (RATE * FINE)
LENGTH, AREA = 30.0, 400.0
SIZE = 6.0


def through(corners):
    """The straight course through corners (time, displacement)."""
    times, places = zip(*corners)
    return np.interp(np.arange(0, times[-1], STEP), times, places)


def motions(kind):
    """The displacement of every recording, mm: presses with holds, pulls with holds, or swings to either side."""
    if kind == "presses":
        found = [
            through([(0, 0), (0.5, 0), (0.5 + a / v, a), (4.5 + a / v, a), (4.5 + 2 * a / v, 0), (7.5 + 2 * a / v, 0)])
            for a in (2.0, 4.0, 6.0)
            for v in (1.0, 6.0, 30.0)
        ]
        cycles = [(0, 0)]
        for begin in (0.5, 2.5, 4.5, 6.5):
            cycles += [(begin, 0), (begin + 0.5, 5), (begin + 1, 5), (begin + 1.5, 0)]
        return [*found, through([*cycles, (10.5, 0)])]
    if kind == "pulls":
        return [
            through([(0, 0), (0.5, 0), (0.5 + a / v, a), (5.5 + a / v, a), (5.5 + 2 * a / v, 0), (8 + 2 * a / v, 0)])
            for a in (3.0, 6.0, 9.0, 12.0)
            for v in (2.0, 20.0)
        ]
    found = []
    for frequency in (0.1, 0.3, 1.0, 3.0):
        for a in (1.0, 3.0):
            lasts = max(3, int(8 * frequency)) / frequency + 2
            time = np.arange(0, lasts, STEP)
            rises = np.clip((time - 1) / 0.2, 0, 1) * np.clip((lasts - 0.5 - time) / 0.2, 0, 1)
            found.append(rises * a * np.sin(2 * np.pi * frequency * (time - 1)))
    return found


def relaxation(specimen, random):
    """Shares and rates, 1/s, of the relaxation function."""
    if specimen in ("elastic", "damped"):
        return [(1.0, 0.0)]
    if specimen == "springpot":
        # (t / 1 s)^(−β) as the integral over rates that it is.
        stays, order = random.uniform(0.2, 0.5), random.uniform(0.15, 0.4)
        logarithms = np.linspace(np.log(1e-5), np.log(1e6), 160)
        rates = np.exp(logarithms)
        shares = (1 - stays) * rates**order * (logarithms[1] - logarithms[0]) / gamma(order)
        return [(stays, 0.0), *zip(shares, rates)]
    fast, slow = random.uniform(0.1, 0.25, 2)
    return [(1 - fast - slow, 0.0), (fast, random.uniform(1, 4)), (slow, random.uniform(0.08, 0.3))]


def relaxed(elastic, terms):
    """The force of a course of elastic responses, straight between the fine steps."""
    change, force = np.diff(elastic, prepend=0.0), np.zeros_like(elastic)
    for share, rate in terms:
        if rate == 0.0:
            force += share * elastic
            continue
        decay = np.exp(-rate * STEP)
        force += share * lfilter([(1 - decay) / (rate * STEP)], [1, -decay], change)
    return force


def played(x, width):
    """A course behind a play of this width."""
    found, at = np.empty_like(x), 0.0
    for k, now in enumerate(x):
        at = min(max(at, now - width / 2), now + width / 2)
        found[k] = at
    return found


class Specimen:
    """A specimen, its recordings, and what happens to them on the way to the signal."""

    def __init__(self, kind, motion, random):
        self.kind, self.bonded = kind, kind in ("rubber", "springs", "damped")
        self.recordings = motions(motion)
        rests = [np.zeros(int(random.uniform(8, 16) / STEP)) for _ in self.recordings]
        self.begins = np.cumsum([0] + [len(a) + len(b) for a, b in zip(self.recordings, rests)])[:-1]
        self.x = np.concatenate([part for pair in zip(self.recordings, rests) for part in pair])
        self.time = np.arange(len(self.x)) * STEP
        self.speed = np.gradient(self.x, STEP)
        swing = np.sin(2 * np.pi * self.time / 700 + random.uniform(0, 6))
        # Above the mean of the set, K.
        self.warmth = 1.5 * swing + 2e-3 * self.time * random.uniform(-1, 1)
        self.warmth -= np.mean(np.concatenate(self.samples(self.warmth)))
        self.stiffness, self.exponent = random.uniform(0.1, 0.4), random.uniform(1.6, 2.4)
        self.modulus, self.spring = random.uniform(0.03, 0.1), random.uniform(0.5, 2)
        self.terms = relaxation(kind, random)
        self.zeros = random.standard_normal(len(self.recordings))

    def elastic(self, x):
        if self.kind in ("elastic", "springpot"):
            return self.stiffness / self.exponent * np.maximum(x, 0) ** self.exponent
        if self.kind == "rubber":
            return self.modulus * AREA * (1 + x / LENGTH - (1 + x / LENGTH) ** -2)
        return self.spring * x

    def signal(self, effect, size):
        """The signal of the whole course, N, without noise."""
        x, time, speed = self.x, self.time, self.speed
        felt = {
            "contact-offset": lambda: x - size,
            "sync-delay": lambda: np.interp(time - size, time, x),
            "permanent-set": lambda: x - size * np.maximum.accumulate(np.maximum(x, 0)),
            "backlash": lambda: played(x, size),
        }.get(effect, lambda: x)()
        elastic = self.elastic(felt)
        largest = np.maximum.accumulate(np.abs(x))
        loadings = np.maximum(np.cumsum(np.diff((x > 0).astype(int), prepend=0) == 1) - 1, 0)
        loaded = felt if self.bonded else np.maximum(felt, 0)
        elastic = {
            "elastic-stiffening": lambda: elastic + size * np.sign(loaded) * loaded**4,
            "mullins": lambda: elastic * (1 - size * np.tanh((largest - np.abs(x)) / 1.0)),
            "cyclic-softening": lambda: elastic * (1 - size * np.log1p(loadings)),
            "thermal-stiffness": lambda: elastic * (1 + size * self.warmth),
        }.get(effect, lambda: elastic)()
        more = {"fast-mode": [(size, 1 / 0.03)], "slow-relaxation": [(size, 10.0**-k) for k in range(4)]}.get(effect, [])
        force = relaxed(elastic, [*self.terms, *more])
        if self.kind == "damped":
            force = force + 0.15 * np.gradient(elastic, STEP)
        if not self.bonded:
            force = np.maximum(force, 0)
        side = np.tanh(speed / 0.05)
        force = {
            "coulomb-friction": lambda: force + size * side,
            "load-friction": lambda: force * (1 + size * side),
            "viscous-drag": lambda: force + size * speed * (self.bonded | (x > 0)),
            "rate-drag": lambda: force + size * np.sign(speed) * np.abs(speed) ** 0.3,
            # The mass of a rig whose corners are 10 ms round.
            "inertia": lambda: force + size * lfilter(np.full(16, 1 / 16), [1], np.gradient(speed, STEP)),
            "drift": lambda: force + size * time,
            "warm-up": lambda: force + size * (1 - np.exp(-time / 150)),
            "thermal-output": lambda: force + size * self.warmth,
            "gauge-nonlinearity": lambda: force - size * force * (np.abs(force) if self.bonded else force),
            "saturation": lambda: np.minimum(force, self.most / (1 + size)),
            "sensor-lag": lambda: lfilter([1 - np.exp(-STEP / size)], [1, -np.exp(-STEP / size)], force),
            "mains-hum": lambda: force + size * np.sin(2 * np.pi * 49.97 * time + 1),
            "zero-shift": lambda: force + size * self.zeros[np.searchsorted(self.begins, np.arange(len(x)), "right") - 1],
        }.get(effect, lambda: force)()
        return force

    def samples(self, course):
        """A course at the samples of every recording."""
        return [course[b : b + len(r) : FINE] for b, r in zip(self.begins, self.recordings)]


def hidden(specimen, effect, noise):
    """The signal with an effect that changes it by so many times the noise."""
    plain = specimen.signal("none", 0.0)
    specimen.most = np.max(plain)
    if effect == "none":
        return plain
    size = {"sync-delay": 3e-3, "sensor-lag": 3e-3, "backlash": 0.03}.get(effect, 0.01)
    for _ in range(4):
        change = np.concatenate(specimen.samples(specimen.signal(effect, size) - plain))
        size *= SIZE * noise / max(np.sqrt(np.mean(change**2)), 1e-12)
    return specimen.signal(effect, size)


def write(kind, motion, effect, seed, folder):
    random = np.random.default_rng([seed, EFFECTS.index(effect), list(LAWS).index(kind)])
    specimen = Specimen(kind, motion, random)
    full = max(np.max(np.abs(part)) for part in specimen.samples(specimen.signal("none", 0.0)))
    noise = full / random.uniform(300, 800)
    signals = specimen.samples(hidden(specimen, effect, noise))
    folder.mkdir(parents=True, exist_ok=True)
    parts = zip(specimen.samples(specimen.x), signals, specimen.samples(specimen.warmth))
    for number, (x, force, warmth) in enumerate(parts):
        white = random.standard_normal(len(x) + 100)
        force = force + noise * lfilter([0.8], [1, -0.6], white)[100:]
        head = f"""# palpate-trace = 1
# [specimen]
# shape = "cylinder"
# radius_mm = {np.sqrt(AREA / np.pi):.6f}
# height_mm = {LENGTH}
# [setup]
# mode = "{"tension" if specimen.bonded else "compression"}"
# sequence = {number + 1}
# start_s = {specimen.begins[number] * STEP:.4f}
time_s,displacement_mm,force_N,temperature_C"""
        table = np.column_stack([np.arange(len(x)) / RATE, x, force, 23 + warmth])
        with (folder / f"{number:02}.csv").open("w") as file:
            file.write(head + "\n")
            np.savetxt(file, table, fmt=["%.4f", "%.6f", "%.6f", "%.4f"], delimiter=",")


if __name__ == "__main__":
    kind, motion, effect, seed, folder = sys.argv[1:]
    write(kind, motion, effect, int(seed), Path(folder))
