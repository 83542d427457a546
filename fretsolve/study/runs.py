"""The runs of a study, made one after another, as far as they are not there yet."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.errors import FretsolveError
from fretsolve.export.selection import relevant_columns
from fretsolve.result import open_result
from fretsolve.result.state import Summary
from fretsolve.simulation.run_to_file import Stop
from fretsolve.simulation.simulation import run
from fretsolve.sweep.base_case import PreparedCase
from fretsolve.sweep.case_run import solve
from fretsolve.sweep.quantity import StageQuantity
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.signals import EXIT_STOPPED

MOST_WARM_UP = 3
"""Increments of a warm-up: the first ones call all of the solvers."""

Show = Callable[[PreparedCase, Summary], None]

_LOADS = frozenset(name for pair in PAIRS for name in pair)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a run gave.

    failure: why there is no solution, empty if there is one. values: of the quantities, ``(n,)``, NaN if the run did
    not get there; peaks: the largest absolute value of each over the whole history, 0 if it is round-off. seconds,
    applications: wall-clock time and applications of the elastic operator of all increments. reused: it was there
    already.
    """

    trial: PreparedCase
    failure: str
    values: DoubleArray
    peaks: DoubleArray
    increments: int
    seconds: float
    applications: int
    reused: bool


def is_done(trial: PreparedCase) -> bool:
    """Return whether the result of a run is there, complete or failed; files appear only when they are whole."""
    return trial.out.exists()


def make_runs(
    trials: Sequence[PreparedCase], quantities: Sequence[StageQuantity], stop: Stop, show: Show
) -> Iterator[Outcome]:
    """Yield the outcomes in the order of `trials`. At a `stop` there are fewer, and the current run is saved.

    show: called after each saved increment. Raises FileError.
    """
    missing = [trial for trial in trials if not is_done(trial)]
    warm: set[object] = set()
    for trial in trials:
        reused = is_done(trial)
        if not reused:
            _warm_up(trial, missing, warm, stop)
            if stop.requested or solve(trial, stop, partial(show, trial)).code == EXIT_STOPPED:
                return
        yield read_outcome(trial, quantities, reused=reused)


def _warm_up(trial: PreparedCase, missing: Sequence[PreparedCase], warm: set[object], stop: Stop) -> None:
    """Compile the kernels and plan the transforms of a grid before its first run, so that its cost excludes them.

    That takes the first increments of the cheapest run of the same grid and terms, whose results are dropped.
    """
    kind = _kind(trial)
    if kind in warm or stop.requested:
        return
    warm.add(kind)
    same = [other for other in missing if _kind(other) == kind]
    cheapest = min(same, key=lambda other: (other.expected.seconds, -other.setup.case.solver.tolerance))
    with suppress(FretsolveError):
        for state in itertools.islice(run(cheapest.setup), MOST_WARM_UP):
            if stop.requested or not cheapest.setup.model.has_shear or state.summary.iterations_tangential:
                break


def _kind(trial: PreparedCase) -> object:
    return trial.setup.grid.shape, trial.setup.model.terms


def read_outcome(trial: PreparedCase, quantities: Sequence[StageQuantity], *, reused: bool) -> Outcome:
    """Return what the result of `trial` says. Raises FileError."""
    with open_result(trial.out) as result:
        steps = [trial.setup.load_path.last_steps[quantity.stage - 1] for quantity in quantities]
        columns = [result.history[quantity.name] for quantity in quantities]
        values = [column[step] if step < len(column) else np.nan for column, step in zip(columns, steps, strict=True)]
        round_off = _LOADS.difference(relevant_columns(result))
        peaks = [
            0.0 if quantity.name in round_off else np.abs(column).max(initial=0.0)
            for quantity, column in zip(quantities, columns, strict=True)
        ]
        return Outcome(
            trial,
            str(result.attributes.get("failure", "")),
            np.array(values, np.float64),
            np.array(peaks, np.float64),
            result.increments,
            float(result.history["wall_time"].sum()),
            int(result.history["operator_applications"].sum()),
            reused,
        )
