"""The stubs say what is there, and what the package says of itself holds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import palpate

PYTHON = Path(__file__).parents[1]


def checked(*words: str, within: Path = PYTHON) -> str:
    call = [sys.executable, "-m", *words]
    done = subprocess.run(call, cwd=within, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_package_is_typed_strictly() -> None:
    assert "no issues found" in checked("mypy", "--config-file", "pyproject.toml")


def test_the_stubs_agree_with_the_compiled_half(tmp_path: Path) -> None:
    checked("mypy.stubtest", "palpate._palpate", within=tmp_path)


def test_a_user_of_the_package_is_checked_by_its_types(tmp_path: Path) -> None:
    good = "import palpate\nfound = palpate.fit('traces/', terms='auto')\nvalue: float = found.parameters['p'].value\n"
    bad = "import palpate\npalpate.fit('traces/', separation='loose')\npalpate.fit(1.0)\n"
    for text, faults in ((good, 0), (bad, 2)):
        (tmp_path / "use.py").write_text(text)
        call = [sys.executable, "-m", "mypy", "--strict", str(tmp_path / "use.py")]
        done = subprocess.run(call, capture_output=True, text=True, cwd=tmp_path, check=False)
        assert done.stdout.count(" error: ") == faults, done.stdout


def test_everything_public_is_documented() -> None:
    for name in palpate.__all__:
        thing = getattr(palpate, name)
        if not name.startswith("__"):
            assert thing.__doc__, name
            for member, value in vars(thing).items() if isinstance(thing, type) else ():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{member}"
