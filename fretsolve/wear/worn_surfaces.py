"""The surfaces of a contact that wears: how much has been worn, and when and by how much their profile changes.

The worn depth counts up with the dissipated energy of each increment. At the end of a solved cycle the surfaces take up
what it has worn, times the number of cycles that it stands for, in an increment of its own with the loads held.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.case.keys.unrolled_path import CyclePass
from fretsolve.contact.increment.certificate import Solution
from fretsolve.contact.increment.increment import SOLVER_TOLERANCE_SHARE, IncrementSolver
from fretsolve.contact.increment.states import InitialState
from fretsolve.contact.solvers.rigid_modes import NormalModes, TangentialModes
from fretsolve.errors import ContactLostError, NotConvergedError
from fretsolve.problem.friction.limit import cycles_of_little_change
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import Increment, LoadPath
from fretsolve.problem.setup.wear_law import WearLaw, owed, rate_over_jump, rates_of
from fretsolve.result.state import Fields, Summary, WearState, Zone
from fretsolve.system.arrays import DoubleArray, FloatArray
from fretsolve.wear.jumps import (
    JumpLimits,
    Progress,
    SolvedCycle,
    allowed_error,
    excess,
    last_jump,
    next_jump,
    require_periodic,
)
from fretsolve.wear.profile import ProfileProblem, wear_over_jump

PROFILE_SHARE = 0.2
"""Part of the tolerance that the error by the change of the pressure over a jump may have: no cycle is solved for it,
only normal problems. In gross slip `wear_error` is 0.28 % with it, 0.20 % with half, at a tolerance of 1 %."""

LEAST_FORCE = 1e-6
"""P over the P before the first cycle, below which the surfaces have worn apart: what is left is near to rounding."""


@dataclass(frozen=True)
class _Jump:
    """A change of the profile whose increment is to be solved.

    number: of the cycles that the last solved one stands for; energy: dissipated per area, and path: slip, both in the
    cycles that were not solved, (nx, ny); error: of the worn volume, as the pressure changes over the jump.
    """

    number: float
    energy: FloatArray
    path: FloatArray
    error: float


class WornSurfaces:
    """The surfaces of one run.

    separation: (nx, ny), of the unworn surfaces, to which `solver` refers; it grows in place by the worn profile.
    friction: of the case; state: what wear has done so far, None before the first increment.
    """

    def __init__(
        self,
        law: WearLaw,
        friction: FrictionSpec,
        solver: IncrementSolver,
        separation: DoubleArray,
        state: WearState | None,
    ):
        self._law, self._friction, self._solver, self._separation = law, friction, solver, separation
        self._unworn, none = separation.copy(), np.zeros(separation.shape)
        self._modes = TangentialModes(solver.grid)
        self._progress: Progress | None = None
        self._jump: _Jump | None = None
        self.state = WearState(none, none, none, none, none, none) if state is None else state
        np.add(self._unworn, self.state.profile, out=separation)

    def begin(
        self, increment: Increment, start: InitialState, fields: Fields, path: LoadPath, history: Sequence[Summary]
    ) -> InitialState:
        """Return the start of an increment; where the surfaces change in it, change them.

        fields, history: before the increment. Raises NoSolutionError.
        """
        cycle, self._jump, progress = increment.stage.cycle, None, Progress(path, history)
        self._progress = progress
        if cycle is not None and increment.step == progress.path.steps_of(cycle.cycle, cycle.turn)[0]:
            _require_contact(cycle, increment.normal, progress)
            self.state = replace(self.state, mark=self.state.depth, path=np.zeros(self._separation.shape))
        if increment.stage.wears is None:
            return start
        if not fields.pressure.any():
            raise ContactLostError(
                "the surfaces do not touch at the end of the cycle, but there they change by its wear, under its"
                " pressure; let the cycle begin and end where they are pressed together",
                "delta_z",
            )
        self._wear(increment.stage.wears, increment.normal, start, fields, progress)
        return replace(start, normal=None)  # so that the pressure is solved anew

    def _wear(
        self, cycle: CyclePass, control: LoadControl, start: InitialState, fields: Fields, progress: Progress
    ) -> None:
        """Change the profile by the wear of the cycles that the last one stands for."""
        state, pressure = self.state, fields.pressure.astype(np.float64)
        # 1. wear of the cycle, and how many it stands for
        rates = rates_of(self._law, start.friction, pressure, state)
        cycles, path = progress.solved(cycle), np.where(pressure > 0.0, state.path, 0.0)
        dissipated, done = (state.depth - state.mark) * rates.energy, progress.history[-1].cycles
        steady = cycles_of_little_change(self._friction, done, fields, dissipated, path)
        number = self._number(cycle, cycles, progress, pressure, steady)
        # 2. the mean rate over the jump; what does not go with the pressure, and what other stages have worn
        jump_before = next((one.jump for one in reversed(cycles) if one.jump > 1.0), 0.0)
        rate = rates.rate
        compliance = number * rate
        if number > 1.0 and jump_before:
            rate = rate_over_jump(rates.rate, number, state, jump_before)
            compliance = np.maximum(number * rate + owed(rates.rate, jump_before, state), 0.0)
        fixed = number * rates.rest + (state.mark - state.profile)
        # 3. the profile at its end
        problem = self._problem(self._separation + fixed, control, start, fields)
        jumps = cycle.jumps
        assert jumps is not None
        worn = wear_over_jump(self._solver.level, problem, compliance, PROFILE_SHARE * jumps.tolerance)
        profile = state.profile + fixed + worn.depth
        np.add(self._unworn, profile, out=self._separation)
        # 4. energy and slip of the cycles that were not solved
        unsettled = (excess(cycles) or 0.0) if number > 1.0 else 0.0
        error = (worn.error + unsettled) * float(worn.depth.sum()) * self._solver.grid.cell_area
        self._jump = _Jump(number, (profile - state.depth) * rates.energy, (number - 1.0) * path, error)
        self.state = replace(state, depth=profile, profile=profile)
        if number > 1.0:
            self.state = replace(self.state, rate=rates.rate, used=rate)

    def _problem(
        self, separation: DoubleArray, control: LoadControl, start: InitialState, fields: Fields
    ) -> ProfileProblem:
        """Return the normal problem of a jump with the shear held, between surfaces of this `separation`."""
        model, operator = self._solver.model, self._solver.level.operator
        if model.has_shear and model.terms.normal_tangential_coupling:
            uz = np.empty_like(separation)
            operator.normal_from_shear(fields.shear.astype(np.float64), uz)
            separation += uz
        # displacements as they are: in a line contact imposed displacements refer to points far below; on a rig the
        # actuator's motions as they are
        rigid, pressure = start.rigid[:3], fields.pressure.astype(np.float64)
        motions = rigid + control.given_way(NormalModes(self._solver.grid).resultants(pressure))
        held = replace(control, values=(*np.where(control.forced, control.values, motions).tolist(),))
        tolerance = SOLVER_TOLERANCE_SHARE * self._solver.tolerance
        return ProfileProblem(separation, held, rigid, pressure, tolerance, self._solver.max_iterations)

    def _number(
        self, cycle: CyclePass, cycles: list[SolvedCycle], progress: Progress, pressure: DoubleArray, steady: float
    ) -> float:
        """Return how many cycles the last one stands for. steady: cycles over which friction stays nearly the same.

        Raises NotConvergedError where cycles do not become periodic, or more are needed than there may be.
        """
        jumps = cycle.jumps
        assert jumps is not None
        left = jumps.represents - progress.path.cycles_done(progress.history, cycle)
        if cycle.is_last:
            raise NotConvergedError(
                f"{jumps.represents - left:g} of {jumps.represents:g} cycles are done after {cycle.turn} solved ones,"
                " and there may be no more of them; take a larger tolerance or jump, or fewer cycles"
            )
        if jumps.jump != 1.0 and not self._solver.model.friction_evolves:
            require_periodic(cycles, jumps.tolerance)
        deepest = float((self.state.depth - self.state.mark).max())
        allowed = allowed_error(jumps.tolerance, *progress.worn(cycle), cycles[-1].volume, left)
        scale = self._scale(pressure) if last_jump(cycles) is None else math.inf  # which only the first jump needs
        return next_jump(cycles, jumps, JumpLimits(deepest, scale, left, steady), allowed)

    def _scale(self, pressure: DoubleArray) -> float:
        """Return the largest normal displacement (mm); in a line contact about by what the middle sinks more than the
        contact's edge."""
        model, grid = self._solver.model, self._solver.grid
        if model.line:
            return model.compliances.A * float(pressure.sum()) * grid.cell_area / math.pi
        uz = np.empty_like(pressure)
        self._solver.level.operator.normal(pressure, uz)
        return float(uz.max())

    def count(
        self,
        summary: Summary,
        increment: Increment,
        before: Fields,
        fields: Fields,
        solution: Solution,
        mean_pressure: FloatArray,
    ) -> Summary:
        """Count the wear of the increment that has begun, and return its row of the history with it.

        before, fields: at its start and end; fields: of its own `solution`; mean_pressure: over it.
        """
        progress, jump, area = self._progress, self._jump, self._solver.grid.cell_area
        assert progress is not None
        energy = fields.work_density - before.work_density
        # the slip of a sticking cell is the certificate's residual, which a jump would multiply
        slips = (fields.zone == Zone.SLIP) | (energy > 0.0)
        slip = np.where(slips, fields.slip_path - before.slip_path, 0.0)
        depth = self.state.depth + self._law.depth(energy, slip, mean_pressure)
        self.state = replace(self.state, depth=depth, path=self.state.path + self._way(before, fields, solution, slip))
        history = progress.history
        last = history[-1] if history else replace(summary, cycles=0.0, wear_error=0.0)
        summary = replace(
            summary,
            cycles=last.cycles,
            wear_volume=float(depth.sum()) * area,
            wear_depth_max=float(depth.max()),
            wear_error=last.wear_error,
        )
        if jump is not None:
            summary = replace(
                summary,
                cycles=last.cycles + jump.number - 1.0,
                jump=jump.number,
                wear_error=last.wear_error + jump.error,
                work_total=summary.work_total + float(jump.energy.sum()) * area,
            )
        return self._at_the_end_of_a_cycle(summary, increment, progress, solution)

    def _way(self, before: Fields, fields: Fields, solution: Solution, slip: FloatArray) -> DoubleArray:
        """Return the way of the surfaces past each other in an increment (mm): the `slip` of cells that touch."""
        way = np.empty_like(solution.displacement)
        self._modes.displacement(solution.motion[3:], way)
        way += solution.previous_displacement - solution.displacement
        touching = (before.pressure > 0.0) & (fields.pressure > 0.0)
        return np.where(touching, slip, np.hypot(way[0], way[1]))

    def _at_the_end_of_a_cycle(
        self, summary: Summary, increment: Increment, progress: Progress, solution: Solution
    ) -> Summary:
        """Return the row of an increment with the cycle that ends with it, and with the error of the jump before it."""
        cycle = increment.stage.cycle
        if cycle is None or increment.step != progress.path.steps_of(cycle.cycle, cycle.turn)[1]:
            return summary
        summary = replace(summary, cycles=summary.cycles + 1.0)
        if cycle.jumps is None or cycle.turn == 1:
            return summary
        last = progress.jump_before(cycle)
        if last <= 1.0:
            return summary
        pressure = solution.pressure
        rate = rates_of(self._law, solution.friction, pressure, self.state).rate
        missing = float(np.abs(owed(rate, last, self.state) * pressure).sum()) * self._solver.grid.cell_area
        return replace(summary, wear_error=summary.wear_error + missing)

    def fields(self, fields: Fields, stored: Sequence[str]) -> Fields:
        """Return the fields of an increment with what the cycles have done that were not solved, and with the worn
        depths that are `stored`."""
        if self._jump is not None:
            work_density, slip_path = fields.work_density + self._jump.energy, fields.slip_path + self._jump.path
            kind = fields.pressure.dtype
            fields = replace(fields, work_density=work_density.astype(kind), slip_path=slip_path.astype(kind))
        whole, (first, second) = self.state.depth, self._law.of_bodies(self.state.depth)
        return replace(
            fields,
            wear_depth=whole if "wear_depth" in stored else None,
            wear_depth_1=first if "wear_depth_1" in stored else None,
            wear_depth_2=second if "wear_depth_2" in stored else None,
        )


def _require_contact(cycle: CyclePass, control: LoadControl, progress: Progress) -> None:
    """Raise ContactLostError where cycles under a held approach have worn the surfaces apart.

    cycle: the repetition that is to begin after the history of `progress`.
    """
    first, _ = progress.path.steps_of(cycle.cycle, 1)
    if cycle.turn == 1 or not first or control.forced[0]:
        return
    before, now = progress.history[first - 1].P, progress.history[-1].P
    if now < LEAST_FORCE * before:
        raise ContactLostError(
            f"the contact is worn away: with the approach held P has fallen from {before:.4g} N to {now:.2g} N after"
            f" {progress.path.cycles_done(progress.history, cycle):g} cycles; let the cycle represent fewer, or impose"
            " P instead",
            "delta_z",
        )
