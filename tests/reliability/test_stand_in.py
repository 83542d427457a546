"""Kills at random moments, a second signal and a full disk: what was reported is readable, and a resume ends alike.

The runs are of `driver.py`, which makes up its states, so that there can be many.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from runs import finish, readable, reported, start

from fretsolve.result import open_result
from fretsolve.system.signals import NOTICE, SAME_SIGNAL

KILLS = int(os.environ.get("FRETSOLVE_KILLS", "25"))
RUN = {"increments": 40, "points": 12, "every": 3}
SEED = 20090131


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("reference") / "out.h5"
    assert finish(out, **RUN)[0] == 0
    return out.read_bytes()


@pytest.fixture(scope="module")
def expected(uninterrupted: bytes, tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    """The column `P` of the whole history."""
    out = tmp_path_factory.mktemp("expected") / "out.h5"
    out.write_bytes(uninterrupted)
    with open_result(out) as result:
        return result.history["P"]


def test_random_kills_lose_nothing(uninterrupted: bytes, expected: np.ndarray, tmp_path: Path) -> None:
    """Every other run holds in its last increment, so that the kill meets it under way."""
    choice, last = random.Random(SEED), RUN["increments"] - 1
    out = tmp_path / "out.h5"
    kills = stopped_between = 0
    while kills < KILLS:
        already = readable(out, expected)
        holds = kills % 2
        process = start(out, "--resume", **RUN, **({"hold_at": last} if holds else {}))
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(choice.randint(holds, last - already))]
        time.sleep(choice.uniform(0.0, 0.02))
        process.send_signal(signal.SIGKILL)
        output, messages = process.communicate()
        assert "Traceback" not in messages
        saved = readable(out, expected)
        assert saved >= max(already, reported("".join(lines) + output))
        stopped_between += already < saved < RUN["increments"]
        kills += process.returncode == -signal.SIGKILL
        if process.returncode == 0 or kills == KILLS or saved >= last:
            assert finish(out, "--resume", **RUN)[0] == 0
            assert out.read_bytes() == uninterrupted
            assert not out.with_name("out.h5.parts").exists()
            out.unlink()
    assert stopped_between >= KILLS // 2


def test_second_signal_stops_at_once(tmp_path: Path, uninterrupted: bytes) -> None:
    out = tmp_path / "out.h5"
    process = start(out, hold_at=1, **RUN)
    assert process.stdout is not None and process.stderr is not None
    assert [process.stdout.readline() for _ in range(2)] == ["increment 0\n", "holding\n"]
    process.send_signal(signal.SIGINT)
    assert process.stderr.readline() == f"fretsolve: SIGINT: {NOTICE}\n"
    time.sleep(2.0 * SAME_SIGNAL)
    process.send_signal(signal.SIGTERM)
    output, _ = process.communicate()  # though nothing ends the second increment
    assert process.returncode == 75
    assert reported(output) == 0  # none after the first, which was read above
    with open_result(out) as result:
        assert result.increments == 1
    assert finish(out, "--resume", **RUN)[0] == 0
    assert out.read_bytes() == uninterrupted


@pytest.fixture()
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a file system of its own of 1 MiB, where the machine lets one mount it."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = shutil.which("mount")
    if mount is None or os.geteuid() != 0:
        pytest.skip("needs the right to mount a tmpfs")
    line = [mount, "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    if subprocess.run(line, capture_output=True, check=False).returncode != 0:
        pytest.skip("this machine lets no tmpfs be mounted")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_full_tmpfs(small_disk: Path, uninterrupted: bytes, expected: np.ndarray) -> None:
    out, ballast = small_disk / "out.h5", small_disk / "ballast"
    ballast.write_bytes(bytes(800_000))
    code, output, messages = finish(out, **RUN)
    assert code == 4
    assert messages.count("\n") == 1
    assert "No space left on device" in messages
    assert 0 < reported(output) <= readable(out, expected) < RUN["increments"]
    ballast.unlink()
    subprocess.run(["mount", "-o", "remount,size=8m", str(small_disk)], check=True)
    assert finish(out, "--resume", **RUN)[0] == 0
    assert out.read_bytes() == uninterrupted
