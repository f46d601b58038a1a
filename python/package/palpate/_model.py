"""Models: base law, parameters, effects, and laws of one's own."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Union

from palpate import _palpate
from palpate._data import PathLike
from palpate.formula import traced

if TYPE_CHECKING:
    from palpate._answers import Change, Discovery, Exploration, Fit, HoldFits

#: What every question takes for a model: one, its file, or the answer that it came of.
AnyModel = Union["Model", "Fit", "HoldFits", "Change", "Discovery", "Exploration", PathLike]


class Model:
    """A base law with its parameters, the effects added to it, and how they were found: a model file in memory.

    A fit gives one (`palpate.fit(data).model`), `Model.read` reads one. It never changes.
    """

    __slots__ = ("_native",)

    def __init__(self, native: _palpate.Model) -> None:
        self._native = native

    @classmethod
    def read(cls, path: PathLike) -> Model:
        """Reads a model file."""
        return cls(_palpate.Model.read(os.fspath(path)))

    @classmethod
    def from_toml(cls, text: str) -> Model:
        """Reads the text of a model file."""
        return cls(_palpate.Model.from_toml(text))

    @classmethod
    def from_dict(cls, keys: Mapping[str, Any]) -> Model:
        """Takes the keys of a model file, as `to_dict` gives them."""
        return cls(_palpate.Model.from_json(json.dumps(keys)))

    def to_toml(self) -> str:
        """The text of the model file."""
        return self._native.to_toml()

    def to_dict(self) -> dict[str, Any]:
        """The keys of the model file."""
        keys: dict[str, Any] = json.loads(self._native.json())
        return keys

    def write(self, path: PathLike, *, force: bool = False) -> None:
        """Writes the model file, whole or not at all; what palpate did not write is replaced only with `force=True`."""
        self._native.write(os.fspath(path), force)

    @property
    def law(self) -> str:
        """The name of its base law."""
        return str(self.to_dict()["base"]["law"])

    @property
    def signal(self) -> str:
        """The column that it predicts."""
        return str(self.to_dict()["base"]["signal"])

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters of its base law."""
        stored = self.to_dict()["base"]["parameters"]
        return {name: parameter["value"] for name, parameter in stored.items()}

    @property
    def effects(self) -> list[str]:
        """The names of its effects, in the order in which they were added."""
        return [effect["name"] for effect in self.to_dict().get("effect", [])]

    def with_law(
        self,
        name: str,
        stage: str,
        expression: str | Callable[..., Any],
        parameters: Mapping[str, float | Mapping[str, Any]],
        *,
        meaning: str | None = None,
    ) -> Model:
        """The same model with a law of one's own to be tried: `diagnose` ranks it among the effects, `add` adds it.

        `stage` is where in the chain it acts (`motion`, `elasticity`, `relaxation`, `contact` or `sensor`), `expression` a
        formula over `t`, `x`, `v`, `a`, `F`, `T`, `n` and `x_max` (docs/formats.md), or a Python function that takes
        some of these and the parameters by name. The function is called once, with symbols: it may compute with operators,
        numpy's functions and those of `palpate.formula`, but not branch. Either is compiled and as
        fast as an effect of the library. `parameters` are its starting values by name, or mappings with `value`, `unit`,
        `lower` and `upper`; the first is the strength that makes the law vanish at 0.
        """
        def stored(value: float | Mapping[str, Any]) -> dict[str, Any]:
            return dict(value) if isinstance(value, Mapping) else {"value": float(value)}

        law: dict[str, Any] = {
            "name": name,
            "stage": stage,
            "expression": traced(expression, list(parameters)) if callable(expression) else expression,
            "parameters": {key: stored(value) for key, value in parameters.items()},
        }
        if meaning is not None:
            law["meaning"] = meaning
        keys = self.to_dict()
        return Model.from_dict({**keys, "candidate": [*keys.get("candidate", []), law]})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.to_toml() == other.to_toml()

    def __hash__(self) -> int:
        return hash(self.to_toml())

    def __repr__(self) -> str:
        effects = "".join(f" + {effect}" for effect in self.effects)
        return f"<palpate.Model {self.law}{effects} of {self.signal}>"

    def _repr_html_(self) -> str:
        from palpate import _html

        return _html.model(self)


def native(model: AnyModel) -> _palpate.Model:
    """What every question takes for a model."""
    if isinstance(model, Model):
        return model._native
    if isinstance(model, (str, os.PathLike)):
        return Model.read(model)._native
    return model.model._native


def effects() -> dict[str, Any]:
    """The library of effects, as `palpate effects --json` prints it."""
    library: dict[str, Any] = json.loads(_palpate.effects())
    return library
