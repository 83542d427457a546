"""Collect the results of a sweep or study: values of quantities with their error bars, cost, running condition."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from fretsolve.case.history import MOTIONS_OF_ACTUATORS, PAIRS
from fretsolve.case.keys.quantity_names import OUTPUT_NAMES
from fretsolve.case.keys.unrolled_path import last_repetitions
from fretsolve.errors import SlidingError
from fretsolve.post.export.selection import is_more_than_round_off, relevant_columns, total_cost
from fretsolve.post.names import crack_path, fatigue_path, stress_path
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.result import Result, open_result
from fretsolve.result.cycles.table import CYCLE_NAMES, CycleTable
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX, stage_ends
from fretsolve.result.verdict import best_column, why_no_bars
from fretsolve.sweep.quantity import LAST_STAGE, StageQuantity
from fretsolve.system.arrays import DoubleArray

RunningCondition = Literal["", "stick", "partial slip", "mixed", "gross slip"]

UNKNOWN = (math.nan, math.nan)
"""A value and its error bar where there is none."""


@dataclass(frozen=True, eq=False)
class CaseOutcome:
    """The part of a result that a sweep or study collects.

    values, errors: of the quantities and their error bars ``(n,)``, NaN where there is none.
    increments, seconds, applications: solved, with their wall-clock time and applications of the elastic operator.
    peaks: the largest absolute value of each quantity on the path, 0 if it is round-off; failure: why there is no
    solution, empty if there is one; stages: of the whole path, 0 if the run failed; units: of the quantities by their
    names, empty without a result; without_bars: from where on there are no error bars, and why, empty if there are all.
    """

    values: DoubleArray
    errors: DoubleArray
    increments: int
    seconds: float = 0.0
    applications: int = 0
    peaks: DoubleArray = field(default_factory=lambda: np.empty(0))
    failure: str = ""
    running_condition: RunningCondition = ""
    stages: int = 0
    units: Mapping[str, str] = field(default_factory=dict)
    without_bars: str = ""


@dataclass(frozen=True, eq=False)
class _Column:
    """One quantity as it stands in a result or a file beside the result.

    values: with their error bars, by the stage or cycle at whose end they are; peak: the largest absolute value on the
    path, 0 if it is round-off; units: empty for the usual ones of the quantity.
    """

    values: Mapping[int, tuple[float, float]]
    peak: float
    units: str


def read_outcome(
    path: Path, quantities: Sequence[StageQuantity], load_path: LoadPath | None = None, *, corrected: bool = False
) -> CaseOutcome:
    """Return the outcome of the result `path`. Raises FileError.

    load_path: of the case, whose cycles the result may have left before their last repetition: the last one that was
    solved stands for it. Without a path the stage in which a run failed counts as not ended.
    corrected: take the values corrected for the number of increments, where there are any.
    """
    with open_result(path) as result:
        columns = _columns(result, quantities, _stage_ends(result, load_path), corrected)
        found = np.array([columns[one.name].values.get(one.stage, UNKNOWN) for one in quantities]).reshape(-1, 2)
        return CaseOutcome(
            found[:, 0],
            found[:, 1],
            result.increments,
            *total_cost(result),
            np.array([columns[one.name].peak for one in quantities]),
            str(result.attributes.get("failure", "")),
            running_condition_of(result),
            int(result.history["stage"][-1]) if result.status == "complete" else 0,
            {one.name: columns[one.name].units or one.units for one in quantities},
            why_no_bars(result.history),
        )


def _stage_ends(result: Result, load_path: LoadPath | None) -> dict[int, int]:
    """Return the increment with which each stage ends; load_path: as for `read_outcome`."""
    stages, complete = result.history["stage"], result.status == "complete"
    if load_path is None or complete:  # cycles that end by themselves leave stages out
        steps = stage_ends(stages)
        ends = dict(zip(stages[steps].tolist(), steps.tolist(), strict=True))
    else:
        ends = dict(enumerate(load_path.last_steps, start=1))
    if complete:
        ends[LAST_STAGE] = result.increments - 1
        if load_path is not None:
            solved = last_repetitions(stage for stage in load_path.stages if stage.number in ends)
            left_out = last_repetitions(load_path.stages).items() - solved.items()
            ends |= {number: ends[solved[place]] for place, number in left_out if place in solved}
            ends.setdefault(len(load_path.stages), result.increments - 1)  # a change by wear that was left out
    elif load_path is None and ends:
        ends.popitem()
    return ends


def _columns(
    result: Result, quantities: Sequence[StageQuantity], ends: Mapping[int, int], corrected: bool
) -> dict[str, _Column]:
    """Return the column of each quantity. Files beside the result are read only where they are needed.

    ends: the increments with which stages end; corrected: take corrected values where there are any.
    """
    names, columns = {one.name for one in quantities}, {}
    relevant = relevant_columns(result)
    for name in names.difference(CYCLE_NAMES, *OUTPUT_NAMES.values()):
        columns[name] = _of_history(result, name, ends, relevant, corrected)
    for name in names.intersection(CYCLE_NAMES):
        columns[name] = _of_cycles(result.cycles, name, corrected)
    if of_stresses := names.intersection(OUTPUT_NAMES["stress"]):
        from fretsolve.post.stress.stress_file import read_peaks

        peaks = read_peaks(stress_path(result.path), result)
        for name in of_stresses:
            values = {stage: peaks[name].get(step, UNKNOWN) for stage, step in ends.items()}
            columns[name] = _Column(values, max((value for value, _ in peaks[name].values()), default=0.0), "")
    known: dict[str, tuple[float, float]] = {}
    if names.intersection(OUTPUT_NAMES["fatigue"]):
        from fretsolve.post.fatigue.fatigue_file import read_worst

        known |= read_worst(fatigue_path(result.path), result)
    if names.intersection(OUTPUT_NAMES["crack"]):
        from fretsolve.post.crack.crack_file import read_crack

        known |= read_crack(crack_path(result.path), result)
    for name in names.intersection(known):  # known of the whole run alone, whatever the stage
        columns[name] = _Column({one.stage: known[name] for one in quantities}, abs(known[name][0]), "")
    return columns


def _of_history(
    result: Result, name: str, ends: Mapping[int, int], relevant: Sequence[str], corrected: bool
) -> _Column:
    history = result.history
    column = best_column(name, history) if corrected else name
    pair = [history.get(one) for one in (column, column + ERROR_SUFFIX)]
    values = {stage: _at(pair, step) for stage, step in ends.items() if step < result.increments}
    as_run = name.removesuffix(CORRECTED_SUFFIX)
    round_off = {one for pair in PAIRS for one in pair}.difference(relevant)
    if as_run in MOTIONS_OF_ACTUATORS and not is_more_than_round_off(result, as_run):
        round_off.add(as_run)
    peak = 0.0 if as_run in round_off else float(abs(history[as_run]).max(initial=0.0))
    return _Column(values, peak, result.units(name))


def _of_cycles(table: CycleTable | None, name: str, corrected: bool) -> _Column:
    """Return a column of the table of cycles, None for a result without a table."""
    if table is None:
        return _Column({}, 0.0, "")
    as_run = name.removesuffix(CORRECTED_SUFFIX)
    column = name + CORRECTED_SUFFIX
    column = column if corrected and column in table.columns else name
    pair = [table.columns.get(one) for one in (column, column + ERROR_SUFFIX)]
    values = {place + 1: _at(pair, place) for place in range(len(table))}
    values |= {LAST_STAGE: values[len(table)]} if values else {}
    return _Column(values, float(np.nan_to_num(abs(table.columns[as_run])).max(initial=0.0)), table.units[as_run])


def _at(pair: Sequence[DoubleArray | None], place: int) -> tuple[float, float]:
    """Return the value and the error bar at a place of two columns, NaN for a column that is not there."""
    value, error = (math.nan if column is None else float(column[place]) for column in pair)
    return value, error


def running_condition_of(result: Result) -> RunningCondition:
    """Return whether the whole contact slips at some time, a part slips, or nothing does; empty without shear.

    A result with cycles is judged by its full cycles, and is mixed if all of the contact slips in some of them alone.
    A run that ended because a force exceeded what friction carries is one of gross slip.
    """
    if result.attributes.get("failure_kind") == SlidingError.kind:
        return "gross slip"
    cycles = result.cycles
    if cycles is None or not len(cycles):
        return _condition_in(result, slice(None))
    ends = zip(cycles.columns["first_step"].tolist(), cycles.columns["last_step"].tolist(), strict=True)
    found = {_condition_in(result, slice(first + 1, last + 1)) for first, last in ends}
    if "gross slip" in found and len(found) > 1:
        return "mixed"
    return next((name for name in ("gross slip", "partial slip", "stick") if name in found), "")


def _condition_in(result: Result, steps: slice) -> RunningCondition:
    columns = ("contact_cells", "stick_cells", "max_shear")
    touching, sticking, shear = (result.history[name][steps] for name in columns)
    if not shear.any():
        return ""
    if ((sticking == 0) & (touching > 0) & (shear > 0.0)).any():
        return "gross slip"
    return "partial slip" if (sticking < touching).any() else "stick"
