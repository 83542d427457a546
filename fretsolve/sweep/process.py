"""Processes that serve a sweep: copies of this one where that is safe, else new interpreters.

A new interpreter takes a second to import what a copy has already. A copy is safe where no other thread runs, whose
locks it would find locked for ever, and on Linux alone (the system libraries of macOS do not bear it).
"""

from __future__ import annotations

import gc
import importlib
import os
import signal
import subprocess
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, NoReturn

from fretsolve.errors import FretsolveError
from fretsolve.sweep.worker import EXIT_BUG, serve
from fretsolve.system.signals import SIGNALS

HEAVY = "fretsolve.sweep.base"
"""What a process imports that works on cases."""


@dataclass(frozen=True)
class ServingProcess:
    """A process of `fretsolve.sweep.worker.serve`, and the pipes to it.

    wait: waits for its end and returns the exit code, or minus the number of the signal that ended it; 0 where
    somebody else has asked for it.
    """

    orders: IO[str]
    reports: IO[str]
    wait: Callable[[], int]


def start(folder: Path, others: Sequence[ServingProcess]) -> ServingProcess:
    """Have a process serve the sweep in `folder`. others: those that serve already. Raises OSError."""
    return copy(folder, others) if is_alone() else new(folder)


def is_alone() -> bool:
    """Whether this process may be copied: on Linux, and without other threads, be they Python's or a library's."""
    try:
        return sys.platform == "linux" and len(list(Path("/proc/self/task").iterdir())) == 1
    except OSError:
        return False


def new(folder: Path) -> ServingProcess:
    """A new interpreter."""
    line = [sys.executable, "-m", "fretsolve", "sweep", "serve", str(folder)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(line, stdin=pipe, stdout=pipe, text=True, encoding="utf-8")
    assert process.stdin is not None
    assert process.stdout is not None
    return ServingProcess(process.stdin, process.stdout, process.wait)


def copy(folder: Path, others: Sequence[ServingProcess]) -> ServingProcess:
    """A copy of this process, which must be the only thread in it."""
    importlib.import_module(HEAVY)
    (taken, orders), (reports, given) = os.pipe(), os.pipe()
    streams = (stream for other in others for stream in (other.orders, other.reports) if not stream.closed)
    not_its_own = [orders, reports, *(stream.fileno() for stream in streams)]
    for stream in (sys.stdout, sys.stderr):
        stream.flush()  # or the copy would have the text as well
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)  # until the copy has its own handlers
    try:
        number = os.fork()
        if number == 0:
            _serve_and_end(folder, taken, given, not_its_own)
    except OSError:
        os.close(orders)
        os.close(reports)
        raise
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        os.close(taken)
        os.close(given)
    return ServingProcess(
        os.fdopen(orders, "w", encoding="utf-8"), os.fdopen(reports, encoding="utf-8"), lambda: _exit_code(number)
    )


def _serve_and_end(folder: Path, orders: int, reports: int, not_its_own: Sequence[int]) -> NoReturn:
    """What a copy does: nothing of what the process would go on with, whatever happens."""
    code = EXIT_BUG
    try:
        gc.freeze()  # looking for garbage would copy the memory that it has in common with its parent
        for descriptor in not_its_own:  # an end of a pipe that stays open hides that the other one is gone
            os.close(descriptor)
        os.dup2(orders, 0)
        os.close(orders)
        code = serve(folder, 0, reports)
    except FretsolveError as error:
        print(error, file=sys.stderr)
        code = error.exit_code
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def _exit_code(number: int) -> int:
    try:
        return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
    except ChildProcessError:  # where SIGCHLD is ignored
        return 0
