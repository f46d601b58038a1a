"""Progress of long work: in a notebook or a terminal unasked, else where it is asked for."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Tell = Callable[[str, int, int], object]

_shown: bool | Tell | None = None


def progress(show: bool | Tell | None) -> None:
    """Says how the progress of long work is shown.

    None, as it is at first: in a notebook and on a terminal. False: not at all. True: on standard error. A function:
    it is called with what is being done, how many of it are done, and of how many, about twenty times a second; an
    exception that it raises ends the work.
    """
    global _shown
    _shown = show


@contextmanager
def told() -> Iterator[Tell | None]:
    """How the work within tells its progress."""
    if callable(_shown):
        yield _shown
    elif _shown is None and _in_notebook():
        with _Notebook() as shown:
            yield shown
    elif _shown or (_shown is None and sys.stderr is not None and sys.stderr.isatty()):
        with _Terminal() as shown:
            yield shown
    else:
        yield None


def _in_notebook() -> bool:
    # What never imported IPython is no notebook; to ask costs nothing then.
    if "IPython" not in sys.modules:
        return False
    from IPython import get_ipython

    return getattr(get_ipython(), "kernel", None) is not None


class _Terminal:
    """One line on standard error, wiped at the end."""

    width = 0

    def __enter__(self) -> _Terminal:
        return self

    def __call__(self, what: str, done: int, of: int) -> None:
        line = f"{what} {done}/{of}"
        print("\r" + line.ljust(self.width), end="", file=sys.stderr, flush=True)
        self.width = max(self.width, len(line))

    def __exit__(self, *_: object) -> None:
        if self.width:
            print("\r" + " " * self.width + "\r", end="", file=sys.stderr, flush=True)


class _Notebook:
    """A bar in the output of the cell, gone at the end."""

    shown: Any = None
    last: tuple[str, int, int] | None = None

    def __enter__(self) -> _Notebook:
        return self

    def __call__(self, what: str, done: int, of: int) -> None:
        if self.last == (what, done, of):
            return
        self.last = (what, done, of)
        self._show(f'<progress value="{done}" max="{of}"></progress> {what} {done}/{of}')

    def _show(self, html: str) -> None:
        from IPython.display import HTML, display

        if self.shown is None:
            self.shown = display(HTML(html), display_id=True)
        else:
            self.shown.update(HTML(html))

    def __exit__(self, *_: object) -> None:
        if self.shown is not None:
            self._show("")
