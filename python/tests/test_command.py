"""The command that the wheel brings, and what the package costs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import palpate
import pytest
from conftest import COMMAND, PRESS, command


def test_the_wheel_brings_the_command(tmp_path: Path) -> None:
    assert command("--version").stdout == f"palpate {palpate.__version__}\n"
    assert "What is in this recording" not in command("--help").stdout
    assert "unexpected argument '--wrong'" in command("fit", "--wrong", status=2).stderr
    said = command("fit", "fung", tmp_path / "none.csv", status=2).stderr
    assert said.startswith("error: ") and "none.csv" in said
    assert "Traceback" not in said
    module = subprocess.run([sys.executable, "-m", "palpate", "--version"], capture_output=True, text=True, check=True)
    assert module.stdout == f"palpate {palpate.__version__}\n"


def test_a_report_says_how_it_was_made(tmp_path: Path) -> None:
    report = tmp_path / "fit.html"
    command("fit", "fung", PRESS, "--report", report)
    assert f"palpate fit fung {PRESS} --report {report}" in report.read_text()


def test_a_reader_that_goes_away_is_no_fault() -> None:
    shell = f"'{COMMAND}' fit fung '{PRESS}' --json | head -1"
    done = subprocess.run(["sh", "-c", shell], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("{\n", "")


def hang_up() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.mark.skipif(sys.platform == "win32", reason="a signal to another process is POSIX")
def test_ctrl_c_ends_the_command_as_a_shell_expects(tmp_path: Path) -> None:
    call = [COMMAND, "dissertation", "-o", str(tmp_path / "report")]
    # Under `nohup` the command would leave signals alone; here it is called as from a terminal.
    child = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=hang_up)
    time.sleep(0.7)
    assert child.poll() is None, "the work is too short to be interrupted"
    child.send_signal(signal.SIGINT)
    assert child.wait(2) == 130


def test_the_time_of_an_import_is_told(capsys: pytest.CaptureFixture) -> None:
    """A figure, not a limit: the machine may be busy. What must not happen is that numpy or pandas come in unasked."""
    code = (
        "import sys, time; began = time.perf_counter(); import palpate; "
        "print(time.perf_counter() - began, 'numpy' in sys.modules, 'pandas' in sys.modules)"
    )
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(5)]
    told = [run.stdout.split() for run in runs]
    assert all(one[1:] == ["False", "False"] for one in told)
    with capsys.disabled():
        size = sum(path.stat().st_size for path in Path(palpate.__file__).parent.glob("_palpate*")) / 1e6
        best = min(float(one[0]) for one in told)
        print(f"\nimport palpate: {best * 1e3:.0f} ms, the best of {len(runs)}; {size:.1f} MB of compiled code; {os.cpu_count()} cores")
