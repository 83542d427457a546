"""The fields of a state, from the solution of its increment and the fields before it.

The slip increment of the solution is the relative motion over the whole increment, but a cell that is open at its start
or end slips only while it touches. docs/theory.md derives the share (T14) and the mean pressure (T15) from the
square-root law of Johnson, Contact Mechanics, section 5.1. An opening cell slips if the edge that leaves it slips; if
that sticks, as at high friction, the cell sticks until it opens.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from fretsolve.contact.increment.increment import Solved
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import Fields, Zone, broadcast_zeros
from fretsolve.system.arrays import BoolArray, FloatArray, IndexArray, vector_lengths

FEW_PAIRS = 10_000_000
"""Pairs of cells up to which all distances are computed, 1 ns each. A tree of the cells is for more of them; it takes
0.1 s or more to load."""

LEVEL = 1e-8
"""Difference of the square of the pressure between neighbouring cells, over that square, up to which it is rounding."""


def unloaded(separation: FloatArray) -> tuple[Fields, FloatArray]:
    """Return fields and displacement before the first increment: the surfaces touch at their nearest points."""
    nearest = np.min(separation, where=np.isfinite(separation), initial=np.inf)
    gap = separation - (nearest if np.isfinite(nearest) else 0.0)
    scalar, vector = broadcast_zeros(separation.shape), broadcast_zeros((2, *separation.shape))
    return Fields(scalar, vector, vector, scalar, scalar, np.zeros(separation.shape, np.uint8), gap), vector


def fields_of(
    solved: Solved, before: Fields, setup: ProblemSetup, team: ThreadTeam
) -> tuple[Fields, FloatArray, float]:
    """Return fields and displacement after an increment, and the energy dissipated in it; team: shares a large grid."""
    slip_path, work_density, work = broadcast_zeros(setup.grid.shape), broadcast_zeros(setup.grid.shape), 0.0
    if setup.model.may_slip:
        slip_path, work_density, work = _accumulate(solved, before, setup, team)
    kept = partial(_kept, precision=precision_of(setup))
    stored, friction = setup.case.output.fields, None
    if "friction" in stored:
        friction = kept(np.array(np.broadcast_to(solved.friction.coefficient_at(solved.pressure), setup.grid.shape)))
    fields = Fields(
        pressure=kept(solved.pressure),
        shear=kept(solved.shear),
        slip=kept(solved.slip),
        slip_path=kept(slip_path),
        work_density=kept(work_density),
        zone=solved.zone,
        gap=kept(solved.gap),
        friction=friction,
        shear_bound=kept(solved.friction_limit) if "shear_bound" in stored else None,
    )
    displacement = kept(solved.displacement)
    displacement.flags.writeable = False
    return read_only(fields), displacement, work


def read_only(fields: Fields) -> Fields:
    """Return the fields as arrays that cannot be written to: the next increment starts from these very arrays."""
    for array in vars(fields).values():
        if array is not None:
            array.flags.writeable = False
    return fields


def precision_of(setup: ProblemSetup) -> type[np.floating]:
    """Return the precision of the elastic operator and of the fields of the states."""
    return np.float32 if setup.case.solver.precision == "single" else np.float64


def _kept(field: FloatArray, precision: type[np.floating]) -> FloatArray:
    """Return `field` in the precision of the states; `broadcast_zeros` stay so."""
    if not any(field.strides):
        return np.broadcast_to(precision(0.0), field.shape)
    return field.astype(precision, copy=False)


def _accumulate(
    solved: Solved, before: Fields, setup: ProblemSetup, team: ThreadTeam
) -> tuple[FloatArray, FloatArray, float]:
    """Return the slip path and the dissipated energy per area since the start, and the increment's dissipated energy.

    Turns the slip of the increment in `solved` into the slip since the start, in place.
    """
    slip, friction = solved.slip, solved.friction
    modulus, orthotropy = setup.model.compliances.contact_modulus, setup.model.orthotropy
    parted = limit_to_contact(slip, before, solved, setup.grid, modulus)
    slip_path, work_density = np.empty(parted.shape), np.empty(parted.shape)

    def accumulate(rows: slice) -> float:
        """Fill some rows, and return the sum of their energy per area in the increment."""
        moved, mean = slip[:, rows], mean_pressure(before.pressure[rows], solved.pressure[rows])
        length = vector_lengths(moved)
        energy = friction.part(rows).limit(mean)
        energy *= length if orthotropy is None else vector_lengths(orthotropy.times(moved))
        # The slip of a sticking cell is the certificate's residual, not slip.
        energy *= (solved.zone[rows] == Zone.SLIP) | parted[rows]
        np.add(length, before.slip_path[rows], out=slip_path[rows])
        np.add(energy, before.work_density[rows], out=work_density[rows])
        moved += before.slip[:, rows]
        return float(energy.sum())

    work = sum(team.of_rows(parted.shape, accumulate)) * setup.grid.cell_area
    return slip_path, work_density, work


def limit_to_contact(slip: FloatArray, before: Fields, solved: Solved, grid: Grid, contact_modulus: float) -> BoolArray:
    """Limit `slip` in place to the time in contact, and return the cells that slipped while they opened, (nx, ny).

    slip: (2, nx, ny) in mm, increment of the cells in contact at the end, 0 elsewhere; opened cells get theirs.
    before: at the start; solved: at the end; contact_modulus: E* (MPa).
    """
    touched, touches = before.pressure > 0.0, solved.pressure > 0.0
    row, column = np.nonzero(touches & ~touched)
    if row.size:
        share = share_in_contact(solved.pressure, before.gap, (row, column), grid, contact_modulus)
        slip[:, row, column] *= share
    opened = touched & ~touches
    if not opened.any():
        return opened
    parted = slipped_apart(opened, solved.zone, before.zone == Zone.SLIP)
    row, column = np.nonzero(parted)
    share = share_in_contact(before.pressure, solved.gap, (row, column), grid, contact_modulus)
    recovered = solved.previous_displacement[:, row, column] - solved.displacement[:, row, column]
    slip[:, row, column] = share * recovered
    moved_x, moved_y, turned = solved.motion[3:]
    slip[0, row, column] += share * (moved_x - turned * grid.y[column])
    slip[1, row, column] += share * (moved_y + turned * grid.x[row])
    return parted


def slipped_apart(parted: BoolArray, zone: NDArray[np.uint8], slipping: BoolArray) -> BoolArray:
    """Return which of the cells `parted` slipped: where the nearest cell in contact slips, or `slipping` without one.

    zone: at the increment's end; slipping: at its start; all (nx, ny).
    """
    contact = np.pad(zone != Zone.OPEN, 1, mode="edge")
    surrounded = contact[2:, 1:-1] & contact[:-2, 1:-1] & contact[1:-1, 2:] & contact[1:-1, :-2]
    places, edge = np.argwhere(parted), np.argwhere(contact[1:-1, 1:-1] & ~surrounded)
    if not len(places) or not len(edge):
        return parted & slipping
    slipped = np.zeros_like(parted)
    slipped[tuple(places.T)] = zone[tuple(edge[nearest(places, edge)].T)] == Zone.SLIP
    return slipped


def nearest(places: IndexArray, cells: IndexArray) -> IndexArray:
    """Return which of the `cells` (n, 2) is nearest to each of the `places` (m, 2), (m,); any of equally near ones."""
    if len(places) * len(cells) > FEW_PAIRS:
        from scipy.spatial import cKDTree  # takes longer to import than a small case to solve

        return np.asarray(cKDTree(cells).query(places)[1])
    # so many pairs have their distances in memory at a time
    found, size = np.empty(len(places), np.intp), max(50_000 // len(cells), 1)
    row, column = cells.T.copy()  # lying together they take half the time
    for first in range(0, len(places), size):
        part = slice(first, first + size)
        distance = np.square(places[part, :1] - row)
        distance += np.square(places[part, 1:] - column)
        found[part] = distance.argmin(axis=1)
    return found


def share_in_contact(
    pressure: FloatArray, gap: FloatArray, cells: tuple[IndexArray, ...], grid: Grid, contact_modulus: float
) -> FloatArray:
    """Return the share of an increment in which `cells` touch, (n,): with `pressure` at one end, `gap` at the other."""
    row, column = cells
    own = pressure[cells].astype(np.float64) ** 2
    slopes = []
    for index, count, length in ((0, grid.nx, grid.dx), (1, grid.ny, grid.dy)):
        steepest = np.zeros(own.shape)
        for step in (-1, 1):
            places = [row, column]
            places[index] = np.minimum(np.maximum(places[index] + step, 0), count - 1)
            steepest = np.maximum(steepest, pressure[places[0], places[1]].astype(np.float64) ** 2 - own)
        slopes.append(steepest / length)
    slope = np.hypot(*slopes)
    # the highest cells; cells that are as high but for rounding may differ by the rounding
    alone = slope * max(grid.dx, grid.dy) <= LEVEL * own
    slope[alone] = own[alone] / max(grid.dx, grid.dy)
    inside = own / slope
    outside = (0.75 * contact_modulus * np.maximum(gap[cells], 0.0) / np.sqrt(slope)) ** (2.0 / 3.0)
    share: FloatArray = inside / (inside + outside)
    return share


def mean_pressure(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return the mean over an increment of a pressure whose square changes linearly, of the arrays' shape."""
    mean: FloatArray = before + after
    product = before * after  # 0 where both are
    product /= np.maximum(mean, np.finfo(mean.dtype).tiny)
    mean -= product
    mean *= 2.0 / 3.0
    return mean
