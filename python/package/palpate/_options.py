"""Options of a command from keywords."""

from __future__ import annotations

import math
from collections.abc import Iterable


def options(**given: object) -> list[str]:
    """The words of the command line for keywords; None and False leave an option out, a list gives it once for each."""
    words: list[str] = []
    for name, value in given.items():
        flag = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(flag)
        elif isinstance(value, (list, tuple)):
            words.extend(f"{flag}={word(one)}" for one in value)
        else:
            words.append(f"{flag}={word(value)}")
    return words


def word(value: object) -> str:
    """A value as on the command line; a number comes back as it is, bit for bit."""
    if isinstance(value, str):
        return value
    if isinstance(value, int):
        return str(int(value))
    number = float(value)  # type: ignore[arg-type]
    return repr(number) if math.isfinite(number) else str(number)


def listed(values: Iterable[object] | None) -> str | None:
    """Values between commas, None for none."""
    return None if values is None else ",".join(word(value) for value in values)
