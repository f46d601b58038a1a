"""Traces from files, arrays and frames: without copies where there can be none, with clear errors."""

from __future__ import annotations

import gc
from pathlib import Path

import numpy as np
import palpate
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
from conftest import PRESS, TOP, TRACES, command
from palpate._data import column

TIME = np.arange(5) / 200
FORCE = np.array([0.0, 0.1, 0.5, 0.4, 0.3])


def test_what_is_read_is_what_the_file_says() -> None:
    data = palpate.read(PRESS)
    trace = data[0]
    assert (data.names, len(data), trace.path) == (["press.csv"], 1, PRESS)
    assert trace.columns[:3] == ["time_s", "displacement_mm", "force_N"]
    assert "force_N" in trace and "force" not in trace
    assert len(trace) == len(trace.time) == len(trace["force_N"])
    assert palpate.read(TRACES).names == palpate.read([TRACES]).names
    assert len(palpate.read(TRACES)[2:4]) == 2


def test_a_column_is_a_view_that_outlives_its_set() -> None:
    trace = palpate.read(PRESS)[0]
    one, again = trace["force_N"], trace["force_N"]
    assert one.__array_interface__["data"] == again.__array_interface__["data"]
    assert not one.flags.writeable and not one.flags.owndata
    copy = one.copy()
    with pytest.raises(ValueError, match="read-only"):
        one[0] = 1.0
    with pytest.raises(ValueError):
        one.setflags(write=True)
    del trace, again
    gc.collect()
    assert np.array_equal(one, copy)


def test_parts_of_a_signal_are_views() -> None:
    part = palpate.decompose(PRESS)["gauge1_ustrain"]
    assert part.fa.__array_interface__["data"] == part.fa.__array_interface__["data"]
    assert not part.fa.flags.writeable and not part.fa.flags.owndata


@pytest.mark.parametrize("kind", ["numpy", "pandas", "polars", "pyarrow"])
def test_a_column_of_a_frame_is_taken_without_a_copy(kind: str) -> None:
    values = {"time_s": TIME, "force_N": FORCE}
    frame = {
        "numpy": lambda: values,
        "pandas": lambda: pd.DataFrame(values),
        "polars": lambda: pl.DataFrame(values),
        "pyarrow": lambda: pa.table(values),
    }[kind]()
    theirs = {
        "numpy": lambda: FORCE,
        "pandas": lambda: frame["force_N"].to_numpy(copy=False),
        "polars": lambda: frame["force_N"].to_numpy(allow_copy=False),
        "pyarrow": lambda: frame["force_N"].chunk(0).to_numpy(zero_copy_only=True),
    }[kind]()
    assert np.shares_memory(column(frame["force_N"], "force_N"), theirs)
    data = palpate.DataSet.from_frame(frame, name="one")
    assert data.names == ["one"]
    assert np.array_equal(data[0]["force_N"], FORCE) and np.array_equal(data[0].time, TIME)


def test_files_of_other_programs_come_in_as_by_the_command(tmp_path: Path) -> None:
    book = TOP / "tests" / "foreign" / "book.xlsx"
    proposed = palpate.suggest(book, part="Run 1")
    assert proposed == command("import", book, "--part", "Run 1", "--suggest").stdout
    (tmp_path / "map.toml").write_text(proposed)
    command("import", book, "--map", tmp_path / "map.toml", "-o", tmp_path / "run.csv")
    wanted = palpate.read(tmp_path / "run.csv")[0]
    for given in (proposed, tmp_path / "map.toml"):
        found = palpate.import_(book, map=given)[0]
        assert found.columns == wanted.columns
        assert all(np.array_equal(found[name], wanted[name]) for name in wanted.columns)
    assert len(palpate.import_(book, map=proposed, every=2)[0]) == (len(wanted) + 1) // 2
    found = palpate.import_(book, part="Run 1")[0]
    assert all(np.array_equal(found[name], wanted[name]) for name in wanted.columns)
    (tmp_path / "bare.txt").write_text("Time,Force\n0,1\n1,2\n2,3\n")
    for words, ask in (
        ("does not say the unit of `Time`, the unit of `Force`", lambda: palpate.import_(tmp_path / "bare.txt")),
        ("Say which: `--part NAME`", lambda: palpate.suggest(book)),
        ("`every` counts from 1", lambda: palpate.import_(book, map=proposed, every=0)),
        ("no file given", lambda: palpate.import_(map=proposed)),
        ("no table `Run 9`; there are Run 1, Run 2", lambda: palpate.import_(book, map=proposed, part="Run 9")),
        ("Run 1, Run 2", lambda: palpate.read(book)),
    ):
        with pytest.raises(palpate.Error, match=words):
            ask()


def test_several_files_of_one_run_are_joined_by_their_times(tmp_path: Path) -> None:
    for name, start in (("b", 0), ("a", 5)):
        rows = "".join(f"{start + i};{i}\n" for i in range(5))
        (tmp_path / f"{name}.txt").write_text("Time (s);Force (N)\n" + rows)
    files = [tmp_path / "a.txt", tmp_path / "b.txt"]
    found = palpate.import_(*files, map=palpate.suggest(files[0]))[0]
    assert list(found.time) == list(range(10))


