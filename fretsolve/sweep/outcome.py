"""Collect the results of a sweep or study: values of quantities with their error bars, cost, running condition."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.case.keys.unrolled_path import last_repetitions
from fretsolve.errors import SlidingError
from fretsolve.export.selection import relevant_columns, total_cost
from fretsolve.fatigue.names import WORST_NAMES, fatigue_path
from fretsolve.model.load_path import LoadPath
from fretsolve.result import Result, open_result
from fretsolve.result.cycles.table import CYCLE_NAMES, CycleTable
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX, stage_ends
from fretsolve.result.verdict import best_column, why_no_bars
from fretsolve.stress.names import PEAK_NAMES, stress_path
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


class _Source(Protocol):
    """A part of a result from which values of some quantities are read."""

    def value(self, quantity: StageQuantity) -> tuple[float, float]:
        """Return a value and its error bar, NaN where there is none."""

    def peak(self, name: str) -> float:
        """Return the largest absolute value on the path, 0 if it is round-off."""

    def units(self, quantity: StageQuantity) -> str:
        """Return the unit of its values."""


@dataclass(frozen=True, eq=False)
class _History:
    """The history. ends: the increments with which stages end; corrected: take corrected values where there are any."""

    result: Result
    ends: Mapping[int, int]
    corrected: bool

    def value(self, quantity: StageQuantity) -> tuple[float, float]:
        history, step = self.result.history, self.ends.get(quantity.stage, self.result.increments)
        name = best_column(quantity.name, history) if self.corrected else quantity.name
        if step >= self.result.increments:
            return UNKNOWN
        value, error = (
            float(history[one][step]) if one in history else math.nan for one in (name, name + ERROR_SUFFIX)
        )
        return value, error

    def peak(self, name: str) -> float:
        as_run = name.removesuffix(CORRECTED_SUFFIX)
        round_off = {one for pair in PAIRS for one in pair}.difference(relevant_columns(self.result))
        return 0.0 if as_run in round_off else float(abs(self.result.history[as_run]).max(initial=0.0))

    def units(self, quantity: StageQuantity) -> str:
        return self.result.units(quantity.name)


@dataclass(frozen=True, eq=False)
class _Cycles:
    """The table of cycles, None for a result without one. corrected: take corrected values where there are any."""

    table: CycleTable | None
    corrected: bool

    def value(self, quantity: StageQuantity) -> tuple[float, float]:
        place = -1 if quantity.stage == LAST_STAGE else quantity.stage - 1
        if self.table is None or place >= len(self.table):
            return UNKNOWN
        name = quantity.name + CORRECTED_SUFFIX
        name = name if self.corrected and name in self.table.columns else quantity.name
        found = [self.table.columns.get(one) for one in (name, name + ERROR_SUFFIX)]
        value, error = (math.nan if column is None else float(column[place]) for column in found)
        return value, error

    def peak(self, name: str) -> float:
        as_run = name.removesuffix(CORRECTED_SUFFIX)
        return 0.0 if self.table is None else float(np.nan_to_num(abs(self.table.columns[as_run])).max())

    def units(self, quantity: StageQuantity) -> str:
        return quantity.units if self.table is None else self.table.units[quantity.name.removesuffix(CORRECTED_SUFFIX)]


@dataclass(frozen=True, eq=False)
class _Stresses:
    """The largest stresses beside a result, with their errors, by name and increment."""

    peaks: Mapping[str, Mapping[int, tuple[float, float]]]
    ends: Mapping[int, int]

    def value(self, quantity: StageQuantity) -> tuple[float, float]:
        return self.peaks[quantity.name].get(self.ends.get(quantity.stage, -1), UNKNOWN)

    def peak(self, name: str) -> float:
        return max((value for value, _ in self.peaks[name].values()), default=0.0)

    def units(self, quantity: StageQuantity) -> str:
        return quantity.units


@dataclass(frozen=True, eq=False)
class _Fatigue:
    """The largest fatigue parameters beside a result, of its last cycle."""

    worst: Mapping[str, float]

    def value(self, quantity: StageQuantity) -> tuple[float, float]:
        return self.worst[quantity.name], math.nan

    def peak(self, name: str) -> float:
        return abs(self.worst[name])

    def units(self, quantity: StageQuantity) -> str:
        return quantity.units


def read_outcome(
    path: Path, quantities: Sequence[StageQuantity], load_path: LoadPath | None = None, *, corrected: bool = False
) -> CaseOutcome:
    """Return the outcome of the result `path`. Raises FileError.

    load_path: of the case, whose cycles the result may have left before their last repetition: the last one that was
    solved stands for it. Without a path the stage in which a run failed counts as not ended.
    corrected: take the values corrected for the number of increments, where there are any.
    """
    with open_result(path) as result:
        sources = _sources(result, {one.name for one in quantities}, _stage_ends(result, load_path), corrected)
        pairs = [(one, sources[one.name]) for one in quantities]
        found = np.array([source.value(one) for one, source in pairs]).reshape(-1, 2)
        return CaseOutcome(
            found[:, 0],
            found[:, 1],
            result.increments,
            *total_cost(result),
            np.array([source.peak(one.name) for one, source in pairs]),
            str(result.attributes.get("failure", "")),
            running_condition_of(result),
            int(result.history["stage"][-1]) if result.status == "complete" else 0,
            {one.name: source.units(one) for one, source in pairs},
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


def _sources(result: Result, names: set[str], ends: Mapping[int, int], corrected: bool) -> dict[str, _Source]:
    """Return the source of each quantity. Files beside the result are read only where they are needed."""
    sources: dict[str, _Source] = dict.fromkeys(names, _History(result, ends, corrected))
    if of_cycles := names.intersection(CYCLE_NAMES):
        sources |= dict.fromkeys(of_cycles, _Cycles(result.cycles, corrected))
    if of_stresses := names.intersection(PEAK_NAMES):
        from fretsolve.stress.stress_file import read_peaks

        sources |= dict.fromkeys(of_stresses, _Stresses(read_peaks(stress_path(result.path), result), ends))
    if of_fatigue := names.intersection(WORST_NAMES):
        from fretsolve.fatigue.fatigue_file import read_worst

        sources |= dict.fromkeys(of_fatigue, _Fatigue(read_worst(fatigue_path(result.path), result)))
    return sources


def running_condition_of(result: Result) -> RunningCondition:
    """Return whether all of the contact slips at some time, a part of it does, or none; empty without shear.

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
    """Return the running condition in some increments."""
    columns = ("contact_cells", "stick_cells", "max_shear")
    touching, sticking, shear = (result.history[name][steps] for name in columns)
    if not shear.any():
        return ""
    if ((sticking == 0) & (touching > 0) & (shear > 0.0)).any():
        return "gross slip"
    return "partial slip" if (sticking < touching).any() else "stick"
