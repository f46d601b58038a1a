"""A simulated fingertip, block by block."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import palpate
import pytest
from conftest import COMMAND

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the simulated fingertip needs a pseudo-terminal")


@pytest.fixture
def port(tmp_path: Path) -> Iterator[Path]:
    link = tmp_path / "fingertip"
    call = [COMMAND, "device", "simulate", "--link", str(link)]
    child = subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 10
        while not link.exists():
            assert child.poll() is None and time.monotonic() < deadline, "no simulated fingertip"
            time.sleep(0.05)
        yield link
    finally:
        child.send_signal(signal.SIGTERM)
        child.wait(5)


def test_a_device_is_an_iterator_of_blocks(port: Path) -> None:
    with palpate.Device(port) as device:
        assert device.about()["device"]
        blocks = []
        for block in device:
            blocks.append(block)
            if sum(map(len, blocks)) > 500:
                break
        numbers = np.concatenate([block.number for block in blocks])
        times = np.concatenate([block.time_s for block in blocks])
        assert numbers[0] == 0 and blocks[-1].lost == 0
        assert np.array_equal(numbers, np.arange(len(numbers)))
        assert (np.diff(times) > 0).all()
        assert blocks[0].fa_ustrain.shape == (len(blocks[0]), 4) == blocks[0].sa_ustrain.shape
        # A second stream of the same device begins anew.
        assert next(iter(device)).number[0] == 0


def test_a_port_without_a_device_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(palpate.Error, match="none") as raised:
        palpate.Device(tmp_path / "none")
    assert raised.value.status == 1
