"""Staggered iteration: normal and tangential problem solved in turns on one active region (Panagiotopoulos 1975).

ST1 to ST8 are the steps in docs/theory.md.
"""

from __future__ import annotations

import numpy as np

from fretsolve.contact.increment.coupled_step import coupled_problem, solve_coupled, solve_directly
from fretsolve.contact.increment.failures import (
    ADVICE,
    gross_slip_error,
    is_far,
    why_not_pressed,
    why_not_settled,
    why_not_sheared,
)
from fretsolve.contact.increment.grid_hierarchy import MOST_DIRECT_STRIPS, GridLevel
from fretsolve.contact.increment.sheared_surfaces import ShearedSurfaces
from fretsolve.contact.increment.states import FIRST_TOLERANCE, InitialState, WorkingState
from fretsolve.contact.kernels import kernels_of
from fretsolve.contact.solvers.incremental_update import add_displacement
from fretsolve.contact.solvers.normal import SolverResult
from fretsolve.contact.solvers.rigid_modes import at_the_limit, largest_error, load_factor
from fretsolve.contact.solvers.tangential import SlipScales
from fretsolve.elastic.rounding import LEAST_MOTION, ROUNDING, circle_width, least_slip, slips
from fretsolve.errors import ContactLostError, NotConvergedError
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import Increment
from fretsolve.problem.model.required_terms import Model
from fretsolve.system.arrays import TINY, FloatArray

ENOUGH_ITERATIONS = 30
"""Iterations after which pressure and shear are solved together (`fretsolve.contact.solvers.coupled_newton`) ..."""

MOST_STAGGERED_ITERATIONS = 200
"""... and, if that fails as well, after which the increment is given up (ST8)."""

CONTRACTION = 0.02
"""Typical change of an iteration over the change of the iteration before; it foresees the last iteration (ST6)."""


