"""Grid levels: the solvers of one grid, and coarser grids that give first estimates of the pressure.

On each level the problem is first solved roughly on the next coarser grid, and the estimate is corrected by the change
there. That pays where an increment begins far from its end, as all do that change the normal load: without it modes II
and III take 1.2 times the seconds on 128 x 128 points, and a first contact five times the applications.

A coarse cell holds two by two fine ones, or two by one where a side has too few points to be halved; the last row of an
odd number of cells is paired with zeros. Coarse problems are posed as in a full approximation scheme (Brandt 1977): an
exact fine estimate solves the coarse problem too, up to the zones' edges, and a poor one is improved.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.contact.increment.failures import require_supported
from fretsolve.contact.solvers.line_tangential import LineTangentialSolver
from fretsolve.contact.solvers.normal import NormalSolver
from fretsolve.contact.solvers.tangential import TangentialSolver
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.operator_on_grid import operator_on
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import ContactLostError
from fretsolve.problem.model.grid import Grid, HalfGrid, LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.required_terms import Model
from fretsolve.system.arrays import FloatArray, Vector

if TYPE_CHECKING:
    from fretsolve.contact.solvers.line_direct import LineDirectSolver

COARSE_TOLERANCE = 1e-2
"""Largest tolerance of a coarse problem."""

MOST_DIRECT_STRIPS, MOST_DIRECT_POINTS = 250, 2500
"""Strips of a line contact, and of its grid, up to which increments are solved directly without
compiled kernels. Calls take most of the time up to some 100 strips; beyond, the time grows with the third power. Line
contacts on 24 to 128 points take .4 to .5 of the time, and would take .8 to .95 with compiled kernels."""

FEWEST_COARSE_POINTS = 49
"""Fewest points that are left of a side that is halved. With 24 a first increment on 48 to 64 points takes 1.4 times as
long, as coarse solves cost calls there, not cells, and the mean of mode I.3 up to 1.1 times."""


class GridLevel:
    """Operator and solvers on `grid`, with a coarser level below if there are enough points.

    dtype: precision of the operator; whole: operator of a small grid that has this one as a part.
    """

    def __init__(
        self, grid: Grid, model: Model, team: ThreadTeam, dtype: type[np.floating], whole: ElasticOperator | None = None
    ):
        self.grid = grid
        self._has_shear, self._compiled = model.has_shear, team.kernels.compiled
        self.operator = operator_on(grid, model.compliances, model.terms, team, dtype, model.orthotropy, whole)
        self._transfer = GridTransfer(grid)
        coarse = self._transfer.coarse
        self.coarser = None if coarse is None else GridLevel(coarse, model, team, dtype)

    @property
    def tolerance(self) -> float:
        """Tolerance of the problem on this grid where it gives an estimate for a finer one."""
        # It differs from the fine problem by about the width of its cells. On 512 x 512 points mode I.2 takes 2 of 18
        # applications less for that, and a first contact one of 13.
        return min(COARSE_TOLERANCE, 0.5 / max(self.grid.whole_shape))

    @cached_property
    def normal(self) -> NormalSolver:
        """Solver of the normal problem; it shares the arrays of the tangential solver, if there is one."""
        workspace = self.tangential.workspace if self._has_shear else None
        return NormalSolver(self.operator, self.grid, workspace)

    @cached_property
    def tangential(self) -> TangentialSolver:
        """Solver of the tangential problem; the model must have shear."""
        if isinstance(self.grid, LineGrid):
            return LineTangentialSolver(self.operator, self.grid)
        return TangentialSolver(self.operator, self.grid)

    @cached_property
    def direct(self) -> LineDirectSolver | None:
        """Solver of increments with at most MOST_DIRECT_STRIPS strips in contact; None on an area, on a large grid, in
        single precision and with compiled kernels."""
        if not isinstance(self.grid, LineGrid) or self.grid.nx > MOST_DIRECT_POINTS:
            return None
        if self._compiled or self.operator.dtype is np.float32:
            return None
        from fretsolve.contact.solvers.line_direct import LineDirectSolver  # other cases do not need it

        return LineDirectSolver(self.operator, self.grid)

    def release(self) -> None:
        """Free the solvers' memory, on coarser levels too; influence coefficients and plans are kept."""
        self.__dict__.pop("normal", None)
        self.__dict__.pop("tangential", None)
        if self.coarser is not None:
            self.coarser.release()

    @property
    def applications(self) -> float:
        """Operator applications so far; an application on a coarser grid counts as a part of one on this grid."""
        coarser = self.coarser
        if coarser is None:
            return float(self.operator.total_applications)
        share = (coarser.grid.nx * coarser.grid.ny) / (self.grid.nx * self.grid.ny)
        return self.operator.total_applications + share * coarser.applications

    def estimate_normal(
        self, separation: FloatArray, control: LoadControl, pressure: FloatArray, rigid: Vector
    ) -> None:
        """Improve the estimate `pressure` (nx, ny) in place by a coarser solution."""
        if self.coarser is None:
            return
        transfer, coarser = self._transfer, self.coarser
        # the coarse problem, with its error in the present displacement added to its separation
        before = transfer.restrict(pressure)
        coarse_separation = transfer.restrict_separation(separation)
        if not _carries(coarse_separation, control, coarser.grid):
            return
        if pressure.any():
            uz, coarse_uz = np.empty_like(pressure), np.empty_like(before)
            self.operator.normal(pressure, uz)
            coarser.operator.normal(before, coarse_uz)
            coarse_separation += transfer.restrict(uz) - coarse_uz
            del uz, coarse_uz  # before the coarse grids need their arrays
        # its solution, from an estimate on still coarser grids
        after = before.copy()
        coarser.estimate_normal(coarse_separation, control, after, rigid)
        coarser.normal.solve(coarse_separation, control, after, coarser.tolerance, 60, rigid)
        # the correction of the fine estimate
        if pressure.any():
            pressure += transfer.prolong(after - before)
            np.maximum(pressure, 0.0, out=pressure)
        else:
            # near the edge of contact the pressure is like a square root, so its square interpolates well
            np.sqrt(transfer.prolong(np.square(after)), out=pressure)
        pressure[np.isinf(separation)] = 0.0


