"""PySINDy on what a base law leaves: sparse regression on polynomials and Fourier terms of displacement, velocity, predicted force
and time, its threshold chosen by traces left out.

    rival.py MEASURED.csv=PREDICTED.csv ...

Prints one JSON object: the error on traces left out, N, and the terms of the fit to all.
"""

import json
import sys
import warnings

import numpy
import pysindy

NAMES = ["x", "v", "F", "t"]
# Of weights for terms of unit norm: all terms below go.
THRESHOLDS = [0.05, 0.1, 0.15, 0.2, 0.3]
RIDGE = 1e-3


def column(path):
    """The columns of a trace by name."""
    with open(path) as file:
        rows = [line for line in file if not line.startswith("#")]
    header = rows[0].strip().split(",")
    values = numpy.array([[float(cell or "nan") for cell in row.split(",")] for row in rows[1:]])
    return dict(zip(header, values.T))


def trace(pair):
    """Quantities, one row a sample, and the residual."""
    measured, predicted = (column(path) for path in pair.split("="))
    time, place = measured["time_s"], measured["displacement_mm"]
    force = numpy.interp(time, predicted["time_s"], predicted["force_N"])
    return numpy.column_stack([place, numpy.gradient(place, time), force, time]), measured["force_N"] - force


def library(quantities):
    """The terms over scaled quantities."""
    terms = pysindy.PolynomialLibrary(degree=3) + pysindy.FourierLibrary(n_frequencies=20)
    terms.fit(quantities)
    return terms


def fit(terms, scale, traces, threshold):
    """The sparse fit to traces; none where the threshold leaves no term."""
    warnings.simplefilter("ignore", UserWarning)  # a threshold may leave no term
    optimizer = pysindy.STLSQ(threshold=threshold, alpha=RIDGE, normalize_columns=True)
    theta = numpy.vstack([numpy.asarray(terms.transform(x / scale)) for x, _ in traces])
    residual = numpy.concatenate([y for _, y in traces])
    optimizer.fit(theta, residual[:, None])
    return optimizer.coef_.ravel()


def main():
    traces = [trace(pair) for pair in sys.argv[1:]]
    every = numpy.vstack([x for x, _ in traces])
    scale = every.std(axis=0)
    terms = library(every / scale)
    found = []
    for threshold in THRESHOLDS:
        squares = count = 0
        for left in range(len(traces)):
            others = traces[:left] + traces[left + 1 :]
            weights = fit(terms, scale, others, threshold)
            x, y = traces[left]
            missed = y - numpy.asarray(terms.transform(x / scale)) @ weights
            squares, count = squares + float(missed @ missed), count + len(y)
        found.append(((squares / count) ** 0.5, threshold))
    error, threshold = min(found)
    weights = fit(terms, scale, traces, threshold)
    named = [name for name, weight in zip(terms.get_feature_names(NAMES), weights) if weight != 0]
    print(json.dumps({"heldout_rms": error, "threshold": threshold, "terms": named}))


if __name__ == "__main__":
    main()
