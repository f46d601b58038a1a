"""What the tests share: bundled recordings, and the command that the wheel installed."""

from __future__ import annotations

import json
import os
import subprocess
import sysconfig
from collections.abc import Callable
from pathlib import Path
from typing import Any

import palpate
import pytest

TOP = Path(__file__).parents[2]
TRACES = TOP / "tests" / "traces"
PRESS = TRACES / "press.csv"
#: The command: another build of the same sources where `PALPATE` names one.
COMMAND = os.environ.get("PALPATE") or str(Path(sysconfig.get_path("scripts")) / "palpate")


def command(*words: object, status: int = 0) -> subprocess.CompletedProcess[str]:
    """Runs the command."""
    call = [COMMAND, *map(str, words)]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode == status, done.stderr
    return done


def answer(*words: object) -> Any:
    """The JSON that the command prints."""
    return json.loads(command(*words, "--json").stdout)


@pytest.fixture(scope="session")
def practice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A practice set in a folder, made by the command."""
    folder = tmp_path_factory.mktemp("sets") / "practice"
    command("hide", "mullins", "--seed", 7, "-o", folder)
    return folder


@pytest.fixture(scope="session")
def model(practice: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The base law fitted to it by the command."""
    path = tmp_path_factory.mktemp("models") / "base.toml"
    command("fit", "fung", practice, "-o", path)
    return path


@pytest.fixture
def press() -> palpate.DataSet:
    """A bundled press with four gauges."""
    return palpate.read(PRESS)


Command = Callable[..., Any]
