"""Signals: the first asks to stop after the increment, the second stops at once.

Imported before anything heavy, since a signal that arrives during an import would end the process unasked.
"""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGUSR1)

EXIT_STOPPED = 75
"""EX_TEMPFAIL of sysexits.h: stopped, the completed increments are saved, `--resume` goes on.

It holds as well for a stop at once, which loses but the increment under way.
"""

SAME_SIGNAL = 0.05
"""Seconds within which signals count as one: `timeout` signals its child and then its whole process group."""

NOTICE = "stopping after this increment; a second signal stops at once"
AT_ONCE_NOTICE = "stopped at once; what was saved before stays, and can be gone on with"
IDLE_NOTICE = "ended before anything was run"


def end_by(number: signal.Signals) -> None:
    """End as a process does that does not catch the signal, so that a shell's loop over cases ends as well."""
    signal.signal(number, signal.SIG_DFL)
    signal.raise_signal(number)


class StopRequest:
    """Catches SIGTERM, SIGINT and SIGUSR1 inside a `with` block, which must be in the main thread.

    `requested` tells the load path to stop after its increment; `notice` is a line written to standard error
    as soon as that is so (empty for none), `at_once` one at a second signal. idle: a signal ends the process at once
    until `begin` is called, since nothing has been done that could be saved.
    """

    def __init__(self, notice: str = NOTICE, *, at_once: str = AT_ONCE_NOTICE, idle: bool = False):
        self._notice, self._at_once = notice, at_once
        self._idle = idle
        self._first: float | None = None
        self._previous: dict[signal.Signals, Any] = {}

    @property
    def requested(self) -> bool:
        """Whether a signal has come."""
        return self._first is not None

    def begin(self) -> None:
        """From now on there is work to stop."""
        self._idle = False

    def __enter__(self) -> StopRequest:
        for number in SIGNALS:
            self._previous[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._previous.items():
            signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._idle:
            self._tell(number, IDLE_NOTICE)
            if number == signal.SIGINT:
                end_by(signal.SIGINT)
            os._exit(EXIT_STOPPED)
        if self._first is None:
            self._first = now
            if self._notice:
                self._tell(number, self._notice)
        elif now - self._first > SAME_SIGNAL:
            if self._notice:
                self._tell(number, self._at_once)
            os._exit(EXIT_STOPPED)  # nothing to save: what is committed stays, and HDF5 holds no file open

    @staticmethod
    def _tell(number: int, text: str) -> None:
        with suppress(OSError):  # whoever read the messages may have ended by the same signal
            os.write(2, f"fretsolve: {signal.Signals(number).name}: {text}\n".encode())
