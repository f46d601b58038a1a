"""A fingertip, live."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from palpate import _palpate
from palpate._data import PathLike

if TYPE_CHECKING:
    from types import TracebackType

    import numpy as np
    import numpy.typing as npt


@dataclass(frozen=True)
class Block:
    """Rows that came together; an array of two dimensions has a column for each of the four gauges."""

    #: Number of each row since the stream began.
    number: npt.NDArray[np.uint64]
    #: Time of each row by the clock of the device, s.
    time_s: npt.NDArray[np.float64]
    #: Fast adapting part, microstrain.
    fa_ustrain: npt.NDArray[np.float64]
    #: Slow adapting part, microstrain; FA + SA is the strain.
    sa_ustrain: npt.NDArray[np.float64]
    #: Region of the grasp: 0 rest, 1 OA, 2 AB, 3 BC, 4 CD, 5 DE, 6 EF.
    region: npt.NDArray[np.float64]
    #: Type of relaxation: 0 settled, 1 Type I, 2 Type II.
    relaxation: npt.NDArray[np.float64]
    #: Rows of this stream that were lost so far.
    lost: int

    def __len__(self) -> int:
        return len(self.number)


class Device:
    """A fingertip on a port, real or simulated: an iterator over the blocks of its stream.

        with palpate.Device("/dev/ttyACM0") as device:
            for block in device:
                ...

    The stream begins with the iteration and ends with it: by `break`, an exception or Ctrl-C. Rows that the line lost are
    counted in `block.lost`; `palpate record` is for recordings that must survive everything.
    """

    def __init__(self, port: PathLike) -> None:
        self._native = _palpate.Device.open(os.fspath(port))

    def about(self) -> dict[str, Any]:
        """Who it is and how it is set, as `palpate device info --json` has it."""
        told: dict[str, Any] = json.loads(self._native.about())
        return told

    def __iter__(self) -> Iterator[Block]:
        self._native.start()
        try:
            while True:
                yield Block(**self._native.block())
        finally:
            self._native.stop()

    def stop(self) -> None:
        """Ends the stream."""
        self._native.stop()

    def __enter__(self) -> Device:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        raised: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()
