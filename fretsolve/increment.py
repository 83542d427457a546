"""One increment: normal and tangential problem alternated until the certificate holds (Panagiotopoulos 1975).

The normal problem is solved at the shear of the last pass, the tangential one at the new pressure. While shear and
pressure still move each other, both are solved only a little more exactly than the last change; so all passes
together cost little more than one exact solve.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.certificate import ON_THE_CIRCLE, Evidence, Examiner, Solution
from fretsolve.errors import NotConvergedError
from fretsolve.feasibility import require_inside, require_supported, sliding_error
from fretsolve.grid import Grid
from fretsolve.level import Level
from fretsolve.load_path import Increment
from fretsolve.model import Model
from fretsolve.modes import Balance, TangentialModes, Vector
from fretsolve.sliding import AT_THE_LIMIT, load_factor
from fretsolve.state import Certificate

FloatArray = NDArray[np.floating]

FIRST_TOLERANCE = 1e-2
"""Of the first pass of a coupled increment."""

PASS_REDUCTION = 0.05
"""How much more exactly than the last pass's change a pass is solved."""

MOST_ALTERNATIONS = 200

MARGIN = 0.3
"""The solvers' own tolerance in units of the case's: their residuals and the certificate's differ a little."""


@dataclass(frozen=True)
class Start:
    """What an increment starts from: tractions, tangential displacement, and rigid displacements.

    pressure: (nx, ny); shear, displacement: (2, nx, ny); rigid: delta_z, phi_x, phi_y, delta_x, delta_y, phi_z.
    """

    pressure: FloatArray
    shear: FloatArray
    displacement: FloatArray
    rigid: Vector
    normal: Balance | None = None


@dataclass(frozen=True)
class Solved:
    """A certified increment and what it took. normal, tangential: resultants (P, Mx, My) and (Qx, Qy, Mz)."""

    solution: Solution
    evidence: Evidence
    normal: Vector
    tangential: Vector
    iterations_normal: int
    iterations_tangential: int
    alternations: int
    operator_applications: int


@dataclass
class _Iterate:
    """What the passes change: tractions, rigid displacements and the counts.

    approach: length that the gap is measured against (mm).
    """

    pressure: FloatArray
    shear: FloatArray
    rigid: Vector
    approach: float = 0.0
    certificate: Certificate | None = None
    iterations_normal: int = 0
    iterations_tangential: int = 0
    alternations: int = 0


