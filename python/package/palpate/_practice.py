"""Practice: data sets with a hidden effect."""

from __future__ import annotations

import json
import os
from functools import cached_property
from typing import Any

from palpate import _palpate
from palpate._data import DataSet, PathLike
from palpate._options import options
from palpate._progress import told


class Practice:
    """Ten traces of a made-up specimen with a secret."""

    def __init__(self, native: _palpate.Practice) -> None:
        self._native = native

    @cached_property
    def data(self) -> DataSet:
        """The traces."""
        return DataSet(self._native.data())

    @property
    def seed(self) -> int:
        """The seed that makes them again."""
        return self._native.seed()

    def truth(self) -> dict[str, Any]:
        """What was hidden, as `palpate hide --open DIR --json` prints it."""
        told: dict[str, Any] = json.loads(self._native.truth())
        return told

    def write(self, folder: PathLike) -> None:
        """Writes traces and sealed truth into a new or empty folder."""
        self._native.write(os.fspath(folder))

    def __repr__(self) -> str:
        return f"<palpate.Practice: {len(self.data)} traces, seed {self.seed}>"

    def _repr_html_(self) -> str:
        return self.data._repr_html_()


def hide(
    *effects: str, any: int | None = None, seed: int | None = None, size: float | None = None
) -> Practice:
    """Makes a practice set in which effects are hidden, `any` of them drawn from the library: `palpate hide`.

    `size` is the misfit that each leaves, over the noise (1); without `seed`, one from the clock is taken.
    """
    words = [*options(any=any, seed=seed, size=size), *effects]
    with told() as tell:
        return Practice(_palpate.hide(words, tell))


def truth(folder: PathLike) -> dict[str, Any]:
    """What is hidden in the practice set of a folder: `palpate hide --open`."""
    told: dict[str, Any] = json.loads(_palpate.truth(os.fspath(folder)))
    return told
