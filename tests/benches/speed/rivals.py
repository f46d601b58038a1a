"""One fit of Fung's law to a folder of traces from a given start, with one of the tools of the trade.

    python rivals.py lmfit|scipy-lm|scipy-trf|numba FOLDER

Prints the CPU seconds of the fit alone, least of three after a first that is not counted, and the sum of squares.
"""

import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter

# p, q, c1, c2, v1, v2: 20 % off the truth.
START = np.array([0.1, 0.7, 0.2, 0.3, 3.2, 0.7])


def read(folder):
    traces = [np.loadtxt(path, delimiter=",", skiprows=1) for path in sorted(Path(folder).glob("*.csv"))]
    return [(t[1, 0] - t[0, 0], np.maximum(t[:, 1], 0.0), t[:, 2]) for t in traces]


def predict(parameters, step, x):
    p, q, c1, c2, v1, v2 = parameters
    elastic = p / (q + 1) * x ** (q + 1)
    change = np.diff(elastic, prepend=0.0)
    force = (1 - c1 - c2) * elastic
    for share, rate in ((c1, v1), (c2, v2)):
        decay = np.exp(-rate * step)
        force += share * lfilter([(1 - decay) / (rate * step)], [1, -decay], change)
    return np.maximum(force, 0.0)


def residuals(parameters, traces):
    return np.concatenate([predict(parameters, step, x) - y for step, x, y in traces])


def with_lmfit(traces):
    import lmfit

    names = ["p", "q", "c1", "c2", "v1", "v2"]
    start = lmfit.Parameters()
    for name, value in zip(names, START):
        start.add(name, value, min=1e-6)
    found = lmfit.minimize(lambda at: residuals([at[name].value for name in names], traces), start)
    return found.chisqr


def with_scipy(traces, method):
    bounds = (-np.inf, np.inf) if method == "lm" else (1e-6, np.inf)
    return 2 * least_squares(residuals, START, args=(traces,), method=method, bounds=bounds).cost


def with_numba():
    import numba

    @numba.njit
    def one(parameters, step, x, y, out):
        p, q, c1, c2, v1, v2 = parameters
        a1, a2 = np.exp(-v1 * step), np.exp(-v2 * step)
        b1, b2 = (1 - a1) / (v1 * step), (1 - a2) / (v2 * step)
        s1 = s2 = before = 0.0
        for k in range(x.size):
            elastic = p / (q + 1) * x[k] ** (q + 1)
            s1 = a1 * s1 + b1 * (elastic - before)
            s2 = a2 * s2 + b2 * (elastic - before)
            before = elastic
            force = (1 - c1 - c2) * elastic + c1 * s1 + c2 * s2
            out[k] = max(force, 0.0) - y[k]

    def all_of(parameters, traces):
        parts = []
        for step, x, y in traces:
            out = np.empty_like(x)
            one(parameters, step, x, y, out)
            parts.append(out)
        return np.concatenate(parts)

    return lambda traces: 2 * least_squares(all_of, START, args=(traces,), method="lm").cost


def main():
    tool, folder = sys.argv[1:]
    fits = {
        "lmfit": lambda: with_lmfit,
        "scipy-lm": lambda: lambda traces: with_scipy(traces, "lm"),
        "scipy-trf": lambda: lambda traces: with_scipy(traces, "trf"),
        "numba": with_numba,
    }
    fit, traces = fits[tool](), read(folder)
    taken = []
    for _ in range(4):
        begin = time.process_time()
        cost = fit(traces)
        taken.append(time.process_time() - begin)
    print(min(taken[1:]), f"{cost:.6f}")


if __name__ == "__main__":
    main()
