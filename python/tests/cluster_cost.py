"""What a survey costs on three workers of Dask on loopback, beside the command and beside the ideal.

    python tests/cluster_cost.py [GRASPS]

Simulated grasps are fitted one by one: by the command on all processors, by the cluster, and by a cluster that loses one of its
workers to SIGKILL in the middle. The ideal is the processor time of the rows, shared evenly among the workers, or among
the processors where those are fewer. On a machine with other work to do the wall time says little; the processor time of all
processes of the cluster, from the call to its end, over that of the rows says what the cluster itself costs. All three make the same
bytes.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import palpate
import psutil
import pyarrow as pa
import pyarrow.parquet as pq
from cluster import Cluster, rows_in
from conftest import COMMAND, TOP
from distributed import Client

FLEET = TOP / "tests" / "fleet"
WORKERS = 3
OF_ONE = 20


def make(folder: Path, grasps: int) -> Path:
    """Grasps in one Parquet file in long format; few are simulated, each stands in it many times with noise of its own."""
    import numpy as np

    random = np.random.default_rng(1)
    model, motion = FLEET / "healthy.toml", FLEET / "grasp.toml"
    made = [palpate.simulate(model, motion, noise=0.01, seed=seed) for seed in range(OF_ONE)]
    tables = []
    for number in range(grasps):
        columns = {name: values.copy() for name, values in made[number % OF_ONE].to_dict().items()}
        columns["force_N"] += random.normal(0.0, 0.005, len(columns["force_N"]))
        tables.append(pa.table({"trace_id": [f"g{number:06}"] * len(columns["time_s"]), **columns}))
    path = folder / "grasps.parquet"
    pq.write_table(pa.concat_tables(tables), path, compression="zstd", row_group_size=500_000)
    return path


def spent(cluster: Cluster) -> float:
    """Processor time of all processes of a cluster that are there, and of this one, s."""
    processes = [psutil.Process(one.pid) for one in cluster.processes if one.poll() is None]
    return sum(sum(process.cpu_times()[:4]) for process in [*processes, psutil.Process()])


def on_cluster(folder: Path, data: Path, kill: bool) -> tuple[Path, float, float]:
    """The results, the wall time of the call, and the processor time of all."""
    out = folder / ("killed" if kill else "cluster")
    with tempfile.TemporaryDirectory() as scratch:
        cluster = Cluster(WORKERS, Path(scratch))
        try:
            with Client(cluster.address, set_as_default=False) as client:
                client.wait_for_workers(WORKERS, timeout=60)
                before, lost = spent(cluster), [0.0]
                if kill:
                    threading.Thread(target=end, args=(cluster.workers[0], out, lost), daemon=True).start()
                began = time.perf_counter()
                palpate.survey("fit", data, by="trace_id", out=out, engine=client)
                took = time.perf_counter() - began
                cost = spent(cluster) + lost[0] - before
                assert len(client.nthreads()) == WORKERS - kill
        finally:
            cluster.end()
    return out, took, cost


def end(worker: subprocess.Popen[bytes], out: Path, lost: list[float]) -> None:
    """Kills a worker in the middle, and notes what it had spent."""
    while rows_in(out) < 300:
        time.sleep(0.01)
    lost[0] = sum(psutil.Process(worker.pid).cpu_times()[:4])
    worker.send_signal(signal.SIGKILL)


def of_children() -> float:
    """Processor time of the processes that this one began and waited for, s."""
    return sum(psutil.Process().cpu_times()[2:4])


def groups(results: Path) -> list[bytes]:
    return [path.read_bytes() for path in sorted((results / "groups").iterdir())]


def main() -> None:
    grasps = int(sys.argv[1]) if len(sys.argv) > 1 else 3000
    processors = os.cpu_count() or 1
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        data = make(folder, grasps)
        command = folder / "command"
        call = [COMMAND, "survey", "fit", "fung", str(data), "--by", "trace_id", "-o", str(command), "--json"]
        before, began = of_children(), time.perf_counter()
        subprocess.run(call, check=True, stdout=subprocess.DEVNULL)
        alone, used = time.perf_counter() - began, of_children() - before
        print(f"{grasps} grasps of {len(pq.read_table(data)) // grasps} samples, {processors} processors")
        print("| by | wall time | ideal | over the ideal | processor time | of the rows | over the rows |")
        print("|-|-|-|-|-|-|-|")

        def row(by: str, results: Path, took: float, cost: float, workers: int) -> None:
            seconds = pq.read_table(results / "work").column("cpu_seconds").to_numpy().sum()
            ideal = seconds / min(workers, processors)
            wall = f"{took:.2f} s | {ideal:.2f} s | {took / ideal - 1:+.1%}"
            print(f"| {by} | {wall} | {cost:.2f} s | {seconds:.2f} s | {cost / seconds - 1:+.1%} |", flush=True)

        row("the command", command, alone, used, processors)
        for kill, by in ((False, f"{WORKERS} workers"), (True, f"{WORKERS} workers, one killed")):
            results, took, cost = on_cluster(folder, data, kill)
            assert groups(results) == groups(command)
            row(by, results, took, cost, WORKERS - kill)


main()
