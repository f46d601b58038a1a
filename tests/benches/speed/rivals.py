"""One fit from a given start, with one of the tools of the trade.

    python rivals.py lmfit|scipy-lm|scipy-trf|numba|jax FOLDER    Fung's law to a folder of traces
    python rivals.py curve_fit|curve_fit-jacobian                 two exponentials to one hold of 860 samples

Prints the CPU seconds of the fit alone, least of some after a first that is not counted, and the sum of squares.
"""

import sys
import time
from pathlib import Path

import numpy as np
from scipy.optimize import curve_fit, least_squares
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


def with_jax():
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    @jax.jit
    def of(parameters, step, x, y):
        p, q, c1, c2, v1, v2 = parameters
        touching = x > 0
        elastic = jnp.where(touching, p / (q + 1) * jnp.where(touching, x, 1.0) ** (q + 1), 0.0)
        shares, rates = jnp.array([c1, c2]), jnp.array([v1, v2])
        decay = jnp.exp(-rates * step)[:, None]
        gain = (1 - decay) / (rates * step)[:, None]

        def sample(states, change):
            states = decay * states + gain * change
            return states, shares @ states

        change = jnp.diff(elastic, prepend=0.0, axis=1)
        _, relaxing = jax.lax.scan(sample, jnp.zeros((2, x.shape[0])), change.T)
        return (jnp.maximum((1 - c1 - c2) * elastic + relaxing.T, 0.0) - y).ravel()

    slopes = jax.jit(jax.jacfwd(of))

    def fit(traces):
        x, y = (np.stack([trace[k] for trace in traces]) for k in (1, 2))
        given = (traces[0][0], x, y)
        residual = lambda at: np.asarray(of(at, *given))
        return 2 * least_squares(residual, START, jac=lambda at: np.asarray(slopes(at, *given)), method="lm").cost

    return fit


def hold(analytic):
    """Two exponentials fitted to one hold: its amplitudes and rates with their covariance."""
    times = np.arange(860) / 200.0
    sum_of = lambda t, a0, a1, a2, v1, v2: a0 + a1 * np.exp(-v1 * t) + a2 * np.exp(-v2 * t)
    noise = np.random.default_rng(36).normal(0, 0.01, times.size)
    force = sum_of(times, 0.4852, 0.2472, 0.2676, 3.981, 0.5325) + noise

    def slopes(t, a0, a1, a2, v1, v2):
        e1, e2 = np.exp(-v1 * t), np.exp(-v2 * t)
        return np.stack([np.ones_like(t), e1, e2, -a1 * t * e1, -a2 * t * e2], axis=1)

    def fit():
        found, _ = curve_fit(sum_of, times, force, p0=[0.5, 0.2, 0.3, 3.3, 0.63], jac=slopes if analytic else None)
        return ((force - sum_of(times, *found)) ** 2).sum()

    return fit


def main():
    tool, *folder = sys.argv[1:]
    if tool.startswith("curve_fit"):
        fit, rounds = hold(tool.endswith("jacobian")), 300
    else:
        of, traces, rounds = fung(tool), read(folder[0]), 3
        fit = lambda: of(traces)
    taken = []
    for _ in range(rounds + 1):
        begin = time.process_time()
        cost = fit()
        taken.append(time.process_time() - begin)
    print(min(taken[1:]), f"{cost:.6f}")


def fung(tool):
    """The fit with this tool."""
    fits = {
        "lmfit": lambda: with_lmfit,
        "scipy-lm": lambda: lambda traces: with_scipy(traces, "lm"),
        "scipy-trf": lambda: lambda traces: with_scipy(traces, "trf"),
        "numba": with_numba,
        "jax": with_jax,
    }
    return fits[tool]()


if __name__ == "__main__":
    main()
