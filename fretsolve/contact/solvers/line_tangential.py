"""The tangential problem of a line contact, also where almost nothing sticks, as under large bulk stress.

There slip of both signs meets in a stick zone of about a cell, which the semismooth Newton method of `tangential` may
miss. Under forces along x alone the shear traction is a number per cell, and the problem

    min q'Kq/2 - e'q - D q'1,   |q| <= b

has one solution for each rigid motion D, whose force grows with D. So D is bracketed until the zones stay, and found
from their linear equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.contact.solvers.normal import SolverResult
from fretsolve.contact.solvers.tangential import SlipScales, TangentialSolver
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.operator_on_grid import strip_influence
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import DoubleArray, FloatArray, IndexArray

MOST_STICKING = 2000
"""Cells that stick, up to which their equations are solved by a dense matrix."""

MOST_WORK = 2e11
"""Sum of the cubes of these numbers of cells, up to which zones are sought: some seconds."""

ROUGH = 1e-2
"""Tolerance from which on a solution is only an estimate, for which the Newton method has to do."""


class LineTangentialSolver(TangentialSolver):
    """Solves the tangential problem on one row of cells; arguments as for `TangentialSolver`."""

    def __init__(self, operator: ElasticOperator, grid: LineGrid):
        super().__init__(operator, grid)
        self._grid = grid

    def solve(
        self,
        elastic_slip: FloatArray,
        control: LoadControl,
        friction_limit: FloatArray,
        shear: FloatArray,
        tolerance: float,
        max_iterations: int,
        scales: SlipScales,
    ) -> SolverResult:
        """Solve as `TangentialSolver` does; where that fails, find the zones one rigid motion after another."""
        arguments = control, friction_limit, shear, tolerance, max_iterations, scales
        found = super().solve(elastic_slip, *arguments)
        contact = np.flatnonzero(friction_limit[:, 0] > 0.0)
        along_y = shear[1].any() or elastic_slip[1].any() or control.imposed_resultant[1]
        if found.converged or along_y or tolerance >= ROUGH or not contact.size:
            return found
        problem = _Problem(
            strip_influence("xx", self._grid, self.operator.compliances)[:, 0],
            contact,
            friction_limit[contact, 0].astype(np.float64),
            control.imposed_resultant[0] / self.modes.cell_area,
        )
        before = shear[0, contact, 0].astype(np.float64)
        free = elastic_slip[0, contact, 0] + problem.moved(before)
        if control.forced[0]:
            solution = problem.solve(free)
        else:
            given_way = 0.0 if control.compliance is None else control.compliance[0][0] * self.modes.cell_area
            problem.kernel = problem.kernel + given_way
            moved = free + control.values[0]
            solution = problem.at(moved, np.sign(moved))
        if solution is None:
            return found
        change = np.zeros_like(shear)
        change[0, contact, 0] = solution - before
        shear += change
        self.operator.tangential(change, change)
        elastic_slip -= change
        self.slipping[:] = False
        self.slipping[contact, 0] = np.abs(solution) >= problem.limit
        return super().solve(elastic_slip, *arguments)


@dataclass
class _Problem:
    """Stick and slip in n cells.

    kernel: influence at the offsets 0, 1, ... in cells; cells: (n,), increasing; limit: of friction, (n,); force: the
    sum of q; work: what the search has cost, as `MOST_WORK` counts it.
    """

    kernel: DoubleArray
    cells: IndexArray
    limit: DoubleArray
    force: float
    work: float = 0.0

    def solve(self, free: DoubleArray) -> DoubleArray | None:
        """Return q, (n,), where q = K^-1 (free + D) sticks; free: the elastic slip without q. None if none is found."""
        reach = float(np.abs(free).max() + self.moved(self.limit).max() + self.kernel[0] * self.limit.max())
        low, high = -reach, reach
        for _ in range(120):
            motion = 0.5 * (low + high)
            state = np.sign(free + motion)  # few cells stick where this solver is needed
            q = self.at(free + motion, state)
            if q is None:
                return None
            exact = self._with_force(free, state)
            if exact is not None:
                return exact
            low, high = (motion, high) if q.sum() < self.force else (low, motion)
        return None

    def moved(self, q: DoubleArray) -> DoubleArray:
        """Return the displacement (n,) by q."""
        from scipy.linalg import matmul_toeplitz

        first = self.cells[0]
        count = int(self.cells[-1] - first) + 1
        whole = np.zeros(count)
        whole[self.cells - first] = q
        moved: DoubleArray = matmul_toeplitz(self.kernel[:count], whole)[self.cells - first]
        return moved

    def _stuck(self, stick: IndexArray) -> DoubleArray | None:
        """Return the influence matrix of the cells that stick; None if the search becomes too long."""
        self.work += float(stick.size) ** 3
        if stick.size > MOST_STICKING or self.work > MOST_WORK:
            return None
        cells = self.cells[stick]
        return self.kernel[np.abs(np.subtract.outer(cells, cells))]

    def at(self, free: DoubleArray, state: DoubleArray) -> DoubleArray | None:
        """Return q at a rigid motion, which `free` holds, and find the zones `state` (0 stick, 1 or -1 slip) for it."""
        for _ in range(60):
            q = state * self.limit
            slip = free - self.moved(q)
            stick = np.flatnonzero(state == 0)
            if stick.size:
                matrix = self._stuck(stick)
                if matrix is None:
                    return None
                q[stick] = np.linalg.solve(matrix, slip[stick])
                slip = free - self.moved(q)
            wanted = np.where(state == 0, np.sign(q) * (np.abs(q) > self.limit), state * (state * slip > 0.0))
            if (wanted == state).all():
                return q
            state[:] = wanted
        return None

    def _with_force(self, free: DoubleArray, state: DoubleArray) -> DoubleArray | None:
        """Return q with the force in the zones `state`, if they stay; None otherwise."""
        q = state * self.limit
        stick = np.flatnonzero(state == 0)
        if not stick.size:
            return q if abs(q.sum() - self.force) <= 1e-12 * self.limit.sum() else None
        matrix = self._stuck(stick)
        if matrix is None:
            return None
        size, scale = stick.size, self.kernel[0]
        bordered = np.zeros((size + 1, size + 1))
        bordered[:size, :size] = matrix
        bordered[:size, size] = -scale
        bordered[size, :size] = scale
        right = np.append((free - self.moved(q))[stick], scale * (self.force - q.sum()))
        *found, motion = np.linalg.solve(bordered, right)
        q[stick] = found
        slip = free + scale * motion - self.moved(q)
        slides = state != 0
        stays = (np.abs(q[stick]) <= self.limit[stick] * (1.0 + 1e-12)).all() and (state * slip >= 0.0)[slides].all()
        return q if stays else None
