"""Signals as seen inside one process, and the cost of the import."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import fretsolve
from fretsolve.system import signals as interrupt
from fretsolve.system.signals import SIGNALS, Stopped, StopRequest

pytestmark = pytest.mark.usefixtures("handlers")


@pytest.mark.parametrize("number", SIGNALS)
def test_first_signal_is_noted_and_announced_once(number: signal.Signals, capfd: pytest.CaptureFixture) -> None:
    with StopRequest() as stop:
        assert not stop.requested
        signal.raise_signal(number)
        assert stop.requested
    notice = interrupt.CLOSED_NOTICE if number == signal.SIGHUP else interrupt.NOTICE
    assert capfd.readouterr().err == f"fretsolve: {number.name}: {notice}\n"


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_ends_what_can_be_made_again_at_once(number: signal.Signals, capfd: pytest.CaptureFixture) -> None:
    done = []
    with StopRequest() as stop, pytest.raises(Stopped), stop.until_signal():
        done.append("begun")
        signal.raise_signal(number)
        done.append("not reached")
    assert done == ["begun"]
    assert capfd.readouterr().err == f"fretsolve: {number.name}: {interrupt.BESIDE_NOTICE}\n"


def test_what_can_be_made_again_is_not_begun_after_a_signal() -> None:
    with StopRequest(notice="") as stop:
        signal.raise_signal(signal.SIGTERM)
        with pytest.raises(Stopped), stop.until_signal():
            raise AssertionError("it is not begun")


def test_without_a_signal_the_handlers_are_restored() -> None:
    before = list(map(signal.getsignal, SIGNALS))
    with StopRequest():
        pass
    assert list(map(signal.getsignal, SIGNALS)) == before


def test_a_terminal_and_its_shell_count_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([10.0, 11.0])
    monkeypatch.setattr(interrupt.time, "monotonic", lambda: next(clock))
    with StopRequest(notice="") as stop:
        signal.raise_signal(signal.SIGHUP)
        signal.raise_signal(signal.SIGHUP)
        assert stop.requested


def test_an_ignored_sighup_stays_ignored(capfd: pytest.CaptureFixture[str]) -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with StopRequest() as stop:
        signal.raise_signal(signal.SIGHUP)
        assert not stop.requested
        signal.raise_signal(signal.SIGTERM)
        assert stop.requested
    assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    assert capfd.readouterr().err == f"fretsolve: SIGTERM: {interrupt.NOTICE}\n"


def test_after_a_stop_no_signal_changes_how_the_process_ends() -> None:
    """Signals come after the block, and while the interpreter ends."""
    code = """\
import atexit, signal
from fretsolve.system.signals import EXIT_STOPPED, SIGNALS, StopRequest
atexit.register(lambda: [signal.raise_signal(number) for number in SIGNALS])
with StopRequest(notice="") as stop:
    signal.raise_signal(signal.SIGTERM)
for number in SIGNALS:
    signal.raise_signal(number)
raise SystemExit(EXIT_STOPPED)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=Path(fretsolve.__file__).parents[1], capture_output=True)
    assert (done.returncode, done.stderr) == (75, b"")


def test_second_signal_exits_at_once_with_75(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    codes: list[int] = []
    monkeypatch.setattr(os, "_exit", codes.append)
    clock = iter([10.0, 10.0 + interrupt.SAME_SIGNAL / 2, 11.0])
    monkeypatch.setattr(interrupt.time, "monotonic", lambda: next(clock))
    with StopRequest(notice="stopping", at_once="stopped"):
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        assert codes == []
        assert capfd.readouterr().err == "fretsolve: SIGTERM: stopping\n"
        signal.raise_signal(signal.SIGINT)
        assert codes == [75]
        assert capfd.readouterr().err == "fretsolve: SIGINT: stopped\n"


def test_outside_the_main_thread_it_refuses() -> None:
    raised: list[Exception] = []

    def enter() -> None:
        try:
            StopRequest().__enter__()
        except ValueError as error:
            raised.append(error)

    thread = threading.Thread(target=enter)
    thread.start()
    thread.join()
    assert len(raised) == 1
