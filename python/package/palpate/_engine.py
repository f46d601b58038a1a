"""Surveys whose rows are made by other processes, on any machine that sees the same files by the same names.

A task is some groups, as text. An engine hands tasks to workers; a worker has each worked off by a process of its own, so
that a group that ends its process ends nothing else; this process alone writes into the folder of the results.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

from palpate import _palpate

if TYPE_CHECKING:
    from palpate._progress import Tell
    from palpate._survey import Engine

Work = Callable[[str], list[str]]
#: Gives what `work` gives for each task, in any order.
Function = Callable[[Work, Iterator[str]], Iterable[list[str]]]

#: How often a group is tried at which the process ends.
ATTEMPTS = 2
#: How long a task should take, s: long beside the start of a process, short beside a survey.
A_TASK_SECONDS = 4.0
#: How long the last ones should take, s: a process starts in some 0.06 s, and no worker waits longer for another.
LAST_SECONDS = 1.0
#: Groups of a task before it is known how long one takes.
FIRST = 5
#: Tasks that a thread of the cluster has before it, so that it never waits.
AHEAD = 2
#: How often an engine tries a task whose worker was lost or failed.
RETRIES = 3
GOES_ON = "what is done is kept, and the same call goes on with the others"


def fill(native: _palpate.Survey, engine: Engine, tell: Tell | None) -> None:
    """Has every group that has no row yet asked by an engine."""
    if isinstance(engine, str):
        with _client(engine) as client:
            return fill(native, client, tell)
    of = native.open()
    try:
        share = _Share(of)
        tasks = _tasks(native, share)
        for rows in engine(work, tasks) if callable(engine) else _dask(engine, tasks, share):
            share.count(rows, native.keep(rows))
            if tell is not None:
                tell("groups", share.done, of)
        if share.done < of:
            raise _failed(f"the engine gave {share.done} of {of} rows; {GOES_ON}")
    finally:
        native.close()


class _Share:
    """How many groups a task should have."""

    def __init__(self, of: int) -> None:
        self.of, self.given, self.came, self.done = of, 0, 0, 0
        self.seconds, self.threads = 0.0, 8

    def next(self) -> int:
        """As many as take `A_TASK_SECONDS`, and fewer at the end, so that all workers end at about one time."""
        left = (self.of - self.given) / (AHEAD * self.threads)
        if self.seconds <= 0:
            return max(1, int(min(FIRST, left)))
        a_second = self.came / self.seconds
        fair = min(max(left, LAST_SECONDS * a_second), self.of / self.threads)
        return max(1, int(min(A_TASK_SECONDS * a_second, fair)))

    def count(self, rows: list[str], kept: int) -> None:
        """Counts rows that came, of which so many were kept, with the processor time that they took."""
        self.came += len(rows)
        self.done += kept
        self.seconds += sum(json.loads(row)[1]["seconds"] for row in rows)


def _tasks(native: _palpate.Survey, share: _Share) -> Iterator[str]:
    while True:
        most = share.next()
        task = native.next_task(most)
        if task is None:
            return
        share.given += most
        yield task


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise _palpate.Error(
            "a survey on many machines needs Dask: pip install 'palpate[cluster]'"
        ) from None
    try:
        return Client(address, set_as_default=False)
    except (OSError, ValueError) as what:
        raise _failed(f"{address}: no scheduler of Dask answers there\n  because {what}") from None


def _dask(client: Any, tasks: Iterator[str], share: _Share) -> Iterator[list[str]]:
    """Keeps every thread of the cluster at work, however many workers come and go."""
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    running = as_completed(loop=client.loop)
    waiting: set[Any] = set()

    def hand_out() -> None:
        share.threads = _threads(client)
        while len(waiting) < AHEAD * share.threads and (task := next(tasks, None)) is not None:
            future = client.submit(work, task, retries=RETRIES, pure=False)
            waiting.add(future)
            running.add(future)

    hand_out()
    try:
        for future in running:
            try:
                rows = future.result()
            except KilledWorker as what:
                lost = "the cluster lost every worker that tried one task"
                raise _failed(f"{lost}; {GOES_ON}\n  because {what}") from None
            waiting.discard(future)
            yield rows
            hand_out()
    finally:
        client.cancel(list(waiting))


def _threads(client: Any) -> int:
    """Threads of the cluster; one where it has none yet, for some clusters grow as work comes."""
    threads: dict[str, int] = client.nthreads()
    return max(1, sum(threads.values()))


def work(task: str) -> list[str]:
    """Works off a task on this machine, in a process of its own, and gives its rows."""
    rows: list[str] = []
    left: str | None = task
    tried = 0
    while left is not None:
        done = _process(left)
        # A line that was cut off is no row.
        whole = done.stdout.split("\n")[:-1]
        rows += whole
        if done.returncode == 0:
            return rows
        if done.returncode in (1, 2):
            raise _failed(done.stderr.strip(), done.returncode)
        tried = 1 if whole else tried + 1
        left = _palpate.survey_rest(left, len(whole), tried)
        if left is not None and tried == ATTEMPTS:
            rows.append(_palpate.survey_gave_up(left, tried, _end(done.returncode)))
            left, tried = _palpate.survey_rest(left, 1, 0), 0
    return rows


def _process(task: str) -> subprocess.CompletedProcess[str]:
    folder = json.loads(task)["folder"]
    call = [sys.executable, "-m", "palpate._rows"]
    try:
        return subprocess.run(
            call, input=task, cwd=folder, capture_output=True, encoding="utf-8", check=False
        )
    except (FileNotFoundError, NotADirectoryError):
        raise _palpate.Error(
            f"a worker has no folder {folder}: workers must see the files of a survey by the same names"
        ) from None


def _failed(words: str, status: int = 1) -> _palpate.Error:
    error = _palpate.Error(words)
    error.status = status
    return error


def _end(status: int) -> str:
    """How a process ended, in words."""
    if status >= 0:
        return f"the process that worked on it ended with status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    return f"the process that worked on it was ended by {name}"
