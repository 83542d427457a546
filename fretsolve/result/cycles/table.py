"""The table of the cycles of a result: the loop of each, what it dissipates, and whether it is periodic.

The loop of a cycle is the force over the displacement along the direction in which the contact is moved, or the torque
over the rotation where no force is. Where nothing tangential acts, the moment or normal force that moves gives the
loop. With a rig in series the loop is also measured over the motion of the actuator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.cycle_quantities import ACTUATOR, CYCLE_QUANTITIES, CYCLES_WITH_BARS, OF_MOTION
from fretsolve.case.dimensions import percent
from fretsolve.case.history import BULK, COMPONENTS, PAIRS
from fretsolve.result.cycles.loops import CycleSteps, History, cycles_in, distance_to_limit, stages_of
from fretsolve.result.cycles.rows import FORCES, HIDDEN, measured_columns, round_off
from fretsolve.result.layout import Quantity
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX
from fretsolve.system.arrays import DoubleArray

CYCLES = (
    Quantity("cycle", "1", "cycle, counted from 1 along the load path", "int64"),
    Quantity("first_step", "1", "increment after which it begins, -1 for the start of the path", "int64"),
    Quantity("last_step", "1", "increment with which it ends", "int64"),
    Quantity("stage", "1", "stage with which it ends", "int64"),
    *(Quantity(name, dimension.stored, meaning) for name, (dimension, meaning) in CYCLE_QUANTITIES.items()),
)
"""Columns of the table of cycles."""

AT_ACTUATOR = tuple(
    replace(one, name=ACTUATOR + one.name, long_name=f"{one.long_name}, at the actuator")
    for one in CYCLES
    if one.name in OF_MOTION
)
"""Columns of the motion of the actuator; only in tables of results with a rig."""

OF_MOMENTS = {"N": "N mm", "mm": "rad", "N/mm": "N mm/rad"}
OF_A_LINE = {"N": "N/mm", "mJ": "mJ/mm", "N/mm": "N/mm/mm"}
"""Other units of columns: of moment and rotation, and per mm of a line contact."""

NOTEWORTHY = 0.05
"""Error of the sliding ratio by the increments from which on it is worth a note."""

_MEASURED = tuple(one.name for one in (*CYCLES, *AT_ACTUATOR) if one.dtype == "float64")

CORRECTED_CYCLE_NAMES = tuple(
    name + CORRECTED_SUFFIX for name in CYCLES_WITH_BARS if not name.endswith("reversal_stiffness")
)
"""Columns of values corrected for the number of increments, where the history has such. The stiffness is extrapolated
from the increments itself."""

CYCLE_NAMES = (*_MEASURED, *CORRECTED_CYCLE_NAMES)
"""Columns that say how a cycle went."""


@dataclass(frozen=True, eq=False)
class CycleTable:
    """The cycles of a result.

    columns: by the names of `CYCLES`, `AT_ACTUATOR`, and of error bars, each ``(cycles,)``, NaN where a value does not
    exist; units, meanings: of each; outcomes: a sentence on each cycle that was to run until it is periodic, and
    whether it is; notes: what the increments of the loops do not tell.
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
    columns = measured_columns(history, cycles, slip, pair)
    if "work_total" + CORRECTED_SUFFIX in history:
        corrected = _with_corrected_values(history)
        found = measured_columns(corrected, cycles, lambda step: None, pair)
        for name in CORRECTED_CYCLE_NAMES:
            as_run = name.removesuffix(CORRECTED_SUFFIX)
            if as_run not in found:  # there is no actuator
                continue
            columns |= {name: found[as_run], name + ERROR_SUFFIX: found[as_run + ERROR_SUFFIX]}
    moments = pair is not None and pair[0].startswith("M")
    chosen = [
        one for one in _quantities(moments=moments, line=effective_case.get("plane") == "strain") if one.name in columns
    ]
    return CycleTable(
        {one.name: columns[one.name].astype(one.dtype) for one in chosen},
        {one.name: one.units for one in chosen},
        {one.name: one.long_name for one in chosen},
        tuple(_outcomes(history, cycles)),
        tuple(_notes(columns)),
    )


def _quantities(*, moments: bool, line: bool) -> list[Quantity]:
    """Return all columns that a table may have: with those at the actuator, corrected values, and error bars."""
    known = {one.name: replace(one, units=_units(one, moments=moments, line=line)) for one in (*CYCLES, *AT_ACTUATOR)}
    for name in CORRECTED_CYCLE_NAMES:
        as_run = known[name.removesuffix(CORRECTED_SUFFIX)]
        known[name] = replace(
            as_run, name=name, long_name=f"{as_run.long_name}, corrected for the number of increments"
        )
    for one in [known[name] for name in (*CYCLES_WITH_BARS, *CORRECTED_CYCLE_NAMES)]:
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
    runs: dict[int, list[CycleSteps]] = {}
    for one in cycles:
        if one.until is not None:
            runs.setdefault(one.run, []).append(one)
    for last in (run[-3:] for run in runs.values()):
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


def _notes(columns: Mapping[str, DoubleArray]) -> Iterator[str]:
    """Yield what the increments of loops do not tell, or not well."""
    if (widest := float(np.nanmax([0.0, *columns[HIDDEN]]))) > NOTEWORTHY:
        yield (
            f"sliding_ratio is known to ± {widest:.2g} by these increments, and sliding_amplitude to half of that times"
            " the displacement range; more of them tell both closer"
        )
    if (np.isnan(columns["reversal_stiffness"]) & (columns["force_range"] * columns["displacement_range"] > 0.0)).any():
        yield (
            "reversal_stiffness is not known: it takes two increments after each reversal, the first of which strains"
            " the bodies more than it slips; take more increments"
        )


def _pair(history: History, cycles: Sequence[CycleSteps]) -> tuple[str, str] | None:
    """Return the load and displacement whose loops all cycles have; None for loops along the direction of shear."""
    moved = frozenset[str]().union(*(one.moved for one in cycles))
    if moved & FORCES.union(*BULK.values()):
        return None
    if moved & set(COMPONENTS[5]):
        return PAIRS[5] if np.any(history["Mz"]) else None
    if any((np.abs(history[name]) > round_off(history)).any() for name in ("Qx", "Qy")):
        return None  # a constant force, whose displacement drifts
    return next(
        ((force, motion) for force, motion, actuator in reversed(COMPONENTS[:3]) if moved & {force, motion, actuator}),
        None,
    )
