"""Signals: the first one stops a run after the increment, the second one at once.

Import this before anything heavy: a signal that arrives during an import would end the process.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from types import FrameType
from typing import Any

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1, signal.SIGHUP)
"""SIGHUP comes when a terminal is closed."""

ENDING = (signal.SIGTERM, signal.SIGHUP)
"""Signals that end a process which does not handle them, without an exception as at Ctrl-C."""

EXIT_STOPPED = 75
"""Exit code (EX_TEMPFAIL of sysexits.h) of a run that was stopped: its completed increments are saved, and `--resume`
goes on. A stop at once loses only the increment under way."""

SAME_SIGNAL = 0.05
"""Seconds within which signals count as one: `timeout` signals its child and then its whole process group."""

CLOSED_NOTICE = "stopping after this increment"
NOTICE = f"{CLOSED_NOTICE}; a second signal stops at once"
AT_ONCE_NOTICE = "stopped at once; what was saved before stays, and the run can be resumed"
IDLE_NOTICE = "ended before anything was run"
BESIDE_NOTICE = "stopped; the result is whole, and --resume writes what else the case asks for"


class Stopped(BaseException):
    """A signal has come in a block that `StopRequest.until_signal` ends."""


def end_by(number: signal.Signals) -> None:
    """End the process as an uncaught signal does, so that a shell's loop over cases ends as well."""
    signal.signal(number, signal.SIG_DFL)
    signal.raise_signal(number)


class Interrupts(AbstractContextManager["Interrupts"]):
    """Note Ctrl-C inside a `with` block: libraries turn the KeyboardInterrupt into errors of their own.

    came: whether it was pressed where nothing else handles it.
    """

    def __init__(self) -> None:
        self.came = False
        self._handled = signal.getsignal(signal.SIGINT) is signal.default_int_handler

    def __enter__(self) -> Interrupts:
        if self._handled:
            signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        if self._handled and signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.came = True
        raise KeyboardInterrupt


class StopRequest(AbstractContextManager["StopRequest"]):
    """Catch `SIGNALS` inside a `with` block, in the main thread. SIGHUP stays ignored if it is, as under nohup.

    After a signal all of them are ignored from the end of the block on, so that they do not change the exit code of the
    process, which is about to end.
    requested: whether a signal has come, so that the run is to stop after its increment. notice: the line written to
    standard error at the first signal, empty for none; at_once: at the second. idle: a signal ends the process at once,
    since there is nothing to save yet.
    """

    def __init__(self, notice: str = NOTICE, *, at_once: str = AT_ONCE_NOTICE, idle: bool = False):
        self._notice, self._at_once = notice, at_once
        self.idle = idle
        self._first: float | None = None
        self._raises = False
        self._previous: dict[signal.Signals, Any] = {}

    @property
    def requested(self) -> bool:
        """True if a signal has come."""
        return self._first is not None

    def __enter__(self) -> StopRequest:
        ignored = {signal.SIGHUP} if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN else set()
        self._previous = {number: signal.signal(number, self._handle) for number in SIGNALS if number not in ignored}
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, signal.SIG_IGN if self.requested else handler)

    @contextmanager
    def until_signal(self) -> Iterator[None]:
        """Raise `Stopped` in the block when a signal comes, or if one has come before: what it has begun is removed."""
        if self.requested:
            raise Stopped
        self._raises = True
        try:
            yield
        finally:
            self._raises = False

    def _handle(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._raises:
            self._first, self._raises = now, False
            _announce(number, BESIDE_NOTICE)
            raise Stopped
        if self.idle:
            _announce(number, IDLE_NOTICE)
            if number == signal.SIGINT:
                end_by(signal.SIGINT)
            os._exit(EXIT_STOPPED)
        if self._first is None:
            self._first = now
            _announce(number, CLOSED_NOTICE if number == signal.SIGHUP and self._notice == NOTICE else self._notice)
        elif now - self._first > SAME_SIGNAL and number != signal.SIGHUP:  # a terminal sends it, and its shell again
            _announce(number, self._notice and self._at_once)
            os._exit(EXIT_STOPPED)  # nothing to save: committed increments stay, and HDF5 has no file open


def _announce(number: int, text: str) -> None:
    """Write a line, unless `text` is empty; the same signal may have ended the reader of the messages."""
    if text:
        with suppress(OSError):
            os.write(2, f"fretsolve: {signal.Signals(number).name}: {text}\n".encode())
