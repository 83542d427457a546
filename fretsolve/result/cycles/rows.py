"""Measure the loop of one cycle: what a row of the table of cycles holds."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.cycle_quantities import ACTUATOR, OF_MOTION
from fretsolve.case.history import ACTUATORS, COMPONENTS, MOTIONS_OF_ACTUATORS
from fretsolve.result.cycles.loops import (
    CycleSteps,
    History,
    Measure,
    area,
    change_within,
    ends_of_loop,
    half_width,
    range_error,
    reversal_stiffness,
)
from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.system.arrays import DoubleArray

FORCES = frozenset(name for names in COMPONENTS[3:5] for name in names)
"""Tangential forces and displacements."""

ROUND_OFF = 1e-12
"""Part of the displacement range below which the width of a loop is 0."""

HIDDEN = "hidden between increments"
"""Error of the sliding ratio by the increments, of which no column is made."""

LEAST_FORCE = 1e-8
"""Tangential force over P below which it is round-off."""


def round_off(history: History) -> float:
    """Return the size below which a tangential force counts as 0."""
    return LEAST_FORCE * float(np.abs(history["P"]).max())


def measured_columns(
    history: History,
    cycles: Sequence[CycleSteps],
    slip: Callable[[int], NDArray[Any] | None],
    pair: tuple[str, str] | None,
) -> dict[str, DoubleArray]:
    """Return the columns of the table, with a rig also those at the actuator.

    pair: load and displacement of the loops, None for the direction of shear; slip: returns the slip after an
    increment.
    """
    least = round_off(history)
    found = _columns(_measured(history, cycle, slip, pair, least) for cycle in cycles)
    if not history.keys() >= MOTIONS_OF_ACTUATORS.keys():
        return found
    columns = [(name, name.removesuffix(ERROR_SUFFIX)) for name in history]
    moved = {
        MOTIONS_OF_ACTUATORS[own] + name.removeprefix(own): history[name]
        for name, own in columns
        if own in MOTIONS_OF_ACTUATORS
    }
    at_actuator = {**history, **moved}
    there = _columns(_measured(at_actuator, cycle, lambda step: None, pair, least) for cycle in cycles)
    of_motion = {name: values for name, values in there.items() if name.removesuffix(ERROR_SUFFIX) in OF_MOTION}
    return found | {ACTUATOR + name: values for name, values in of_motion.items()}


def _columns(rows: Iterable[Mapping[str, float]]) -> dict[str, DoubleArray]:
    """Return rows of the same names as columns. Of long histories the rows would take ten times as much memory."""
    found: dict[str, array[float]] = {}
    for row in rows:
        for name, value in row.items():
            found.setdefault(name, array("d")).append(value)
    return {name: np.array(values) for name, values in found.items()}


def _measured(
    history: History,
    cycle: CycleSteps,
    slip: Callable[[int], NDArray[Any] | None],
    pair: tuple[str, str] | None,
    least: float,
) -> dict[str, float]:
    """Return what a row of the table holds of the contact. least: tangential force up to which it counts as 0."""
    force, motion = _loop(history, cycle, pair, least)
    begin, end = ends_of_loop(motion if np.isfinite(motion).all() else force)
    force_range, motion_range = float(np.ptp(force)), float(np.ptp(motion))
    energy, box = change_within(history["work_total"], cycle), force_range * motion_range
    # Where one load alone moves, friction dissipates what its loop encloses, and does so more exactly than a polygon.
    alone = len(cycle.moved) == 1 and cycle.moved <= (FORCES if pair is None else {*pair, ACTUATORS[pair[1]]})
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
        names = [name for name in names if not math.isnan(history[name][cycle.last])] or names  # delta_y of a line is
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


def _loop(
    history: History, cycle: CycleSteps, pair: tuple[str, str] | None, least: float
) -> tuple[DoubleArray, DoubleArray]:
    """Return force and displacement along the direction of the loop, or the columns of a `pair`, from its begin on."""
    if pair is not None:
        return _rows(history, pair[0], cycle), _rows(history, pair[1], cycle)
    forces, motions = (
        np.array([_rows(history, name, cycle) for name in names]) for names in (("Qx", "Qy"), ("delta_x", "delta_y"))
    )
    forces[np.abs(forces) <= least] = 0.0
    motions[np.isnan(motions).all(axis=1) & ~forces.any(axis=1)] = (
        0.0  # along y in a line contact, as nothing acts there
    )
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
