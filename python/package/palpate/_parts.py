"""Signals in their fast and slow adapting parts, as the device computes them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from palpate import _palpate
from palpate._answers import Answer
from palpate._data import DataSet

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd

#: The parts of a signal.
NAMES = ("input", "fa", "sa", "elastic", "equilibrium", "latent")


class Part:
    """One signal of one trace in its parts: read-only arrays over the memory that the filter wrote."""

    __slots__ = ("_channel", "_parts", "_trace", "signal")

    def __init__(self, parts: _palpate.Parts, trace: int, channel: int, signal: str) -> None:
        self._parts, self._trace, self._channel = parts, trace, channel
        #: The column that it came from.
        self.signal = signal

    def _part(self, name: str) -> npt.NDArray[np.float64]:
        return self._parts.part(self._trace, self._channel, name)

    @property
    def input(self) -> npt.NDArray[np.float64]:
        """The signal as the filter took it: rounded to the device's integers."""
        return self._part("input")

    @property
    def fa(self) -> npt.NDArray[np.float64]:
        """The fast adapting part; FA + SA is the input."""
        return self._part("fa")

    @property
    def sa(self) -> npt.NDArray[np.float64]:
        """The slow adapting part."""
        return self._part("sa")

    @property
    def elastic(self) -> npt.NDArray[np.float64]:
        """The response without memory to the same motion."""
        return self._part("elastic")

    @property
    def equilibrium(self) -> npt.NDArray[np.float64]:
        """Where the signal settles if the motion stops."""
        return self._part("equilibrium")

    @property
    def latent(self) -> npt.NDArray[np.float64]:
        """What is still to relax: input − equilibrium."""
        return self._part("latent")

    def integers(self, name: str) -> npt.NDArray[np.int32]:
        """A part in the device's own integers, bit for bit, by its name (`fa`)."""
        import numpy as np

        # A count of at most 32 bits times a power of two, or the device's 2⁻⁸: the quotient is exact.
        return (self._part(name) / self.lsb).astype(np.int32)

    @property
    def lsb(self) -> float:
        """One of the device's integers, in the unit of the signal: a power of two."""
        return self._parts.lsb(self._trace, self._channel)

    @property
    def saturated(self) -> int:
        """How many samples were beyond full scale."""
        return self._parts.saturated(self._trace, self._channel)

    @property
    def region(self) -> npt.NDArray[np.uint8]:
        """The region of every sample: 0 rest, 1 OA, 2 AB, 3 BC, 4 CD, 5 DE, 6 EF."""
        return self._parts.region(self._trace, self._channel)

    @property
    def relaxation(self) -> npt.NDArray[np.uint8]:
        """The type of relaxation of every sample: 0 settled, 1 Type I, 2 Type II."""
        return self._parts.relaxation(self._trace, self._channel)

    def __repr__(self) -> str:
        return f"<palpate.Part {self.signal}: {len(self.input)} samples>"


class Decomposition(Answer):
    """Traces in their fast and slow adapting parts; `parts["gauge1_ustrain"]` is a signal of the first trace."""

    def __init__(
        self, native: _palpate.Answer, parts: _palpate.Parts, data: _palpate.DataSet
    ) -> None:
        super().__init__(native)
        self._parts, self._data = parts, DataSet(data)

    def trace(self, index: int) -> dict[str, Part]:
        """The signals of one trace by name."""
        signals = self._parts.signals()[index]
        place = range(len(self._parts.signals()))[index]
        return {
            signal: Part(self._parts, place, channel, signal)
            for channel, signal in enumerate(signals)
        }

    def __getitem__(self, signal: str) -> Part:
        return self.trace(0)[signal]

    def __iter__(self) -> Iterator[dict[str, Part]]:
        return (self.trace(index) for index in range(len(self)))

    def __len__(self) -> int:
        return len(self._data)

    @property
    def data(self) -> DataSet:
        """The traces with their parts as further columns, as `palpate decompose -o` writes them."""
        return DataSet(self._native.traces())

    def to_frame(self) -> pd.DataFrame:
        """The parts of every sample: trace, time, signal, each part, region and type of relaxation."""
        import pandas as pd

        frames = []
        for trace, parts in zip(self._data, self):
            for signal, part in parts.items():
                columns: dict[str, Any] = {"time_s": trace.time}
                columns.update({name: part._part(name) for name in NAMES})
                columns.update(region=part.region, relaxation=part.relaxation)
                frames.append(pd.DataFrame(columns).assign(trace=trace.name, signal=signal))
        return pd.concat(frames, ignore_index=True)
