"""SIGTERM, SIGINT and SIGUSR1: the first stops after the increment, the second at once; a resume goes on."""

from __future__ import annotations

import signal
import subprocess
import time
from pathlib import Path

import pytest
from runs import finish, reported, run_line, start

from fretsolve.result import open_result
from fretsolve.system.signals import NOTICE, SAME_SIGNAL

RUN = {"increments": 5, "every": 2}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("reference") / "out.h5"
    assert finish(run_line(out, **RUN))[0] == 0
    return out.read_bytes()


def start_and_wait(out: Path) -> subprocess.Popen[str]:
    """Start a run and wait until it holds in its second increment."""
    process = start(run_line(out, hold_at=1, **RUN))
    assert process.stdout is not None
    assert process.stdout.readline() == "increment 0\n"
    assert process.stdout.readline() == "holding\n"
    return process


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGUSR1])
def test_first_signal_finishes_the_increment(number: signal.Signals, tmp_path: Path, uninterrupted: bytes) -> None:
    out = tmp_path / "out.h5"
    process = start_and_wait(out)
    assert process.stderr is not None
    process.send_signal(number)
    assert process.stderr.readline() == f"fretsolve: {number.name}: {NOTICE}\n"
    out.with_suffix(".h5.go").touch()
    output, messages = process.communicate()
    assert (process.returncode, messages, reported(output)) == (75, "", 2)
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", 2)
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
    assert out.read_bytes() == uninterrupted


def test_second_signal_stops_at_once(tmp_path: Path, uninterrupted: bytes) -> None:
    out = tmp_path / "out.h5"
    process = start_and_wait(out)
    assert process.stderr is not None
    process.send_signal(signal.SIGINT)
    assert process.stderr.readline() == f"fretsolve: SIGINT: {NOTICE}\n"
    time.sleep(2.0 * SAME_SIGNAL)
    process.send_signal(signal.SIGTERM)
    output, _ = process.communicate()  # though nothing ends the second increment
    assert process.returncode == 75
    assert reported(output) == 0  # none after the first, which was read above
    with open_result(out) as result:
        assert result.increments == 1
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
    assert out.read_bytes() == uninterrupted


def test_growing_result_is_read_as_running_and_locked(tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    process = start_and_wait(out)
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
