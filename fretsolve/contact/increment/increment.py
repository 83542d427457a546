"""One increment: solved on the active region around the contact, certified on all of its grid."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.contact.increment.active_region import FREE_CELLS, ActiveRegion, region_around
from fretsolve.contact.increment.certificate import Solution, Verification, Verifier
from fretsolve.contact.increment.failures import ADVICE, TOO_FEW_DIGITS, require_inside, require_supported
from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.contact.increment.staggered_iteration import StaggeredIteration
from fretsolve.contact.increment.states import InitialState, WorkingState
from fretsolve.contact.kernels import kernels_of
from fretsolve.elastic.kernels import NUMPY, Kernels
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import NoSolutionError, NotConvergedError, SlidingError
from fretsolve.problem.model.grid import LARGE_GRID, Grid, HalfGrid
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.model.required_terms import Model
from fretsolve.result.state import Certificate, broadcast_zeros
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

SOLVER_TOLERANCE_SHARE = 0.3
"""Tolerance of the solvers over the case's tolerance: residuals of solvers and certificate differ a little."""


@dataclass(frozen=True)
class Solved(Solution, Verification):
    """A certified increment and its cost.

    operator_applications: in parts of one on the whole grid where they are on smaller grids, rounded up.
    """

    iterations_normal: int
    iterations_tangential: int
    staggered_iterations: int
    operator_applications: int


