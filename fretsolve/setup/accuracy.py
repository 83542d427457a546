"""What an accuracy that is asked for comes to: the settings that it picks, and whether the error bars of a run meet it.

The settings come from laws that were measured, not from the case's own errors; those are told by its error bars. All
errors here are in parts of a scale of their kind (`SCALES`), at the ends of stages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.system.arrays import DoubleArray, IndexArray

if TYPE_CHECKING:
    from fretsolve.case import Case, SolverSpec
    from fretsolve.model.load_path import LoadPath

CELLS, CELLS_ERROR, CELLS_ORDER = 30.0, 0.025, 1.4
"""Error bars of the cells, where the contact is this many cells across: at most about this, of the stick radius, and
how they fall with the number of cells. docs/error_bars.md has them."""

SHEARED_SLIP, PRESSED_SLIP = (0.9, 2.4), (1.5, 1.57)
"""Error bar of the work where the slip annulus is a cell wide, and the order with which it falls with its cells:
between bodies alike under shear, and between bodies that differ and are pressed together."""

MOST_FOR_SLIP = 4.0
"""Times as many cells, or increments, as else are taken at most for a narrow annulus: its work is next to nothing."""

FEWEST_POINTS = 32

ROUND_POINTS = 4
"""Points per side are a multiple of it, so that the companion runs have just half of them."""

INCREMENTS_ERROR, INCREMENTS_ORDER = 0.06, 1.35
"""Error bars of the increments that `increments: auto` takes by itself: about this of the work, and how they fall with
their number. Those of displacements begin at a third of it and fall with an order of 1."""

FEWEST_REFINED = 0.5

WIDE_SLIP, NARROW_ORDER = 0.5, 0.4
"""Width of the slip annulus, over the contact radius, between bodies that differ and are pressed together, below which
it takes more increments, and how their number rises with its inverse."""

TOLERANCE = 1e-4
"""Of the iteration, in parts of the accuracy: no part of the error is its, and the slip of small last steps is seen."""

TIGHTEST, LOOSEST = 1e-8, 1e-5

LEAST_MOTION = 1e-3
"""Displacements and turns count in parts of no less than this much of the approach, or of approach over radius."""


def points_for(
    accuracy: float,
    size: tuple[float, float],
    extent: tuple[float, float],
    sheared_width: float = 0.0,
    pressed_width: float = 0.0,
) -> tuple[int, int]:
    """Points along x and y on an area of `size` (mm) for a contact of `extent` (mm).

    sheared_width, pressed_width: of the annulus that slips under shear and under pressure alone, over the contact
    radius; 0 where there is none, or where it is not known.
    """
    usual = cells = CELLS * (CELLS_ERROR / accuracy) ** (1.0 / CELLS_ORDER)
    for width, (error, order) in ((sheared_width, SHEARED_SLIP), (pressed_width, PRESSED_SLIP)):
        if width > 0.0:
            across_slip = (error / accuracy) ** (1.0 / order)
            cells = max(cells, min(2.0 * across_slip / width, MOST_FOR_SLIP * usual))
    wanted = (max(FEWEST_POINTS, cells * side / reach) for side, reach in zip(size, extent, strict=True))
    nx, ny = (ROUND_POINTS * math.ceil(count / ROUND_POINTS - 1e-9) for count in wanted)
    return nx, ny


def refinement(accuracy: float | None, pressed_width: float = 0.0) -> float:
    """Factor on the number of automatic increments where the slip depends on the path; 1 where nothing is asked for.

    pressed_width: as in `points_for`.
    """
    if accuracy is None:
        return 1.0
    factor = max(FEWEST_REFINED, math.pow(INCREMENTS_ERROR / accuracy, 1.0 / INCREMENTS_ORDER))
    if pressed_width > 0.0:
        factor *= min(max(1.0, math.pow(WIDE_SLIP / pressed_width, NARROW_ORDER)), MOST_FOR_SLIP)
    return factor


def settled(case: Case) -> Case:
    """The case with the solver's settings that its accuracy picks; explicit ones stay."""
    accuracy, given = case.solver.accuracy, case.solver.model_fields_set
    if accuracy is None:
        return case
    picked: dict[str, object] = {}
    if "tolerance" not in given:
        picked["tolerance"] = tolerance_for(accuracy)
    if "error_bars" not in given:
        picked["error_bars"] = True
    return case.model_copy(update={"solver": case.solver.model_copy(update=picked)})


def tolerance_for(accuracy: float) -> float:
    """Of the solver, in one digit."""
    return float(f"{min(max(TOLERANCE * accuracy, TIGHTEST), LOOSEST):.0e}")