class StaggeredIteration:
    """Solves increments on the grid of `level`; separation: (nx, ny), undeformed; tolerance: of the certificate."""

    def __init__(self, level: GridLevel, separation: FloatArray, model: Model, max_iterations: int, tolerance: float):
        self.level, self.model, self.max_iterations, self._tolerance = level, model, max_iterations, tolerance
        self._undeformed = separation
        self._coupled = model.terms.normal_tangential_coupling and model.has_shear
        self._first = True
        shape = level.grid.shape
        if model.has_shear:
            self._elastic_slip, self._friction_limit = np.zeros((2, *shape)), np.zeros(shape)
        self._surfaces: ShearedSurfaces | None = None
        if self._coupled:
            self._surfaces, self._pressure = ShearedSurfaces(level, separation), np.zeros(shape)

    def run(self, increment: Increment, start: InitialState, work: WorkingState, target: float) -> None:
        """Iterate until pressure and shear change each other by less than `target` and both are solved to it.

        `work` is changed in place. Raises SlidingError, ContactLostError or NotConvergedError.
        """
        self._least_slip = least_slip(
            start.largest_displacement, start.rigid, self.level.grid.farthest, self._tolerance
        )
        problem, self._friction = None, start.friction
        self._control = increment.tangential.relative_to(start.rigid[3:])
        if start.friction.varied and self._holds(increment, start, work):
            return
        if self.model.has_shear and not is_far(increment.tangential, self.level.grid):
            least, precision = self._least_slip, self.level.operator.dtype
            problem = coupled_problem(self._undeformed, increment, self._control, start, work, least, precision)

        def solved_together() -> bool:
            most = self.max_iterations
            return problem is not None and solve_coupled(self.level, problem, start, work, target, most)

        # a rig may couple the motions as the surfaces do not: then both problems are solved together at once
        together = work.coupled_step or increment.coupling is not None
        if self._solved_directly(increment, start, work, target) or (together and solved_together()):
            return
        if increment.coupling is not None and self.model.has_shear:
            raise NotConvergedError(f"pressure and shear, which the rig couples, are not found together; {ADVICE}")
        # ST1: the surfaces deformed by the shear of the start
        self._begin(work, target)
        while True:
            # ST2: tolerance of a twentieth of the last change
            tolerance = max(target, 0.05 * work.change) if self._coupled else target
            # ST3: the pressure between these surfaces
            gap_error, shear_error = self._press(increment, start, work, tolerance), 0.0
            if self._must_solve_shear(increment, start, work):
                # ST4 to ST6: the shear under this pressure
                try:
                    shear_error = self._shear(increment, start, work, tolerance)
                except NotConvergedError:
                    if solved_together():
                        return
                    raise
            # ST7: the surfaces deformed by the new shear, and their change c
            self._finish(work)
            # ST8: stop, where the change leaves the gap small enough and the last shear was solved well enough: after a
            # small step the change alone says little
            if gap_error + work.change <= max(3.0 * target, ROUNDING) and shear_error <= 3.0 * target:
                return
            # else solve both together, or give up
            if work.staggered_iterations == ENOUGH_ITERATIONS:
                if solved_together():
                    return
                if self._surfaces is not None:
                    self._surfaces.begin(work, self._friction_limit)
            if work.staggered_iterations >= MOST_STAGGERED_ITERATIONS:
                raise NotConvergedError(why_not_settled(work, self.model))

    def _press(self, increment: Increment, start: InitialState, work: WorkingState, tolerance: float) -> float:
        """Solve for the pressure between the present surfaces, and return the error of the gap over its scale."""
        if not self._coupled and not work.staggered_iterations and start.normal == increment.normal:
            return 0.0
        # N1 to N8
        separation = self._undeformed if self._surfaces is None else self._surfaces.separation
        arguments = increment.normal, work.pressure, tolerance, self.max_iterations, work.rigid[:3]
        found = self.level.normal.solve(separation, *arguments, self._kept_tolerance, known=work.gap_scale > 0.0)
        self._accept_pressure(found, work, tolerance)
        return min(found.residual, tolerance)

    def _shear(self, increment: Increment, start: InitialState, work: WorkingState, tolerance: float) -> float:
        """Solve for the shear under the present pressure, and return the error of the slip over its scale.

        tolerance: the least one. Raises SlidingError, NotConvergedError.
        """
        # ST4: friction limit b, such as mu p, and loads that it can carry (T12)
        self._friction.limit(work.pressure, out=self._friction_limit)
        control = self._carried(increment, start, work)
        # ST5: elastic slip at the new pressure
        tolerance, scales = self._slip_scales(start, work, tolerance)
        self._take_elastic_slip(start, work)
        # ST6: TG1 to TG8 at the new pressure
        arguments = self._elastic_slip, control, self._friction_limit, work.shear
        found = self.level.tangential.solve(*arguments, tolerance, self.max_iterations, scales)
        self._last_slip_scale = found.scale
        work.iterations_tangential += found.iterations
        work.rigid[3:] = start.rigid[3:] + found.rigid
        if not found.converged:
            solver, limit, most = self.level.tangential, self._friction_limit, self.max_iterations
            raise NotConvergedError(why_not_sheared(solver, self.level.grid, found, tolerance, control, limit, most))
        return min(found.residual, tolerance)

    def _solved_directly(self, increment: Increment, start: InitialState, work: WorkingState, target: float) -> bool:
        """Solve an increment with few strips in contact as a whole, if that succeeds and nothing has been tried yet."""
        # A small grid begins to touch under shear, with no estimate of the pressure. The estimate saves a third of the
        # time of such increments where it lets them be solved directly.
        touches = start.normal != increment.normal and not work.pressure.any()
        small = self.level.coarser is None and self.level.grid.nx <= 2 * MOST_DIRECT_STRIPS
        first = touches and self.model.has_shear and small
        if (
            not (first or self._few_touch(work))
            or work.staggered_iterations
            or is_far(increment.tangential, self.level.grid)
            or increment.normal.compliance is not None
            or increment.coupling is not None
        ):
            return False
        solver = self.level.direct
        if solver is None:
            return False
        if first:
            self._touch(increment, work)
            if not self._few_touch(work):
                return False
        arguments = self._undeformed, increment, self._control, start, work, self._least_slip
        problem = coupled_problem(*arguments, self.level.operator.dtype)
        presses = self._coupled or start.normal != increment.normal
        slides = self._must_solve_shear(increment, start, work)
        return solve_directly(solver, problem, start, work, target, presses=presses, slides=slides)

    def _few_touch(self, work: WorkingState) -> bool:
        return 0 < int(np.count_nonzero(work.pressure)) <= MOST_DIRECT_STRIPS

    def _touch(self, increment: Increment, work: WorkingState) -> None:
        """Estimate the pressure of a first contact without shear, as coarser grids do where there are any."""
        loads = increment.normal, work.pressure, FIRST_TOLERANCE, self.max_iterations, work.rigid[:3]
        found = self.level.normal.solve(self._undeformed, *loads)
        work.iterations_normal += found.iterations
        work.rigid[:3] = found.rigid

    def _holds(self, increment: Increment, start: InitialState, work: WorkingState) -> bool:
        """Return whether the start is the solution: nothing imposed changes, and its shear is within friction."""
        control = self._control
        if start.normal != increment.normal or start.mismatch is not None or increment.coupling is not None:
            return False
        if not self.model.has_shear or not np.array_equal(work.shear, start.shear):
            return False
        limit = self._friction.limit(work.pressure, out=self._friction_limit)
        allowed = circle_width(self.level.operator.dtype) * float(limit.max())
        if kernels_of(self.level.operator).friction.excess(work.shear, limit) > allowed:
            return False
        if control.displacement(self.level.tangential.modes.resultants(work.shear)).any():
            return False
        if not control.forced_index:
            return True
        modes, capacity = self.level.tangential.modes, float(limit.sum()) * self.level.grid.cell_area or TINY
        unbalance = largest_error(modes.resultants(work.shear), control, capacity, modes.arms[3:])
        return unbalance <= self._tolerance

    def _begin(self, work: WorkingState, target: float) -> None:
        """Start with slip zone and separation of the tractions in `work`."""
        self._target, self._last_slip_scale, self._first = target, 0.0, True
        work.gap_scale = 0.0
        if self.model.has_shear:
            limit = self._friction.limit(work.pressure, out=self._friction_limit)
            self.level.tangential.slipping[:] = slips(work.shear, limit, circle_width(self.level.operator.dtype))
        if self._surfaces is not None:
            np.copyto(self._pressure, work.pressure)
            self._surfaces.begin(work, self._friction_limit)  # ST4 computes the friction limit anew
            work.change = FIRST_TOLERANCE

    def _finish(self, work: WorkingState) -> None:
        """Count an iteration, and update the separation and its change for the new shear."""
        self._first = False
        work.staggered_iterations += 1
        before, work.change = work.change, 0.0
        if self._surfaces is None:
            return
        work.change = self._surfaces.follow(work, self._kept_tolerance * work.gap_scale, self._friction_limit)
        # from the second iteration on, as at first the zones still move
        if work.staggered_iterations > 1 and work.change > 0.1 * before:
            self._surfaces.accelerate()

    @property
    def _kept_tolerance(self) -> float:
        """Tolerance that limits the rounding of reused displacements; 0 with acceleration, which would magnify it."""
        return 0.0 if self._surfaces is not None and self._surfaces.accelerated else self._target

    def _accept_pressure(self, found: SolverResult, work: WorkingState, tolerance: float) -> None:
        """Write the result of the normal problem into `work`, or raise an error if it is not solved."""
        work.iterations_normal += found.iterations
        work.rigid[:3] = found.rigid
        work.gap_scale = found.scale
        if found.converged:
            return
        if not work.pressure.any():
            raise ContactLostError("a moment is imposed where delta_z lifts the body off; impose P or a tilt instead")
        raise NotConvergedError(why_not_pressed(found, tolerance))

    def _must_solve_shear(self, increment: Increment, start: InitialState, work: WorkingState) -> bool:
        """Return whether there is shear to solve for; else set the tangential rigid displacements."""
        imposed = increment.tangential
        if self.model.has_shear:
            if self._coupled or start.shear.any() or start.displacement.any():
                return True
            if any(self._control.values):
                return True
        elif self.model.friction == 0.0 and imposed.imposed_resultant.any():
            raise gross_slip_error(imposed, 0.0, 0.0, self.model.line, rig=self.model.rig)
        motion = imposed.imposed_displacement
        if increment.coupling is not None:  # the pressure alone bends the rig
            motion = motion - increment.coupling.T @ self.level.normal.modes.resultants(work.pressure)
        work.rigid[3:] = np.where(imposed.forced, start.rigid[3:], motion)
        return False

    def _carried(self, increment: Increment, start: InitialState, work: WorkingState) -> LoadControl:
        """Return what is imposed on the tangential problem, as increments.

        A load that friction cannot carry is an error once the pressure is settled; before, it is cut to just below the
        limit load.
        """
        imposed, control = increment.tangential, self._control
        enough = 1.0 + at_the_limit(self.level.operator.dtype)
        factor = load_factor(self._friction_limit, control, self.level.tangential.modes, enough)
        if factor > enough:
            return control
        lifted = not self._friction_limit.any() and not work.shear.any()  # no shear can bring the contact back
        settled = not self._coupled or work.change < 1e-4 or lifted
        only_forces = increment.normal.forced[0] and not imposed.forced[2]  # then the limit load is mu P from the start
        if settled or only_forces:
            capacity = float(self._friction_limit.sum()) * self.level.grid.cell_area
            varied, rig = start.friction.varied, self.model.rig
            raise gross_slip_error(imposed, factor, capacity, self.model.line, varied, rig)
        return control.with_loads_scaled(0.999 * factor)

    def _slip_scales(self, start: InitialState, work: WorkingState, tolerance: float) -> tuple[float, SlipScales]:
        """Return the tolerance of the shear and the scales of slips.

        The tolerance is a hundredth of the slip error that the last change caused, and at least `tolerance`; if the
        next change is expected to be small enough to stop (ST8), it is `tolerance`.
        """
        moved: list[float] = (np.abs(work.rigid - start.rigid) * self.level.tangential.modes.arms).tolist()
        elastic, least = start.largest_displacement, self._least_slip
        mismatch = start.largest_mismatch(work.pressure)
        motion = max(*moved[:3], mismatch, LEAST_MOTION * elastic, least)
        if self._coupled and CONTRACTION * work.change > 2.0 * self._target:
            disturbed = work.change * work.gap_scale / max(motion, *moved[3:], TINY)
            tolerance = max(tolerance, min(0.01 * disturbed, FIRST_TOLERANCE))
        return tolerance, SlipScales(motion, least, elastic, self._last_slip_scale, self._kept_tolerance)

    def _take_elastic_slip(self, start: InitialState, work: WorkingState) -> None:
        slip, operator = self._elastic_slip, self.level.operator
        if self._first and work.elastic_slip is not None:
            slip[:] = work.elastic_slip
        elif self._first:
            operator.tangential(work.shear, slip)
            np.subtract(start.displacement, slip, out=slip)
            if self._coupled:
                displacement = self.level.tangential.workspace.double
                operator.tangential_from_pressure(work.pressure, displacement)
                slip -= displacement
                np.copyto(self._pressure, work.pressure)
        if self._coupled:
            workspace = self.level.tangential.workspace
            change = np.subtract(work.pressure, self._pressure, out=workspace.double[:1])
            np.copyto(self._pressure, work.pressure)
            allowed = self._kept_tolerance * self._last_slip_scale
            add_displacement(operator, type(operator).tangential_from_pressure, slip, change, workspace, allowed, -1.0)
