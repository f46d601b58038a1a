"""Fung's law fitted to every grasp of a Parquet file with pandas, joblib and scipy: python rival.py FILE.parquet OUT.parquet

Each fit begins 20 % off the truth and gives values, standard errors from the Jacobian, and the residual; processes as
many as there are processors. Prints how many fits came close to the noise.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from scipy.optimize import least_squares

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "speed"))
from rivals import START, residuals

NAMES = ["p", "q", "c1", "c2", "v1", "v2"]


def one(name, rows):
    time, x, force = rows
    trace = [(time[1] - time[0], np.maximum(x, 0.0), force)]
    found = least_squares(residuals, START, args=(trace,), bounds=(1e-6, np.inf))
    variance = 2 * found.cost / (force.size - START.size)
    errors = np.sqrt(np.diag(np.linalg.pinv(found.jac.T @ found.jac) * variance))
    row = {"trace_id": name, "residual_rms": np.sqrt(2 * found.cost / force.size)}
    row |= dict(zip(NAMES, found.x))
    return row | {f"{name}_standard_error": error for name, error in zip(NAMES, errors)}


def main():
    table = pd.read_parquet(sys.argv[1])
    columns = ["time_s", "displacement_mm", "force_N"]
    groups = ((name, [rows[column].to_numpy() for column in columns]) for name, rows in table.groupby("trace_id"))
    found = pd.DataFrame(Parallel(n_jobs=-1)(delayed(one)(name, rows) for name, rows in groups))
    found.to_parquet(sys.argv[2])
    print(f"{(found.residual_rms < 0.022).mean():.1%} of its fits end within 10 % of the noise")


main()
