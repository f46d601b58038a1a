"""The questions, each with the options of the command of its name."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Literal, TypeVar, Union

from palpate import _palpate
from palpate._answers import (
    Answer,
    Change,
    Comparison,
    Diagnosis,
    Discovery,
    Exploration,
    Fit,
    HoldFits,
    Plan,
    Ranking,
    Relaxation,
    Segmentation,
)
from palpate._data import Data, DataSet, PathLike, Trace, native
from palpate._model import AnyModel
from palpate._model import native as native_model
from palpate._options import listed, options
from palpate._parts import Decomposition
from palpate._progress import told

A = TypeVar("A", bound=Answer)
Terms = Union[int, Literal["auto"]]
Separation = Literal["clamp", "free", "bonded"]


def fit(
    data: Data,
    law: str = "fung",
    *,
    terms: Terms | None = None,
    separation: Separation | None = None,
    segments: int | None = None,
    exponent: float | Literal["auto"] | None = None,
    elastic: str | None = None,
    relaxation: str | None = None,
    signal: str | None = None,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Fit:
    """Fits a law to load, hold and unload of all traces together: `palpate fit LAW`.

    `law` is `kelvin-voigt`, `maxwell`, `generalized-maxwell`, `fung`, `latency`, `latency-power` or `creep`; `terms` its
    number of exponentials (1 to 4, or `auto`; 2), `separation` what happens where contact breaks (`clamp`), `segments`
    and `exponent` options of the latency models, `elastic` and `relaxation` other responses than power law and
    exponentials, `signal` the column (`force_N`). `tare` takes its mean before the touch off each trace, `drop_outliers`
    leaves out impossible samples, `join_steps` takes the motion as straight between its steps where the displacement was
    held or rounded. The answer has the model.
    """
    words = options(
        terms=terms,
        separation=separation,
        segments=segments,
        exponent=exponent,
        elastic=elastic,
        relaxation=relaxation,
        signal=signal,
        tare=tare,
        drop_outliers=drop_outliers,
        join_steps=join_steps,
    )
    with told() as tell:
        return _warned(Fit(_palpate.fit(law, native(data), words, tell)))


def fit_holds(
    data: Data,
    *,
    terms: Terms | None = None,
    signs: bool = False,
    signal: str | None = None,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> HoldFits:
    """Fits eq. 3.4 to each hold by itself: `palpate fit fung --hold-only`.

    `signs` lets no share have the wrong sign for its type, nor c0 be negative.
    """
    words = options(
        hold_only=True,
        terms=terms,
        signs=signs,
        signal=signal,
        tare=tare,
        drop_outliers=drop_outliers,
        join_steps=join_steps,
    )
    with told() as tell:
        return HoldFits(_palpate.fit("fung", native(data), words, tell))


def fit_all(
    data: Data,
    *,
    terms: int | None = None,
    separation: Separation | None = None,
    signal: str | None = None,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Ranking:
    """Fits every law and ranks them by their error on traces left out: `palpate fit --all`."""
    words = options(
        terms=terms,
        separation=separation,
        signal=signal,
        tare=tare,
        drop_outliers=drop_outliers,
        join_steps=join_steps,
    )
    with told() as tell:
        return Ranking(_palpate.fit(None, native(data), words, tell))


def compare(
    model: AnyModel,
    data: Data,
    *,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Comparison:
    """Says in which traces and regions a model fails, and what the error depends on: `palpate compare`."""
    words = options(tare=tare, drop_outliers=drop_outliers, join_steps=join_steps)
    with told() as tell:
        return Comparison(_palpate.compare(native_model(model), native(data), words, tell))


def diagnose(
    model: AnyModel,
    data: Data,
    *,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Diagnosis:
    """Says which physical effect a model lacks, how sure that is, and what would decide: `palpate diagnose`."""
    words = options(tare=tare, drop_outliers=drop_outliers, join_steps=join_steps)
    with told() as tell:
        return Diagnosis(_palpate.diagnose(native_model(model), native(data), words, tell))


def explore(
    model: AnyModel,
    data: Data,
    *,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Exploration:
    """Adds what is missing, one effect after the other, until only noise is left: `palpate explore`."""
    words = options(tare=tare, drop_outliers=drop_outliers, join_steps=join_steps)
    with told() as tell:
        return Exploration(_palpate.explore(native_model(model), native(data), words, tell))


def discover(
    model: AnyModel,
    data: Data,
    *,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Discovery:
    """Finds a formula for what no effect of the library explains: `palpate discover`."""
    words = options(tare=tare, drop_outliers=drop_outliers, join_steps=join_steps)
    with told() as tell:
        return Discovery(_palpate.discover(native_model(model), native(data), words, tell))


def add(
    effect: str,
    model: AnyModel,
    data: Data,
    *,
    law: str | None = None,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Change:
    """Adds an effect of the library, or a law of one's own, to a model and refits it: `palpate add`.

    Where an effect has several laws, the one with the least BIC is taken, or `law`. Raises `Error` with status 1 where
    the error rises.
    """
    words = options(law=law, tare=tare, drop_outliers=drop_outliers, join_steps=join_steps)
    with told() as tell:
        return _warned(Change(_palpate.add(effect, native_model(model), native(data), words, tell)))


def drop(
    effect: str,
    model: AnyModel,
    data: Data,
    *,
    tare: bool = False,
    drop_outliers: bool = False,
    join_steps: bool = False,
) -> Change:
    """Takes an effect out of a model and refits what remains: `palpate drop`."""
    words = options(tare=tare, drop_outliers=drop_outliers, join_steps=join_steps)
    with told() as tell:
        return _warned(Change(_palpate.drop(effect, native_model(model), native(data), words, tell)))


def decompose(
    data: Data, model: AnyModel | None = None, *, signal: str | Sequence[str] | None = None
) -> Decomposition:
    """Splits signals into what adapts fast and what slowly, by the filter of the device: `palpate decompose`.

    `signal` names columns; without it, the gauges, or the force where there is no gauge. The relaxation function is that
    of `model`, or that of eq. 3.6.
    """
    columns = [signal] if isinstance(signal, str) else signal
    words = options(signal=None if columns is None else list(columns))
    of = None if model is None else native_model(model)
    taken = native(data)
    with told() as tell:
        answer, parts = _palpate.decompose(of, taken, words, tell)
    return Decomposition(answer, parts, taken)


def segment(data: Data) -> Segmentation:
    """Cuts grasps into their six regions, cycle by cycle, with work and dissipation: `palpate segment`."""
    with told() as tell:
        return Segmentation(_palpate.segment(native(data), tell))


def relaxation(
    data: Data, *, terms: Terms | None = None, signs: bool = False, signal: str | None = None
) -> Relaxation:
    """Says what each hold shows, whether repeats agree, how many exponentials are told: `palpate relaxation`."""
    words = options(terms=terms, signs=signs, signal=signal)
    with told() as tell:
        return Relaxation(_palpate.relaxation(native(data), words, tell))


def simulate(
    model: AnyModel,
    motion: Trace | DataSet | PathLike | None = None,
    *,
    force: PathLike | None = None,
    nodes: bool = False,
    noise: float | None = None,
    seed: int | None = None,
) -> Trace:
    """Predicts the force of a motion, or the motion under a controlled force: `palpate simulate`.

    `motion` is a trace, in memory or a file, or the file of a motion profile; `force` the file of a force profile.
    `noise` adds white noise of that standard deviation with `seed`.
    """
    words = options(nodes=nodes, noise=noise, seed=seed)
    of = native_model(model)
    if (motion is None) == (force is None):
        raise _palpate.Error("give either a motion or a force profile")
    if force is not None:
        made, remarks = _palpate.simulate_force(of, os.fspath(force), words)
    elif isinstance(motion, (Trace, DataSet)):
        if isinstance(motion, DataSet) and len(motion) != 1:
            raise _palpate.Error(f"{len(motion)} traces given: simulate the motion of one, data[0]")
        made, remarks = _palpate.simulate(of, native(motion), words)
    else:
        assert motion is not None
        made, remarks = _palpate.simulate_file(of, os.fspath(motion), words)
    for remark in remarks:
        warnings.warn(remark, stacklevel=2)
    return DataSet(made)[0]


def plan(
    noise: float,
    model: AnyModel | None = None,
    *,
    compression: float | None = None,
    force: float | None = None,
    shares: Sequence[float] | None = None,
    rates: Sequence[float] | None = None,
    rate: float | None = None,
    duration: float | None = None,
    want: Mapping[str, float] | None = None,
    longest: float | None = None,
    fastest: float | None = None,
) -> Plan:
    """Says how long and how fast to record to know a parameter to so many percent: `palpate plan`.

    `noise` is the standard deviation of one sample. The relaxation function is that of `model` at a `compression` (mm),
    or `shares` and `rates` (1/s) from a `force` on, or that of eqs 3.5 and 3.6. `want` has percent by parameter.
    """
    words = options(
        noise=noise,
        compression=compression,
        force=force,
        shares=listed(shares),
        rates=listed(rates),
        rate=rate,
        duration=duration,
        want=[f"{name}={percent}" for name, percent in (want or {}).items()],
        longest=longest,
        fastest=fastest,
    )
    of = None if model is None else native_model(model)
    with told() as tell:
        return Plan(_palpate.plan(of, words, tell))


def _warned(answer: A) -> A:
    """The answer, with a warning where the command would end with status 1."""
    failed = answer._native.failed()
    if failed is not None:
        warnings.warn(failed, stacklevel=3)
    return answer
