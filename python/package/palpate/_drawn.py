"""The figures of reports, and the numbers that they draw."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from palpate._palpate import Error

if TYPE_CHECKING:
    import pandas as pd


def figures(sections: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The figures of sections, those that are folded away included."""
    found: list[dict[str, Any]] = []

    def gather(blocks: list[dict[str, Any]]) -> None:
        for block in blocks:
            if block["kind"] == "details":
                gather(block["blocks"])
            elif block["kind"] in ("panels", "heat map", "bars"):
                found.append(block)

    for section in sections:
        gather(section["blocks"])
    return found


def chosen(sections: list[dict[str, Any]], which: int) -> dict[str, Any]:
    """One figure of sections, by its place."""
    found = figures(sections)
    if not found:
        raise Error("nothing is drawn of this answer")
    if not -len(found) <= which < len(found):
        raise Error(f"figure {which} of {len(found)}")
    return found[which]


def numbers(sections: list[dict[str, Any]], which: int) -> pd.DataFrame:
    """What one figure of sections draws, a row a point, a cell or a bar."""
    import pandas as pd

    one = chosen(sections, which)
    rows = {"panels": _points, "heat map": _cells, "bars": _bars}[one["kind"]](one)
    frame = pd.DataFrame(rows)
    frame.attrs["title"] = one["title"]
    return frame


def _points(figure: dict[str, Any]) -> list[dict[str, Any]]:
    rows = []
    for plot in figure["plots"]:
        x, y = (named(plot[axis]) for axis in ("x", "y"))
        for series in plot["series"]:
            # A band goes from `y` to its upper end; bars reach as far as their error to both sides.
            others = {f"{y} {name}": series[name] for name in ("upper", "error") if name in series}
            columns = {x: series["x"], y: series["y"], **others}
            said = {"plot": plot["title"], "series": series["name"]}
            for values in zip(*(column.tolist() for column in columns.values())):
                rows.append({**said, **dict(zip(columns, values))})
    return rows


def named(axis: dict[str, Any]) -> str:
    """What an axis says: its label with its unit."""
    return f"{axis['label']} ({axis['unit']})" if axis["unit"] else str(axis["label"])


def _cells(figure: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        {"row": row, "column": column, "value": value}
        for row, values in zip(figure["rows"], figure["values"].tolist())
        for column, value in zip(figure["columns"], values)
    ]


def _bars(figure: dict[str, Any]) -> list[dict[str, Any]]:
    rows = []
    for series in figure["series"]:
        # Bars without errors have none at all.
        errors = series["errors"].tolist() or [None] * len(figure["groups"])
        for group, value, error in zip(figure["groups"], series["values"].tolist(), errors):
            said = {"group": group, "series": series["name"]}
            rows.append({**said, named(figure["axis"]): value, "error": error})
    return rows