def picks(case: Case, points: tuple[int, int], load_path: LoadPath) -> tuple[str, ...]:
    """What the accuracy of `case`, as it was read, has picked, in words."""
    if case.solver.accuracy is None:
        return ()
    given = case.solver.model_fields_set
    found = []
    if case.grid.points is None:
        found.append(f"{points[0]} x {points[1]} points")
    counts = {
        count for stage, count in zip(case.stages(), load_path.counts, strict=True) if stage.increments is None
    }
    if counts and load_path.path_dependent:
        least, most = min(counts), max(counts)
        found.append(f"{most if most == least else f'{least} to {most}'} increments per stage")
    if "tolerance" not in given:
        found.append(f"tolerance {tolerance_for(case.solver.accuracy):g}")
    if "error_bars" not in given:
        found.append("error bars")
    return tuple(found)


@dataclass(frozen=True)
class Verdict:
    """Whether a run has met its accuracy, by its error bars.

    worst: the largest bar in parts of its scale, NaN where one is not known; quantity, stage: whose it is.
    """

    accuracy: float
    worst: float
    quantity: str
    stage: int

    @property
    def met(self) -> bool:
        """Whether all bars are known and within the accuracy."""
        return self.worst <= self.accuracy

    def __str__(self) -> str:
        asked = f"accuracy {percent(self.accuracy)}"
        if math.isnan(self.worst):
            return f"{asked} is not proved: there are no error bars from stage {self.stage} on"
        of = f"{self.quantity} at the end of stage {self.stage}"
        if self.met:
            return f"{asked} is met: {percent(self.worst)} at most, of {of}"
        return f"{asked} is not met: {of} is known to {percent(self.worst)} of {SCALES.get(self.quantity, LARGEST)}"


def percent(part: float) -> str:
    """In two digits."""
    return f"{100.0 * part:.2g} %"


def verdict(solver: SolverSpec | Mapping[str, object], history: Mapping[str, DoubleArray]) -> Verdict | None:
    """Of a run by its history; None where no accuracy is asked for or there are no error bars."""
    accuracy = solver.get("accuracy") if isinstance(solver, Mapping) else solver.accuracy
    if not isinstance(accuracy, float) or "P" + ERROR_SUFFIX not in history or not len(history["stage"]):
        return None
    ends = np.flatnonzero(np.append(np.diff(history["stage"]) != 0, True))
    worst, quantity, where = 0.0, "P", int(ends[-1])
    for name, scale in scales(history, ends).items():
        if scale > 0.0:
            bars = history[name + ERROR_SUFFIX][ends] / scale
            place = int(np.argmax(bars))  # of NaN, if there is one
            if math.isnan(bars[place]) or bars[place] > worst:
                worst, quantity, where = float(bars[place]), name, int(ends[place])
            if math.isnan(worst):
                break
    return Verdict(accuracy, worst, quantity, int(history["stage"][where]))


def scales(history: Mapping[str, DoubleArray], ends: IndexArray) -> dict[str, float]:
    """What an error of each quantity is a part of: the largest value of its kind at the ends of the stages."""
    largest = {name: float(np.abs(history[name][ends]).max()) for name in QUANTITIES}
    approach, radius, force = largest["delta_z"], largest["contact_radius"], largest["P"]
    turn = approach / radius if radius else 0.0
    found = dict(largest)
    found |= dict.fromkeys(("Qx", "Qy"), max(largest["Qx"], largest["Qy"], LEAST_MOTION * force))
    found |= dict.fromkeys(("Mx", "My", "Mz"), force * radius)
    found |= dict.fromkeys(
        ("delta_x", "delta_y"), max(largest["delta_x"], largest["delta_y"], LEAST_MOTION * approach)
    )
    found |= dict.fromkeys(("phi_x", "phi_y"), turn)
    found |= {"phi_z": max(largest["phi_z"], LEAST_MOTION * turn)}
    return found | dict.fromkeys(("contact_radius", "stick_radius"), radius)


LARGEST = "its largest value"
SCALES = {
    **dict.fromkeys(("Qx", "Qy"), "the largest tangential force"),
    **dict.fromkeys(("Mx", "My", "Mz"), "the largest P times the contact radius"),
    **dict.fromkeys(("delta_x", "delta_y"), "the largest tangential displacement"),
    **dict.fromkeys(("phi_x", "phi_y"), "the largest delta_z over the contact radius"),
    "stick_radius": "the largest contact radius",
}
"""What errors are parts of, in words; where nothing is said, of the quantity's largest value at the ends of stages."""

QUANTITIES = (
    *("P", "Qx", "Qy", "Mx", "My", "Mz", "delta_z", "delta_x", "delta_y", "phi_x", "phi_y", "phi_z"),
    *("contact_radius", "stick_radius", "max_pressure", "work_total"),
)
