"""Many grasps in one Parquet file, long format: python grasps.py COUNT FILE.parquet"""

import os
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from scipy.signal import lfilter

SAMPLES, RATE, NOISE, AT_A_TIME = 1000, 200.0, 0.02, 1000
C1, C2, V1, V2 = 0.25, 0.24, 4.0, 0.55


def grasps(first, count):
    """Time, displacement and force of grasps, one a row."""
    random = np.random.default_rng(first)
    step = 1.0 / RATE
    time = np.tile(np.arange(SAMPLES) * step, (count, 1))
    deep, speed = random.uniform(4.0, 13.0, (count, 1)), random.uniform(10.0, 55.0, (count, 1))
    p, q = random.uniform(0.07, 0.09, (count, 1)), random.uniform(0.75, 0.85, (count, 1))
    x = np.minimum(deep, np.minimum(speed * (time - 0.5), deep - speed * (time - 3.75)))
    x = np.maximum(x, -1.0)
    elastic = p / (q + 1) * np.maximum(x, 0.0) ** (q + 1)
    change = np.diff(elastic, prepend=0.0, axis=1)
    force = (1 - C1 - C2) * elastic
    for share, rate in ((C1, V1), (C2, V2)):
        decay = np.exp(-rate * step)
        force += share * lfilter([(1 - decay) / (rate * step)], [1, -decay], change, axis=1)
    force = np.maximum(force, 0.0) + random.normal(0.0, NOISE, force.shape)
    return time, np.round(x, 6), np.round(force, 6)


def main():
    count, path = int(sys.argv[1]), sys.argv[2]
    writer = None
    for first in range(0, count, AT_A_TIME):
        here = min(AT_A_TIME, count - first)
        time, x, force = grasps(first, here)
        ids = np.repeat([f"g{first + k:07}" for k in range(here)], SAMPLES)
        columns = {"trace_id": ids, "time_s": time.ravel(), "displacement_mm": x.ravel(), "force_N": force.ravel()}
        rows = pa.table(columns)
        writer = writer or pq.ParquetWriter(path + ".making", rows.schema, compression="zstd")
        writer.write_table(rows)
    writer.close()


    os.rename(path + ".making", path)


main()
