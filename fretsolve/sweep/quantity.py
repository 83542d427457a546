"""Quantities that sweeps collect and studies compare: columns of the history at the end of a stage."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from fretsolve.case.dimensions import NUMBER, TIME
from fretsolve.case.history import HISTORY_DIMENSIONS, PAIRS, SHEARING
from fretsolve.case.problems import nearest
from fretsolve.errors import CaseError, SlidingError
from fretsolve.export.selection import relevant_columns, total_cost
from fretsolve.fatigue.names import WORST_NAMES, fatigue_path
from fretsolve.result import Result, open_result
from fretsolve.result.cycles import CYCLE_NAMES, CYCLES
from fretsolve.result.layout import ERRORS, HISTORY
from fretsolve.result.state import CORRECTED, CORRECTED_SUFFIX, ERROR_SUFFIX, stage_ends
from fretsolve.result.verdict import best_column
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.stress.names import PEAK_NAMES, stress_path
from fretsolve.system.arrays import DoubleArray

NAMES = tuple(
    column.name
    for column in HISTORY
    if HISTORY_DIMENSIONS.get(column.name, NUMBER) not in (NUMBER, TIME) and column.name != "work"
)
"""Columns that can be collected; the dissipated energy of one increment depends on how many there are."""

CORRECTED_NAMES = tuple(name + CORRECTED_SUFFIX for name in NAMES if name in CORRECTED)
"""Columns that can be collected too, from runs with error bars."""

_ALL_NAMES = (*NAMES, *CORRECTED_NAMES, *PEAK_NAMES, *WORST_NAMES, *CYCLE_NAMES)

_COLUMN_UNITS = {column.name: column.units for column in (*HISTORY, *ERRORS, *CYCLES)}
_COLUMN_UNITS |= dict.fromkeys((*PEAK_NAMES, *WORST_NAMES), "MPa") | {"fatemi_socie_max": "1"}

RunningCondition = Literal["", "stick", "partial slip", "mixed", "gross slip"]

LAST_STAGE = 1_000_000_000
"""Stands for the last stage where the number of stages is not known."""


@dataclass(frozen=True)
class StageQuantity:
    """A column of the history, by name, at the end of a stage (from 1, cycles unrolled; or `LAST_STAGE`).

    For a column of the table of cycles, `stage` is the number of the cycle (or `LAST_STAGE`, for the last one).
    """

    name: str
    stage: int

    @property
    def units(self) -> str:
        """The unit of its values."""
        return _COLUMN_UNITS[self.name]

    def __str__(self) -> str:
        return f"{self.name}@{self.stage}" if self.stage != LAST_STAGE else self.name


def read_quantity(text: str, stages: int = LAST_STAGE) -> StageQuantity:
    """Read ``NAME`` or ``NAME@STAGE``, by default at the last of `stages`; or ``NAME@CYCLE``. Raises CaseError."""
    name, at, stage = (part.strip() for part in text.partition("@"))
    if name not in _ALL_NAMES:
        known = (*NAMES, *CYCLE_NAMES)
        raise _refused(f"{name!r} is not a quantity that can be compared; {nearest(name, known)}", text)
    if name in CYCLE_NAMES:
        if at and not (stage.isdecimal() and len(stage) < 10 and int(stage) >= 1):
            raise _refused(f"there is no cycle {stage!r}; one from 1 on is needed", text)
        return StageQuantity(name, int(stage) if at else LAST_STAGE)
    if at and not (stage.isdecimal() and len(stage) < 10 and 1 <= int(stage) <= stages):
        ends = "on" if stages == LAST_STAGE else f"to {stages}"
        raise _refused(f"there is no stage {stage!r}; one from 1 {ends} is needed", text)
    if at and name in WORST_NAMES and int(stage) != stages:
        raise _refused(f"{name} is that of the last cycle; leave @{stage} out", text)
    return StageQuantity(name, int(stage) if at else stages)


def key_beside(name: str) -> str:
    """Return the key of the case without which a quantity is not known, such as output.stress; empty for none."""
    return "output.stress" if name in PEAK_NAMES else "output.fatigue" if name in WORST_NAMES else ""


def usual_quantities(setup: ProblemSetup) -> tuple[StageQuantity, ...]:
    """Return the responses to the load path at its end and what the case expects, without what is imposed."""
    last = len(setup.load_path.last_steps)
    found = [StageQuantity(name, last) for name in _moved(setup)] + list(expected_values(setup))
    imposed = setup.load_path.imposed
    return in_order([quantity for quantity in found if quantity.name not in imposed[quantity.stage - 1]])


def expected_values(setup: ProblemSetup) -> dict[StageQuantity, float]:
    """Return what the case expects; of two values of one quantity the first."""
    last = len(setup.load_path.last_steps)
    return {
        StageQuantity(one.quantity, one.stage or last): one.value
        for one in reversed(setup.case.expect)
        if one.quantity in NAMES
    }


def in_order(quantities: Iterable[StageQuantity]) -> tuple[StageQuantity, ...]:
    """Return each quantity once, in the order of the history and of the stages."""
    return tuple(sorted(set(quantities), key=lambda quantity: (_ALL_NAMES.index(quantity.name), quantity.stage)))


def _moved(setup: ProblemSetup) -> list[str]:
    """Return both components of each load pair that is moved, and what describes the contact."""
    moved = {name for load in setup.load_path.imposed for name, value in load.items() if value}
    names = [name for pair in PAIRS for name in pair if moved & set(pair)]
    if setup.model.line:  # whose displacements have a free constant
        known = "delta_z" if setup.case.reference_depth else ""
        names = [name for name in names if name == known or not name.startswith("delta_")]
    names += ["max_pressure", "contact_radius"]
    if setup.model.has_shear and (moved & SHEARING or setup.model.terms.normal_tangential_coupling):
        names += ["stick_radius", "work_total"]
    return names


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--quantity {text if text.isprintable() else repr(text)}")


@dataclass(frozen=True, eq=False)
class Outcome:
    """The part of a result that a sweep or study collects.

    values, errors: of the quantities and their error bars ``(n,)``, NaN where there is none.
    increments, seconds, applications: solved, with their wall-clock time and applications of the elastic operator.
    peaks: the largest absolute value of each quantity on the path, 0 if it is round-off; failure: why there is no
    solution, empty if there is one; stages: of the whole path, 0 if the run failed; units: of the quantities by their
    names, empty without a result.
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


