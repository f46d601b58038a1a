"""Answers as HTML for notebooks, and as text."""

from __future__ import annotations

import base64
import re
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from palpate._answers import Answer
    from palpate._data import Trace
    from palpate._model import Model

#: Most traces that a table lists.
MOST = 30


def answer(one: Answer) -> str:
    """What a terminal shows of an answer, and the first figure of its report."""
    from palpate import _drawn

    told = "".join(_section(section) for section in one.sections(short=True))
    drawn = _drawn.figures(one.sections())
    picture = _picture(drawn[0]) if drawn else ""
    return f'<div class="palpate">{told}{picture}</div>'


def traces(some: list[Trace]) -> str:
    """What traces are there, as a table."""
    rows = [
        (trace.name, len(trace), f"{trace.time[-1] - trace.time[0]:.4g}", ", ".join(trace.columns))
        for trace in some[:MOST]
    ]
    told = _table(("trace", "samples", "duration (s)", "columns"), rows)
    more = len(some) - MOST
    return told + (f"<p>and {more} more</p>" if more > 0 else "")


def model(one: Model) -> str:
    """A model's law, effects and parameters, as a table."""
    keys = one.to_dict()
    parts = [(keys["base"]["law"], keys["base"]["parameters"])]
    parts += [(effect["name"], effect["parameters"]) for effect in keys.get("effect", [])]
    rows = []
    for of, parameters in parts:
        for name, stored in parameters.items():
            error = stored.get("standard_error")
            known = "" if error is None else f"{error:.2g}"
            rows.append((of, name, f"{stored['value']:.6g}", known, stored.get("unit", "")))
    return _table(("of", "parameter", "value", "standard error", "unit"), rows)


def _section(section: dict[str, Any]) -> str:
    return f"<h4>{_inline(section['title'])}</h4>" + "".join(map(_block, section["blocks"]))


def _block(block: dict[str, Any]) -> str:
    kind = block["kind"]
    if kind in ("heading", "paragraph"):
        mark = "h5" if kind == "heading" else "p"
        return f"<{mark}>{_inline(block['text'])}</{mark}>"
    if kind == "code":
        return f"<pre>{escape(block['text'])}</pre>"
    if kind == "list":
        return "<ul>" + "".join(f"<li>{_inline(point)}</li>" for point in block["points"]) + "</ul>"
    if kind == "callout":
        colour = "#d55e00" if block["warning"] else "#00875f"
        words = f"<b>{_inline(block['title'])}</b> {_inline(block['text'])}"
        return f'<p style="border-left:4px solid {colour};padding-left:.6em">{words}</p>'
    if kind == "definitions":
        pairs = (f"<dt>{_inline(a)}</dt><dd>{_inline(b)}</dd>" for a, b in block["terms"])
        return "<dl>" + "".join(pairs) + "</dl>"
    if kind == "details":
        inside = "".join(map(_block, block["blocks"]))
        return f"<details><summary>{_inline(block['summary'])}</summary>{inside}</details>"
    if kind == "table":
        heads = [f"{name} ({unit})" if unit else name for name, unit in block["columns"]]
        notes = "".join(f"<p><small>{_inline(note)}</small></p>" for note in block["notes"])
        return _table(heads, block["rows"], block["caption"]) + notes
    return ""  # a figure: the first of the report stands below


def _table(heads: Any, rows: Any, caption: str = "") -> str:
    told = f"<caption>{_inline(caption)}</caption>" if caption else ""
    head = "".join(f"<th>{_inline(str(name))}</th>" for name in heads)
    body = "".join(
        "<tr>" + "".join(f"<td>{_inline(str(cell))}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table>{told}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _picture(figure: dict[str, Any]) -> str:
    """A figure as a picture of its own, whose style touches nothing else on the page."""
    data = base64.b64encode(figure["svg"].encode()).decode()
    about = escape(figure["summary"] or figure["title"], quote=True)
    source = f"data:image/svg+xml;base64,{data}"
    return f'<img alt="{about}" style="max-width:100%;background:#fff" src="{source}">'


def _inline(words: str) -> str:
    """Text in which what stands between backticks is code."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(words))


def text(sections: list[dict[str, Any]]) -> str:
    """Sections as plain text."""
    lines: list[str] = []

    def tell(block: dict[str, Any]) -> None:
        kind = block["kind"]
        if kind in ("heading", "paragraph", "code"):
            lines.append(block["text"].replace("`", ""))
        elif kind == "list":
            lines.extend("- " + point.replace("`", "") for point in block["points"])
        elif kind == "callout":
            mark = "! " if block["warning"] else "=> "
            lines.append(mark + block["text"].replace("`", ""))
        elif kind == "definitions":
            lines.extend(f"{term}: {meaning}" for term, meaning in block["terms"])
        elif kind == "details":
            for inner in block["blocks"]:
                tell(inner)
        elif kind == "table":
            _rows(block, lines)

    for section in sections:
        for block in section["blocks"]:
            tell(block)
    return "\n".join(lines)


def _rows(table: dict[str, Any], lines: list[str]) -> None:
    heads = [f"{name} ({unit})" if unit else name for name, unit in table["columns"]]
    cells = ([cell.replace("`", "") for cell in row] for row in table["rows"])
    # A triangle of correlations has rows of all lengths.
    rows = [heads, *(row + [""] * (len(heads) - len(row)) for row in cells)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(heads))]
    if table["caption"]:
        lines.append(table["caption"].replace("`", ""))
    lines.extend("  ".join(cell.ljust(w) for cell, w in zip(row, widths)).rstrip() for row in rows)
    lines.extend(table["notes"])
