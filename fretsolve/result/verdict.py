"""Judge by the error bars of a run whether it meets the accuracy of its case.

All errors are at the ends of stages, relative to the scale of their quantity (`scales`). A value corrected for the
number of increments replaces the value as run. The module loads no pydantic, so that results open fast.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretsolve.case.cycle_quantities import CYCLES_WITH_BARS
from fretsolve.case.dimensions import percent
from fretsolve.case.history import ACTUATORS, EXTENTS, SCALED, USUAL
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX, stage_ends
from fretsolve.system.arrays import DoubleArray, IndexArray

LEAST_MOTION_SCALE = 1e-3
"""Least scale of tangential displacements over the approach, of phi_z over approach by radius, and of the dissipated
energy over P times the approach."""

ROUNDING = 1e-9
"""Largest size of a load or displacement that is 0 but for rounding, over the scale that it is measured against."""

UNSEEN_ENERGY = 1e-11
"""Error bar over P times the contact radius from which on a dissipated energy of 0 is one that no cell shows."""

SCALES = {
    **dict.fromkeys(("Qx", "Qy"), "the largest tangential force"),
    **dict.fromkeys(("Mx", "My", "Mz"), "the largest P times the contact radius"),
    **dict.fromkeys(("delta_x", "delta_y"), "the largest tangential displacement"),
    **dict.fromkeys(("phi_x", "phi_y"), "the largest delta_z over the contact radius"),
    **dict.fromkeys(("actuator_x", "actuator_y"), "the largest tangential displacement of the actuator"),
    **dict.fromkeys(("actuator_phi_x", "actuator_phi_y"), "the largest delta_z over the contact radius"),
    **dict.fromkeys(("stick_radius", *EXTENTS), "the largest contact radius"),
    "work_total": "its largest value, or of a thousandth of P times delta_z if that is more",
}
"""The scales of errors in words; any other quantity has its largest value at the ends of stages as its scale."""

POINTS_ORDER, MOST_REFINED = 1.4, 4.0
"""Order by which error bars fall with the points per side, and the most times as many points or increments that are
advised. Of more it is only said that they are needed."""

LEFT_OVER = 0.5
"""The part of the error by the increments that corrected values keep. Errors of first order would leave next to
nothing."""

POINTS_DIVISOR = 6
"""Picked or advised points are a multiple of this number, so that the coarse runs have a half and a third of them."""


@dataclass(frozen=True)
class Verdict:
    """The judgement of a run's error bars by its accuracy.

    worst: the largest bar over its scale, NaN where one is unknown; quantity: of what it is, empty where nothing has a
    bar; stage, cycle: at the end of which stage, or in which cycle, it is; corrected: whether the bar belongs to a
    corrected value; unbounded: quantities left out, since no bar holds them; unseen: whether the dissipated energy is
    left out, as it is 0 and may not be; small: quantities that are next to nothing, and count over a least scale;
    advice: key and value of settings with which the accuracy may be met; far: of
    what it would take more than MOST_REFINED times as many; reason: why no finer run was made.
    """

    accuracy: float
    worst: float
    quantity: str
    stage: int | None = None
    cycle: int | None = None
    corrected: bool = False
    unbounded: tuple[str, ...] = ()
    unseen: bool = False
    small: tuple[str, ...] = ()
    advice: str = ""
    far: str = ""
    reason: str = ""

    @property
    def met(self) -> bool:
        """True if all bars are known and within the accuracy."""
        return self.worst <= self.accuracy and not self.unbounded

    def __str__(self) -> str:
        asked = f"accuracy {percent(self.accuracy)}"
        place = f"at the end of stage {self.stage}" if self.cycle is None else f"in cycle {self.cycle}"
        reason = f"; {self.reason}" if self.reason else ""
        if not self.quantity and not self.unbounded:
            return f"{asked} is not proved: all that it is about is 0"
        if not self.quantity or (self.unbounded and self.worst <= self.accuracy):
            return f"{asked} is not proved: {', '.join(self.unbounded)} is unbounded"
        if math.isnan(self.worst):
            return f"{asked} is not proved: there is no error bar of {self.quantity} {place}{reason}"
        of = f"{'the corrected ' * self.corrected}{self.quantity} {place}"
        scale = SCALES.get(self.quantity, "its largest value")
        left_out = "; no cell slips, so that work_total is not known and does not count" if self.unseen else ""
        if self.small:
            left_out += f"; {', '.join(self.small)} is next to nothing, and counts over a thousandth of what presses"
        if self.met:
            return f"{asked} is met: {percent(self.worst)} at most, of {of}{left_out}"
        advised = f"; --set {shlex.quote(self.advice)} may do" if self.advice else ""
        if self.far:
            advised = f"; more than {MOST_REFINED:g} times the {self.far} would be needed"
        return f"{asked} is not met: {of} is known to {percent(self.worst)} of {scale}{reason or advised}{left_out}"


@dataclass(frozen=True, eq=False)
class Judged:
    """The error bars of a quantity where it is judged: at the ends of stages, or of cycles.

    bars, by_increments: error bars and their parts by the increments, over the scale (n,); the rest is by the cells.
    numbers: of the stages or cycles; steps: the last increments, none of cycles; small: whether the scale is a least
    one, since the quantity is next to nothing.
    """

    quantity: str
    column: str
    scale: float
    bars: DoubleArray
    by_increments: DoubleArray
    numbers: IndexArray
    steps: IndexArray | None = None
    small: bool = False


Cycles = Callable[[], Mapping[str, Any] | None]
"""Returns the columns of the table of cycles, None without any."""


def judged(of: Sequence[str], history: Mapping[str, DoubleArray], cycles: Cycles) -> list[Judged]:
    """Return the error bars that an accuracy is about, some perhaps infinite or NaN.

    of: quantities, none for the usual ones. Loads and displacements that are 0 but for rounding have no place in it;
    what is next to nothing counts over a least scale, unless it is named.
    """
    ends = stage_ends(history["stage"])
    own = scales(history, ends, 0.0)
    known = own if of else scales(history, ends)
    found = []
    for name in of or USUAL:
        if known.get(name, 0.0) > 0.0 and not _is_nothing(name, history, ends):
            bars, by_increments = (part[ends] / known[name] for part in _parts(name, history))
            numbers, small = history["stage"][ends].astype(int), known[name] > own[name]
            column = best_column(name, history)
            found.append(Judged(name, column, known[name], bars, by_increments, numbers, ends, small))
    of_cycles = [name for name in of if name in CYCLES_WITH_BARS]
    table = (cycles() if of_cycles else None) or {}
    for name in of_cycles:
        column = best_column(name, table)
        known_cycles = np.flatnonzero(np.isfinite(table.get(column, np.empty(0))))
        if not known_cycles.size:  # it has no value in any cycle
            found.append(Judged(name, name, 1.0, np.array([math.nan]), np.zeros(1), np.array([1])))
        elif (scale := float(np.abs(table[column][known_cycles]).max())) > 0.0:
            bars, by_increments = (part[known_cycles] / scale for part in _parts(name, table))
            found.append(Judged(name, column, scale, bars, by_increments, table["cycle"][known_cycles]))
    return found


def _parts(name: str, columns: Mapping[str, Any]) -> tuple[DoubleArray, DoubleArray]:
    """Return the error bars of the best values of a quantity, and their parts by the increments.

    The squares of both bars differ by what the correction takes off the square of the part by the increments.
    """
    as_run, best = (columns[column + ERROR_SUFFIX] for column in (name, best_column(name, columns)))
    taken = np.subtract(as_run**2, best**2, out=np.zeros(len(best)), where=np.isfinite(best) & (as_run > best))
    return best, LEFT_OVER * np.sqrt(taken / (1.0 - LEFT_OVER**2))


def verdict_of(effective_case: Mapping[str, Any], history: Mapping[str, DoubleArray], cycles: Cycles) -> Verdict | None:
    """Judge a run by the accuracy of the case in its result; None without an accuracy or error bars."""
    accuracy = effective_case.get("solver", {}).get("accuracy")
    if accuracy is None or "P" + ERROR_SUFFIX not in history or not len(history["stage"]):
        return None
    points = effective_case.get("grid", {}).get("points") or ()
    bars = judged(accuracy.get("of", ()), history, cycles)
    return verdict(accuracy["target"], bars, history, [points] if isinstance(points, int) else points)


def verdict(
    accuracy: float, bars: Sequence[Judged], history: Mapping[str, DoubleArray], points: Sequence[int] = ()
) -> Verdict:
    """Judge a run by its error bars and its history.

    points: of the grid along x and y, in line contact along x alone, which advice on them needs.
    """
    unbounded = tuple(one.quantity for one in bars if np.isinf(one.bars).any())
    bounded = [one for one in bars if one.quantity not in unbounded]
    if not bounded:
        return Verdict(accuracy, math.nan, "", unbounded=unbounded)
    peaks = [float(one.bars.max()) for one in bounded]
    worst = bounded[int(np.argmax(peaks))]  # the one with a NaN, if there is one
    index = int(np.argmax(worst.bars))
    number = int(worst.numbers[index])
    found = Verdict(
        accuracy,
        float(worst.bars[index]),
        worst.quantity,
        None if worst.steps is None else number,
        number if worst.steps is None else None,
        worst.column != worst.quantity,
        unbounded,
        "work_total" + ERROR_SUFFIX in history and hides_energy(history),
        tuple(one.quantity for one in bounded if one.small),
    )
    return found if found.worst <= accuracy else _with_advice(found, worst, index, history, points)


def hides_energy(history: Mapping[str, DoubleArray]) -> bool:
    """Return whether nothing is dissipated up to the ends of stages, although by the error bar something may be."""
    ends = stage_ends(history["stage"])
    found, bars = history["work_total"][ends], history["work_total" + ERROR_SUFFIX][ends]
    force, radius = (float(history[name][ends].max()) for name in ("P", "contact_radius"))
    return not found.any() and bool((bars > UNSEEN_ENERGY * force * radius).any())


def why_no_bars(history: Mapping[str, DoubleArray]) -> str:
    """Return in one line from where on a run has no error bars though it was to have some, empty if it has all."""
    unknown = np.flatnonzero(np.isnan(history.get("P" + ERROR_SUFFIX, np.empty(0))))
    if not unknown.size:
        return ""
    step = int(unknown[0])
    return (
        f"no error bars from increment {step} (stage {int(history['stage'][step])}) on: a coarse run has no solution"
        " there; lower loads near gross slip, more grid.points or a larger grid.size may do"
    )


def _with_advice(
    missed: Verdict, worst: Judged, index: int, history: Mapping[str, DoubleArray], points: Sequence[int]
) -> Verdict:
    """Return the verdict with the key and value of more points or increments, by where the worst bar is from.

    Where more than MOST_REFINED times as many are needed, it says whether of points or increments.
    """
    if math.isnan(missed.worst):
        return missed
    factor = missed.worst / missed.accuracy
    if worst.by_increments[index] ** 2 > 0.5 * missed.worst**2:
        stage = int(worst.numbers[index])
        if factor > MOST_REFINED:  # error bars fall with the first power of the increments
            return replace(missed, far=f"increments of stage {stage}")
        count = int(np.count_nonzero(history["stage"] == stage))
        return replace(missed, advice=f"stage.{stage}.increments={max(math.ceil(count * factor), count + 1)}")
    finer = factor ** (1.0 / POINTS_ORDER)
    if finer > MOST_REFINED:
        return replace(missed, far="points")
    sides = [str(POINTS_DIVISOR * math.ceil(finer * side / POINTS_DIVISOR)) for side in points]
    if len(sides) == 1:
        return replace(missed, advice=f"grid.points={sides[0]}")
    return replace(missed, advice=f"grid.points=[{','.join(sides)}]" if sides else "")


def _is_nothing(name: str, history: Mapping[str, DoubleArray], ends: IndexArray) -> bool:
    """Return whether a load or displacement is 0 but for rounding at all `ends` of stages, as by symmetry."""
    size = pressing_scales(history, ends).get(name)
    return size is not None and float(np.abs(history[name][ends]).max()) <= ROUNDING * size


def pressing_scales(history: Mapping[str, DoubleArray], rows: IndexArray | slice = slice(None)) -> dict[str, float]:
    """Return what presses in some rows: the scales against which other loads and displacements may be next to nothing.

    What is not known, as the approach of a line contact, counts as 0.
    """
    pressing = ("P", "delta_z", "contact_radius")
    force, approach, radius = (float(np.nan_to_num(np.abs(history[one][rows])).max()) for one in pressing)
    turn = approach / radius if radius else 0.0
    found = {
        **dict.fromkeys(("Qx", "Qy"), force),
        **dict.fromkeys(("Mx", "My", "Mz"), force * radius),
        **dict.fromkeys(("delta_x", "delta_y"), approach),
        **dict.fromkeys(("phi_x", "phi_y", "phi_z"), turn),
    }
    if "actuator_x" in history:  # of a soft rig a tangential force next to nothing moves the actuator far
        far = (float(np.nan_to_num(np.abs(history[one][rows])).max()) for one in ("actuator_x", "actuator_y"))
        found |= dict.fromkeys(("actuator_x", "actuator_y"), max(approach, *far))
        found |= dict.fromkeys((ACTUATORS[name] for name in ("phi_x", "phi_y", "phi_z")), turn)
    return found


def best_column(name: str, history: Mapping[str, DoubleArray]) -> str:
    """Return the column with the best values of a quantity: the corrected ones if `history` has them."""
    return name + CORRECTED_SUFFIX if name + CORRECTED_SUFFIX in history else name


def scales(history: Mapping[str, DoubleArray], ends: IndexArray, least: float = LEAST_MOTION_SCALE) -> dict[str, float]:
    """Return the scale of each quantity's error, as `SCALES` names it.

    ends: the last increments of stages; least: part of what presses that what moves and dissipates counts as, at least.
    """
    sizes = {name for name in SCALED if name in history and name not in EXTENTS}
    largest = {name: float(np.abs(history[name][ends]).max()) for name in sizes}
    # In a line contact displacements may not be known, which leaves their scales 0.
    unknown = [name for name, value in largest.items() if math.isnan(value)]
    largest |= dict.fromkeys(unknown, 0.0)
    approach, radius, force = largest["delta_z"], largest["contact_radius"], largest["P"]
    turn = approach / radius if radius else 0.0
    tangential_force = max(largest["Qx"], largest["Qy"], least * force)
    tangential_motion = max(largest["delta_x"], largest["delta_y"], least * approach)
    of_rig: dict[str, float] = {}
    if "actuator_x" in history:
        far = max(largest["actuator_x"], largest["actuator_y"], tangential_motion)
        of_rig = dict.fromkeys(("actuator_x", "actuator_y"), far)
        of_rig |= dict.fromkeys(("actuator_phi_x", "actuator_phi_y"), turn)
        of_rig["actuator_phi_z"] = max(largest["actuator_phi_z"], least * turn)
    return {
        **largest,
        **of_rig,
        **dict.fromkeys(("Qx", "Qy"), tangential_force),
        **dict.fromkeys(("Mx", "My", "Mz"), force * radius),
        **dict.fromkeys(("delta_x", "delta_y"), tangential_motion),
        **dict.fromkeys(("phi_x", "phi_y"), turn),
        "phi_z": max(largest["phi_z"], least * turn),
        **dict.fromkeys((name for name in ("stick_radius", *EXTENTS) if name in history), radius),
        "work_total": max(largest["work_total"], least * force * approach) if largest["work_total"] else 0.0,
        **dict.fromkeys(unknown, 0.0),
    }
