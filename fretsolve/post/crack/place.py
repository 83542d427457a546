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
from fretsolve.post.crack.stress_line import StressLine, require_memory
from fretsolve.post.fatigue.criteria import fatigue_field
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.influence import COMPONENTS
from fretsolve.post.stress.request import cell_centres, layers, stress_request
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import DoubleArray

SAME_TENSION = 1e-3
"""Share by which the tension at the right edge must be larger; a contact loaded to and fro has the same at both."""


BEYOND, MOST_BEYOND = (0.668, 0.923, -0.172), 0.83
"""Where contact ends beyond the middle of the last cell, in cells, by the ratio of its pressure to that of the cell
behind: a polynomial, largest power first. It holds to 0.02 of a cell at edges across the row and 0.08 at slanting ones,
measured on Hertz contacts. By the extrapolation of the squared pressure to 0 it would be 0.2."""

SAME_END = 0.1
"""Distance in cells within which the contact as a whole and the contact on a row end at the same place."""


@dataclass(frozen=True)
class CrackPlace:
    """A place on the surface (mm), and in words why it is there."""

    x: float
    y: float
    reason: str


@dataclass(frozen=True)
class RowOfContact:
    """The contact in an increment on the row of cells nearest to its middle: y of the row, and both ends along x (mm).

    Of several spots on the row the outermost ends count.
    """

    step: int
    y: float
    left: float
    right: float

    @property
    def half_width(self) -> float:
        """Half of the distance of both ends (mm)."""
        return 0.5 * (self.right - self.left)


def rows_of_contact(tractions: TractionHistory, steps: Sequence[int]) -> list[RowOfContact]:
    """Return the row of each increment with a contact. Raises CaseError if there is none.

    The history knows better where the contact as a whole ends, which counts where that is the end of the row.
    """
    history, grid, found = tractions.result.history, tractions.grid, []
    for step in steps:
        pressure = tractions.pressure(step)
        rows = np.flatnonzero((pressure > 0.0).any(axis=0))
        if not rows.size:
            continue
        middle = 0.0 if tractions.plane_strain else float(history["contact_center_y"][step])
        row = int(rows[np.abs(grid.y[rows] - middle).argmin()])
        ends = ends_by_pressure(pressure[:, row], grid)
        half = np.array([-1.0, 1.0]) * history["contact_half_width_x"][step]
        of_all = history["contact_center_x"][step] + half
        left, right = np.where(np.abs(ends - of_all) < SAME_END * grid.dx, of_all, ends).tolist()
        found.append(RowOfContact(step, float(grid.y[row]), left, right))
    if not found:
        raise CaseError("the bodies do not touch in the chosen cycles, so that no crack begins")
    return found


def ends_by_pressure(pressure: DoubleArray, grid: Grid) -> DoubleArray:
    """Return where the contact on a row ends to the left and to the right (mm), from the ratio of its last two cells.

    pressure: in the cells of the row, (nx,). A cell alone ends at its own edge, and so does a pressure that does not
    fall towards the edge.
    """
    inside, found = np.flatnonzero(pressure > 0.0), []
    for last, towards in ((inside[0], -1), (inside[-1], 1)):
        behind = pressure[last - towards] if 0 <= last - towards < len(pressure) else 0.0
        ratio = pressure[last] / behind if behind > pressure[last] else None
        beyond = 0.5 if ratio is None else min(float(np.polyval(BEYOND, ratio)), MOST_BEYOND)
        found.append(grid.x[last] + towards * beyond * grid.dx)
    return np.array(found)


def at_edge(tractions: TractionHistory, line: StressLine, rows: Sequence[RowOfContact]) -> CrackPlace:
    """Return the end of a row of contact with the largest tension along x of all increments.

    The tension is that half a cell below the surface, where cells do not show. Raises CaseError.
    """
    require_round(_surfaces(tractions))
    half_a_cell = np.array([0.5 * tractions.grid.dx])
    best, found = -math.inf, CrackPlace(0.0, 0.0, "")
    for row in rows:
        for x, name in ((row.left, "left"), (row.right, "right")):
            tension = float(line.of(row.step).stress((x, row.y), half_a_cell, ("xx",))[0, 0, 0, 0])
            if tension > best + SAME_TENSION * abs(best if math.isfinite(best) else 0.0):
                best, found = tension, CrackPlace(x, row.y, f"{name} edge of contact, increment {row.step}")
    require_finite(_surfaces(tractions), tractions.grid, found)
    return found


def at_length(tractions: TractionHistory, rows: Sequence[RowOfContact], x: float) -> CrackPlace:
    """Return a given place on the last of the rows of contact. Raises CaseError."""
    found = CrackPlace(x, rows[-1].y, "as given")
    require_inside(tractions.grid, x)
    require_finite(_surfaces(tractions), tractions.grid, found)
    return found


def at_largest(
    tractions: TractionHistory,
    line: StressLine,
    cycles: Sequence[LoadCycle],
    criterion: LifeCriterion,
    material: Material,
) -> CrackPlace:
    """Return where a fatigue parameter on the surface is largest, of all cycles. Raises CaseError.

    cycles: their states are places in the steps of `line`.
    """
    request = stress_request(tractions, line.steps, (line.body,), (0.0,))
    held = 2.0 * 8.0 * len(COMPONENTS) * math.prod(request.shape) * len(line.steps)
    require_memory(held + request.memory(1), f"the stresses on the surface in {len(line.steps)} increments")
    stress = np.array([layer.stress.reshape(6, -1) for layer in layers(tractions, request)])
    values = [fatigue_field(criterion, material, one.of(stress)).value for one in cycles]
    value = np.max(values, axis=0)
    worst = int(value.argmax())
    if not value[worst] > 0.0:
        raise CaseError(f"the parameter {criterion} is 0 everywhere on the surface; edge, or a place, is needed")
    x, y = cell_centres(tractions.grid, request.target)
    i, j = divmod(worst, request.shape[1])
    found = CrackPlace(float(x[i]), float(y[j]), f"largest {criterion} parameter on the surface")
    require_finite(_surfaces(tractions), tractions.grid, found)
    return found


def require_inside(grid: Grid, x: float) -> None:
    """Raise CaseError if a place is outside of the grid."""
    low, high = float(grid.x[0]) - 0.5 * grid.dx, float(grid.x[-1]) + 0.5 * grid.dx
    if not low <= x <= high:
        needed = f"edge, max, or a place from {low:.6g} to {high:.6g} mm is needed"
        raise CaseError(f"{x:g} mm is outside of the grid; {needed}")


def require_finite(surfaces: Sequence[dict[str, Any]], grid: Grid, place: CrackPlace) -> None:
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
