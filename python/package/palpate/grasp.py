"""What a soft contact carries before it slips: `palpate grasp`.

A contact is given by its sizes in mm: `circle:R`, `ellipse:XxY`, `rectangle:LxW` of a fixed size, `sphere:R`,
`cylinder:RxH:POISSON`, `block:LxWxH:POISSON` that grow as they are pressed.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, Union

from palpate import _palpate
from palpate._answers import Answer
from palpate._data import Data, PathLike, native
from palpate._model import AnyModel
from palpate._model import native as native_model
from palpate._options import listed, options

#: A column, or a number.
Source = Union[str, float]


class Surface(Answer):
    """What a contact carries, and the margin of a load."""

    def _rows(self) -> list[dict[str, Any]]:
        return list(self._answer["points"])


class Growth(Answer):
    """A limit surface over time."""

    def _rows(self) -> list[dict[str, Any]]:
        return list(self._answer["course"])


class Margin(Answer):
    """The margin over recordings."""

    def _rows(self) -> list[dict[str, Any]]:
        return list(self._answer["traces"])


class Friction(Answer):
    """Friction and pressure from a slide."""


class HandPlan(Answer):
    """How several fingers are to grasp."""


def surface(
    contact: str,
    *,
    friction: float,
    force: float,
    exponent: float | None = None,
    compression: float | None = None,
    tangential: float | None = None,
    across: float | None = None,
    moment: float | None = None,
    directions: int | None = None,
    steps: int | None = None,
) -> Surface:
    """The limit surface of a contact pressed with `force` (N), and the margin of a load: `palpate grasp surface`."""
    words = options(
        contact=contact,
        friction=friction,
        force=force,
        exponent=exponent,
        compression=compression,
        tangential=tangential,
        across=across,
        moment=moment,
        directions=directions,
        steps=steps,
    )
    return Surface(_palpate.grasp_surface(words))


def growth(
    contact: str,
    model: AnyModel | None = None,
    *,
    friction: float,
    force: float | None = None,
    compression: float | None = None,
    creep: float | None = None,
    shares: Sequence[float] | None = None,
    rates: Sequence[float] | None = None,
    exponent: float | None = None,
    duration: float | None = None,
    points: int | None = None,
) -> Growth:
    """How the limit surface grows under creep or shrinks under relaxation: `palpate grasp growth`."""
    words = options(
        contact=contact,
        friction=friction,
        force=force,
        compression=compression,
        creep=creep,
        shares=listed(shares),
        rates=listed(rates),
        exponent=exponent,
        duration=duration,
        points=points,
    )
    return Growth(_palpate.grasp_growth(None if model is None else native_model(model), words))


def margin(
    data: Data,
    model: AnyModel | None = None,
    *,
    friction: float,
    contact: str | None = None,
    exponent: float | None = None,
    normal: str | None = None,
    tangential: Source | None = None,
    across: Source | None = None,
    moment: Source | None = None,
    contact_above: float | None = None,
) -> Margin:
    """The margin over recordings, and when they first slip; with a model also once settled: `palpate grasp margin`."""
    words = options(
        contact=contact,
        friction=friction,
        exponent=exponent,
        normal=normal,
        tangential=tangential,
        across=across,
        moment=moment,
        contact_above=contact_above,
    )
    of = None if model is None else native_model(model)
    return Margin(_palpate.grasp_margin(of, native(data), words))


def friction(
    data: Data,
    *,
    contact: str | None = None,
    exponent: float | None = None,
    from_: float | None = None,
    to: float | None = None,
    normal: str | None = None,
    tangential: str | None = None,
    across: str | None = None,
    moment: str | None = None,
    contact_above: float | None = None,
) -> Friction:
    """Friction μ and exponent k of the pressure from one recorded slide: `palpate grasp friction`."""
    words = options(
        contact=contact,
        exponent=exponent,
        from_=from_,
        to=to,
        normal=normal,
        tangential=tangential,
        across=across,
        moment=moment,
        contact_above=contact_above,
    )
    taken = native(data)
    if len(taken) != 1:
        raise _palpate.Error(f"{len(taken)} traces given: a slide is one")
    return Friction(_palpate.grasp_friction(taken, words))


def plan(
    hand: PathLike,
    model: AnyModel | None = None,
    *,
    margin: float | None = None,
    least: Literal["sum", "largest"] | None = None,
    for_: float | None = None,
    after: float | None = None,
) -> HandPlan:
    """Several fingers on one object, by the file of a hand: least grip, margin, when it slips: `palpate grasp plan`."""
    words = options(margin=margin, least=least, for_=for_, after=after)
    of = None if model is None else native_model(model)
    return HandPlan(_palpate.grasp_plan(os.fspath(hand), of, words))
