"""Surveys whose rows are made by other processes, on any machine that sees the same files by the same names, or the same URLs.

A task is some groups, as text. An engine hands tasks to workers (`_worker.py`); this process alone writes into the folder of the
results.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator
from multiprocessing.pool import ThreadPool
from typing import TYPE_CHECKING, Any

from palpate import _palpate, _remote
from palpate._worker import end_all, failed, work

if TYPE_CHECKING:
    from palpate._progress import Tell
    from palpate._survey import Engine

Work = Callable[[str], list[str]]
#: Gives what `work` gives for each task, in any order.
Function = Callable[[Work, Iterator[str]], Iterable[list[str]]]

#: How long a task should take, s: long beside handing it out, short beside a survey.
A_TASK_SECONDS = 4.0
#: How long the last ones should take, s: no worker waits longer for another.
LAST_SECONDS = 0.5
#: Groups of a task before it is known how long one takes.
FIRST = 5
#: Objects of a store that are looked into at a time.
OBJECTS = 16
#: Tasks that a thread of the cluster has before it, so that it never waits.
AHEAD = 2
#: How often an engine tries a task whose worker was lost or failed.
RETRIES = 3
GOES_ON = "what is done is kept, and the same call goes on with the others"


def fill(native: _palpate.Survey, engine: Engine | None, tell: Tell | None) -> None:
    """Has every group that has no row yet asked by an engine; without one by this machine."""
    if engine is None:
        with ThreadPool(os.cpu_count()) as pool:
            return fill(native, pool.imap_unordered, tell)
    if isinstance(engine, str):
        with _client(engine) as client:
            return fill(native, client, tell)
    of = native.open(_contents(native, engine))
    try:
        share = _Share(of)
        for rows in _worked_off(engine, _tasks(native, share), share):
            share.count(len(rows), *native.keep(rows))
            if tell is not None:
                tell("groups", share.done, of)
        if share.done < of:
            raise failed(f"the engine gave {share.done} of {of} rows; {GOES_ON}")
    finally:
        native.close()
        end_all()


def _contents(native: _palpate.Survey, engine: Engine) -> list[str] | None:
    """What objects of a store hold, as those say who work on them; none where the data are files."""
    data = native.data()
    if not any(map(_remote.is_url, data)):
        return None
    if not all(map(_remote.is_url, data)):
        raise _palpate.Error("a survey is of files or of URLs, not of both")
    urls = _remote.listed(data)
    looks = (native.look(urls[first : first + OBJECTS]) for first in range(0, len(urls), OBJECTS))
    found: dict[str, str] = {}
    for some in _worked_off(engine, looks, _Share(len(urls))):
        found.update((json.loads(one)["input"]["path"], one) for one in some)
    if len(found) < len(set(urls)):
        raise failed(f"the engine looked into {len(found)} of {len(urls)} objects")
    return [found[url] for url in urls]


def _worked_off(engine: Engine, tasks: Iterator[str], share: _Share) -> Iterable[list[str]]:
    return engine(work, tasks) if callable(engine) else _dask(engine, tasks, share)


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

    def count(self, came: int, kept: int, seconds: float) -> None:
        """Counts rows that came, of which so many were kept, with the processor time that they took."""
        self.came += came
        self.done += kept
        self.seconds += seconds


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
        raise failed(f"{address}: no scheduler of Dask answers there\n  because {what}") from None


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
                raise failed(f"{lost}; {GOES_ON}\n  because {what}") from None
            waiting.discard(future)
            yield rows
            hand_out()
    finally:
        client.cancel(list(waiting))


def _threads(client: Any) -> int:
    """Threads of the cluster; one where it has none yet, for some clusters grow as work comes."""
    threads: dict[str, int] = client.nthreads()
    return max(1, sum(threads.values()))
