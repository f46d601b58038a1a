"""Recordings of other programs, through a mapping that is written once and kept."""

from __future__ import annotations

import os

from palpate import _palpate
from palpate._data import DataSet, PathLike


def suggest(path: PathLike, *, part: str | None = None) -> str:
    """A mapping proposed for a file of another program, to check and edit: `palpate import --suggest`.

    It is the text of a mapping file (docs/formats.md): keep it beside the recording. `part` names one of several tables.
    """
    return _palpate.suggest(os.fspath(path), part)


def import_(
    *files: PathLike, map: PathLike | str | None = None, part: str | None = None, every: int | None = None
) -> DataSet:
    """Makes a trace of one recording of another program, in one file or several: `palpate import`.

    `map` is a mapping file, or the text of one as `suggest` gives it; without it, what the names and units in the file say, where
    they leave no question open. Several files are joined by their times. `part` names
    one of several tables, `every` keeps every so many-th sample. The mapping is kept in the head of the trace.
    """
    given = None if map is None else os.fspath(map)
    # A text has lines; a path has none.
    name, text = ("mapping", given) if given is not None and "\n" in given else (given, None)
    paths = [os.fspath(file) for file in files]
    return DataSet(_palpate.DataSet.imported(paths, name, text, part, every))