class IncrementSolver:
    """Solves the increments of one problem: grid, model, and separation (nx, ny) of the undeformed surfaces."""

    _verifier_type: type[Verifier] = Verifier

    def __init__(
        self,
        grid: Grid,
        separation: DoubleArray,
        model: Model,
        tolerance: float,
        max_iterations: int,
        threads: int = 1,
        map_border: BoolArray | None = None,
        precision: type[np.floating] = np.float64,
        kernels: Kernels = NUMPY,
    ):
        self.grid, self.separation, self.model, self._map_border = grid, separation, model, map_border
        self.tolerance, self.max_iterations = tolerance, max_iterations
        self._precision, self._single = precision, precision is np.float32
        self.team = ThreadTeam(threads, kernels)
        self.level = GridLevel(grid, model, self.team, precision)
        self._verifier = self._verifier_type(
            separation, model.friction, grid, tolerance, model.may_slip, precision, kernels_of(self.level.operator)
        )
        self._iterations: dict[ActiveRegion, StaggeredIteration] = {}
        self._spent = 0.0
        self._large = math.prod(grid.whole_shape) > LARGE_GRID

    def solve(self, increment: Increment, start: InitialState) -> Solved:
        """Solve an increment from `start` and certify it.

        Raises SlidingError, ContactLostError, GridEdgeError or NotConvergedError.
        """
        before = self.applications
        if start.prediction is not None:
            with suppress(NoSolutionError):  # then the start itself may be nearer to the solution
                return self._solve(increment, start, before)
            start = replace(start, prediction=None)
        try:
            return self._solve(increment, start, before)
        except NotConvergedError:
            if start.normal == increment.normal or not start.pressure.any():
                raise
        # as if nothing had touched before, since the contact may move by more than its size
        return self._solve(increment, start, before, afresh=True)

    def _solve(self, increment: Increment, start: InitialState, before: float, afresh: bool = False) -> Solved:
        """Solve an increment from `start`; before: applications before it; afresh: with no pressure as an estimate."""
        target, free = SOLVER_TOLERANCE_SHARE * self.tolerance, FREE_CELLS
        require_supported(increment.normal, self.separation, self.grid)
        work = self._estimate(increment, start, afresh)
        expected = work.pressure > 0.0
        for _ in range(12):
            # solve on a region that holds the expected contact, and on a larger one if the contact leaves it
            region, iteration = self._region_for(expected, free)
            part = self._enter(region, start, work)
            iteration.run(increment, part, work, target)
            self._leave(region, work)
            self._release(iteration.level)
            expected |= work.pressure > 0.0
            if not region.holds(expected):
                free *= 4
                continue
            # C1: displacements of the tractions on the whole grid; C2 to C6: the certificate
            solution = self._solution(start, work)
            verified = self._verifier.verify(solution, increment.normal, increment.tangential, increment.coupling)
            if verified.certificate.worst <= self.tolerance:
                require_inside(work.pressure, self.grid, self._map_border)
                return Solved(
                    **vars(solution),
                    **vars(verified),
                    iterations_normal=work.iterations_normal,
                    iterations_tangential=work.iterations_tangential,
                    staggered_iterations=work.staggered_iterations,
                    operator_applications=math.ceil(round(self.applications - before, 6)),
                )
            # C7: try again with a larger region or a tighter target, unless rounding is the cause
            rounding = self._verifier.lost_in_rounding(solution, verified)
            if rounding:
                break
            expected |= verified.gap < 0.0
            if region.holds(expected):
                target *= SOLVER_TOLERANCE_SHARE
        raise NotConvergedError(self._why_not_certified(verified.certificate, rounding))

    def in_series(self, increment: Increment) -> DoubleArray:
        """Return the compliance (3, 3) in series with the tangential motions that an increment imposes."""
        return increment.tangential.matrix

    @property
    def applications(self) -> float:
        """Operator applications so far, in parts of one on the whole grid."""
        inside = sum(
            iteration.level.applications * region.count / (self.grid.nx * self.grid.ny)
            for region, iteration in self._iterations.items()
            if iteration.level is not self.level
        )
        return self.level.applications + inside + self._spent

    def _estimate(self, increment: Increment, start: InitialState, afresh: bool) -> WorkingState:
        """Return a copy of the start, with a pressure estimated on coarser grids if the normal load changes.

        afresh: from no pressure.
        """
        slip = broadcast_zeros(start.shear.shape) if start.mismatch is None else -start.mismatch
        work = WorkingState(np.array(start.pressure, np.float64), self._own(start.shear), start.rigid.copy(), slip)
        if start.normal != increment.normal:
            self._estimate_pressure(increment, work, afresh)
        if start.prediction is not None:
            start.prediction.apply(work)
        return work

    def _estimate_pressure(self, increment: Increment, work: WorkingState, afresh: bool) -> None:
        """Estimate the pressure and the normal motion in `work` on coarser grids."""
        if afresh:
            work.pressure[:] = 0.0
        separation = self.separation
        if self.model.terms.normal_tangential_coupling and work.shear.any():
            uz = np.empty_like(work.pressure)
            self.level.operator.normal_from_shear(work.shear, uz)
            separation = np.add(separation, uz, out=uz)
            self._release(self.level)
        self.level.estimate_normal(separation, increment.normal, work.pressure, work.rigid[:3])
        self._release(self.level)
        work.elastic_slip = None

    def _release(self, level: GridLevel) -> None:
        """Free the memory of a part of an increment, on a large grid, before the next part needs its own."""
        if self._large:
            level.release()
            self.team.release()

    def _region_for(self, expected: BoolArray, free: int) -> tuple[ActiveRegion, StaggeredIteration]:
        """Return a region that holds the expected contact, and the staggered iteration on it.

        Those of the last two regions are kept, on a large grid of one: a contact that changes between two sizes needs
        no new spectra at each increment.
        """
        region = region_around(expected, free, isinstance(self.grid, HalfGrid))
        iteration = self._iterations.pop(region, None)
        if iteration is None:
            if len(self._iterations) == (1 if self._large else 2):
                before = self.applications
                del self._iterations[next(iter(self._iterations))]
                self._spent += before - self.applications
            level = self.level
            if region.count < self.grid.nx * self.grid.ny:
                part = region.part_of(self.grid)
                whole = None if self._large else self.level.operator
                level = GridLevel(part, self.model, self.team, self._precision, whole)
            separation = self.separation[region.cells]
            iteration = StaggeredIteration(level, separation, self.model, self.max_iterations, self.tolerance)
        self._iterations[region] = iteration
        return region, iteration

    def _enter(self, region: ActiveRegion, start: InitialState, work: WorkingState) -> InitialState:
        """Cut the tractions of `work` to a region, and return that part of `start`."""
        cells = region.cells
        if work.elastic_slip is None and self._single:
            work.elastic_slip = -self._moved(start, work)
        work.elastic_slip = None if work.elastic_slip is None else work.elastic_slip[cells]
        mismatch = None if start.mismatch is None else start.mismatch[cells]
        work.pressure, work.shear = work.pressure[cells].copy(), self._own(work.shear[cells])
        pressure, shear, displacement = start.pressure[cells], start.shear[cells], start.displacement[cells]
        friction = start.friction.part(cells)
        return InitialState(pressure, shear, displacement, start.rigid, friction, start.normal, mismatch)

    def _leave(self, region: ActiveRegion, work: WorkingState) -> None:
        pressure, shear = np.zeros(self.grid.shape), broadcast_zeros((2, *self.grid.shape))
        pressure[region.cells] = work.pressure
        if self.model.may_slip:
            shear = np.zeros(shear.shape)
            shear[region.cells] = work.shear
        work.pressure, work.shear, work.elastic_slip = pressure, shear, None

    def _own(self, shear: FloatArray) -> FloatArray:
        """Return a copy to work in, if there may be shear."""
        return np.array(shear, np.float64) if self.model.may_slip else shear

    def _solution(self, start: InitialState, work: WorkingState) -> Solution:
        """Return the tractions, rounded to the precision that is stored, and their displacements on the whole grid."""
        if self._single:
            work.pressure = work.pressure.astype(np.float32).astype(np.float64)
            if self.model.may_slip:
                work.shear = work.shear.astype(np.float32).astype(np.float64)
        uz, displacement = np.zeros(self.grid.shape), broadcast_zeros((2, *self.grid.shape))
        terms, operator = self.model.terms, self.level.operator
        if terms.tangential or terms.normal_tangential_coupling:
            displacement = np.zeros(displacement.shape)
        if self.model.has_shear and (terms.normal_tangential_coupling or work.shear.any()):
            operator.all(work.pressure, work.shear, uz, displacement)
        else:
            operator.normal(work.pressure, uz)
            if terms.normal_tangential_coupling:
                operator.tangential_from_pressure(work.pressure, displacement)
        previous = displacement - self._moved(start, work) if self._single else start.displacement
        if self._large:
            self.team.release()
        motion = work.rigid - start.rigid
        mismatch = start.largest_mismatch(work.pressure)
        tractions = work.pressure, work.shear
        return Solution(*tractions, uz, displacement, work.rigid, motion, previous, start.friction, mismatch)

    def _moved(self, start: InitialState, work: WorkingState) -> FloatArray:
        """Return the change (2, nx, ny) of the tangential displacement since the start, and the mismatch added to it.

        It follows from the change of the tractions: in single precision the difference of two displacements loses it.
        """
        moved, operator = work.shear - start.shear, self.level.operator
        if moved.any():
            operator.tangential(moved, moved)
        if self.model.terms.normal_tangential_coupling:
            sideways = np.empty_like(moved)
            operator.tangential_from_pressure(work.pressure - start.pressure, sideways)
            moved += sideways
        if start.mismatch is not None:
            moved += start.mismatch
        return moved

    def _why_not_certified(self, certificate: Certificate, rounding: str) -> str:
        """Return why an increment is given up; rounding: in words, where it is the cause."""
        residuals = vars(certificate)
        name = max(residuals, key=lambda key: residuals[key])
        missed = f"the certificate is not met: residual_{name} is {residuals[name]:.2g}, {self.tolerance:.2g} is needed"
        if rounding:
            return f"{missed}; the error is {rounding}, so more iterations do not help: loosen solver.tolerance"
        return f"{missed}; {TOO_FEW_DIGITS if self._single else ''}{ADVICE}"


