"""What a worker of an engine does: it has tasks of a survey worked off by a process of its own.

A group that ends its process ends nothing else. The process is kept for the next task: its start takes as long as some hundred
groups.
"""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
import tempfile
from typing import Any, ClassVar

from palpate import _palpate, _remote

#: How often a group is tried at which the process ends.
ATTEMPTS = 2
#: How long a process has to end, s.
PATIENCE = 5.0


def work(task: str) -> list[str]:
    """Works off a task on this machine, in a process beside this one, and gives its rows."""
    folder = _folder(json.loads(task))
    rows: list[str] = []
    left: str | None = task
    tried = 0
    while left is not None:
        whole, end = _Process.of(folder).done(left)
        rows += whole
        if end is None:
            return rows
        if end.status in (1, 2):
            raise failed(end.words, end.status)
        if '"files"' in left and "files" in json.loads(left):
            raise failed(f"{end}: it looked into files")
        tried = 1 if whole else tried + 1
        left = _palpate.survey_rest(left, len(whole), tried)
        if left is not None and tried == ATTEMPTS:
            rows.append(_palpate.survey_gave_up(left, tried, str(end)))
            left, tried = _palpate.survey_rest(left, 1, 0), 0
    return rows


def _folder(task: dict[str, Any]) -> str:
    """The folder from which the names of the files of a task count, with the files in it."""
    places = [place for group in task.get("groups", ()) for place in group["places"]]
    files = task.get("files") or [place.get("File") or place["Rows"]["path"] for place in places]
    if files and _remote.is_url(files[0]):
        return _remote.fetched(files)
    folder: str = task["folder"]
    return folder


class _End:
    """How a process ended."""

    def __init__(self, status: int, words: str) -> None:
        self.status, self.words = status, words

    def __str__(self) -> str:
        if self.status >= 0:
            return f"the process that worked on it ended with status {self.status}"
        try:
            name = signal.Signals(-self.status).name
        except ValueError:
            name = f"signal {-self.status}"
        return f"the process that worked on it was ended by {name}"


class _Process:
    """Works off one task after the other, with names of files that count from one folder."""

    #: Those that wait for a task, by their folders.
    idle: ClassVar[dict[str, list[_Process]]] = {}

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.said = tempfile.TemporaryFile()
        call = [sys.executable, "-m", "palpate._rows"]
        pipe = subprocess.PIPE
        try:
            self.process = subprocess.Popen(call, cwd=folder, stdin=pipe, stdout=pipe, stderr=self.said)
        except (FileNotFoundError, NotADirectoryError):
            raise _palpate.Error(
                f"a worker has no folder {folder}: workers must see the files of a survey by the same names"
            ) from None

    @classmethod
    def of(cls, folder: str) -> _Process:
        """One that waits, or a new one."""
        waiting = cls.idle.setdefault(folder, [])
        try:
            return waiting.pop()
        except IndexError:
            return cls(folder)

    def done(self, task: str) -> tuple[list[str], _End | None]:
        """The rows of a task as far as it came, and how the process ended if it did."""
        rows: list[str] = []
        into, out = self.process.stdin, self.process.stdout
        assert into is not None and out is not None
        try:
            try:
                into.write(task.encode() + b"\n")
                into.flush()
            except BrokenPipeError:
                pass
            for line in out:
                if line == b"\n":
                    self.idle.setdefault(self.folder, []).append(self)
                    return rows, None
                # A line that was cut off is no row.
                if line.endswith(b"\n"):
                    rows.append(line[:-1].decode())
            return rows, self._end()
        except BaseException:
            # What it still says belongs to a task that nobody waits for.
            self.process.kill()
            self._end()
            raise

    def _end(self) -> _End:
        status = self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                _close(pipe)
        self.said.seek(0)
        words = self.said.read().decode(errors="replace").strip()
        self.said.close()
        return _End(status, words)

    def end(self) -> None:
        """Ends it, while it waits."""
        if self.process.stdin is not None:
            _close(self.process.stdin)
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
        self._end()


def end_all() -> None:
    """Ends the processes that wait."""
    while _Process.idle:
        for one in _Process.idle.popitem()[1]:
            one.end()


def _close(pipe: Any) -> None:
    try:
        pipe.close()
    except BrokenPipeError:
        pass


atexit.register(end_all)
if hasattr(os, "register_at_fork"):
    # They answer to the process that began them.
    os.register_at_fork(after_in_child=_Process.idle.clear)


def failed(words: str, status: int = 1) -> _palpate.Error:
    """An error with these words."""
    error = _palpate.Error(words)
    error.status = status
    return error
