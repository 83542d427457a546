"""The passes of an increment: normal and tangential problem alternated (Panagiotopoulos 1975) on one window.

The normal problem is solved at the shear of the last pass, the tangential one at the new pressure. While shear and
pressure still move each other, both are solved only a little more exactly than the last change; so all passes
together cost little more than one exact solve.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fretsolve.elastic.rounding import LEAST_MOTION, ROUNDING, TINY, circle_width
from fretsolve.errors import ContactLostError, NotConvergedError
from fretsolve.increment.coupled_step import JointPass, Reference
from fretsolve.increment.grid_hierarchy import Level
from fretsolve.increment.load_checks import sliding_error
from fretsolve.increment.working_state import FIRST_TOLERANCE, Iterate, Start
from fretsolve.model.load_control import LoadControl
from fretsolve.model.load_path import Increment
from fretsolve.solvers.anderson import Mixing
from fretsolve.solvers.limit_load import at_the_limit, load_factor
from fretsolve.solvers.rigid_modes import TangentialModes
from fretsolve.solvers.tangential import SlipScales, TangentialResult
from fretsolve.system.arrays import FloatArray

if TYPE_CHECKING:
    from fretsolve.model.required_terms import Model


PASS_REDUCTION = 0.05
"""How much more exactly than the last pass's change a pass is solved."""

SHEAR_REDUCTION = 0.01
"""The same for the shear alone, against the slip error that the pressure's last change made."""

EXACT_ENOUGH = 3.0
"""The last pass is solved to this many targets at least: after a small step the change alone says little."""

SETTLED = 1e-4
"""Change below which the pressure tells what friction can carry. Before, a load beyond it is cut to just below it."""

SLOW = 0.1
"""Ratio of one change to the last from which on the passes are mixed (`fretsolve.solvers.anderson`) ..."""

FEWEST_PLAIN = 1
"""... after these many plain ones: at first the zones still move."""

CUT = 0.999

NEXT_TO_SLIDING = 1e-3
"""Distance of the loads from sliding, relative to them, that is named where no solution is found."""

FAR = 1e4
"""Distance from the origin, in sizes of the area, from which on a torque about it is a matter of rounding."""

ENOUGH_ALTERNATIONS = 30
"""Passes after which pressure and shear are solved together (`fretsolve.solvers.coupled_newton`) ..."""

MOST_ALTERNATIONS = 200
"""... or, where that fails as well, passes after which the increment is given up."""

EASIER = "loosen solver.tolerance, or take more increments"
TOO_FEW_DIGITS = "what changes may be too little for solver.precision: single, take double; else "

ADVICE = f"raise solver.max_iterations, {EASIER}"