def test_other_numbers_come_as_doubles_and_other_columns_stay_away() -> None:
    frame = pd.DataFrame({"t": TIME.astype(np.float32), "force": [1, 2, 3, 4, 5], "note": list("abcde")})
    data = palpate.DataSet.from_frame(frame, names={"t": "time_s"})
    assert data[0].columns == ["time_s", "force_N"]
    assert data[0]["force_N"].dtype == np.float64 and list(data[0]["force_N"]) == [1, 2, 3, 4, 5]


def test_a_long_frame_is_cut_by_a_column_in_order_of_appearance() -> None:
    frame = pd.DataFrame(
        {"take": ["b"] * 5 + ["a"] * 5, "time_s": [*TIME, *TIME], "force_N": [*FORCE, *(2 * FORCE)]}
    )
    for taken in (frame, pl.from_pandas(frame), pa.Table.from_pandas(frame)):
        data = palpate.DataSet.from_frame(taken, by="take")
        assert data.names == ["b", "a"]
        assert np.array_equal(data[1]["force_N"], 2 * FORCE)


def test_a_trace_goes_through_a_frame_and_a_file_unchanged(tmp_path: Path) -> None:
    trace = palpate.read(TRACES / "table-3.1-row-01.csv")[0]
    back = palpate.DataSet.from_frame(trace.to_frame())[0]
    assert back.head == trace.head
    assert all(np.array_equal(back[name], trace[name]) for name in trace.columns)
    for name in ("one.csv", "one.parquet"):
        trace.write(tmp_path / name)
        again = palpate.read(tmp_path / name)[0]
        assert again.head == trace.head and np.array_equal(again["force_N"], trace["force_N"])
        with pytest.raises(palpate.Error, match="exists already.*force=True"):
            trace.write(tmp_path / name)
        trace.write(tmp_path / name, force=True)


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        (dict(time=TIME, force=FORCE[:3]), "`force_N` has 3 values, `time_s` has 5"),
        (dict(time=TIME[::-1].copy(), force=FORCE), "row 1: time 0.015 s is not later than 0.02 s"),
        (dict(time=TIME, force=[0, 1, np.nan, 2, 3]), "`force_N`, row 2: NaN is not a finite number"),
        (dict(time=TIME, force=list("abcde")), "`force_N` is not of numbers"),
        (dict(time=TIME, force=FORCE.reshape(1, 5)), "has 2 dimensions"),
        (dict(time=TIME[:1], force=FORCE[:1]), "1 sample"),
        (dict(time=TIME, columns={"Force (mN)": FORCE}), "has this quantity as `force_N`"),
        (dict(time=TIME, force=FORCE, columns={"force_N": FORCE}), "two columns are called `force_N`"),
        (dict(time=TIME, head={"specimen": {"height_mm": -1}}), "height_mm = -1, a size is above 0"),
        (dict(time=TIME, head={"control": "sideways"}), "the head: unknown variant `sideways`"),
    ],
)
def test_what_is_no_trace_is_refused_in_words(arrays: dict, words: str) -> None:
    with pytest.raises(palpate.Error) as raised:
        palpate.DataSet.from_arrays(**arrays)
    assert words in str(raised.value)


def test_a_frame_without_time_is_refused_with_what_it_has() -> None:
    with pytest.raises(palpate.Error, match="no column `time_s`; there are force_N, other"):
        palpate.DataSet.from_frame({"force_N": FORCE, "other": FORCE})


def test_two_traces_with_one_place_in_the_order_are_refused() -> None:
    heads = [{"setup": {"sequence": 1}}, {"setup": {"sequence": 1}}]
    one, other = (palpate.DataSet.from_arrays(TIME, FORCE, FORCE, head=head) for head in heads)
    with pytest.raises(palpate.Error, match="sequence = 1"):
        one + other


@pytest.mark.parametrize("size", [1e308, -1e308])
def test_a_force_beyond_all_measure_is_an_error_and_never_nan(size: float, press: palpate.DataSet) -> None:
    trace = press[0]
    force = trace["force_N"].copy()
    force[300] = size
    data = palpate.DataSet.from_arrays(trace.time, trace["displacement_mm"], force)
    for question in (palpate.fit, palpate.fit_all, palpate.decompose):
        with pytest.raises(palpate.Error, match="1e308|finite|negative"):
            question(data)


def test_errors_have_the_words_and_the_status_of_the_command(tmp_path: Path) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("time_s,force_N\n0,1\n1,x\n")
    for question, words in (
        (lambda: palpate.read(bad), ("segment", bad)),
        (lambda: palpate.fit(PRESS, "fang"), ("fit", "fang", PRESS)),
        (lambda: palpate.fit(PRESS, "maxwell", segments=3), ("fit", "maxwell", PRESS, "--segments", 3)),
        (lambda: palpate.Model.read(bad), ("compare", bad, PRESS)),
        (lambda: palpate.read(tmp_path / "none"), ("segment", tmp_path / "none")),
    ):
        with pytest.raises(palpate.Error) as raised:
            question()
        assert raised.value.status == 2
        said = command(*words, status=2).stderr
        assert said == f"error: {raised.value}\n"
    with pytest.raises(palpate.Error, match="invalid value '9' for '--terms .*1 to 4, or auto"):
        palpate.fit(PRESS, "fung", terms=9)