def read_outcome(
    path: Path, quantities: Sequence[StageQuantity], last_steps: Sequence[int] | None = None, *, corrected: bool = False
) -> Outcome:
    """Return the outcome of the result `path`. Raises FileError.

    last_steps: the increments at which stages end. Without it the stage in which a run failed counts as not ended.
    corrected: take the values corrected for the number of increments, where there are any.
    """
    with open_result(path) as result:
        history, complete = result.history, result.status == "complete"
        steps = stage_ends(history["stage"]) if last_steps is None else last_steps
        ends = dict(enumerate(steps, start=1))
        if last_steps is None or complete:  # cycles that end by themselves leave stages out
            steps = stage_ends(history["stage"])
            ends = dict(zip(history["stage"][steps].tolist(), steps, strict=True))
        if complete:
            ends[LAST_STAGE] = result.increments - 1
        elif last_steps is None and ends:
            ends.popitem()

        stresses: dict[str, dict[int, tuple[float, float]]] = {}
        if any(one.name in PEAK_NAMES for one in quantities):
            from fretsolve.stress.stress_file import read_peaks

            stresses = read_peaks(stress_path(result.path), result)
        worst: dict[str, float] = {}
        if any(one.name in WORST_NAMES for one in quantities):
            from fretsolve.fatigue.fatigue_file import read_worst

            worst = read_worst(fatigue_path(result.path), result)

        cycles = result.cycles if any(one.name in CYCLE_NAMES for one in quantities) else None

        def at_end(name: str, stage: int) -> float:
            if name in worst:
                return worst[name]
            if name.removesuffix(ERROR_SUFFIX) in CYCLE_NAMES:
                column = cycles.columns.get(name) if cycles is not None else None
                place = -1 if stage == LAST_STAGE else stage - 1
                return float(column[place]) if column is not None and place < len(column) else math.nan
            step = ends.get(stage, result.increments)
            if (as_run := name.removesuffix(ERROR_SUFFIX)) in stresses:
                return stresses[as_run].get(step, (math.nan, math.nan))[name != as_run]
            return float(history[name][step]) if name in history and step < result.increments else math.nan

        columns = [best_column(one.name, history) if corrected else one.name for one in quantities]

        def peak(name: str) -> float:
            as_run = name.removesuffix(CORRECTED_SUFFIX)
            if name in worst:
                return abs(worst[name])
            if name in CYCLE_NAMES:
                return float(np.nan_to_num(abs(cycles.columns[name])).max()) if cycles is not None else 0.0
            if name in stresses:
                return max((value for value, _ in stresses[name].values()), default=0.0)
            return 0.0 if as_run in round_off else float(abs(history[as_run]).max(initial=0.0))

        def unit(one: StageQuantity) -> str:
            if one.name in CYCLE_NAMES and cycles is not None:
                return cycles.units[one.name]
            return one.units if key_beside(one.name) or one.name in CYCLE_NAMES else result.units(one.name)

        round_off = {name for pair in PAIRS for name in pair}.difference(relevant_columns(result))
        return Outcome(
            np.array([at_end(name, one.stage) for name, one in zip(columns, quantities, strict=True)]),
            np.array([at_end(name + ERROR_SUFFIX, one.stage) for name, one in zip(columns, quantities, strict=True)]),
            result.increments,
            *total_cost(result),
            np.array([peak(one.name) for one in quantities]),
            str(result.attributes.get("failure", "")),
            running_condition_of(result),
            int(history["stage"][-1]) if complete else 0,
            {one.name: unit(one) for one in quantities},
        )


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
