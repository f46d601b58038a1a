"""Surveys from Python, on this machine and on a cluster: the bytes of the command, whatever ends in the middle."""

from __future__ import annotations

import multiprocessing
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import palpate
import pyarrow.parquet as pq
import pytest
from cluster import Cluster, rows_in
from conftest import PRESS, TRACES, answer, command

FINGERS = 60
FIT = {"by": "finger", "names": "f{finger}-*.csv", "terms": 1}
WORDS = ("--by", "finger", "--names", "f{finger}-*.csv", "--terms", 1)

#: Makes a process of palpate end at one finger, whoever asks.
POISON = """
import json, os, signal
from palpate import _palpate

whole = _palpate.survey_work

def survey_work(task):
    groups = json.loads(task)["groups"]
    at = [k for k, group in enumerate(groups) if group["key"] == [os.environ["POISONED"]]]
    if not at:
        return whole(task)
    whole(json.dumps({**json.loads(task), "groups": groups[: at[0]]}))
    os.kill(os.getpid(), signal.SIGKILL)

_palpate.survey_work = survey_work
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A trace many times over, the force a little larger each time; and one file that is no trace."""
    folder = tmp_path_factory.mktemp("survey")
    (folder / "lab").mkdir()
    (trace,) = palpate.read(TRACES / "table-3.1-row-01.csv")
    for finger in range(FINGERS):
        columns = {name: values for name, values in trace.to_dict().items() if name != "time_s"}
        columns["force_N"] = columns["force_N"] * (1 + 0.001 * finger)
        made = palpate.DataSet.from_arrays(trace.time, columns=columns, head=trace.head)
        made[0].write(folder / "lab" / f"f{finger:02}-a.csv")
    (folder / "lab" / "f99-a.csv").write_text("no trace")
    return folder


@pytest.fixture(scope="module")
def whole(lab: Path) -> dict[str, bytes]:
    """What the command finds on one machine."""
    done = subprocess.run(
        [*command_words(), "-o", "whole"], cwd=lab, capture_output=True, text=True, check=True
    )
    assert f"{FINGERS + 1} groups by finger: {FINGERS} done, 1 refused" in done.stdout
    return groups(lab / "whole")


def command_words() -> list[str]:
    from conftest import COMMAND

    return [COMMAND, "survey", "fit", "fung", "lab", *map(str, WORDS)]


def groups(results: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (results / "groups").iterdir()}


