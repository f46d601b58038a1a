"""Traces: recordings as arrays, with what their heads say."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union, overload

from palpate import _palpate
from palpate._palpate import Error

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd

PathLike = Union[str, "os.PathLike[str]"]
#: What every question takes for data: a set, one trace, or what `read` takes.
Data = Union["DataSet", "Trace", PathLike, Sequence[PathLike]]

TIME = "time_s"
DISPLACEMENT = "displacement_mm"
FORCE = "force_N"
TEMPERATURE = "temperature_C"

#: Names that frames commonly have for what a trace calls otherwise, where the unit is the same or not said.
COMMON = {"time": TIME, "displacement": DISPLACEMENT, "force": FORCE, "temperature": TEMPERATURE}


def read(*paths: PathLike | Sequence[PathLike]) -> DataSet:
    """Reads traces: files, and folders for the traces in them, as every command does.

    Raises `Error` with the words of the command where a file is not a trace.
    """
    files: list[str] = []
    for path in paths:
        if isinstance(path, (str, os.PathLike)):
            files.append(os.fspath(path))
        else:
            files.extend(os.fspath(one) for one in path)
    return DataSet(_palpate.DataSet.read(files))


class Trace:
    """One recording: columns over time, with what its head says.

    A column is a read-only numpy array over the very memory that is fitted: `trace["force_N"]`.
    """

    __slots__ = ("_index", "_set")

    def __init__(self, of: DataSet, index: int) -> None:
        self._set, self._index = of._native, index

    @property
    def name(self) -> str:
        """What tables call it: its file's name, else the name in its head."""
        return self._set.label(self._index)

    @property
    def path(self) -> Path | None:
        """The file that it was read from."""
        path = self._set.path(self._index)
        return None if path is None else Path(path)

    @property
    def head(self) -> dict[str, Any]:
        """What its head says, with the keys of the file."""
        head: dict[str, Any] = json.loads(self._set.head(self._index))
        return head

    @property
    def columns(self) -> list[str]:
        """The names of its columns, time first; each name has its unit."""
        return self._set.columns(self._index)

    @property
    def time(self) -> npt.NDArray[np.float64]:
        """Time of each sample, s."""
        return self[TIME]

    def __getitem__(self, column: str) -> npt.NDArray[np.float64]:
        return self._set.column(self._index, column)

    def __contains__(self, column: object) -> bool:
        return column in self.columns

    def __len__(self) -> int:
        return len(self.time)

    def to_dict(self) -> dict[str, npt.NDArray[np.float64]]:
        """Its columns by name."""
        return {name: self[name] for name in self.columns}

    def to_frame(self) -> pd.DataFrame:
        """Its columns as a pandas frame, with what its head says in `attrs`."""
        import pandas as pd

        frame = pd.DataFrame(self.to_dict())
        frame.attrs["head"] = self.head
        return frame

    def write(self, path: PathLike, *, force: bool = False) -> None:
        """Writes it, head and all, as CSV or Parquet by the file's name, whole or not at all.

        A file that is there is replaced only with `force=True`, for it may be a measurement.
        """
        self._set.write(self._index, os.fspath(path), force)

    def plot(self) -> Any:
        """Draws its columns below each other with matplotlib and gives the figure."""
        from palpate import _plot

        return _plot.trace(self)

    def __repr__(self) -> str:
        return f"<palpate.Trace {self.name!r}: {len(self)} samples of {', '.join(self.columns)}>"

    def _repr_html_(self) -> str:
        from palpate import _html

        return _html.traces([self])


