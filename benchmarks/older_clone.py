"""Measure with the package of this clone and of an older one in turns, so that other load disturbs their ratio little.

A script that does so answers requests by `answer` when it is called with MEASURE, in a process for each clone.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MEASURE = "--measure"
REPETITIONS = 5


class Clone:
    """A process in which `script` measures with the package of one clone; compiled: with numba."""

    def __init__(self, script: str, root: Path, compiled: bool):
        own = {"PYTHONPATH": str(root), "FRETSOLVE_NUMBA": str(int(compiled)), "OMP_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            [sys.executable, script, MEASURE],
            env=os.environ | own,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def measure(self, request: str) -> tuple[float, ...]:
        """Return the numbers that the script answers to a request."""
        assert self._process.stdin is not None and self._process.stdout is not None
        print(request, file=self._process.stdin, flush=True)
        return tuple(map(float, self._process.stdout.readline().split()))

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the root of an older clone, and the option by which a clone's process is told."""
    parser.add_argument("--older", type=Path, help="the root of an older clone")
    parser.add_argument(MEASURE, action="store_true", help=argparse.SUPPRESS)


def answer(measured: Callable[[str], Sequence[float]]) -> None:
    """Answer each request on the standard input."""
    for line in sys.stdin:
        print(*measured(line.strip()), flush=True)


def headings(older: Path | None) -> list[str]:
    """Return those of `rows`."""
    if older is None:
        return ["ms", "applications"]
    return ["older, ms", "ms", "ratio", "older, applications", "applications"]


def rows(script: str, older: Path | None, compiled: bool, requests: Sequence[str]) -> Iterator[list[str]]:
    """Yield for each request the milliseconds and applications of an increment, the least of some runs.

    With an older clone those of both, and the ratio of the times.
    """
    clones = [Clone(script, root, compiled) for root in ([] if older is None else [older.resolve()]) + [ROOT]]
    for request in requests:
        rounds = [[clone.measure(request) for clone in clones] for _ in range(REPETITIONS)]
        costs = [min(runs) for runs in zip(*rounds, strict=True)]
        times, applications = ([f"{value:.1f}" for value in values] for values in zip(*costs, strict=True))
        yield [*times, *([] if older is None else [f"{costs[1][0] / costs[0][0]:.2f}"]), *applications]
    for clone in clones:
        clone.close()
