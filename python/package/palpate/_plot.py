"""The figures of reports, drawn with matplotlib."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from palpate._data import TIME
from palpate._drawn import chosen, named

if TYPE_CHECKING:
    from palpate._data import Trace

#: The hues of the reports, readable in every kind of colour vision.
HUES = ("#0072b2", "#d55e00", "#00875f", "#b4558c", "#a87400", "#6d4c36")
INK, GREY, SHADE = "#1b1f24", "#59616b", "#eef2f6"
HEIGHT, WIDTH = 2.4, 8.0


def figure(sections: list[dict[str, Any]], which: int) -> Any:
    """Draws one figure of sections."""
    one = chosen(sections, which)
    draw = {"panels": _panels, "heat map": _heat_map, "bars": _bars}[one["kind"]]
    drawn = draw(one)
    if one["title"]:
        drawn.suptitle(textwrap.fill(one["title"], 90))
    return drawn


def trace(one: Trace) -> Any:
    """Draws the columns of a trace below each other."""
    names = [name for name in one.columns if name != TIME]
    drawn, axes = _stack(len(names))
    for axis, name in zip(axes, names):
        axis.plot(one.time, one[name], color=INK, linewidth=1)
        axis.set_ylabel(name)
    axes[-1].set_xlabel(TIME)
    drawn.suptitle(one.name)
    return drawn


def _stack(count: int, height: float = HEIGHT) -> tuple[Any, list[Any]]:
    """A figure with plots over one x axis."""
    # Not pyplot's: a figure that is given is shown once, and is gone with its last name.
    from palpate._figure import Drawn

    drawn = Drawn(figsize=(WIDTH, max(1, count) * height + 0.8), layout="constrained")
    axes = drawn.subplots(max(1, count), 1, sharex=True, squeeze=False)
    return drawn, [row[0] for row in axes]


def _hue(number: int) -> str:
    return {-1: INK, -2: GREY}.get(number) or HUES[number % len(HUES)]


def _panels(one: dict[str, Any]) -> Any:
    drawn, axes = _stack(len(one["plots"]))
    for axis, plot in zip(axes, one["plots"]):
        _plot(axis, plot)
    axes[-1].set_xlabel(named(one["plots"][-1]["x"]))
    return drawn


def _plot(axis: Any, plot: dict[str, Any]) -> None:
    for start, end, label in plot["spans"]:
        axis.axvspan(start, end, color=SHADE, zorder=0)
        if label:
            place = axis.get_xaxis_transform()
            axis.text((start + end) / 2, 1, label, transform=place, ha="center", va="top", fontsize=7)
    for series in plot["series"]:
        _series(axis, series)
    for value, label in plot["levels"]:
        axis.axhline(value, color=GREY, linewidth=0.8, linestyle=":")
        if label:
            place = axis.get_yaxis_transform()
            axis.text(1, value, label, transform=place, ha="right", va="bottom", fontsize=7)
    for place, label in plot["marks"]:
        axis.axvline(place, color=GREY, linewidth=0.8, linestyle=":", label=label or None)
    for x, y, text in plot["annotations"]:
        axis.annotate(text, (x, y), fontsize=8)
    for which, scale in (("x", plot["x"]), ("y", plot["y"])):
        if scale["log"]:
            getattr(axis, f"set_{which}scale")("log")
        if scale["range"] is not None:
            getattr(axis, f"set_{which}lim")(*scale["range"])
    axis.set_ylabel(named(plot["y"]))
    if plot["title"]:
        axis.set_title(plot["title"], fontsize=9, loc="left")
    if sum(bool(series["name"]) for series in plot["series"]) > 1:
        axis.legend(fontsize=8)


def _series(axis: Any, series: dict[str, Any]) -> None:
    x, y = series["x"], series["y"]
    how = {"color": _hue(series["colour"]), "label": series["name"] or None}
    line = {"linewidth": series["width"], "linestyle": "--" if series["dashed"] else "-"}
    kind = series["kind"]
    if kind == "points":
        axis.plot(x, y, "o", markersize=4, **how)
    elif kind == "band":
        axis.fill_between(x, y, series["upper"], alpha=0.25, linewidth=0, **how)
    elif kind == "error bars":
        axis.errorbar(x, y, series["error"], fmt="o", markersize=4, capsize=2, **how)
    elif kind == "step":
        axis.step(x, y, where="post", **how, **line)
    else:
        axis.plot(x, y, **how, **line)


def _heat_map(one: dict[str, Any]) -> Any:
    import numpy as np

    values = one["values"]
    drawn, (axis,) = _stack(1, 1 + 0.3 * len(one["rows"]))
    most = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 1.0
    image = axis.imshow(values, aspect="auto", cmap="RdBu", vmin=-most, vmax=most)
    axis.set_xticks(range(len(one["columns"])), one["columns"])
    axis.set_yticks(range(len(one["rows"])), one["rows"])
    drawn.colorbar(image, ax=axis)
    return drawn


def _bars(one: dict[str, Any]) -> Any:
    drawn, (axis,) = _stack(1, 3.2)
    count = len(one["series"])
    for place, series in enumerate(one["series"]):
        at = [group + (place - (count - 1) / 2) * 0.8 / count for group in range(len(one["groups"]))]
        errors = series["errors"] if len(series["errors"]) else None
        how = {"color": _hue(series["colour"]), "label": series["name"] or None}
        axis.bar(at, series["values"], 0.8 / count, yerr=errors, capsize=2, **how)
    for value, label in one["levels"]:
        axis.axhline(value, color=GREY, linewidth=0.8, linestyle=":", label=label or None)
    axis.set_xticks(range(len(one["groups"])), one["groups"], rotation=20, ha="right")
    axis.set_ylabel(named(one["axis"]))
    if one["axis"]["log"]:
        axis.set_yscale("log")
    if any(series["name"] for series in one["series"]):
        axis.legend(fontsize=8)
    return drawn
