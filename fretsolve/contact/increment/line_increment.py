"""Increments of a line contact: scales of the certificate without the free constant, and imposed displacements.

Displacements of a line contact are known up to a constant, so its residuals refer to A P/pi instead: by as much the
middle of Hertz's contact moves more than its edge. Imposed displacements are displacements of points at a reference
depth. Along x these points follow the surfaces by a compliance times Qx, as a rig would. How far they sink depends on
the tractions, a little on where they act, so the increment is solved again until an imposed delta_z fits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretsolve.case.keys.body_specs import Body
from fretsolve.contact.increment.certificate import Solution, Verifier
from fretsolve.contact.increment.increment import IncrementSolver, Solved
from fretsolve.contact.increment.states import InitialState, WorkingState
from fretsolve.contact.solvers.rigid_modes import GapErrors
from fretsolve.errors import NotConvergedError
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.model.materials import Compliances
from fretsolve.system.arrays import DoubleArray, FloatArray, Vector


@dataclass(frozen=True)
class PointsAtDepth:
    """The points at `depth` (mm) below the grid's middle in both bodies, to which displacements refer (L2)."""

    grid: LineGrid
    bodies: tuple[Body, Body]
    depth: float

    @cached_property
    def compliance(self) -> float:
        """By how much both points move along x under Qx of 1 N/mm (mm), far below the contact.

        Source: Johnson, Contact Mechanics (1985), eq. 5.56, for shear: the term -1/(2 (1 - nu)) changes its sign. Left
        out are terms of the order contact over depth, by a pressure beside the grid's middle.
        """
        total = 0.0
        for body in self.bodies:
            if body != "rigid":
                nu = body.poisson_ratio
                shear_modulus = body.young_modulus / (2.0 * (1.0 + nu))
                total += ((1.0 - nu) * math.log(self.depth / self.grid.log_length) + 0.5) / (math.pi * shear_modulus)
        return total

    def sinks(self, pressure: FloatArray, shear: FloatArray) -> float:
        """Return how far both points sink together (mm), from pressure (nx, 1) and shear (2, nx, 1)."""
        offset, depth = self.grid.x - self.grid.x0, self.depth
        square = offset**2 + depth**2
        total = 0.0
        for body, sign in zip(self.bodies, (-1.0, 1.0), strict=True):
            if body == "rigid":
                continue
            nu = body.poisson_ratio
            normal = depth**2 / square - (1.0 - nu) * np.log(square / self.grid.log_length**2)
            along = -offset * depth / square - (1.0 - 2.0 * nu) * np.arctan(offset / depth)
            shear_modulus = body.young_modulus / (2.0 * (1.0 + nu))
            carried = float(normal @ pressure[:, 0]) + sign * float(along @ shear[0, :, 0])
            total += carried * self.grid.dx / (2.0 * math.pi * shear_modulus)
        return total


class LineVerifier(Verifier):
    """Checks solutions of a line contact. material: its compliances; before: P, Qx, Qy at the increment's start."""

    material: Compliances
    before: Vector

    def forces(self, pressure: FloatArray, shear: FloatArray) -> Vector:
        """Return P, Qx, Qy (N/mm)."""
        side = self.grid.cell_area
        return side * np.array([pressure.sum(dtype=np.float64), *shear.sum(axis=(1, 2), dtype=np.float64)])

    def gap_errors(self, solution: Solution, gap: FloatArray) -> GapErrors:
        """Write the gap and return its errors over A P/pi."""
        errors = super().gap_errors(solution, gap)
        load = float(self.forces(solution.pressure, solution.shear)[0])
        if load <= 0.0:
            return errors
        of_layer = self.material.layer_normal * load / self._width(solution)
        return replace(errors, gap_scale=self.material.A * load / math.pi + of_layer)

    def moved(self, solution: Solution) -> Vector:
        """Return A/pi times the change of each force (mm), since the rigid displacements hold the free constant.

        A layer adds its compliance times the change of the mean traction.
        """
        changed = np.abs(self.forces(solution.pressure, solution.shear) - self.before)
        material = self.material
        moved: Vector = changed / math.pi * [material.A, material.A, material.A + material.B]
        layer = np.array([material.layer_normal, material.layer_shear, material.layer_shear])
        return moved + changed * (layer / self._width(solution))

    def _width(self, solution: Solution) -> float:
        """Return the width of the contact (mm), a strip at least."""
        return self.grid.dx * max(int(np.count_nonzero(solution.pressure)), 1)


