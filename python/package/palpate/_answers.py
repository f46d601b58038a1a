"""What questions give: the answers of the commands, as objects, frames, tables and plots."""

from __future__ import annotations

import json
import os
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from palpate import _palpate
from palpate._data import PathLike
from palpate._model import Model

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Parameter:
    """A fitted value."""

    #: Its value, in `unit`.
    value: float
    #: Its standard error; None where the data do not determine it.
    standard_error: float | None
    #: Its unit; empty for a pure number.
    unit: str


def parameter(given: dict[str, Any]) -> Parameter:
    """A fitted value as the JSON answer has it."""
    return Parameter(given["value"], given["standard_error"], given.get("unit", ""))


class Answer:
    """What a question found.

    `to_dict()` is the JSON object of the command's `--json`, `to_frame()` its main table for pandas, `plot()` the
    figures of its report with matplotlib, `report(path)` the report itself. `print(answer)` says what a terminal shows.
    """

    def __init__(self, native: _palpate.Answer) -> None:
        self._native = native
        for remark in native.remarks():
            warnings.warn(remark, stacklevel=3)

    @cached_property
    def _answer(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    def to_dict(self) -> dict[str, Any]:
        """The answer as the command's `--json` prints it."""
        found: dict[str, Any] = json.loads(self._native.json())
        return found

    def to_frame(self) -> pd.DataFrame:
        """The main table of the answer as a pandas frame, with numbers as they are."""
        import pandas as pd

        return pd.DataFrame(self._rows())

    def _rows(self) -> list[dict[str, Any]]:
        raise NotImplementedError(f"{type(self).__name__} has no table of numbers; see to_dict()")

    def plot(self, which: int | None = None) -> Any:
        """Draws a figure of the report with matplotlib and gives it; without `which`, the first."""
        from palpate import _plot

        return _plot.figure(self.sections(), which or 0)

    def plot_data(self, which: int | None = None) -> pd.DataFrame:
        """The numbers of a figure of the report, all of them, a row a point, a cell or a bar; without `which`, the first.

        `plot_data().to_csv("figure.csv")` writes them for another program.
        """
        from palpate import _drawn

        return _drawn.numbers(self.sections(), which or 0)

    def sections(self, *, short: bool = False) -> list[dict[str, Any]]:
        """The sections of the report as plain objects (`short`: those of the terminal), to draw or set them otherwise."""
        return self._native.sections(short)

    def report(self, path: PathLike, *, force: bool = False) -> None:
        """Writes the report of `--report`: one HTML file that needs nothing else."""
        self._native.report(os.fspath(path), force)

    @property
    def title(self) -> str:
        """What it is of."""
        return self._native.title()

    def __str__(self) -> str:
        from palpate import _html

        return _html.text(self.sections(short=True))

    def __repr__(self) -> str:
        return f"<palpate.{type(self).__name__}: {self.title}>"

    def _repr_html_(self) -> str:
        from palpate import _html

        return _html.answer(self)


class _WithModel(Answer):
    """An answer that a model came of."""

    @cached_property
    def model(self) -> Model:
        """The model that came of it."""
        made = self._native.model()
        if made is None:
            raise _palpate.Error(f"no model came of {self.title.lower()}")
        return Model(made)


class Fit(_WithModel):
    """A law fitted to whole motions."""

    @property
    def law(self) -> str:
        """The name of the law."""
        return str(self._answer["law"])

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Its parameters by name."""
        return {name: parameter(given) for name, given in self._answer["parameters"].items()}

    @property
    def rms(self) -> float:
        """Root mean square of what the law leaves, in `unit`."""
        return float(self._answer["residual_rms"])

    @property
    def held_out_rms(self) -> float | None:
        """The same over each trace left out of the fit in turn; None for a single trace."""
        found: float | None = self._answer["heldout_rms"]
        return found

    @property
    def noise_rms(self) -> float | None:
        """The noise of the signal where it is told without the model."""
        found: float | None = self._answer["noise_rms"]
        return found

    @property
    def r_squared(self) -> float:
        """Coefficient of determination."""
        return float(self._answer["r_squared"])

    @property
    def unit(self) -> str:
        """The unit of the signal and of its errors."""
        return str(self._answer["unit"])

    @property
    def converged(self) -> bool:
        """Whether the search came to an end by itself; the command's status is 1 where it did not."""
        return bool(self._answer["converged"])

    @property
    def warnings(self) -> list[str]:
        """What to beware of."""
        return list(self._answer["warnings"])

    def _rows(self) -> list[dict[str, Any]]:
        return [{"parameter": name, **given} for name, given in self._answer["parameters"].items()]


class HoldFits(_WithModel):
    """Eq. 3.4 fitted to each hold by itself."""

    def _rows(self) -> list[dict[str, Any]]:
        return [_flat(hold) for hold in self._answer["holds"]]


class Ranking(Answer):
    """Every law, best first."""

    @property
    def best(self) -> str:
        """The law that predicts best what it has not seen."""
        return str(self._answer["laws"][0]["law"])

    def _rows(self) -> list[dict[str, Any]]:
        return [_flat(law) for law in self._answer["laws"]]


class Comparison(Answer):
    """A model against measurements: where it fails and what the error depends on."""

    @property
    def rms(self) -> float:
        """Root mean square error."""
        return float(self._answer["rms"])

    @property
    def noise_rms(self) -> float | None:
        """The noise of the signal where it is told without the model."""
        found: float | None = self._answer["noise_rms"]
        return found

    @property
    def only_noise(self) -> bool:
        """Whether what is left is noise."""
        return bool(self._answer["only_noise"])

    @property
    def in_words(self) -> str:
        """Where it fails, in words."""
        return str(self._answer["in_words"])

    def _rows(self) -> list[dict[str, Any]]:
        return list(self._answer["where"])


@dataclass(frozen=True)
class Step:
    """One effect that was missing, with its evidence."""

    #: The effect.
    effect: str
    #: The law of it that fits best.
    law: str | None
    #: Effects that the traces cannot distinguish from it.
    credible_set: list[str]
    #: Its parameters by name.
    parameters: dict[str, Parameter]
    #: Root mean square error before and after, on the traces fitted.
    rms: tuple[float, float]
    #: The same on traces left out; None where there are too few.
    held_out_rms: tuple[float | None, float | None]
    #: How much the Bayesian information criterion fell.
    delta_bic: float
    #: Chance of as much by noise alone.
    p_value: float | None


def _step(given: dict[str, Any]) -> Step:
    return Step(
        effect=given["effect"],
        law=given["law"],
        credible_set=list(given["credible_set"]),
        parameters={name: parameter(one) for name, one in given["parameters"].items()},
        rms=(given["rms_before"], given["rms_after"]),
        held_out_rms=(given["heldout_rms_before"], given["heldout_rms_after"]),
        delta_bic=given["delta_bic"],
        p_value=given["p_value"],
    )


class Diagnosis(Answer):
    """Which physical effect a model lacks."""

    @property
    def verdict(self) -> str:
        """`adequate`, `named`, `ambiguous` or `unknown`."""
        return str(self._answer["verdict"])

    @property
    def steps(self) -> list[Step]:
        """The effects that were missing, in the order in which they help."""
        return [_step(given) for given in self._answer["steps"]]

    @property
    def effects(self) -> list[str]:
        """Their names."""
        return [step.effect for step in self.steps]

    @property
    def next_experiment(self) -> str | None:
        """What to record to know more; None where nothing is open."""
        found: str | None = self._answer["next_experiment"]
        return found

    @property
    def in_words(self) -> str:
        """The verdict in words."""
        return str(self._answer["in_words"])

    def _rows(self) -> list[dict[str, Any]]:
        return [_flat(step) for step in self._answer["steps"]]


class Exploration(Diagnosis, _WithModel):
    """The way from a first model to the last, which is its `model`."""


class Discovery(_WithModel):
    """Formulas for what no effect of the library explains; its `model` has them as candidates."""

    @property
    def outcome(self) -> str:
        """`adequate`, `library`, `formula` or `nothing`."""
        return str(self._answer["outcome"])

    @property
    def formulas(self) -> list[dict[str, Any]]:
        """Each with its `name`, `stage`, `expression`, `parameters`, `alternatives`, `cause` and `experiment`."""
        found: list[dict[str, Any]] = self._answer["formulas"]
        return found

    @property
    def ladder(self) -> list[dict[str, Any]]:
        """The errors of the model without formula and with each: `add`, `fitted_rms`, `heldout_rms`."""
        found: list[dict[str, Any]] = self._answer["ladder"]
        return found

    def _rows(self) -> list[dict[str, Any]]:
        return self.ladder


class Change(_WithModel):
    """An effect added to a model, or taken out, and what that did to the error."""

    @property
    def effect(self) -> str:
        """The effect."""
        return str(self._answer["effect"])

    @property
    def rms(self) -> tuple[float, float]:
        """Root mean square error before and after, on the traces fitted."""
        return self._answer["rms_before"], self._answer["rms_after"]

    @property
    def held_out_rms(self) -> tuple[float | None, float | None]:
        """The same on traces left out; None for a single trace."""
        return self._answer["heldout_rms_before"], self._answer["heldout_rms_after"]

    @property
    def parameters(self) -> dict[str, dict[str, Parameter]]:
        """The parameters of the base law and of each effect, by name."""
        return {
            of: {name: parameter(given) for name, given in parameters.items()}
            for of, parameters in self._answer["parameters"].items()
        }

    def _rows(self) -> list[dict[str, Any]]:
        return list(self._answer["ladder"])


class Segmentation(Answer):
    """Grasps in their six regions, cycle by cycle."""

    def _rows(self) -> list[dict[str, Any]]:
        return [
            {"trace": trace["trace"], **_flat(cycle)}
            for trace in self._answer["traces"]
            for cycle in trace["cycles"]
        ]


class Relaxation(Answer):
    """What holds of a displacement show."""

    def _rows(self) -> list[dict[str, Any]]:
        return [_flat(hold) for hold in self._answer["holds"]]


class Plan(Answer):
    """What recordings would determine."""

    @property
    def standard_errors(self) -> dict[str, float | None]:
        """The least standard error of each parameter; None where it is not determined."""
        return dict(self._answer["standard_errors"])

    def _rows(self) -> list[dict[str, Any]]:
        errors = self.standard_errors.items()
        return [{"parameter": name, "standard_error": error} for name, error in errors]


def _flat(nested: dict[str, Any], before: str = "") -> dict[str, Any]:
    """A row of a table: nested objects as columns of their own, `parameters.v1.value`; lists stay as they are."""
    row: dict[str, Any] = {}
    for key, value in nested.items():
        if isinstance(value, dict):
            row.update(_flat(value, f"{before}{key}."))
        else:
            row[before + key] = value
    return row
