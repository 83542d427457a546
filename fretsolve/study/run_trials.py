"""Making the runs of a study one after another, each into a result file, as far as they are not there yet."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.load_components import PAIRS
from fretsolve.errors import FretsolveError, NoSolutionError
from fretsolve.export.selection import relevant_columns
from fretsolve.result import SAME_COMMAND, HistoryWriter, Result, open_result
from fretsolve.simulation.run_to_file import Saving, missing_states
from fretsolve.simulation.simulation import run
from fretsolve.study.quantity import Observable
from fretsolve.study.trial import Trial
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result.state import Summary
    from fretsolve.system.signals import StopRequest

MOST_WARM_UP = 3
"""Increments of a warm-up: the first ones call all of the solvers."""

Show = Callable[[Trial, "Summary"], None]

_LOADS = frozenset(name for pair in PAIRS for name in pair)


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a trial came to.

    failure: why there is no solution, empty where there is. values: of the observables, ``(n,)``, NaN where the run
    did not get there; peaks: the largest |value| of each over the whole history, 0 where it is but round-off.
    seconds, applications: cost of all increments, the wall-clock time and that of the elastic operator. reused: it was
    there already.
    """

    trial: Trial
    failure: str
    values: DoubleArray
    peaks: DoubleArray
    increments: int
    seconds: float
    applications: int
    reused: bool


def is_done(trial: Trial) -> bool:
    """Whether its result is there, complete or failed; files appear whole."""
    return trial.out.exists()


def make_runs(
    trials: Sequence[Trial], observables: Sequence[Observable], stop: StopRequest, show: Show
) -> Iterator[Outcome]:
    """The outcomes in the order of `trials`; fewer where `stop` is requested, with what is done of the next one saved.

    show: called after each saved increment. Raises FileError.
    """
    missing = [trial for trial in trials if not is_done(trial)]
    warm: set[object] = set()
    for trial in trials:
        reused = is_done(trial)
        if not reused:
            _warm_up(trial, missing, warm, stop)
            if stop.requested or not _solve(trial, stop, show):
                return
        yield read_outcome(trial, observables, reused=reused)


def _solve(trial: Trial, stop: StopRequest, show: Show) -> bool:
    """Solve and save what is missing, until the end or a failure (True), or until a signal."""
    with HistoryWriter.open(trial.out, trial.header, resume=True, advice=SAME_COMMAND) as writer:
        saving = Saving(writer, trial.setup.load_path.increments, lambda summary, _: show(trial, summary))
        try:
            with saving:
                states = missing_states(trial.setup, writer)
                while not stop.requested and (state := next(states, None)) is not None:
                    saving.append(state)
        except NoSolutionError:
            return True
        return saving.complete


def _warm_up(trial: Trial, missing: Sequence[Trial], warm: set[object], stop: StopRequest) -> None:
    """Compile the kernels and plan the transforms of a grid before its first run, or they would count as its cost.

    That takes the first increments of the cheapest run of the same grid and terms, which are thrown away.
    """
    kind = _kind(trial)
    if kind in warm or stop.requested:
        return
    warm.add(kind)
    cheapest = min((other for other in missing if _kind(other) == kind), key=_effort)
    with suppress(FretsolveError):
        for state in itertools.islice(run(cheapest.setup), MOST_WARM_UP):
            if stop.requested or not cheapest.setup.model.has_shear or state.summary.iterations_tangential:
                break


def _kind(trial: Trial) -> object:
    return trial.setup.grid.shape, trial.setup.model.terms


def _effort(trial: Trial) -> tuple[float, float]:
    return trial.seconds, -trial.setup.case.solver.tolerance


def read_outcome(trial: Trial, observables: Sequence[Observable], *, reused: bool) -> Outcome:
    """What the result of `trial` says. Raises FileError."""
    with open_result(trial.out) as result:
        steps = [trial.setup.load_path.last_steps[observable.stage - 1] for observable in observables]
        columns = [result.history[observable.name] for observable in observables]
        values = [column[step] if step < len(column) else np.nan for column, step in zip(columns, steps, strict=True)]
        nothing = _nothing(result)
        peaks = [
            0.0 if observable.name in nothing else np.abs(column).max(initial=0.0)
            for observable, column in zip(observables, columns, strict=True)
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


def _nothing(result: Result) -> frozenset[str]:
    """Load components that are but round-off."""
    return _LOADS.difference(relevant_columns(result))
