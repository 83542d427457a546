"""What a cell slips and dissipates in an increment, where the contact's edge passes over it in the middle of it.

The slip increment of the solution is the surfaces' relative motion over the whole increment. A cell that was open at
its start, or is at its end, slips only while it touches; taking all of the motion makes the work too large, with an
error of order 3/2 in the increment. The part follows from how far the edge has gone on both sides of the cell: at a
distance s from it the pressure inside is C s^(1/2), the gap outside 4 C s^(3/2) / 3 E* (Johnson, Contact Mechanics,
section 5.1), and C^2 is the slope of the squared pressure, which is straight near the edge (in Hertz's contact:
everywhere). So the squared pressure of a cell grows with the way of the edge, and the mean of the friction bound is
that of mu p with p^2 changing evenly from start to end.

A cell that parts slips as it does so where the edge that leaves it slips; where the edge sticks, as at much friction,
it sticks until it parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray

if TYPE_CHECKING:
    from fretsolve.increment.certificate import Evidence, Solution
    from fretsolve.model.grid import Grid

Cells = tuple[IndexArray, ...]


@dataclass(frozen=True)
class ContactState:
    """Pressure (MPa), gap (mm, may be infinite) and what slipped at the start of an increment, all ``(nx, ny)``."""

    pressure: FloatArray
    gap: FloatArray
    slipping: BoolArray


def limit_to_contact(
    slip: FloatArray,
    before: ContactState,
    solution: Solution,
    evidence: Evidence,
    grid: Grid,
    contact_modulus: float,
) -> BoolArray:
    """Cut `slip` in place to the time in contact; returns the cells that slipped as they parted, (nx, ny).

    slip: (2, nx, ny) in mm, increment of the cells in contact at the end, 0 elsewhere, where parted cells get theirs;
    evidence: gap and zones at the end; contact_modulus: E* (MPa).
    """
    gap = evidence.gap
    touched, touches = before.pressure > 0.0, solution.pressure > 0.0
    parted = slipped_apart(touched & ~touches, evidence.zone, before.slipping)
    row, column = np.nonzero(touches & ~touched)
    share = share_in_contact(solution.pressure, before.gap, (row, column), grid, contact_modulus)
    slip[:, row, column] *= share
    row, column = np.nonzero(parted)
    share = share_in_contact(before.pressure, gap, (row, column), grid, contact_modulus)
    slip[:, row, column] = share * (
        solution.previous_displacement[:, row, column] - solution.displacement[:, row, column]
    )
    moved_x, moved_y, turned = solution.motion[3:]
    slip[0, row, column] += share * (moved_x - turned * grid.y[column])
    slip[1, row, column] += share * (moved_y + turned * grid.x[row])
    return parted


def slipped_apart(
    parted: BoolArray, zone: NDArray[np.uint8], slipping: BoolArray
) -> BoolArray:
    """Of the cells `parted` those whose nearest one in contact slips; where no contact is left, those that did before.

    zone: at the increment's end; slipping: at its start; all (nx, ny).
    """
    places, edge = np.argwhere(parted), np.argwhere(_edge(zone != Zone.OPEN))
    if not len(places) or not len(edge):
        return parted & slipping
    from scipy.spatial import cKDTree  # takes as long to import as a small increment to solve

    _, nearest = cKDTree(edge).query(places)
    slipped = np.zeros_like(parted)
    slipped[tuple(places.T)] = zone[tuple(edge[nearest].T)] == Zone.SLIP
    return slipped


def _edge(contact: BoolArray) -> BoolArray:
    """Cells in contact beside one that is not."""
    inner = contact.copy()
    inner[1:] &= contact[:-1]
    inner[:-1] &= contact[1:]
    inner[:, 1:] &= contact[:, :-1]
    inner[:, :-1] &= contact[:, 1:]
    return contact & ~inner


def share_in_contact(
    pressure: FloatArray, gap: FloatArray, cells: Cells, grid: Grid, contact_modulus: float
) -> FloatArray:
    """Part of an increment in which `cells` touch, (n,): they have `pressure` at one end of it, `gap` at the other."""
    row, column = cells
    own = pressure[cells].astype(np.float64) ** 2
    slopes = []
    for index, count, length in ((0, grid.nx, grid.dx), (1, grid.ny, grid.dy)):
        steepest = np.zeros(own.shape)
        for step in (-1, 1):
            places = [row, column]
            places[index] = np.clip(places[index] + step, 0, count - 1)
            steepest = np.maximum(steepest, pressure[places[0], places[1]].astype(np.float64) ** 2 - own)
        slopes.append(steepest / length)
    slope = np.hypot(*slopes)
    alone = slope == 0.0
    slope[alone] = own[alone] / max(grid.dx, grid.dy)
    inside = own / slope
    outside = (0.75 * contact_modulus * np.maximum(gap[cells], 0.0) / np.sqrt(slope)) ** (2.0 / 3.0)
    share: FloatArray = inside / (inside + outside)
    return share


def mean_pressure(before: FloatArray, after: FloatArray) -> FloatArray:
    """Mean over an increment of a pressure whose square changes evenly, of the arrays' shape."""
    total = before + after
    product = np.divide(before * after, total, out=np.zeros_like(total), where=total > 0.0)
    mean: FloatArray = (total - product) * (2.0 / 3.0)
    return mean
