"""Where a crack begins: at the edge of contact, where a fatigue parameter is largest, or at a given place."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.output_spec import LifeCriterion
from fretsolve.errors import CaseError
from fretsolve.post.crack.stress_line import StressLine
from fretsolve.post.fatigue.criteria import fatigue_field
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.request import cell_centres, layers, memory_problem, stress_request
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.model.grid import Grid

SAME_TENSION = 1e-3
"""Share by which the tension at the right edge must be larger; a contact loaded to and fro has the same at both."""


@dataclass(frozen=True)
class Place:
    """A place on the surface (mm), and in words why it is there."""

    x: float
    y: float
    reason: str


def contact_steps(tractions: TractionHistory, steps: Sequence[int]) -> list[int]:
    """Return the increments with a contact. Raises CaseError if there is none."""
    widths = tractions.result.history["contact_half_width_x"]
    found = [step for step in steps if widths[step] > 0.0]
    if not found:
        raise CaseError("the bodies do not touch in the chosen cycles, so that no crack begins")
    return found


def at_edge(tractions: TractionHistory, line: StressLine) -> Place:
    """Return the edge of contact with the largest tension along x of all increments.

    The tension is that half a cell below the surface, where cells do not show. Edges are known to a fraction of a cell.
    Raises CaseError.
    """
    require_round(_surfaces(tractions))
    history, half_a_cell = tractions.result.history, np.array([0.5 * tractions.grid.dx])
    best, found = -math.inf, Place(0.0, 0.0, "")
    for step in contact_steps(tractions, line.steps):
        middle, width = float(history["contact_center_x"][step]), float(history["contact_half_width_x"][step])
        y = nearest_row(tractions, step)
        for side, name in ((-1.0, "left"), (1.0, "right")):
            x = middle + side * width
            tension = float(line.of(step).stress((x, y), half_a_cell, ("xx",))[0, 0, 0, 0])
            if tension > best + SAME_TENSION * abs(best if math.isfinite(best) else 0.0):
                best, found = tension, Place(x, y, f"{name} edge of contact, increment {step}")
    require_finite(_surfaces(tractions), tractions.grid, found)
    return found


def at_length(tractions: TractionHistory, steps: Sequence[int], x: float) -> Place:
    """Return a given place on the row through the middle of the contact. Raises CaseError."""
    found = Place(x, nearest_row(tractions, contact_steps(tractions, steps)[-1]), "as given")
    require_inside(tractions.grid, x)
    require_finite(_surfaces(tractions), tractions.grid, found)
    return found


def at_largest(
    tractions: TractionHistory,
    line: StressLine,
    cycles: Sequence[LoadCycle],
    criterion: LifeCriterion,
    material: Material,
) -> Place:
    """Return where a fatigue parameter on the surface is largest, of all cycles. Raises CaseError.

    cycles: their states are places in the steps of `line`.
    """
    request = stress_request(tractions, line.steps, (line.body,), (0.0,))
    if (problem := memory_problem(request, 1)) is not None:
        raise CaseError(problem)
    stress = np.array([layer.stress.reshape(6, -1) for layer in layers(tractions, request)])
    values = [fatigue_field(criterion, material, one.with_rest(stress[list(one.states)])).value for one in cycles]
    value = np.max(values, axis=0)
    worst = int(value.argmax())
    if not value[worst] > 0.0:
        raise CaseError(f"the parameter {criterion} is 0 everywhere on the surface; edge, or a place, is needed")
    x, y = cell_centres(tractions.grid, request.target)
    i, j = divmod(worst, request.shape[1])
    found = Place(float(x[i]), float(y[j]), f"largest {criterion} parameter on the surface")
    require_finite(_surfaces(tractions), tractions.grid, found)
    return found


def nearest_row(tractions: TractionHistory, step: int) -> float:
    """Return y of the row of cells nearest to the middle of the contact in an increment (mm)."""
    if tractions.plane_strain:
        return 0.0
    rows = tractions.grid.y
    return float(rows[np.abs(rows - tractions.result.history["contact_center_y"][step]).argmin()])


def require_inside(grid: Grid, x: float) -> None:
    """Raise CaseError if a place is outside of the grid."""
    low, high = float(grid.x[0]) - 0.5 * grid.dx, float(grid.x[-1]) + 0.5 * grid.dx
    if not low <= x <= high:
        needed = f"edge, max, or a place from {low:.6g} to {high:.6g} mm is needed"
        raise CaseError(f"{x:g} mm is outside of the grid; {needed}")


def require_finite(surfaces: Sequence[dict[str, Any]], grid: Grid, place: Place) -> None:
    """Raise CaseError if a place is within a cell of a sharp edge or a tip, where stress has no bound.

    surfaces: of the effective case.
    """
    for x, what in _unbounded(surfaces, place.y, grid):
        if abs(place.x - x) < grid.dx:
            raise CaseError(
                f"x = {place.x:.6g} mm is at {what}, where stress is infinite; a place at least a cell"
                f" ({grid.dx:.3g} mm) away from it, or for a punch an edge_radius, is needed"
            )


def require_round(surfaces: Sequence[dict[str, Any]]) -> None:
    """Raise CaseError if the edge of contact is the sharp edge of a punch, where stress has no bound."""
    kinds = [(kind, keys) for one in surfaces for kind, keys in one.items()]
    if len(kinds) == 1 and kinds[0][0] == "punch" and not kinds[0][1].get("edge_radius"):
        raise CaseError(
            "edge is the sharp edge of the punch, where stress is infinite; a place at least a cell away from it, or an"
            " edge_radius of the punch, is needed"
        )


def _surfaces(tractions: TractionHistory) -> Sequence[dict[str, Any]]:
    found: Sequence[dict[str, Any]] = tractions.result.effective_case.get("surface", ())
    return found


def _unbounded(surfaces: Sequence[dict[str, Any]], y: float, grid: Grid) -> Iterator[tuple[float, str]]:
    """Yield the places along x at which stress has no bound on a row, and what is there."""
    for kind, keys in ((kind, keys) for one in surfaces for kind, keys in one.items() if kind in ("punch", "cone")):
        middle = np.broadcast_to(keys["center"], 2) if np.ndim(keys["center"]) else (keys["center"], y)
        beside = abs(y - middle[1])
        if kind == "cone":
            if beside < grid.dy:
                yield float(middle[0]), "the tip of the cone"
        elif not keys.get("edge_radius"):
            radius = keys.get("radius")
            half = keys["half_width"] if radius is None else math.sqrt(max(0.0, radius**2 - beside**2))
            yield from ((float(middle[0] + side * half), "the sharp edge of the punch") for side in (-1.0, 1.0))
