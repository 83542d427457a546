"""Solve the rounds of an accuracy in memory, and return the last one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, TypeGuard

import numpy as np

from fretsolve.case.models import Case
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import State, Summary
from fretsolve.result.verdict import Verdict
from fretsolve.simulation.accuracy.rounds import Judgement, Round, first_round, judge, no_solution
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars as with_error_bars
from fretsolve.simulation.simulation import run as one_run
from fretsolve.system.arrays import DoubleArray


def run(
    case: Case | ProblemSetup, start: State | None = None, history: Sequence[Summary] = (), threads: int = 1
) -> Iterator[State]:
    """Solve `case` and yield a `State` per increment, each certified.

    With an accuracy all its rounds are solved first, and the states of the last one are kept in memory.

    start, history: the last state and the summaries of all increments so far, to go on from; threads: number of threads
    that share the transforms, on which no bit of a state depends.
    Raises NoSolutionError if an increment has no solution or none was found; the states before it hold.
    """
    if in_rounds(case, start):
        return iter(solved(case, threads)[1])
    return one_run(case, start, history, threads)


def run_with_error_bars(
    case: Case | ProblemSetup,
    start: State | None = None,
    history: Sequence[Summary] = (),
    threads: int = 1,
    warn: Callable[[str], object] | None = None,
) -> Iterator[State]:
    """Solve `case` as `run` does, and yield each state with its error bars.

    If a coarse run has no solution, the error bars are NaN from there on, and `warn` is called with one line.
    Raises NoSolutionError if the run itself has none, and CaseError on too few points for coarse runs.
    """
    if in_rounds(case, start):
        return iter(solved(case, threads, warn)[1])
    return with_error_bars(case, start, history, threads, warn)


def in_rounds(case: Case | ProblemSetup, start: State | None) -> TypeGuard[Case]:
    """Return whether a case is solved in rounds. Raises CaseError if it is, and is to go on from a state."""
    if not isinstance(case, Case) or case.solver.accuracy is None:
        return False
    if start is not None:
        message = "a state belongs to one round, so that rounds do not go on from it; give the setup of its round"
        raise case.source.problem(message, ("solver", "accuracy"))
    return True


def solved(
    case: Case, threads: int = 1, warn: Callable[[str], object] | None = None
) -> tuple[Round, list[State], Verdict | None]:
    """Solve the rounds of a case in memory, and return the last one with its states and the verdict on it.

    warn: as for `run_with_error_bars`. If a later round has no solution, the round before it is the last one. Raises
    NoSolutionError if the first round has none, CaseError and FileError as `run`.
    """
    *_, (last, rows, found) = rounds_of(case, threads, warn)
    return last, rows, found.verdict


def rounds_of(
    case: Case, threads: int = 1, warn: Callable[[str], object] | None = None
) -> Iterator[tuple[Round, list[State], Judgement]]:
    """Yield each round of a case with its states and what it is known to, as `solved` takes the last one."""
    current, done = first_round(case), None
    while True:
        began = time.perf_counter()
        try:
            rows = list(_states(current.setup, threads, warn))
        except NoSolutionError as error:
            if done is None or (verdict := done[2].verdict) is None:
                raise
            yield *done[:2], Judgement(replace(verdict, reason=no_solution(current, error)))
            return
        history = history_of(rows)
        found = judge(current, history, partial(cycles_of, current.setup, history), time.perf_counter() - began)
        yield current, rows, found
        if found.following is None:
            return
        current, done = found.following, (current, rows, found)


def _states(setup: ProblemSetup, threads: int, warn: Callable[[str], object] | None) -> Iterator[State]:
    if not setup.case.solver.error_bars:
        return one_run(setup, threads=threads)
    return with_error_bars(setup, threads=threads, warn=warn)


def history_of(rows: Sequence[State]) -> dict[str, DoubleArray]:
    """Return the columns of the history of states, and of their error bars."""
    columns = [vars(row.summary) | (vars(row.errors) if row.errors is not None else {}) for row in rows]
    return {name: np.array([column[name] for column in columns]) for name in (columns[0] if columns else ())}


def cycles_of(setup: ProblemSetup, history: Mapping[str, DoubleArray]) -> Mapping[str, Any] | None:
    """Return the columns of the table of cycles, None without any."""
    from fretsolve.result.cycles.table import cycle_table  # few accuracies are about cycles

    table = cycle_table(history, setup.case.effective(), lambda step: None, ended=True)
    return None if table is None else table.columns