def _carries(separation: FloatArray, control: LoadControl, grid: Grid) -> bool:
    """Return whether a coarse grid, which may miss a small punch, has the material that the load needs."""
    try:
        require_supported(control, separation, grid)
    except ContactLostError:
        return False
    return bool(np.isfinite(separation).any())


class GridTransfer:
    """Transfer between the grid `fine` and a grid `coarse`, which is None where no side can be halved."""

    def __init__(self, grid: Grid):
        self.fine = grid
        self.factors = tuple(2 if count >= 2 * FEWEST_COARSE_POINTS else 1 for count in grid.whole_shape)
        self.coarse: Grid | None = None
        if 2 in self.factors:  # cells that cover the cells of `fine`, from the same corner on
            fx, fy = self.factors
            nx, ny = -(-grid.nx // fx), -(-grid.ny // fy)
            x0, y0 = grid.x0 + 0.5 * (nx * fx - grid.nx) * grid.dx, grid.y0 + 0.5 * (ny * fy - grid.ny) * grid.dy
            self.coarse = grid.part(nx, ny, (fx * grid.dx, fy * grid.dy), (x0, y0))

    def restrict(self, field: FloatArray) -> FloatArray:
        """Return means over the coarse cells, ``(..., nx, ny)``, with zeros beyond the fine grid."""
        fx, fy = self.factors
        rows = _pair_mean(field, -2) if fx == 2 else field
        return _pair_mean(rows, -1) if fy == 2 else rows

    def restrict_separation(self, separation: FloatArray) -> FloatArray:
        """Return means where all of a coarse cell has material, +inf elsewhere."""
        padding = [(0, count % factor) for count, factor in zip(separation.shape, self.factors, strict=True)]
        return self.restrict(np.pad(separation, padding, constant_values=np.inf))

    def prolong(self, field: FloatArray) -> FloatArray:
        """Return the bilinear interpolation to the fine cells, (nx, ny), with zeros outside of the grid.

        On one half of a grid the other half of the field is its mirror image.
        """
        fx, fy = self.factors
        rows = _interpolate(field, -2)[..., : self.fine.nx, :] if fx == 2 else field
        if fy == 1:
            return rows
        found = _interpolate(rows, -1)[..., : self.fine.ny]
        if isinstance(self.fine, HalfGrid):
            found[..., 0] += 0.25 * rows[..., 0]
        return found


def _pair_mean(field: FloatArray, axis: int) -> FloatArray:
    moved = np.moveaxis(field, axis, 0)
    if moved.shape[0] % 2:
        moved = np.concatenate([moved, np.zeros_like(moved[:1])])
    return np.moveaxis(0.5 * (moved[0::2] + moved[1::2]), 0, axis)


def _interpolate(field: FloatArray, axis: int) -> FloatArray:
    moved = np.moveaxis(field, axis, 0)
    result = np.empty((2 * moved.shape[0], *moved.shape[1:]), dtype=field.dtype)
    result[0::2] = 0.75 * moved
    result[1::2] = 0.75 * moved
    result[2::2] += 0.25 * moved[:-1]
    result[1:-1:2] += 0.25 * moved[1:]
    return np.moveaxis(result, 0, axis)
