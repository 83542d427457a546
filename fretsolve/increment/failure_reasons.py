"""Why an increment is given up, and what would help: the lines that a user reads."""

from __future__ import annotations

import numpy as np

from fretsolve.increment.grid_hierarchy import GridLevel
from fretsolve.increment.working_state import WorkingState
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.model.required_terms import Model
from fretsolve.solvers.limit_load import load_factor
from fretsolve.solvers.normal import SolverResult
from fretsolve.system.arrays import FloatArray

EASIER = "loosen solver.tolerance, or take more increments"
TOO_FEW_DIGITS = "the changes may be too small for solver.precision: single, take double; else "

ADVICE = f"raise solver.max_iterations, {EASIER}"


def is_far(control: LoadControl, grid: Grid) -> bool:
    """Return whether a torque is imposed about an origin too far away for double precision."""
    return control.forced[2] and grid.farthest > 1e4 * max(grid.size)


def why_not_pressed(found: SolverResult, tolerance: float) -> str:
    """Return why the normal problem is given up."""
    if found.residual <= tolerance:
        return "the imposed loads are not balanced by a contact of so few cells; take more points or a smaller area"
    return (
        f"the normal problem is not solved after {found.iterations} iterations: the largest gap error is"
        f" {found.residual:.2g} of the normal displacement, {tolerance:.2g} is needed; {ADVICE}"
    )


def why_not_sheared(
    level: GridLevel,
    found: SolverResult,
    tolerance: float,
    control: LoadControl,
    friction_limit: FloatArray,
    max_iterations: int,
) -> str:
    """Return why the tangential problem is given up."""
    if is_far(control, level.grid):
        return (
            f"the torque about an origin {level.grid.farthest:.3g} mm away is not balanced: so long an arm"
            " leaves too few digits in double precision; move surface and grid towards the origin, or impose phi_z"
        )
    if found.residual <= tolerance:
        return "the tangential loads are not balanced by so few cells; take more points or a smaller area"
    spare = load_factor(friction_limit, control, level.tangential.modes) - 1.0
    if spare < 1e-3:
        return (
            f"the tangential problem is not solved: the loads are within {spare:.1g} of gross slip, where"
            " almost nothing sticks; lower them, raise P or the friction, or impose displacements"
        )
    advice = ADVICE if found.iterations >= max_iterations else EASIER  # more iterations would only cycle
    digits = TOO_FEW_DIGITS if level.operator.dtype is np.float32 else ""
    return (
        f"the tangential problem is not solved after {found.iterations} iterations: the largest slip error is"
        f" {found.residual:.2g} of the rigid displacement, {tolerance:.2g} is needed; {digits}{advice}"
    )


def why_not_settled(work: WorkingState, model: Model) -> str:
    """Return why the staggered iteration is given up."""
    friction, beta = model.friction, abs(model.compliances.dundurs_constant)
    return (
        f"pressure and shear still change each other after {work.staggered_iterations} staggered iterations, by"
        f" {work.change:.2g} of the normal displacement, and solving both together fails as well: the coupling is"
        f" strong, friction times Dundurs' constant is {friction:g} x {beta:.2g}; take more increments, or less"
        " friction"
    )