class DataSet(Sequence[Trace]):
    """Traces of one specimen in one set-up, in order of recording: what is fitted together. It never changes.

    `read` gives one, and so do `from_arrays` and `from_frame`; `a + b` joins two.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _palpate.DataSet) -> None:
        self._native = native

    @classmethod
    def from_arrays(
        cls,
        time: npt.ArrayLike,
        displacement: npt.ArrayLike | None = None,
        force: npt.ArrayLike | None = None,
        *,
        temperature: npt.ArrayLike | None = None,
        columns: Mapping[str, npt.ArrayLike] | None = None,
        head: Mapping[str, Any] | None = None,
        name: str | None = None,
    ) -> DataSet:
        """One trace from arrays: time in s, displacement in mm, force in N, temperature in °C.

        `columns` has others by name, with their unit in the name (`gauge1_ustrain`). `head` is what the head of a file
        says (`{"specimen": {"height_mm": 30}, "setup": {"start_s": 0.0}}`): what is known of specimen and set-up can
        change a fit. `name` is short for the head's `name`. Several traces are joined with `+`.

        An array is taken as `numpy.asarray` gives it, in double precision, and copied once into the set: what is fitted
        while the interpreter is free must not change.
        """
        named = {TIME: time, DISPLACEMENT: displacement, FORCE: force, TEMPERATURE: temperature}
        arrays = {key: values for key, values in named.items() if values is not None}
        for key, values in (columns or {}).items():
            if key in arrays:
                raise Error(f"two columns are called `{key}`")
            arrays[key] = values
        told = dict(head or {})
        if name is not None:
            told["name"] = name
        given = [(key, column(values, key)) for key, values in arrays.items()]
        return cls(_palpate.DataSet.from_columns([(given, json.dumps(told), None)]))

    @classmethod
    def from_frame(
        cls,
        frame: Any,
        *,
        names: Mapping[str, str] | None = None,
        by: str | None = None,
        head: Mapping[str, Any] | None = None,
        name: str | None = None,
    ) -> DataSet:
        """Traces from a frame of pandas or polars, a pyarrow table, or a mapping of arrays.

        Columns are taken by their names with units (`time_s`, `displacement_mm`, `force_N`); `names` says what others
        are (`{"t": "time_s"}`), and `time`, `displacement`, `force` and `temperature` alone mean s, mm, N and °C. Only
        columns of numbers are taken. `by` names a column whose values tell one trace from the next; rows of one trace
        keep their order. What a pandas frame has in `attrs["head"]` is its head, as `Trace.to_frame` leaves it there.
        """
        import numpy as np

        told = dict(head if head is not None else getattr(frame, "attrs", {}).get("head", {}))
        if name is not None:
            told["name"] = name
        renamed = {**COMMON, **(names or {})}
        arrays: dict[str, npt.NDArray[np.float64]] = {}
        for key in _names(frame):
            known = key in renamed or key == TIME
            if key == by or not (known or _numeric(frame[key])):
                continue
            target = renamed.get(key, key)
            if target in arrays:
                raise Error(f"two columns are called `{target}`")
            arrays[target] = column(frame[key], key)
        if by is None:
            return cls(_palpate.DataSet.from_columns([(list(arrays.items()), json.dumps(told), None)]))
        groups = np.asarray(frame[by])
        keys, first, place = np.unique(groups, return_index=True, return_inverse=True)
        traces = []
        for group in np.argsort(first):
            rows = place == group
            mine = [(key, np.ascontiguousarray(values[rows])) for key, values in arrays.items()]
            traces.append((mine, json.dumps({**told, "name": str(keys[group])}), None))
        return cls(_palpate.DataSet.from_columns(traces))

    @overload
    def __getitem__(self, index: int) -> Trace: ...
    @overload
    def __getitem__(self, index: slice) -> DataSet: ...
    def __getitem__(self, index: int | slice) -> Trace | DataSet:
        if isinstance(index, slice):
            return DataSet(self._native.select(list(range(*index.indices(len(self))))))
        place = index + len(self) if index < 0 else index
        if not 0 <= place < len(self):
            raise IndexError(f"trace {index} of {len(self)}")
        return Trace(self, place)

    def __iter__(self) -> Iterator[Trace]:
        return (Trace(self, index) for index in range(len(self)))

    def __len__(self) -> int:
        return len(self._native)

    def __add__(self, other: DataSet) -> DataSet:
        return DataSet(_palpate.DataSet.joined([self._native, other._native]))

    @property
    def names(self) -> list[str]:
        """What tables call the traces."""
        return [trace.name for trace in self]

    def to_frame(self) -> pd.DataFrame:
        """All traces below each other as a pandas frame, with a column `trace`."""
        import pandas as pd

        frames = [trace.to_frame().assign(trace=trace.name) for trace in self]
        return pd.concat(frames, ignore_index=True)

    def __repr__(self) -> str:
        return f"<palpate.DataSet: {len(self)} traces, {sum(map(len, self))} samples>"

    def _repr_html_(self) -> str:
        from palpate import _html

        return _html.traces(list(self))


def column(values: Any, name: str) -> npt.NDArray[np.float64]:
    """Values as an array in double precision: the very memory where they are that already, in a row, without gaps."""
    import numpy as np

    try:
        array = np.ascontiguousarray(np.asarray(values), np.float64)
    except (TypeError, ValueError) as what:
        raise Error(f"column `{name}` is not of numbers: {what}") from None
    if array.ndim != 1:
        raise Error(f"column `{name}` has {array.ndim} dimensions: a column has one")
    return array


def _names(frame: Any) -> list[str]:
    """The names of a frame's columns."""
    names = getattr(frame, "column_names", None)  # pyarrow
    if names is None:
        names = frame.keys() if isinstance(frame, Mapping) else frame.columns
    return [str(name) for name in names]


def _numeric(values: Any) -> bool:
    """Whether a column holds numbers."""
    import numpy as np

    return np.asarray(values).dtype.kind in "fiu"


def native(data: Data) -> _palpate.DataSet:
    """What every question takes for data."""
    if isinstance(data, DataSet):
        return data._native
    if isinstance(data, Trace):
        return data._set.select([data._index])
    return read(data)._native