@pytest.fixture
def there(lab: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder above the lab, as the working one."""
    monkeypatch.chdir(lab)
    return lab


def test_a_survey_has_the_bytes_of_the_command(there: Path, whole: dict[str, bytes]) -> None:
    found = palpate.survey("fit", "lab", out="mine", **FIT)
    assert groups(there / "mine") == whole
    told = answer("survey", "report", "mine")
    assert found.to_dict() == told and (told["done"], told["refused"]) == (FINGERS, 1)
    frame = found.to_frame().set_index("finger")
    assert len(frame) == FINGERS + 1
    one = palpate.fit("lab/f07-a.csv", terms=1)
    for name, parameter in one.parameters.items():
        assert frame.loc["07", name] == parameter.value
        assert frame.loc["07", f"{name}.standard_error"] == parameter.standard_error
    assert frame.attrs["units"]["v1"] == "1/s" == one.parameters["v1"].unit
    assert frame.loc["99", "status"] == "refused" and "f99-a.csv" in frame.loc["99", "reason"]
    assert "61 groups by finger" in str(found) and found.folder == Path("mine")
    # The command goes on with it: all is done.
    done = subprocess.run([*command_words(), "-o", "mine"], capture_output=True, text=True, check=True)
    assert "61 groups by finger" in done.stdout and groups(there / "mine") == whole


def test_every_question_is_that_of_the_command(tmp_path: Path, model: Path) -> None:
    for question, given, words in (
        ("compare", {"model": model}, ("compare", model)),
        ("diagnose", {"model": model, "tare": True}, ("diagnose", "--model", model, "--tare")),
        ("segment", {}, ("segment",)),
        ("relaxation", {"terms": 1, "signs": True}, ("relaxation", "--terms", 1, "--signs")),
        ("decompose", {"signal": ["force_N"], "model": model}, ("decompose", "--signal", "force_N", "--model", model)),
    ):
        mine, theirs = tmp_path / f"{question}-mine", tmp_path / f"{question}-theirs"
        palpate.survey(question, PRESS, by="trace", out=mine, **given)
        command("survey", *words, PRESS, "--by", "trace", "-o", theirs)
        assert groups(mine) == groups(theirs) and groups(mine), question


def test_a_survey_that_cannot_be_is_refused_in_words(there: Path) -> None:
    for wrong, words in (
        (lambda: palpate.survey("fit", "none", by="finger", out="no"), "none: cannot be read"),
        (lambda: palpate.survey("fit", "lab", by="finger", out="no"), "nothing gives its `finger`"),
        (lambda: palpate.survey("segment", "lab", by="trace", out="no", terms=1), "no such option"),
        (lambda: palpate.survey("segment", "lab", by="trace", out="no", law="fung"), "`law` is of `fit`"),
        (lambda: palpate.survey("diagnose", "lab", by="trace", out="no"), "--model"),
    ):
        with pytest.raises(palpate.Error, match=words) as raised:
            wrong()
        assert raised.value.status == 2
    assert not (there / "no").exists()


def test_progress_is_told_and_what_is_done_when_it_is_ended_goes_on(there: Path, whole: dict[str, bytes]) -> None:
    seen: list[tuple[str, int, int]] = []

    def stop(*told: object) -> None:
        seen.append(told)  # type: ignore[arg-type]
        if told[1] >= 10:  # type: ignore[operator]
            raise KeyboardInterrupt

    try:
        palpate.progress(stop)
        with pytest.raises(KeyboardInterrupt):
            palpate.survey("fit", "lab", out="ended", engine=here, **FIT)
    finally:
        palpate.progress(None)
    assert {(what, of) for what, _, of in seen} == {("groups", FINGERS + 1)}
    assert not groups(there / "ended")
    kept = (there / "ended" / "unfinished" / "part-00000.jsonl").read_text().count("\n")
    assert 10 <= kept < FINGERS
    subprocess.run([*command_words(), "-o", "ended"], capture_output=True, check=True)
    assert groups(there / "ended") == whole


def here(work: Callable[[str], list[str]], tasks: Iterator[str]) -> Iterator[list[str]]:
    """An engine that works off one task after the other."""
    return map(work, tasks)


def test_any_engine_will_do_and_rows_come_in_any_order_and_twice(there: Path, whole: dict[str, bytes]) -> None:
    def backwards(work: Callable[[str], list[str]], tasks: Iterator[str]) -> list[list[str]]:
        last, *others = reversed(list(tasks))
        return [work(last), *(work(task) for task in others), work(last)]

    palpate.survey("fit", "lab", out="backwards", engine=backwards, **FIT)
    assert groups(there / "backwards") == whole
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        palpate.survey("fit", "lab", out="pool", engine=pool.imap_unordered, **FIT)
    assert groups(there / "pool") == whole
    with pytest.raises(palpate.Error, match="gave 0 of 61 rows.*goes on") as raised:
        palpate.survey("fit", "lab", out="nothing", engine=lambda work, tasks: [], **FIT)
    assert raised.value.status == 1


@pytest.mark.skipif(sys.platform == "win32", reason="ended by a signal")
def test_a_poisoned_group_is_tried_twice_and_becomes_its_row(
    there: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(POISON)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("POISONED", "23")
    found = palpate.survey("fit", "lab", out="poisoned", engine=here, **FIT).to_frame()
    assert list(found.group) == list(range(FINGERS + 1))
    (poisoned,) = found[found.finger == "23"].to_dict("records")
    assert poisoned["status"] == "failed"
    assert poisoned["reason"] == "gave up 2 times: the process that worked on it was ended by SIGKILL"
    assert (found.status == "done").sum() == FINGERS - 1
    attempts = pq.read_table(there / "poisoned" / "work").to_pandas().set_index("group").attempts
    assert attempts[23] == 2 and attempts.drop(23).eq(1).all()


@pytest.fixture
def cluster(there: Path, tmp_path: Path) -> Iterator[Cluster]:
    made = Cluster(3, tmp_path)
    try:
        yield made
    finally:
        made.end()


@pytest.mark.skipif(sys.platform == "win32", reason="ended by a signal")
def test_a_cluster_that_loses_a_worker_gives_the_bytes_of_one_machine(
    there: Path, whole: dict[str, bytes], cluster: Cluster
) -> None:
    from distributed import Client

    victim, killed = cluster.workers[0], threading.Event()

    def kill() -> None:
        while rows_in(there / "cluster") < 5:
            time.sleep(0.001)
        victim.send_signal(signal.SIGKILL)
        killed.set()

    with Client(cluster.address, set_as_default=False) as client:
        client.wait_for_workers(3, timeout=30)
        threading.Thread(target=kill, daemon=True).start()
        found = palpate.survey("fit", "lab", out="cluster", engine=client, **FIT)
        assert killed.is_set() and victim.wait(5) == -signal.SIGKILL
        assert len(client.nthreads()) == 2
    assert groups(there / "cluster") == whole
    assert len(found.to_frame()) == FINGERS + 1
    # By an address, from a shell, over what the command began.
    process = subprocess.Popen([*command_words(), "-o", "shell", "--jobs", "1"], stdout=subprocess.DEVNULL)
    while rows_in(there / "shell") < 5:
        assert process.poll() is None, "the command ended before it could be killed"
        time.sleep(0.001)
    process.kill()
    process.wait()
    call = [sys.executable, "-m", "palpate.survey", *command_words()[2:], "-o", "shell"]
    call += ["--engine", cluster.address, "--report", "fleet.html"]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "61 groups by finger: 60 done, 1 refused" in done.stdout
    assert groups(there / "shell") == whole
    assert "palpate survey fit fung lab" in (there / "fleet.html").read_text()


def test_without_an_engine_the_module_is_the_command(there: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT", "1s")

    def module(*words: str) -> subprocess.CompletedProcess[str]:
        call = [sys.executable, "-m", "palpate.survey", *words]
        return subprocess.run(call, capture_output=True, text=True, check=False)

    assert "palpate survey" in module("fit", "--help").stdout
    wrong = module("fit", "fung", "none", "--by", "trace", "-o", "no")
    assert wrong.returncode == 2 and wrong.stderr == command(
        "survey", "fit", "fung", "none", "--by", "trace", "-o", "no", status=2
    ).stderr
    nobody = module("segment", "lab", "--by", "trace", "-o", "nobody", "--engine=tcp://127.0.0.1:9")
    assert nobody.returncode == 1 and "no scheduler of Dask answers there" in nobody.stderr, nobody.stderr


def test_the_function_stays_where_the_module_is_imported() -> None:
    code = "import palpate, palpate.survey, sys; print(callable(palpate.survey), 'distributed' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "True False\n"
