"""Pick the settings that an accuracy asks for, and judge by the error bars of a run whether it is met.

The settings follow from measured laws (docs/accuracy.md); the error bars give the case's own errors. All errors are at
the ends of stages, relative to the scale of their quantity (`scales`).
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.case.models import Case
from fretsolve.case.quantities import percent
from fretsolve.errors import CaseError
from fretsolve.model.load_path import LoadPath
from fretsolve.model.required_terms import Model
from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.setup.closed_forms import ClosedForms, spence_ratio
from fretsolve.setup.contact_size import MARGIN, Size, automatic_size
from fretsolve.system.arrays import DoubleArray, IndexArray

CELLS, CELLS_ERROR, CELLS_ORDER = 30.0, 0.025, 1.4
"""Cells across the contact, the error bar of the stick radius with them (the largest one of the cells), and the order
with which it falls with their number (docs/error_bars.md)."""

SHEARED_SLIP, PRESSED_SLIP = (0.9, 2.4), (1.5, 1.57)
"""Error bar of the dissipated energy where the slip annulus is a cell wide, and the order with which it falls with the
cells of the annulus: for similar bodies under shear, and for dissimilar bodies pressed together."""

MOST_FOR_SLIP = 4.0
"""Largest factor on cells or increments for a narrow annulus, which dissipates next to nothing."""

FEWEST_POINTS, ROUND_POINTS = 32, 4
"""Least number of points per side, and its divisor, so that the coarse runs have half of them."""

INCREMENTS_ERROR, INCREMENTS_ORDER, FEWEST_REFINED = 0.06, 1.35, 0.5
"""Error bar of the dissipated energy with automatic increments without an accuracy (displacements: a third of it), the
order with which it falls with their number (displacements: 1), and the least factor on that number."""

WIDE_SLIP, NARROW_ORDER = 0.5, 0.4
"""Width of the slip annulus, over the contact radius, of dissimilar bodies pressed together, below which more
increments are taken, and the order with which their number rises with the inverse of the width."""

LEAST_MOTION = 1e-3
"""Least scale of tangential displacements over the approach, and of phi_z over approach by radius."""

SCALES = {
    **dict.fromkeys(("Qx", "Qy"), "the largest tangential force"),
    **dict.fromkeys(("Mx", "My", "Mz"), "the largest P times the contact radius"),
    **dict.fromkeys(("delta_x", "delta_y"), "the largest tangential displacement"),
    **dict.fromkeys(("phi_x", "phi_y"), "the largest delta_z over the contact radius"),
    "stick_radius": "the largest contact radius",
}
"""The scales of errors in words; that of any other quantity is its largest value, at the ends of stages."""

QUANTITIES = (*itertools.chain(*PAIRS), "contact_radius", "stick_radius", "max_pressure", "work_total")
"""The columns of the history that an accuracy is about."""


def points_needed(forms: ClosedForms, load_path: LoadPath, size: Size) -> tuple[int, int]:
    """Return the points along x and y that the case's accuracy needs on an area of `size` (mm).

    They follow from the contact's share of the area, which is all of it where the contact's size is unknown.
    """
    accuracy, holds_contact = forms.case.solver.accuracy, size
    assert accuracy is not None
    if forms.case.grid.size is not None:
        with contextlib.suppress(CaseError):
            holds_contact = automatic_size(forms, load_path.normal_loads())
    usual = cells = CELLS * (CELLS_ERROR / accuracy) ** (1.0 / CELLS_ORDER)
    sheared_width = 0.0 if forms.model.coupled else load_path.slip_width
    for width, (error, order) in ((sheared_width, SHEARED_SLIP), (_pressed_width(forms.model), PRESSED_SLIP)):
        if width > 0.0:
            across_slip = (error / accuracy) ** (1.0 / order)
            cells = max(cells, min(2.0 * across_slip / width, MOST_FOR_SLIP * usual))
    extents = (side / MARGIN for side in holds_contact)
    wanted = (max(FEWEST_POINTS, cells * side / extent) for side, extent in zip(size, extents, strict=True))
    nx, ny = (ROUND_POINTS * math.ceil(count / ROUND_POINTS - 1e-9) for count in wanted)
    return nx, ny


def refinement(accuracy: float | None, model: Model) -> float:
    """Return the factor on automatic numbers of increments where the slip depends on the path; 1 without accuracy."""
    if accuracy is None:
        return 1.0
    factor = max(FEWEST_REFINED, math.pow(INCREMENTS_ERROR / accuracy, 1.0 / INCREMENTS_ORDER))
    width = _pressed_width(model)
    return factor * min(max(1.0, math.pow(WIDE_SLIP / width, NARROW_ORDER)), MOST_FOR_SLIP) if width > 0.0 else factor


def _pressed_width(model: Model) -> float:
    """Return the width of the slip annulus under P alone over the contact radius, 0 if tangential loads dissipate."""
    return 0.0 if model.moved else 1.0 - spence_ratio(model)


def settled(case: Case) -> Case:
    """Return the case with the tolerance, to one digit, and the error bars of its accuracy, unless they are given."""
    solver = case.solver
    if solver.accuracy is None:
        return case
    # Such a tolerance adds no error, and resolves the slip of small increments.
    picked = {"tolerance": float(f"{min(max(1e-4 * solver.accuracy, 1e-8), 1e-5):.0e}"), "error_bars": True}
    missing = {name: value for name, value in picked.items() if name not in solver.model_fields_set}
    return case.model_copy(update={"solver": solver.model_copy(update=missing)})


def picks(asked: Case, case: Case, points: tuple[int, int], load_path: LoadPath) -> tuple[str, ...]:
    """Return in words the settings of `case` that its accuracy has picked. asked: the case as it was read."""
    if asked.solver.accuracy is None:
        return ()
    stages, given = zip(asked.stages(), load_path.counts, strict=True), asked.solver.model_fields_set
    counts = sorted({count for stage, count in stages if stage.increments is None})
    span = " to ".join(str(count) for count in dict.fromkeys(counts[:1] + counts[-1:]))
    texts = {
        f"{points[0]} x {points[1]} points": asked.grid.points is None,
        f"{span} increments per stage": counts and load_path.path_dependent,
        f"tolerance {case.solver.tolerance:g}": "tolerance" not in given,
        "error bars": "error_bars" not in given,
    }
    return tuple(text for text, is_picked in texts.items() if is_picked)


@dataclass(frozen=True)
class Verdict:
    """The judgement of a run's error bars by its accuracy.

    worst: the largest bar over its scale, NaN where one is unknown; quantity, stage: where it is.
    """

    accuracy: float
    worst: float
    quantity: str
    stage: int

    @property
    def met(self) -> bool:
        """True if all bars are known and within the accuracy."""
        return self.worst <= self.accuracy

    def __str__(self) -> str:
        asked = f"accuracy {percent(self.accuracy)}"
        if math.isnan(self.worst):
            return f"{asked} is not proved: there are no error bars from stage {self.stage} on"
        of = f"{self.quantity} at the end of stage {self.stage}"
        scale = SCALES.get(self.quantity, "its largest value")
        if self.met:
            return f"{asked} is met: {percent(self.worst)} at most, of {of}"
        return f"{asked} is not met: {of} is known to {percent(self.worst)} of {scale}"


def verdict(solver: Mapping[str, object], history: Mapping[str, DoubleArray]) -> Verdict | None:
    """Judge a run by its history and the values under ``solver``; None without an accuracy or error bars."""
    accuracy = solver.get("accuracy")
    if not isinstance(accuracy, float) or "P" + ERROR_SUFFIX not in history or not len(history["stage"]):
        return None
    ends = np.flatnonzero(np.append(np.diff(history["stage"]) != 0, True))
    known = {name: scale for name, scale in scales(history, ends).items() if scale > 0.0} or {"P": math.inf}
    bars = np.array([history[name + ERROR_SUFFIX][ends] / scale for name, scale in known.items()])
    which, end = np.unravel_index(np.argmax(bars), bars.shape)  # that of NaN, if there is one
    return Verdict(accuracy, float(bars[which, end]), list(known)[which], int(history["stage"][ends[end]]))


def scales(history: Mapping[str, DoubleArray], ends: IndexArray) -> dict[str, float]:
    """Return the scale of each quantity's error, as `SCALES` names it; ends: the last increments of stages."""
    largest = {name: float(np.abs(history[name][ends]).max()) for name in QUANTITIES}
    approach, radius, force = largest["delta_z"], largest["contact_radius"], largest["P"]
    turn = approach / radius if radius else 0.0
    tangential_force = max(largest["Qx"], largest["Qy"], LEAST_MOTION * force)
    tangential_motion = max(largest["delta_x"], largest["delta_y"], LEAST_MOTION * approach)
    return {
        **largest,
        **dict.fromkeys(("Qx", "Qy"), tangential_force),
        **dict.fromkeys(("Mx", "My", "Mz"), force * radius),
        **dict.fromkeys(("delta_x", "delta_y"), tangential_motion),
        **dict.fromkeys(("phi_x", "phi_y"), turn),
        "phi_z": max(largest["phi_z"], LEAST_MOTION * turn),
        "stick_radius": radius,
    }