class IncrementSolver:
    """Solvers and operator of one scene: a grid, a model and the undeformed surfaces."""

    def __init__(
        self,
        grid: Grid,
        separation: FloatArray,
        model: Model,
        tolerance: float,
        max_iterations: int,
        threads: int = 1,
    ):
        self.grid, self.separation, self.model = grid, separation, model
        self.tolerance, self.max_iterations = tolerance, max_iterations
        self.level = Level(grid, model, threads)
        self.operator, self.normal, self.tangential = self.level.operator, self.level.normal, self.level.tangential
        self._examiner = Examiner(separation, model.friction, self.normal.modes, TangentialModes(grid))
        self._separation = np.array(separation) if model.terms.coupled else separation
        self._known = np.zeros((2, *grid.shape))
        self._bound = np.zeros(grid.shape)

    def solve(self, increment: Increment, start: Start) -> Solved:
        """Solve an increment from `start` and prove it.

        Raises SlidingError, ContactLostError, GridEdgeError or NotConvergedError.
        """
        before = self.level.applications
        require_supported(increment.normal, self.separation, self.grid)
        work = _Iterate(start.pressure.copy(), start.shear.copy(), start.rigid.copy())
        target, change = MARGIN * self.tolerance, FIRST_TOLERANCE
        coupled = self.model.terms.coupled and self.model.sheared
        if self.tangential is not None:
            bound = np.multiply(start.pressure, self.model.friction * (1.0 - ON_THE_CIRCLE), out=self._bound)
            np.greater_equal(np.hypot(start.shear[0], start.shear[1]), bound, out=self.tangential.slipping)
        if coupled:
            self._couple_normal(work)
        while True:
            tolerance = max(target, PASS_REDUCTION * change) if coupled else target
            self._normal_pass(increment, start, work, tolerance)
            settled = not coupled or change < FIRST_TOLERANCE
            self._tangential_pass(increment, start, work, tolerance, settled)
            work.alternations += 1
            change = self._couple_normal(work) if coupled else 0.0
            if change <= target:
                solved = self._proved(increment, start, work, before)
                if solved is not None:
                    return solved
                target *= MARGIN
            if work.alternations >= MOST_ALTERNATIONS or target < MARGIN**4 * self.tolerance:
                raise NotConvergedError(_unproved(work, change, self.tolerance))

    def _proved(self, increment: Increment, start: Start, work: _Iterate, before: float) -> Solved | None:
        """The solution with its evidence, None where the certificate is not met."""
        uz, displacement = np.zeros(self.grid.shape), np.zeros((2, *self.grid.shape))
        if self.model.terms.tangential:
            self.operator.all(work.pressure, work.shear, uz, displacement)
        else:
            self.operator.normal(work.pressure, uz)
        solution = Solution(
            work.pressure, work.shear, uz, displacement, work.rigid, work.rigid - start.rigid, start.displacement
        )
        evidence = self._examiner.examine(solution, increment.normal, increment.tangential)
        work.certificate = evidence.certificate
        if not evidence.certificate.worst <= self.tolerance:
            return None
        require_inside(work.pressure, self.grid)
        spent = math.ceil(self.level.applications - before)
        return Solved(
            solution,
            evidence,
            self._examiner.normal.resultants(work.pressure),
            self._examiner.tangential.resultants(work.shear),
            work.iterations_normal,
            work.iterations_tangential,
            work.alternations,
            spent,
        )

    def _normal_pass(self, increment: Increment, start: Start, work: _Iterate, tolerance: float) -> None:
        unchanged = start.normal == increment.normal and work.alternations == 0
        if unchanged and not self.model.terms.coupled:
            return
        separation = self._separation if self.model.sheared else self.separation
        if work.alternations == 0 and not unchanged:
            self.level.estimate_normal(separation, increment.normal, work.pressure, work.rigid[:3])
        result = self.normal.solve(
            separation, increment.normal, work.pressure, tolerance, self.max_iterations, work.rigid[:3]
        )
        work.iterations_normal += result.iterations
        work.rigid[:3] = result.rigid
        work.approach = result.scale
        if not result.converged:
            raise NotConvergedError(
                f"the normal problem is not solved after {result.iterations} iterations: the largest gap error is"
                f" {result.residual:.2g} of delta_z, {tolerance:.2g} is needed; {_ADVICE}"
            )

    def _tangential_pass(
        self, increment: Increment, start: Start, work: _Iterate, tolerance: float, settled: bool
    ) -> None:
        if self.tangential is None:
            self._slide_without_friction(increment, start, work)
            return
        np.multiply(work.pressure, self.model.friction, out=self._bound)
        balance = self._carried(increment, start, settled)
        if self.model.terms.coupled:
            self.operator.tangential_from_pressure(work.pressure, self._known)
            np.subtract(start.displacement, self._known, out=self._known)
        else:
            self._known[:] = start.displacement
        motion = work.rigid[:3] - start.rigid[:3]
        reach = max(self.grid.size) / 2
        largest = max(abs(motion[0]), abs(motion[1]) * reach, abs(motion[2]) * reach)
        unlike_the_last = start.normal != increment.normal or not work.shear.any()
        if work.alternations == 0 and unlike_the_last:
            self.level.estimate_tangential(self._known, balance, self._bound, work.shear, largest)
        result = self.tangential.solve(
            self._known, balance, self._bound, work.shear, tolerance, self.max_iterations, largest
        )
        work.iterations_tangential += result.iterations
        work.rigid[3:] = start.rigid[3:] + result.rigid
        if not result.converged:
            raise NotConvergedError(
                f"the tangential problem is not solved after {result.iterations} iterations: the largest slip error"
                f" is {result.residual:.2g} of the rigid displacement, {tolerance:.2g} is needed; {_ADVICE}"
            )

    def _carried(self, increment: Increment, start: Start, settled: bool) -> Balance:
        """The tangential balance as increments; a load that friction cannot carry is an error once the pressure is
        settled, and cut to what it can carry while it is not."""
        imposed = increment.tangential
        balance = imposed.relative_to(start.rigid[3:])
        factor = load_factor(self._bound, balance, self._examiner.tangential)
        if factor > 1.0 + AT_THE_LIMIT:
            return balance
        only_forces = increment.normal.forced[0] and not imposed.forced[2]
        if settled or only_forces:
            raise sliding_error(imposed, factor, float(self._bound.sum()) * self.grid.cell_area)
        return balance.with_loads_scaled(0.9 * factor)

    def _slide_without_friction(self, increment: Increment, start: Start, work: _Iterate) -> None:
        imposed = increment.tangential
        if self.model.friction == 0.0 and imposed.imposed_resultant.any():
            raise sliding_error(imposed, 0.0, 0.0)
        work.rigid[3:] = np.where(imposed.forced, start.rigid[3:], imposed.imposed_displacement)

    def _couple_normal(self, work: _Iterate) -> float:
        """Separation as the shear deforms it; its largest change in the contact over the approach."""
        uz, separation = self._bound, self._separation
        self.operator.normal_from_shear(work.shear, uz)
        np.add(self.separation, uz, out=uz)
        contact = work.pressure > 0.0
        np.subtract(uz, separation, out=separation, where=contact)
        change = float(np.max(np.abs(separation), where=contact, initial=0.0))
        separation[:] = uz
        return change / (work.approach or 1.0)


def _unproved(work: _Iterate, change: float, tolerance: float) -> str:
    """Why an increment is given up."""
    if work.certificate is None:
        return (
            f"pressure and shear still change each other after {work.alternations} alternations, by {change:.2g} of"
            f" delta_z; {_ADVICE}"
        )
    residuals = {name: getattr(work.certificate, name) for name in ("gap", "stick", "slip", "bound", "load")}
    name = max(residuals, key=lambda key: residuals[key])
    return (
        f"the certificate is not met: residual_{name} is {residuals[name]:.2g}, {tolerance:.2g} is needed; {_ADVICE}"
    )


_ADVICE = "raise solver.max_iterations, loosen solver.tolerance, or take more increments"
