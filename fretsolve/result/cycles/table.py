"""The table of the cycles of a result: the loop of each, what it dissipates, and whether it is periodic.

The loop of a cycle is the force over the displacement along the direction in which the contact is moved, or the torque
over the rotation where no force is. Where nothing tangential acts, the moment or normal force that moves gives the
loop.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import percent
from fretsolve.case.history import BULK, PAIRS
from fretsolve.result.cycles.loops import (
    CycleSteps,
    History,
    Measure,
    area,
    change_within,
    cycles_in,
    distance_to_limit,
    ends_of_loop,
    half_width,
    range_error,
    reversal_stiffness,
    stages_of,
)
from fretsolve.result.layout import Quantity
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX
from fretsolve.system.arrays import DoubleArray

CYCLES = (
    Quantity("cycle", "1", "cycle, counted from 1 along the load path", "int64"),
    Quantity("first_step", "1", "increment after which it begins, -1 for the start of the path", "int64"),
    Quantity("last_step", "1", "increment with which it ends", "int64"),
    Quantity("stage", "1", "stage with which it ends", "int64"),
    Quantity("dissipated_energy", "mJ", "energy dissipated in the cycle"),
    Quantity("energy_ratio", "1", "area of the loop over force range times displacement range"),
    Quantity("sliding_ratio", "1", "width of the loop at its mean force over the displacement range"),
    Quantity("sliding_amplitude", "mm", "half of the width of the loop at its mean force"),
    Quantity("slip_amplitude", "mm", "largest local slip amplitude, half of the slip between the ends of the loop"),
    Quantity("reversal_stiffness", "N/mm", "slope of the loop just after a reversal, the mean of its reversals"),
    Quantity("force_range", "N", "largest less smallest force"),
    Quantity("displacement_range", "mm", "largest less smallest displacement"),
    Quantity("force_drift", "N", "force at the end less that at the beginning"),
    Quantity("displacement_drift", "mm", "displacement at the end less that at the beginning"),
)
"""Columns of the table of cycles."""

OF_MOMENTS = {"N": "N mm", "mm": "rad", "N/mm": "N mm/rad"}
OF_A_LINE = {"N": "N/mm", "mJ": "mJ/mm", "N/mm": "N/mm/mm"}
"""Other units of columns: of moment and rotation, and per mm of a line contact."""

FORCES = frozenset(name for pair in PAIRS[3:5] for name in pair)
"""Tangential forces and displacements."""

ROUND_OFF = 1e-12
"""Part of the displacement range below which the width of a loop is 0."""

HIDDEN, NOTEWORTHY = "hidden between increments", 0.05
"""Error of the sliding ratio by the increments, of which no column is made, and how large it is worth a note."""

LEAST_FORCE = 1e-8
"""Tangential force over P below which it is round-off."""

_MEASURED = tuple(one.name for one in CYCLES if one.dtype == "float64")

WITH_ERRORS = tuple(name for name in _MEASURED if name != "slip_amplitude" and not name.endswith("_drift"))
"""Columns that have error bars where the history has."""

CORRECTED_CYCLE_NAMES = tuple(name + CORRECTED_SUFFIX for name in WITH_ERRORS if name != "reversal_stiffness")
"""Columns of values corrected for the number of increments, where the history has such. The stiffness is extrapolated
from the increments itself."""

CYCLE_NAMES = (*_MEASURED, *CORRECTED_CYCLE_NAMES)
"""Columns that say how a cycle went."""


@dataclass(frozen=True, eq=False)
class CycleTable:
    """The cycles of a result.

    columns: by the names of `CYCLES`, and of error bars, each ``(cycles,)``, NaN where a value does not exist; units,
    meanings: of each; outcomes: a sentence on each cycle that was to run until it is periodic, and whether it is;
    notes: what the increments of the loops do not tell.
    """

    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str]
    meanings: Mapping[str, str]
    outcomes: tuple[tuple[str, bool], ...] = ()
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.columns["cycle"])


def cycle_table(
    history: History, effective_case: Mapping[str, Any], slip: Callable[[int], NDArray[Any] | None], *, ended: bool
) -> CycleTable | None:
    """Return the table of the cycles in the history of a case, None if there is none.

    slip: returns the slip ``(2, nx, ny)`` after an increment, None where it is not stored; ended: whether the last
    stage has ended.
    """
    cycles = cycles_in(stages_of(effective_case), history["stage"], ended=ended)
    if not cycles:
        return None
    pair = _pair(history, cycles)
    rows = [_measured(history, one, slip, pair) for one in cycles]
    if "work_total" + CORRECTED_SUFFIX in history:
        corrected = _with_corrected_values(history)
        for row, one in zip(rows, cycles, strict=True):
            found = _measured(corrected, one, lambda step: None, pair)
            for name in CORRECTED_CYCLE_NAMES:
                as_run = name.removesuffix(CORRECTED_SUFFIX)
                row |= {name: found[as_run], name + ERROR_SUFFIX: found[as_run + ERROR_SUFFIX]}
    moments = pair is not None and pair[0].startswith("M")
    chosen = [
        one for one in _quantities(moments=moments, line=effective_case.get("plane") == "strain") if one.name in rows[0]
    ]
    return CycleTable(
        {one.name: np.array([row[one.name] for row in rows], one.dtype) for one in chosen},
        {one.name: one.units for one in chosen},
        {one.name: one.long_name for one in chosen},
        tuple(_outcomes(history, cycles)),
        tuple(_notes(rows)),
    )


def _quantities(*, moments: bool, line: bool) -> list[Quantity]:
    """Return all columns that a table may have: `CYCLES`, corrected values, and the error bars of both."""
    known = {one.name: replace(one, units=_units(one, moments=moments, line=line)) for one in CYCLES}
    for name in CORRECTED_CYCLE_NAMES:
        as_run = known[name.removesuffix(CORRECTED_SUFFIX)]
        known[name] = replace(
            as_run, name=name, long_name=f"{as_run.long_name}, corrected for the number of increments"
        )
    for one in [known[name] for name in (*WITH_ERRORS, *CORRECTED_CYCLE_NAMES)]:
        name = one.name + ERROR_SUFFIX
        known[name] = replace(one, name=name, long_name=f"estimated error of {one.long_name}")
    return list(known.values())


def _with_corrected_values(history: History) -> dict[str, NDArray[Any]]:
    """Return a history with the corrected values, and their error bars, in place of the values as run."""
    corrected = [name for name in history if name.endswith(CORRECTED_SUFFIX)]
    found = dict(history)
    for name in corrected:
        as_run = name.removesuffix(CORRECTED_SUFFIX)
        found |= {as_run: history[name], as_run + ERROR_SUFFIX: history[name + ERROR_SUFFIX]}
    return found


def _units(one: Quantity, *, moments: bool, line: bool) -> str:
    if one.name == "slip_amplitude":
        return one.units
    units = OF_A_LINE.get(one.units, one.units) if line else one.units
    return OF_MOMENTS.get(units, units) if moments else units


def _outcomes(history: History, cycles: Sequence[CycleSteps]) -> list[tuple[str, bool]]:
    """Return for each cycle that was to run until it is periodic whether it is, in words."""
    found = []
    for run in dict.fromkeys(one.run for one in cycles if one.until is not None):
        last = [one for one in cycles if one.run == run][-3:]
        cycle, ends = last[-1], f"{last[-1].turn} cycles"
        if len(last) < 2 or cycle.until is None:
            continue
        left = distance_to_limit(history, last)
        if len(last) == 2 and left.largest > cycle.until:
            distances = "two cycles do not tell how far the limit is"
        else:
            energy, value = (percent(round(one, 6)) for one in (left.energy, left.value))
            distances = (
                f"by the last changes the dissipated energy is about {energy} from its limit, {left.name} at the end"
                f" {value} of its scale, tolerance {percent(cycle.until)}"
            )
        if left.largest <= cycle.until:
            found.append((f"{cycle.key}: periodic after {ends} of at most {cycle.most}: {distances}", True))
        elif cycle.turn == cycle.most:
            text = f"{cycle.key}: not periodic after {ends}: {distances}; at_most: {2 * cycle.turn} would go on"
            found.append((text, False))
    return found


def _notes(rows: Sequence[Mapping[str, float]]) -> Iterator[str]:
    """Yield what the increments of loops do not tell, or not well."""
    if (widest := float(np.nanmax([0.0, *(row[HIDDEN] for row in rows)]))) > NOTEWORTHY:
        yield (
            f"sliding_ratio is known to ± {widest:.2g} by these increments, and sliding_amplitude to half of that times"
            " the displacement range; more of them tell both closer"
        )
    if any(
        math.isnan(row["reversal_stiffness"]) and row["force_range"] * row["displacement_range"] > 0.0 for row in rows
    ):
        yield (
            "reversal_stiffness is not known: it takes two increments after each reversal, the first of which strains"
            " the bodies more than it slips; take more increments"
        )


def _pair(history: History, cycles: Sequence[CycleSteps]) -> tuple[str, str] | None:
    """Return the load and displacement whose loops all cycles have; None for loops along the direction of shear."""
    moved = frozenset[str]().union(*(one.moved for one in cycles))
    if moved & FORCES.union(*BULK.values()):
        return None
    if moved & set(torsion := PAIRS[5]):
        return torsion if np.any(history["Mz"]) else None
    if any((np.abs(history[name]) > _round_off(history)).any() for name in ("Qx", "Qy")):
        return None  # a constant force, whose displacement drifts
    return next((pair for pair in reversed(PAIRS[:3]) if moved & set(pair)), None)


def _round_off(history: History) -> float:
    """Return the size below which a tangential force counts as 0."""
    return LEAST_FORCE * float(np.abs(history["P"]).max())


def _measured(
    history: History, cycle: CycleSteps, slip: Callable[[int], NDArray[Any] | None], pair: tuple[str, str] | None
) -> dict[str, float]:
    """Return a row of the table. pair: see `_pair`."""
    force, motion = _loop(history, cycle, pair)
    begin, end = ends_of_loop(motion if np.isfinite(motion).all() else force)
    force_range, motion_range = float(np.ptp(force)), float(np.ptp(motion))
    energy, box = change_within(history["work_total"], cycle), force_range * motion_range
    # Where one load alone moves, friction dissipates what its loop encloses, and does so more exactly than a polygon.
    alone = len(cycle.moved) == 1 and cycle.moved <= (FORCES if pair is None else set(pair))
    enclosed = Measure(energy, 0.0) if alone else area(force, motion)
    width, stiffness = half_width(force, motion, begin, end), reversal_stiffness(force, motion)
    sliding = 0.0 if width.value <= ROUND_OFF * motion_range else width.value  # NaN stays
    row = {
        "cycle": cycle.number,
        "first_step": cycle.first,
        "last_step": cycle.last,
        "stage": int(history["stage"][cycle.last]),
        "dissipated_energy": energy,
        "energy_ratio": enclosed.value / box if box > 0.0 else math.nan,
        "sliding_ratio": 2.0 * sliding / motion_range if motion_range > 0.0 else math.nan,
        "sliding_amplitude": sliding,
        "slip_amplitude": _slip_amplitude(slip, *(cycle.first + place for place in (begin, end))),
        "reversal_stiffness": stiffness.value,
        "force_range": force_range,
        "displacement_range": motion_range,
        "force_drift": float(force[-1] - force[0]),
        "displacement_drift": float(motion[-1] - motion[0]),
        HIDDEN: 2.0 * width.error / motion_range if motion_range > 0.0 else math.nan,
    }
    if "work_total" + ERROR_SUFFIX not in history:
        return row
    stage = _rows(history, "stage", cycle)
    by_increments = {
        "energy_ratio": enclosed.error / box if box > 0.0 else math.nan,
        "sliding_ratio": row[HIDDEN],
        "sliding_amplitude": width.error,
        "reversal_stiffness": stiffness.error,
        "force_range": range_error(force, stage),
        "displacement_range": range_error(motion, stage),
    }
    return row | _errors(history, cycle, row, by_increments, (begin, end), pair)


def _errors(
    history: History,
    cycle: CycleSteps,
    row: Mapping[str, float],
    by_increments: Mapping[str, float],
    places: tuple[int, int],
    pair: tuple[str, str] | None,
) -> dict[str, float]:
    """Return the error bars of a row. by_increments: what the loop between them may hide; places: of both ends."""

    def bar(name: str, place: int) -> float:
        step = cycle.first + place
        return float(history[name + ERROR_SUFFIX][step]) if step >= 0 else 0.0

    def of_range(names: Sequence[str]) -> float:
        both = [math.hypot(*(bar(name, place) for name in names)) for place in places]
        return math.hypot(*both)

    force = of_range(("Qx", "Qy") if pair is None else pair[:1])
    motion = of_range(("delta_x", "delta_y") if pair is None else pair[1:])
    total, bars = float(history["work_total"][cycle.last]), history["work_total" + ERROR_SUFFIX]
    before = float(bars[cycle.first]) if cycle.first >= 0 else 0.0
    # Its error is mostly the same part of the energy in each increment.
    relative = float(bars[cycle.last]) / total if total else 0.0
    energy = max(abs(float(bars[cycle.last]) - before), relative * abs(row["dissipated_energy"]))

    def share(value: float, name: str) -> float:
        return value / abs(row[name]) if row[name] else 0.0

    of_energy, of_force = share(energy, "dissipated_energy"), share(force, "force_range")
    of_motion = share(motion, "displacement_range")
    # The loop's width follows from its area: energy over force.
    of_width = math.hypot(of_energy, of_force)
    found = {
        "dissipated_energy": energy,
        "energy_ratio": row["energy_ratio"] * math.hypot(of_energy, of_force, of_motion),
        "sliding_ratio": row["sliding_ratio"] * math.hypot(of_width, of_motion),
        "sliding_amplitude": row["sliding_amplitude"] * of_width,
        "reversal_stiffness": row["reversal_stiffness"] * math.hypot(of_force, of_motion),
        "force_range": force,
        "displacement_range": motion,
    }
    return {name + ERROR_SUFFIX: math.hypot(value, by_increments.get(name, 0.0)) for name, value in found.items()}


def _loop(history: History, cycle: CycleSteps, pair: tuple[str, str] | None) -> tuple[DoubleArray, DoubleArray]:
    """Return force and displacement along the direction of the loop, or the columns of a `pair`, from its begin on."""
    if pair is not None:
        return _rows(history, pair[0], cycle), _rows(history, pair[1], cycle)
    forces, motions = (
        np.array([_rows(history, name, cycle) for name in names]) for names in (("Qx", "Qy"), ("delta_x", "delta_y"))
    )
    forces[np.abs(forces) <= _round_off(history)] = 0.0
    leading = motions if np.isfinite(motions).all() else forces
    spans = leading - leading[:, :1]
    farthest = int(np.hypot(*spans).argmax())
    direction = spans[:, farthest]
    length = float(np.hypot(*direction))
    # From the first end to the other one forces fall, so that they have the sign of the history.
    unit = -direction / length if length > 0.0 else np.array([1.0, 0.0])
    if unit[np.abs(unit).argmax()] < 0.0:
        unit = -unit
    return unit @ forces, unit @ motions


def _rows(history: History, name: str, cycle: CycleSteps) -> DoubleArray:
    """Return a column from the begin of a cycle to its end."""
    inside = np.asarray(history[name][max(cycle.first, 0) : cycle.last + 1], np.float64)
    return inside if cycle.first >= 0 else np.concatenate([[0.0], inside])


def _slip_amplitude(slip: Callable[[int], NDArray[Any] | None], first: int, second: int) -> float:
    """Return half of the largest slip between two increments, NaN where it is not stored."""
    fields = [slip(step) if step >= 0 else None for step in (first, second)]
    if fields[0] is None or fields[1] is None:
        return math.nan
    between = np.asarray(fields[1], np.float64) - fields[0]
    return 0.5 * float(np.hypot(between[0], between[1]).max(initial=0.0))
