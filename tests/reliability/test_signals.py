"""SIGTERM, SIGINT and SIGUSR1: the first stops after the increment, the second at once; a resume goes on."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

import pytest
from runs import finish, reported, run_line, start

from fretsolve.result import open_result
from fretsolve.system.signals import NOTICE

RUN = {"increments": 5, "every": 2}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("reference") / "out.h5"
    assert finish(run_line(out, **RUN))[0] == 0
    return out.read_bytes()


def start_and_wait(out: Path, pause: float) -> subprocess.Popen[str]:
    """A run of `pause` seconds an increment that has just saved its first one."""
    process = start(run_line(out, pause=pause, **RUN))
    assert process.stdout is not None
    assert process.stdout.readline() == "increment 0\n"
    return process


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGUSR1])
def test_first_signal_finishes_the_increment(number: signal.Signals, tmp_path: Path, uninterrupted: bytes) -> None:
    out = tmp_path / "out.h5"
    process = start_and_wait(out, pause=0.3)
    process.send_signal(number)
    output, messages = process.communicate()
    assert process.returncode == 75
    # The signal may come before or after the look at it that follows the first increment.
    done = max(reported(output), 1)
    assert done <= 2
    assert messages == f"fretsolve: {number.name}: {NOTICE}\n"
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", done)
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
    assert out.read_bytes() == uninterrupted


def test_second_signal_stops_at_once(tmp_path: Path, uninterrupted: bytes) -> None:
    out = tmp_path / "out.h5"
    process = start_and_wait(out, pause=1.5)
    begin = time.monotonic()
    process.send_signal(signal.SIGINT)
    time.sleep(0.2)
    process.send_signal(signal.SIGTERM)
    output, _ = process.communicate()
    assert process.returncode == 75
    assert time.monotonic() - begin < 1.2
    assert reported(output) == 0  # none after the first, which was read above
    with open_result(out) as result:
        assert result.increments == 1
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
    assert out.read_bytes() == uninterrupted


def test_growing_result_is_read_as_running_and_locked(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    process = start_and_wait(out, pause=6.0)  # six such outlast the commands below, also on a loaded machine
    try:
        with open_result(out) as result:
            assert result.status == "running"
            assert result.field("pressure").shape == (6, 6)
        for flags in ((), ("--resume",), ("--overwrite",)):
            code, output, messages = finish(run_line(out, *flags, **RUN))
            assert (code, output) == (4, "")
            assert messages.startswith(f"{out}.parts: another run is writing this output (process {process.pid} on ")
            assert messages.count("\n") == 1
    finally:
        process.kill()
        process.communicate()
    with open_result(out) as result:
        assert result.status == "stopped"
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
