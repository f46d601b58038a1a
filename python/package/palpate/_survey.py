"""One question put to every group of a large data set, on this machine or on many."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Union

from palpate import _palpate
from palpate._answers import Answer
from palpate._data import PathLike
from palpate._options import options
from palpate._progress import told
from palpate._remote import is_url

if TYPE_CHECKING:
    import pandas as pd
    from distributed import Client

    from palpate._ask import Separation, Terms
    from palpate._engine import Function

    #: The address of a scheduler of Dask, a client of one, or a function that gives what each task gives.
    Engine = Union[str, Client, Function]

Question = Literal["fit", "compare", "diagnose", "segment", "relaxation", "decompose"]


def survey(
    question: Question,
    data: PathLike | Sequence[PathLike],
    *,
    by: str | Sequence[str],
    out: PathLike,
    law: str | None = None,
    model: PathLike | None = None,
    names: str | None = None,
    trace_id: str | None = None,
    columns: Mapping[str, str] | None = None,
    jobs: int | None = None,
    engine: Engine | None = None,
    force: bool = False,
    terms: Terms | None = None,
    separation: Separation | None = None,
    segments: int | None = None,
    exponent: float | Literal["auto"] | None = None,
    elastic: str | None = None,
    relaxation: str | None = None,
    signal: str | Sequence[str] | None = None,
    signs: bool = False,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Survey:
    """Puts one question to every group of a large data set: `palpate survey QUESTION`.

    `data` are files and folders, or their URLs in an object store (`s3://lab/grasps`), `by` the keys that traces are
    grouped by, `names` where keys stand in names of files, `columns` what a trace calls the columns of Parquet files
    with many traces (`{"timestamp": "time_s"}`), `out` the folder of the results: one row a group, in the files, with
    the bytes, that the command makes. A folder of the same survey goes on, whichever way it was begun; `force` begins
    it anew. `law` is what `fit` fits (`fung`), `model` the model file of `compare` and `diagnose`, and of `decompose`
    where it is wanted; the other options are those of the single question.

    `engine` is who works: without it the processors of this machine, `jobs` groups at a time; the address of a
    scheduler of Dask (`tcp://scheduler:8786`) or a `distributed.Client`, whose workers see the same files by the same
    names; or a function `engine(work, tasks)` that gives `work(task)` for each of the tasks, in any order, as
    `multiprocessing.Pool.imap_unordered` does. What a worker does that is killed is done by another; a group at which
    the process ends twice is a row that says so.
    """
    if question == "fit":
        first = [law or "fung"]
    elif question == "compare" and model is not None:
        first, model = [os.fspath(model)], None
    else:
        first = []
    if law is not None and question != "fit":
        raise _palpate.Error("`law` is of `fit`")
    paths = [data] if isinstance(data, (str, os.PathLike)) else list(data)
    keys = by if isinstance(by, str) else ",".join(by)
    told_signal = signal if signal is None or isinstance(signal, str) else list(signal)
    words = options(
        by=keys,
        names=names,
        trace_id=trace_id,
        columns=None if columns is None else ",".join(f"{name}={to}" for name, to in columns.items()),
        output=os.fspath(out),
        model=None if model is None else os.fspath(model),
        jobs=jobs,
        force=force,
        terms=terms,
        separation=separation,
        segments=segments,
        exponent=exponent,
        elastic=elastic,
        relaxation=relaxation,
        signal=told_signal,
        signs=signs,
        tare=tare,
        drop_outliers=drop_outliers,
        join_steps=join_steps,
    )
    native = _palpate.Survey.called([question, *first, *(os.fspath(path) for path in paths), *words])
    fill(native, engine)
    return Survey(native, Path(out))


def fill(native: _palpate.Survey, engine: Engine | None) -> None:
    """Asks every group that has no row yet."""
    with told() as tell:
        if engine is None and not any(map(is_url, native.data())):
            native.ask(tell)
        else:
            from palpate import _engine

            _engine.fill(native, engine, tell)


class Survey(Answer):
    """What all groups of a large data set say: `to_dict()` what they say together, `to_frame()` a row a group."""

    def __init__(self, native: _palpate.Survey, folder: Path) -> None:
        super().__init__(native.found())
        #: The folder of the results.
        self.folder = folder

    def to_frame(self) -> pd.DataFrame:
        """A row a group: its keys, status, errors, verdict, and every estimate in a column of its own.

        A standard error stands beside what it is of (`v1`, `v1.standard_error`). `attrs["units"]` has the unit of
        each estimate.
        """
        import pandas as pd

        by, rows = _palpate.survey_rows(self.folder)
        units: dict[str, str] = {}
        frame = pd.DataFrame([_row(by, json.loads(row), units) for row in rows])
        frame.attrs["units"] = units
        return frame


def _row(by: list[str], row: dict[str, Any], units: dict[str, str]) -> dict[str, Any]:
    """A row of the table; `units` takes up those of its estimates."""
    said = row.pop("said")
    key = row.pop("key")
    group = row.pop("group")
    estimates = said.pop("estimates")
    wide = {"group": group, **dict(zip(by, key)), **row, **said}
    for one in estimates:
        name = f"{one['of']}: {one['name']}" if one["of"] else one["name"]
        wide[name] = one["value"]
        if one["standard_error"] is not None:
            wide[f"{name}.standard_error"] = one["standard_error"]
        units[name] = one["unit"]
    return wide
