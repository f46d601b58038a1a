"""A law of one's own written as a Python function: it is run once on symbols, and what it does is the law's formula.

    def cogging(x, size, pitch):
        return size * np.sin(2 * np.pi * x / pitch)

    model.with_law("cogging", "sensor", cogging, {"size": 0.0, "pitch": 1.7})

Besides operators and numpy's functions a law may use what remembers: `lag`, `peak`, `total` and `since`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from palpate._palpate import Error

#: What numpy calls otherwise than a formula does.
FUNCTIONS = {
    "absolute": "abs", "fabs": "abs", "sign": "sign", "sqrt": "sqrt", "cbrt": "cbrt", "exp": "exp", "log": "ln", "log2": "log2",
    "log10": "log10", "sin": "sin", "cos": "cos", "tan": "tan", "arcsin": "asin", "arccos": "acos", "arctan": "atan",
    "sinh": "sinh", "cosh": "cosh", "tanh": "tanh", "arcsinh": "asinh", "arccosh": "acosh", "arctanh": "atanh",
    "floor": "floor", "ceil": "ceil", "minimum": "min", "maximum": "max", "fmin": "min", "fmax": "max", "arctan2": "atan2",
}
OPERATORS = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "power": "^", "float_power": "^"}
#: What a law may speak of besides its parameters.
VARIABLES = ("t", "t_set", "x", "v", "a", "T", "n", "x_max", "N", "F")

INSTEAD = "a formula has no branches: use np.minimum, np.maximum, np.sign or abs"


class Formula:
    """A value that a law computes, by name: what is done to it is written down."""

    __slots__ = ("text",)

    def __init__(self, text: str) -> None:
        self.text = text

    def __add__(self, other: Any) -> Formula:
        return infix("+", self, other)

    def __radd__(self, other: Any) -> Formula:
        return infix("+", other, self)

    def __sub__(self, other: Any) -> Formula:
        return infix("-", self, other)

    def __rsub__(self, other: Any) -> Formula:
        return infix("-", other, self)

    def __mul__(self, other: Any) -> Formula:
        return infix("*", self, other)

    def __rmul__(self, other: Any) -> Formula:
        return infix("*", other, self)

    def __truediv__(self, other: Any) -> Formula:
        return infix("/", self, other)

    def __rtruediv__(self, other: Any) -> Formula:
        return infix("/", other, self)

    def __pow__(self, other: Any) -> Formula:
        return infix("^", self, other)

    def __rpow__(self, other: Any) -> Formula:
        return infix("^", other, self)

    def __neg__(self) -> Formula:
        return Formula(f"(-{self.text})")

    def __pos__(self) -> Formula:
        return self

    def __abs__(self) -> Formula:
        return called("abs", self)

    def __bool__(self) -> bool:
        raise Error(INSTEAD)

    def __lt__(self, other: Any) -> bool:
        raise Error(INSTEAD)

    __le__ = __gt__ = __ge__ = __lt__

    def __eq__(self, other: object) -> bool:
        raise Error(INSTEAD)

    __ne__ = __eq__
    __hash__ = None  # type: ignore[assignment]

    def __float__(self) -> float:
        raise Error("use the functions of numpy (np.sin), not those of math: they take a number alone")

    def __array_ufunc__(self, function: Any, method: str, *values: Any, **options: Any) -> Formula:
        name = function.__name__
        if method == "__call__" and not options:
            if name in OPERATORS:
                return infix(OPERATORS[name], *values)
            if name == "negative":
                return -values[0]  # type: ignore[no-any-return]
            if name == "square":
                return infix("^", values[0], 2.0)
            if name in FUNCTIONS:
                return called(FUNCTIONS[name], *values)
        raise Error(f"np.{name} has no place in a formula; {INSTEAD}")


def text(value: Any) -> str:
    """A value as a formula writes it."""
    if isinstance(value, Formula):
        return value.text
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise Error(f"a formula is of single numbers, not of {type(value).__name__}") from None
    return repr(number) if number >= 0 else f"({number!r})"


def infix(sign: str, left: Any, right: Any) -> Formula:
    return Formula(f"({text(left)} {sign} {text(right)})")


def called(name: str, *values: Any) -> Formula:
    return Formula(f"{name}({', '.join(map(text, values))})")


def lag(value: Any, time: Any) -> Any:
    """The value behind a first-order low pass of this time constant, s."""
    return called("lag", value, time)


def peak(value: Any) -> Any:
    """The largest value so far."""
    return called("peak", value)


def total(value: Any) -> Any:
    """The integral of the value over time."""
    return called("total", value)


def since(value: Any) -> Any:
    """How long the value has been above 0, s."""
    return called("since", value)


def play(value: Any, gap: Any) -> Any:
    """The value behind a play: it stays until the value is more than the gap away from it."""
    return called("play", value, gap)


def traced(law: Callable[..., Any], parameters: list[str]) -> str:
    """The formula of a function over variables and parameters, which it takes by their names."""
    names = list(inspect.signature(law).parameters)
    unknown = [name for name in names if name not in VARIABLES and name not in parameters]
    unused = [name for name in parameters if name not in names]
    if unknown:
        known = ", ".join([*VARIABLES, *parameters])
        raise Error(f"the law takes `{unknown[0]}`, which is no variable and no parameter; there are {known}")
    if unused:
        raise Error(f"the law does not take its parameter `{unused[0]}`")
    return text(law(**{name: Formula(name) for name in names}))
