"""A cluster of Dask on loopback, for tests and figures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path


#: Dask looks after itself less often than by its own settings, as docs/fleet.md recommends.
SELDOM = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "false",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "10s",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "2s",
}


def rows_in(results: Path) -> int:
    """Number of rows that the first part of a survey has so far, while it is under way."""
    journal = results / "unfinished" / "part-00000.jsonl"
    return journal.read_text().count("\n") if journal.exists() else 0


class Cluster:
    """A scheduler of Dask and its workers, a process each, on loopback."""

    def __init__(self, workers: int, folder: Path) -> None:
        self.file = folder / "scheduler.json"
        scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        while not self.file.exists():
            assert scheduler.poll() is None, "the scheduler ended"
            time.sleep(0.05)
        threads = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory", str(folder))
        self.workers = [self.start("worker", *threads) for _ in range(workers)]
        self.processes = [*self.workers, scheduler]

    def start(self, what: str, *words: str) -> subprocess.Popen[bytes]:
        call = [sys.executable, "-m", "dask", what, "--scheduler-file", str(self.file), *words]
        silent = subprocess.DEVNULL
        return subprocess.Popen(call, stdout=silent, stderr=silent, env={**os.environ, **SELDOM})

    @property
    def address(self) -> str:
        address: str = json.loads(self.file.read_text())["address"]
        return address

    def end(self) -> None:
        """Ends all of them at once: a worker that is asked to end waits for its scheduler."""
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.wait()
