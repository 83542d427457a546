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
from fretsolve.system.signals import SIGNALS, StopRequest


@pytest.mark.parametrize("number", SIGNALS)
def test_first_signal_is_noted_and_announced_once(number: signal.Signals, capfd: pytest.CaptureFixture) -> None:
    before = signal.getsignal(number)
    with StopRequest() as stop:
        assert not stop.requested
        signal.raise_signal(number)
        assert stop.requested
    assert signal.getsignal(number) is before
    assert capfd.readouterr().err == f"fretsolve: {number.name}: {interrupt.NOTICE}\n"


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


def test_without_notice_nothing_is_written(capfd: pytest.CaptureFixture) -> None:
    with StopRequest(notice=""):
        signal.raise_signal(signal.SIGUSR1)
    assert capfd.readouterr().err == ""


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


def test_import_is_light() -> None:
    code = "import sys, fretsolve.system.signals; print(*{'numpy', 'h5py', 'rich'} & set(sys.modules))"
    root = Path(fretsolve.__file__).parents[1]
    assert subprocess.check_output([sys.executable, "-c", code], cwd=root, text=True).strip() == ""
