"""Long work beside a live interpreter: it stays free, Ctrl-C ends the work, progress is told."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import palpate
import pytest

LONG = """
import sys, time, palpate
data, model = palpate.read(sys.argv[1]), palpate.Model.read(sys.argv[2])
print("begun", flush=True)
try:
    while True:
        palpate.diagnose(model, data)
except KeyboardInterrupt:
    print("interrupted", flush=True)
time.sleep(1)
before = time.process_time()
time.sleep(1)
print(time.process_time() - before, flush=True)
"""


def test_the_interpreter_is_free_while_it_works(practice: Path, model: Path) -> None:
    data, base = palpate.read(practice), palpate.Model.read(model)
    turns, done = 0, threading.Event()

    def count() -> None:
        nonlocal turns
        while not done.is_set():
            turns += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    began = time.monotonic()
    palpate.diagnose(base, data)
    took = time.monotonic() - began
    done.set()
    counter.join()
    assert turns > 50 * took, f"{turns} turns in {took} s"


def test_questions_in_threads_do_not_disturb_each_other(practice: Path) -> None:
    from concurrent.futures import ThreadPoolExecutor

    data = palpate.read(practice)
    wanted = [palpate.fit(data[k : k + 2]).to_dict() for k in range(4)]
    with ThreadPoolExecutor(4) as pool:
        found = pool.map(lambda k: palpate.fit(data[k : k + 2]).to_dict(), range(4))
    assert list(found) == wanted


@pytest.mark.skipif(sys.platform == "win32", reason="a signal to another process is POSIX")
def test_ctrl_c_ends_it_and_the_work_behind_it(practice: Path, model: Path) -> None:
    call = [sys.executable, "-c", LONG, str(practice), str(model)]
    child = subprocess.Popen(call, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "begun\n"
    time.sleep(0.7)
    began = time.monotonic()
    child.send_signal(signal.SIGINT)
    assert child.stdout.readline() == "interrupted\n"
    assert time.monotonic() - began < 1.0
    # What it was doing is given up too: a second later next to no processor time is used.
    assert float(child.stdout.readline()) < 0.2
    assert child.wait(10) == 0


def diagnose_until(enough: Callable[[], bool], model: Path, practice: Path) -> None:
    """Again and again: one may be done before anything is told."""
    for _ in range(100):
        palpate.diagnose(model, practice)
        if enough():
            return


def test_progress_is_told_and_an_exception_in_it_ends_the_work(practice: Path, model: Path) -> None:
    seen: list[tuple[str, int, int]] = []
    try:
        palpate.progress(lambda *told: seen.append(told))
        diagnose_until(lambda: bool(seen), model, practice)
        assert seen and all(0 <= done <= of for _, done, of in seen)
        assert all(isinstance(what, str) and what for what, _, _ in seen)

        def stop(*_: object) -> None:
            raise RuntimeError("enough")

        palpate.progress(stop)
        with pytest.raises(RuntimeError, match="enough"):
            diagnose_until(lambda: False, model, practice)
    finally:
        palpate.progress(None)


def test_progress_on_a_terminal_is_wiped(practice: Path, model: Path, capsys: pytest.CaptureFixture) -> None:
    told = ""

    def is_told() -> bool:
        nonlocal told
        told += capsys.readouterr().err
        return "/" in told

    try:
        palpate.progress(True)
        diagnose_until(is_told, model, practice)
    finally:
        palpate.progress(None)
    told += capsys.readouterr().err
    assert "/" in told and told.endswith(" \r")
    palpate.fit(practice)
    assert capsys.readouterr().err == ""