class OrthotropicIncrementSolver(IncrementSolver):
    """Solves increments under friction with two coefficients, in scaled shear tractions and slips (`Orthotropy`).

    Start and result are in true tractions and slips; the certificate refers to the scaled problem.
    """

    def solve(self, increment: Increment, start: InitialState) -> Solved:
        """Solve an increment from `start` and certify it; as `IncrementSolver.solve`."""
        scale = self.model.orthotropy
        assert scale is not None
        scaled_start = replace(
            start,
            shear=scale.inverse.times(start.shear),
            displacement=scale.times(start.displacement),
            rigid=scale.times_motion(start.rigid),
            mismatch=None if start.mismatch is None else scale.times(start.mismatch),
        )
        coupling = None if increment.coupling is None else increment.coupling @ scale.matrix
        scaled = replace(increment, tangential=scale.scaled(increment.tangential), coupling=coupling)
        try:
            solved = super().solve(scaled, scaled_start)
        except SlidingError as error:
            # the loads in the message, and the limit in brackets, are the scaled ones
            loads = zip(("Qx", "Qy"), increment.tangential.imposed_resultant, strict=False)
            named = ", ".join(f"{name} = {load:.6g} N" for name, load in loads if load)
            carried = re.sub(r" \(.*?\)", "", error.message.partition(":")[2], count=1)
            error.message = f"gross slip under {named}:{carried}"
            raise
        shear = scale.times(solved.shear)
        return replace(
            solved,
            shear=shear,
            displacement=scale.inverse.times(solved.displacement),
            previous_displacement=start.displacement,
            rigid=scale.inverse.times_motion(solved.rigid),
            motion=scale.inverse.times_motion(solved.motion),
            slip=scale.inverse.times(solved.slip),
            resultants=np.concatenate([solved.resultants[:3], self._verifier.tangential.resultants(shear)]),
        )