class LineIncrementSolver(IncrementSolver):
    """Solves the increments of a line contact. points: those to which delta_z and delta_x refer, if there are any."""

    grid: LineGrid
    points: PointsAtDepth | None = None
    _verifier_type = LineVerifier

    def solve(self, increment: Increment, start: InitialState) -> Solved:
        """Solve an increment from `start` and certify it; imposed displacements hold at the points at depth."""
        increment = replace(increment, tangential=increment.tangential.with_compliance(self.in_series(increment)))
        if self.points is None or increment.normal.forced[0]:
            return super().solve(increment, start)
        wanted, *tilts = increment.normal.values
        sunk = self.points.sinks(start.pressure, start.shear)
        # each solution is nearer by about (contact/depth)^2
        for _ in range(20):
            control = replace(increment.normal, values=(wanted + sunk, *tilts))
            solved = super().solve(replace(increment, normal=control), start)
            before, sunk = sunk, self.points.sinks(solved.pressure, solved.shear)
            if abs(sunk - before) <= 0.1 * self.tolerance * abs(wanted):
                return solved
        raise NotConvergedError("no contact has the imposed delta_z: the reference depth is too near to the contact")

    def in_series(self, increment: Increment) -> DoubleArray:
        """Return the compliance (3, 3) of a rig, and of all between the surfaces and the points at depth."""
        matrix = super().in_series(increment)
        if self.points is not None and not increment.tangential.forced[0]:
            matrix[0, 0] += self.points.compliance
        return matrix

    def displacements(self, solved: Solved) -> tuple[float, float]:
        """Return delta_z and delta_x (mm) of the points at depth; NaN without any."""
        if self.points is None:
            return math.nan, math.nan
        approach = float(solved.rigid[0]) - self.points.sinks(solved.pressure, solved.shear)
        return approach, float(solved.rigid[3] + self.points.compliance * solved.resultants[3])

    def rigid_start(self, pressure: FloatArray, shear: FloatArray, rigid: Vector) -> Vector:
        """Return the rigid displacements of a state from which the next increment counts.

        delta_z follows from the tractions, since the history has it without the free constant or not at all. delta_x is
        0 without points at depth; delta_y and phi_z always are.
        rigid: from the history.
        """
        before, rigid = rigid, np.zeros(6)
        contact = pressure > 0.0
        rigid[2] = phi_y = float(before[2])
        if self.points is not None:
            rigid[3] = before[3] - self.points.compliance * float(shear[0].sum(dtype=np.float64)) * self.grid.dx
        if contact.any():
            uz, operator = np.empty(self.grid.shape), self.level.operator
            operator.normal(np.array(pressure, np.float64), uz)
            if self.model.has_shear and self.model.terms.normal_tangential_coupling:
                from_shear = np.empty_like(uz)
                operator.normal_from_shear(np.array(shear, np.float64), from_shear)
                uz += from_shear
            touching = (self.separation + uz - phi_y * self.grid.x[:, None])[contact]
            rigid[0] = float(touching.mean())
        return rigid

    def _solution(self, start: InitialState, work: WorkingState) -> Solution:
        assert isinstance(self._verifier, LineVerifier)
        self._verifier.material = self.model.compliances
        self._verifier.before = self._verifier.forces(start.pressure, start.shear)
        return super()._solution(start, work)