class Alternation:
    """Passes on the grid of `level` between surfaces of `separation` (nx, ny); tolerance: of the certificate."""

    def __init__(
        self, level: Level, separation: FloatArray, model: Model, max_iterations: int, tolerance: float
    ):
        self._tolerance = tolerance
        self.level, self.model, self.max_iterations = level, model, max_iterations
        self._undeformed = separation
        self._coupled = model.terms.normal_tangential_coupling and model.has_shear
        self._separation = np.array(separation) if self._coupled else separation
        self._tangential_modes = TangentialModes(level.grid)
        self._joint = JointPass(level, separation, model, max_iterations)
        self._mixing: Mixing | None = None
        shape = level.grid.shape
        if model.has_shear:
            self._elastic_slip = np.zeros((2, *shape))
            self._bound = np.zeros(shape)
        if self._coupled:
            self._uz, self._pressure, self._shear = np.zeros((1, *shape)), np.zeros(shape), np.zeros((2, *shape))

    def run(self, increment: Increment, start: Start, work: Iterate, target: float) -> None:
        """Pass until pressure and shear change each other by less than `target` and both are solved to it.

        `work` is changed in place. Raises SlidingError or NotConvergedError.
        """
        reference = Reference.of(start, work, self.level.operator.dtype) if self.model.has_shear else None
        self._least_slip = start.least_slip(self.level.grid, self._tolerance)

        def solve_jointly() -> bool:
            if reference is None or self._is_far(increment.tangential):
                return False
            return self._joint.solve(increment, start, work, reference, target, self._least_slip)

        if work.jointly and solve_jointly():
            return
        self._mixing, self._target, self._slip_scale, passes = None, target, 0.0, 0
        if self.model.has_shear:
            self._mark_slipping(work)
        if self._coupled:
            np.copyto(self._pressure, work.pressure)
            self._couple_normal(work, first=True)
            work.change = FIRST_TOLERANCE
        while True:
            tolerance = max(target, PASS_REDUCTION * work.change) if self._coupled else target
            settled = not self._coupled or work.change < SETTLED
            self._normal_pass(increment, start, work, tolerance, passes == 0)
            try:
                tolerance = self._tangential_pass(increment, start, work, tolerance, settled, passes == 0)
            except NotConvergedError:
                if solve_jointly():
                    return
                raise
            passes += 1
            work.alternations += 1
            work.at_start = False
            before = work.change
            work.change = self._couple_normal(work) if self._coupled else 0.0
            if self._mixing is None and work.alternations > FEWEST_PLAIN and work.change > SLOW * before:
                self._mixing = Mixing()
            if work.change <= max(target, ROUNDING) and tolerance <= EXACT_ENOUGH * target:
                return
            if work.alternations == ENOUGH_ALTERNATIONS and solve_jointly():
                return
            if work.alternations >= MOST_ALTERNATIONS:
                raise NotConvergedError(self._unsettled(work))

    def _unsettled(self, work: Iterate) -> str:
        friction, beta = self.model.friction, abs(self.model.compliances.dundurs_constant)
        return (
            f"pressure and shear still change each other after {work.alternations} alternations, by {work.change:.2g}"
            f" of the normal displacement, and are not found together either: the coupling is strong, friction times"
            f" Dundurs' constant is {friction:g} x {beta:.2g}; take more increments, or less friction"
        )

    @property
    def _kept_tolerance(self) -> float:
        """Tolerance that the rounding of what follows the tractions is judged by: none where passes are mixed, which
        would mix the rounding as well."""
        return 0.0 if self._mixing is not None else self._target

    def _mark_slipping(self, work: Iterate) -> None:
        inside = 1.0 - circle_width(self.level.operator.dtype)
        bound = np.multiply(work.pressure, self.model.friction * inside, out=self._bound)
        np.greater_equal(np.hypot(work.shear[0], work.shear[1]), bound, out=self.level.tangential.slipping)

    def _normal_pass(
        self, increment: Increment, start: Start, work: Iterate, tolerance: float, first: bool
    ) -> None:
        if not self._coupled and work.alternations == 0 and start.normal == increment.normal:
            return
        result = self.level.normal.solve(
            self._separation,
            increment.normal,
            work.pressure,
            tolerance,
            self.max_iterations,
            work.rigid[:3],
            self._kept_tolerance,
            0.0 if first else work.approach,
        )
        work.iterations_normal += result.iterations
        work.rigid[:3] = result.rigid
        work.approach = result.scale
        if not result.converged and not work.pressure.any():
            raise ContactLostError("a moment is imposed where delta_z lifts the body off; impose P or a tilt instead")
        if not result.converged and result.residual <= tolerance:
            raise NotConvergedError(
                "the imposed loads are not balanced by a contact of so few cells; take more points or a smaller area"
            )
        if not result.converged:
            raise NotConvergedError(
                f"the normal problem is not solved after {result.iterations} iterations: the largest gap error is"
                f" {result.residual:.2g} of the normal displacement, {tolerance:.2g} is needed; {ADVICE}"
            )

    def _tangential_pass(
        self, increment: Increment, start: Start, work: Iterate, tolerance: float, settled: bool, first: bool
    ) -> float:
        """Returns the tolerance that was met."""
        if not self.model.has_shear:
            self._slide_without_friction(increment, start, work)
            return tolerance
        if self._stays_unsheared(increment, start):
            work.rigid[3:] = start.rigid[3:]
            return tolerance
        np.multiply(work.pressure, self.model.friction, out=self._bound)
        control = self._carried(increment, start, settled)
        motion = work.rigid[:3] - start.rigid[:3]
        reach = max(self.level.grid.size) / 2
        elastic, least = start.elastic, self._least_slip
        largest = max(
            abs(motion[0]), abs(motion[1]) * reach, abs(motion[2]) * reach, LEAST_MOTION * elastic, least
        )
        unlike_the_last = start.normal != increment.normal or not work.shear.any()
        if self._coupled:
            moved = np.abs(work.rigid[3:] - start.rigid[3:]) * (1.0, 1.0, reach)
            disturbed = work.change * work.approach / max(largest, float(moved.max()), TINY)
            tolerance = max(tolerance, min(SHEAR_REDUCTION * disturbed, FIRST_TOLERANCE))
        if first:
            self._begin_slip(start, work)
        elif self._coupled:
            self._follow_pressure(work)
        if work.alternations == 0 and unlike_the_last:
            self.level.estimate_tangential(self._elastic_slip, control, self._bound, work.shear, largest)
        result = self.level.tangential.solve(
            self._elastic_slip,
            control,
            self._bound,
            work.shear,
            tolerance,
            self.max_iterations,
            largest,
            SlipScales(self._kept_tolerance, self._slip_scale, least, elastic),
        )
        self._slip_scale = result.least_scale
        work.iterations_tangential += result.iterations
        work.rigid[3:] = start.rigid[3:] + result.rigid
        if not result.converged:
            raise NotConvergedError(self._unsheared(result, tolerance, control))
        return tolerance

    def _begin_slip(self, start: Start, work: Iterate) -> None:
        """The elastic slip at the tractions of `work`; none as long as nothing has changed."""
        slip, operator = self._elastic_slip, self.level.operator
        if work.at_start or start.elastic_slip is not None:
            slip[:] = 0.0 if work.at_start else start.elastic_slip
            if self._coupled:
                self._follow_pressure(work)
            return
        operator.tangential(work.shear, slip)
        np.subtract(start.displacement, slip, out=slip)
        if self._coupled:
            room = self.level.tangential.room.double
            operator.tangential_from_pressure(work.pressure, room)
            slip -= room
            np.copyto(self._pressure, work.pressure)

    def _follow_pressure(self, work: Iterate) -> None:
        """Bring the elastic slip up to the pressure."""
        room = self.level.tangential.room
        np.subtract(work.pressure, self._pressure, out=room.double[0])
        np.copyto(self._pressure, work.pressure)
        self.level.operator.incremental_tangential_from_pressure.add(
            self._elastic_slip, room, self._kept_tolerance * self._slip_scale, -1.0
        )

    def _unsheared(self, result: TangentialResult, tolerance: float, control: LoadControl) -> str:
        """Why the tangential problem is given up."""
        if self._is_far(control):
            return (
                f"the torque about an origin {self.level.grid.farthest:.3g} mm away is not balanced: so long an arm"
                " leaves too few digits in double precision; move surface and grid towards the origin, or impose phi_z"
            )
        if result.residual <= tolerance:
            return "the tangential loads are not balanced by so few cells; take more points or a smaller area"
        spare = load_factor(self._bound, control, self._tangential_modes) - 1.0
        if spare < NEXT_TO_SLIDING:
            return (
                f"the tangential problem is not solved: the loads are within {spare:.1g} of those under which all"
                " slides, where next to nothing sticks; lower them, raise P or the friction, or impose displacements"
            )
        advice = ADVICE if result.iterations >= self.max_iterations else EASIER  # more would go round in circles
        digits = TOO_FEW_DIGITS if self.level.operator.dtype is np.float32 else ""
        return (
            f"the tangential problem is not solved after {result.iterations} iterations: the largest slip error is"
            f" {result.residual:.2g} of the rigid displacement, {tolerance:.2g} is needed; {digits}{advice}"
        )

    def _is_far(self, control: LoadControl) -> bool:
        """Whether a torque is imposed about an origin so far away that next to no force makes it."""
        return control.forced[2] and self.level.grid.farthest > FAR * max(self.level.grid.size)

    def _stays_unsheared(self, increment: Increment, start: Start) -> bool:
        """Whether nothing is there that could cause shear: no load, no motion, no pressure that moves the surfaces."""
        if self._coupled or start.shear.any() or start.displacement.any():
            return False
        wanted = increment.tangential.relative_to(start.rigid[3:])
        return not any(wanted.values)

    def _carried(self, increment: Increment, start: Start, settled: bool) -> LoadControl:
        """The tangential balance as increments; a load that friction cannot carry is an error once the pressure is
        settled, and cut to what it can carry while it is not."""
        imposed = increment.tangential
        control = imposed.relative_to(start.rigid[3:])
        factor = load_factor(self._bound, control, self._tangential_modes)
        if factor > 1.0 + at_the_limit(self.level.operator.dtype):
            return control
        only_forces = increment.normal.forced[0] and not imposed.forced[2]
        if settled or only_forces:
            raise sliding_error(imposed, factor, float(self._bound.sum()) * self.level.grid.cell_area)
        return control.with_loads_scaled(CUT * factor)

    def _slide_without_friction(self, increment: Increment, start: Start, work: Iterate) -> None:
        imposed = increment.tangential
        if self.model.friction == 0.0 and imposed.imposed_resultant.any():
            raise sliding_error(imposed, 0.0, 0.0)
        work.rigid[3:] = np.where(imposed.forced, start.rigid[3:], imposed.imposed_displacement)

    def _couple_normal(self, work: Iterate, first: bool = False) -> float:
        """Separation as the shear deforms it; its largest change in the contact over the approach."""
        self._follow_shear(work, first)
        image, separation = self._bound, self._separation
        np.add(self._undeformed, self._uz[0], out=image)
        contact = work.pressure > 0.0
        if not contact.any():
            contact = np.isfinite(separation)  # delta_z then is where the surfaces touch
        change = float(np.max(np.abs(np.subtract(image, separation, where=contact, out=np.zeros_like(image)))))
        if self._mixing is not None:
            material = np.isfinite(image)
            image[material] = self._mixing.next(
                separation[material], image[material], contact[material].astype(np.float64)
            )
        separation[:] = image
        return change / (work.approach or 1.0)

    def _follow_shear(self, work: Iterate, first: bool) -> None:
        """Bring the normal displacement that the shear causes up to the shear."""
        operator = self.level.operator
        if first:
            operator.normal_from_shear(work.shear, self._uz[0])
        else:
            room = self.level.tangential.room
            np.subtract(work.shear, self._shear, out=room.double)
            operator.incremental_normal_from_shear.add(self._uz, room, self._kept_tolerance * work.approach)
        np.copyto(self._shear, work.shear)
