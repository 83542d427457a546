"""Processes that serve a sweep: copies of this one where that is safe, else new interpreters.

A new interpreter takes a second to import what a copy has already. A copy is safe where no other thread runs, whose
locks it would find locked for ever, and on Linux alone (the system libraries of macOS do not bear it).
"""

from __future__ import annotations

import importlib
import os
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, NoReturn

from fretsolve.errors import FretsolveError
from fretsolve.interrupt import SIGNALS
from fretsolve.sweep.worker import EXIT_BUG, serve

HEAVY = "fretsolve.sweep.base"
"""What a process imports that works on cases."""


@dataclass(frozen=True)
class ServingProcess:
    """A process of `fretsolve.sweep.worker.serve`, and the pipes to it.

    wait: waits for its end and returns the exit code, or minus the number of the signal that ended it.
    """

    orders: IO[str]
    reports: IO[str]
    wait: Callable[[], int]


def start(folder: Path, others: Sequence[ServingProcess]) -> ServingProcess:
    """Have a process serve the sweep in `folder`. others: those that serve already."""
    may_copy = sys.platform == "linux" and threading.active_count() == 1
    return _copy(folder, others) if may_copy else _new(folder)


def _new(folder: Path) -> ServingProcess:
    line = [sys.executable, "-m", "fretsolve", "sweep", "serve", str(folder)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(line, stdin=pipe, stdout=pipe, text=True, encoding="utf-8")
    assert process.stdin is not None
    assert process.stdout is not None
    return ServingProcess(process.stdin, process.stdout, process.wait)


def _copy(folder: Path, others: Sequence[ServingProcess]) -> ServingProcess:
    importlib.import_module(HEAVY)
    taken, orders = os.pipe()
    reports, given = os.pipe()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()  # or the copy would have the text as well
    signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)  # until the copy has its own handlers
    number = os.fork()
    if number == 0:
        open_ones = (stream for other in others for stream in (other.orders, other.reports) if not stream.closed)
        ours = [stream.fileno() for stream in open_ones]
        _serve_and_end(folder, taken, given, [orders, reports, *ours])
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    os.close(taken)
    os.close(given)
    ended = lambda: os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])  # noqa: E731
    return ServingProcess(os.fdopen(orders, "w", encoding="utf-8"), os.fdopen(reports, encoding="utf-8"), ended)


def _serve_and_end(folder: Path, orders: int, reports: int, not_its_own: Sequence[int]) -> NoReturn:
    """What a copy does: nothing of what the process would go on with, whatever happens."""
    code = EXIT_BUG
    try:
        for descriptor in not_its_own:  # an end of a pipe that stays open hides that the other one is gone
            os.close(descriptor)
        code = serve(folder, orders, reports)
    except FretsolveError as error:
        print(error, file=sys.stderr)
        code = error.exit_code
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)
