"""Objects of a store by their URLs, through fsspec: listed where a survey is called, fetched by whoever works on them.

An object lies in the folder of a worker by the name of its URL (`s3://lab/f1.csv` is a name that a file can have), so that every
part of a survey calls it alike.
"""

from __future__ import annotations

import os
import sys
import tempfile
import threading
from collections.abc import Iterable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from palpate import _palpate

if TYPE_CHECKING:
    from collections.abc import Iterator

#: Files that are traces, where a folder is given.
TRACES = (".csv", ".parquet")

_own = threading.local()


def is_url(name: str) -> bool:
    """Whether this names an object of a store, and no file."""
    return "://" in name


def listed(data: Iterable[str]) -> list[str]:
    """The URLs of the traces that these URLs name, or that lie below them, folder by folder in the order of names."""
    found: list[str] = []
    for url in data:
        with _in_words(url):
            store, root = _store(url)
            inside = [root] if store.isfile(root) else _below(store, root)
            if not inside:
                raise _palpate.Error(f"{url}: no traces in it (.csv, .parquet)")
            found += [store.unstrip_protocol(path) for path in inside]
    return found


def _below(store: Any, root: str) -> list[str]:
    def is_trace(path: str) -> bool:
        parts = path[len(root) :].split("/")
        return path.lower().endswith(TRACES) and not any(part.startswith(".") for part in parts)

    return sorted(filter(is_trace, store.find(root)), key=lambda path: path.split("/"))


def fetched(urls: Sequence[str]) -> str:
    """The folder of this thread, in which these objects now lie by their names and no others, each with the time of its last change."""
    if sys.platform == "win32":
        raise _palpate.Error("objects of a store are fetched on Linux and macOS alone: no file of Windows has the name of a URL")
    if not hasattr(_own, "folder"):
        _own.folder = tempfile.TemporaryDirectory(prefix="palpate-")
        _own.there = set()
    folder, there, wanted = Path(_own.folder.name), _own.there, dict.fromkeys(urls)
    for url in there - wanted.keys():
        there.remove(url)
        (folder / url).unlink()
    missing = [url for url in wanted if url not in there]
    if missing:
        with _in_words(missing[0]):
            store, _ = _store(missing[0])
            paths = [store._strip_protocol(url) for url in missing]
            store.get(paths, [str(folder / url) for url in missing])
            for url, path in zip(missing, paths):
                time = _modified(store, path)
                os.utime(folder / url, (time, time))
        there.update(missing)
    return str(folder)


def _modified(store: Any, path: str) -> float:
    """When an object was last changed, s since 1970; 0 where its store does not say."""
    try:
        return float(store.modified(path).timestamp())
    except NotImplementedError:
        return 0.0


def _store(url: str) -> tuple[Any, str]:
    try:
        from fsspec.core import url_to_fs
    except ImportError:
        raise _palpate.Error("a survey of URLs needs fsspec: pip install 'palpate[cluster]'") from None
    try:
        store, path = url_to_fs(url)
    except ImportError as what:
        raise _palpate.Error(f"{url}: {what}") from None
    return store, path


@contextmanager
def _in_words(url: str) -> Iterator[None]:
    """What a store answers, as an error of this package."""
    try:
        yield
    except _palpate.Error:
        raise
    except Exception as what:  # Each store has errors of its own.
        raise _palpate.Error(f"{url}: cannot be read: {what}") from what
