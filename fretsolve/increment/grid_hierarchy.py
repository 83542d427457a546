"""Solvers of one grid, and of coarser ones that give them first estimates.

On each level the problem is first solved roughly on the next coarser grid and the estimate corrected by what
changed there. It pays where an increment begins far from its end, as all do that change the normal load.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.elastic.convolution import RowSpace
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ONE_THREAD, ThreadTeam
from fretsolve.errors import ContactLostError
from fretsolve.increment.grid_transfer import Coarsening
from fretsolve.increment.load_checks import require_supported
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.normal import NormalSolver
from fretsolve.solvers.tangential import TangentialSolver
from fretsolve.system.arrays import FloatArray, Vector

if TYPE_CHECKING:
    from fretsolve.model.required_terms import Model


COARSE_TOLERANCE = 1e-2
"""Of a coarse problem, whose solution differs from the fine one's by about this much anyway."""

COARSE_ITERATIONS = 60
"""A coarse problem that takes more is left as it is: a poor estimate costs iterations, nothing else."""

NEAR_THE_BOUND = 0.8
"""A cell slips at first if its coarse cell does and its shear has this part of the bound."""


class Level:
    """Operator and solvers on `grid`, with a coarser level below as long as there are points enough."""

    def __init__(
        self,
        grid: Grid,
        model: Model,
        threads: ThreadTeam = ONE_THREAD,
        space: RowSpace | None = None,
        dtype: type[np.floating] = np.float64,
    ):
        self.grid = grid
        self._sheared = model.has_shear
        space = space or RowSpace()
        self.operator = ElasticOperator(
            grid.shape, (grid.dx, grid.dy), model.compliances, model.terms, threads, space, dtype
        )
        self._coarsening = Coarsening(grid)
        coarse = self._coarsening.coarse
        self.coarser = Level(coarse, model, threads, space, dtype) if coarse is not None else None

    @cached_property
    def normal(self) -> NormalSolver:
        """Solver of the normal problem on this grid; it works in the tangential one's arrays, where there is one."""
        return NormalSolver(self.operator, self.grid, self.tangential.space if self._sheared else None)

    @cached_property
    def tangential(self) -> TangentialSolver:
        """Solver of the tangential problem on this grid; the model must have shear."""
        return TangentialSolver(self.operator, self.grid)

    def release(self) -> None:
        """Give back the solvers' memory, on coarser levels too; influence coefficients and plans are kept."""
        self.__dict__.pop("normal", None)
        self.__dict__.pop("tangential", None)
        if self.coarser is not None:
            self.coarser.release()

    @property
    def applications(self) -> float:
        """Operator applications so far, those on coarser grids in parts of one on this grid."""
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
        transfer, coarser = self._coarsening, self.coarser
        before = transfer.restrict(pressure)
        coarse_separation = transfer.restrict_separation(separation)
        if not _carries(coarse_separation, control, coarser.grid):
            return
        if pressure.any():
            uz, coarse_uz = np.empty_like(pressure), np.empty_like(before)
            self.operator.normal(pressure, uz)
            coarser.operator.normal(before, coarse_uz)
            coarse_separation += transfer.restrict(uz) - coarse_uz
        after = before.copy()
        coarser.estimate_normal(coarse_separation, control, after, rigid)
        coarser.normal.solve(coarse_separation, control, after, COARSE_TOLERANCE, COARSE_ITERATIONS, rigid)
        if pressure.any():
            pressure += transfer.prolong(after - before)
            np.maximum(pressure, 0.0, out=pressure)
        else:
            # Where contact ends the pressure falls like a square root, so its square interpolates well.
            np.sqrt(transfer.prolong(np.square(after)), out=pressure)
        pressure[np.isinf(separation)] = 0.0

    def estimate_tangential(
        self, elastic_slip: FloatArray, control: LoadControl, bound: FloatArray, shear: FloatArray, motion: float
    ) -> None:
        """Improve the estimate `shear` (2, nx, ny), its slip zone and elastic slip, in place by a coarser solution."""
        if self.coarser is None:
            return
        transfer, coarser = self._coarsening, self.coarser
        before = transfer.restrict(shear)
        coarse_bound, coarse_slip = transfer.restrict(bound), transfer.restrict(elastic_slip)
        after = before.copy()
        solver = coarser.tangential
        solver.slipping[:] = np.hypot(before[0], before[1]) >= NEAR_THE_BOUND * coarse_bound
        coarser.estimate_tangential(coarse_slip, control, coarse_bound, after, motion)
        solver.solve(coarse_slip, control, coarse_bound, after, COARSE_TOLERANCE, COARSE_ITERATIONS, motion)
        change = transfer.prolong(after - before)
        shear += change
        self.operator.tangential(change, change)
        elastic_slip -= change
        near = np.hypot(shear[0], shear[1]) >= NEAR_THE_BOUND * bound
        np.logical_and(transfer.inject(solver.slipping), near, out=self.tangential.slipping)


def _carries(separation: FloatArray, control: LoadControl, grid: Grid) -> bool:
    """Whether a coarse grid has the material that the load needs; a small punch may fall through it."""
    try:
        require_supported(control, separation, grid)
    except ContactLostError:
        return False
    return bool(np.isfinite(separation).any())
