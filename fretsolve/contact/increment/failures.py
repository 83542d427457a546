"""Why an increment has no solution, or is given up, and what would help: the lines that a user reads.

Loads that no contact can carry are found before iterating; contact at the edge of the grid is found at the end.
"""

from __future__ import annotations

import numpy as np

from fretsolve.contact.increment.states import WorkingState
from fretsolve.contact.solvers.normal import SolverResult
from fretsolve.contact.solvers.rigid_modes import load_factor
from fretsolve.contact.solvers.tangential import TangentialSolver
from fretsolve.errors import ContactLostError, GridEdgeError, SlidingError
from fretsolve.problem.model.grid import Grid, HalfGrid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.required_terms import Model
from fretsolve.problem.model.rig import Rig, driver
from fretsolve.system.arrays import BoolArray, FloatArray

EASIER = "loosen solver.tolerance, or take more increments"
TOO_FEW_DIGITS = "the changes may be too small for solver.precision: single, take double; else "

ADVICE = f"raise solver.max_iterations, {EASIER}"


def require_supported(control: LoadControl, separation: FloatArray, grid: Grid) -> None:
    """Raise ContactLostError where no pressure >= 0 on the grid has the imposed P, Mx, My.

    The point of application (My/P, Mx/P) must lie among the cells that have material opposite.
    """
    load, mx, my = control.imposed_resultant
    if not control.forced[0]:
        return
    material = np.isfinite(separation)
    if not material.any():
        raise ContactLostError("the surfaces nowhere face each other on the grid, so P cannot be imposed there", "P")
    if load == 0.0:
        if mx or my:
            raise ContactLostError("no contact can carry a moment at P = 0", "Mx" if mx else "My")
        return
    for name, mode, moment, along, axis, centers in (("Mx", 1, mx, "y", 0, grid.y), ("My", 2, my, "x", 1, grid.x)):
        if not control.forced[mode]:
            continue
        reached = centers[material.any(axis=axis)]
        if not reached.min() <= moment / load <= reached.max():
            raise ContactLostError(
                f"the load acts at {along} = {name}/P = {moment / load:.6g} mm, outside of the potential contact area"
                f" ({reached.min():.6g} to {reached.max():.6g} mm), so no equilibrium exists",
                name,
            )


def require_inside(pressure: FloatArray, grid: Grid, map_border: BoolArray | None = None) -> None:
    """Raise GridEdgeError where the contact has reached the edge of the potential contact area.

    map_border: cells beyond which a height map ends, (nx, ny). Its end is not the end of the material.
    """
    if map_border is not None and pressure[map_border].any():
        raise GridEdgeError(
            "the contact reaches the edge of the height map, beyond which nothing is known; take a map that is larger"
            " than the contact, or, where the material does end, with a rim of NaN",
            "map",
        )
    first = not isinstance(grid, HalfGrid) and pressure[:, 0].any()  # one half of a grid begins in its middle
    edges = {"x": (pressure[0].any(), pressure[-1].any()), "y": (first, pressure[:, -1].any())}
    sides = [f"{sign}{axis}" for axis in grid.axes for sign, at in zip("-+", edges[axis], strict=True) if at]
    if sides:
        size = " x ".join(f"{side:.4g}" for _, side in zip(grid.axes, grid.size, strict=False))
        raise GridEdgeError(
            f"the contact reaches the edge ({', '.join(sides)}) of the potential contact area of {size} mm, where its"
            " pressure would be cut off"
        )


def gross_slip_error(
    imposed: LoadControl,
    factor: float,
    capacity: float,
    line: bool = False,
    varied: bool = False,
    rig: Rig | None = None,
) -> SlidingError:
    """Return the error for tangential loads of which friction carries `factor`; capacity: mu P (N).

    line: for a line contact, whose loads are per mm and whose motion along y cannot be imposed; varied: the capacity is
    the sum of a friction limit that is not mu P; rig: in series with the contact.
    """
    loads, limit = imposed.imposed_resultant, "sum of the friction limit" if varied else "mu P"
    unit = "N/mm" if line else "N"
    names = zip(("Qx", "Qy", "Mz"), (unit, unit, "N mm"), ("delta_x", "delta_y", "phi_z"), loads, strict=True)
    named = [(name, f"{name} = {load:.6g} {unit}", motion) for name, unit, motion, load in names if load]
    if factor == 0.0 and capacity > 0.0 and loads[2]:
        return SlidingError(
            f"Mz = {loads[2]:.6g} N mm on a contact of one cell, which has no arm to carry a torque; take more points"
            " or a smaller area, or impose phi_z instead",
            "Mz",
        )
    carried = f"at most {factor:.6g} of it" if factor > 0.0 else "none of it"
    if abs(factor - 1.0) < 2e-6:  # which six digits do not show
        carried = "slightly less"
    instead = f", or impose {' and '.join(driver(rig, motion) for _, _, motion in named)} instead"
    if line:
        instead = "" if loads[1] else f"{instead}, with a reference_depth"
    return SlidingError(
        f"gross slip under {', '.join(load for _, load, _ in named)}: friction carries {carried} ({limit} ="
        f" {capacity:.6g} {unit}); lower the load, {'' if instead else 'or '}raise P or the friction{instead}",
        named[0][0],
    )


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
    solver: TangentialSolver,
    grid: Grid,
    found: SolverResult,
    tolerance: float,
    control: LoadControl,
    friction_limit: FloatArray,
    max_iterations: int,
) -> str:
    """Return why the tangential problem is given up."""
    if is_far(control, grid):
        return (
            f"the torque about an origin {grid.farthest:.3g} mm away is not balanced: so long an arm"
            " leaves too few digits in double precision; move surface and grid towards the origin, or impose phi_z"
        )
    if found.residual <= tolerance:
        return "the tangential loads are not balanced by so few cells; take more points or a smaller area"
    spare = load_factor(friction_limit, control, solver.modes) - 1.0
    if spare < 1e-3:
        return (
            f"the tangential problem is not solved: the loads are within {spare:.1g} of gross slip, where"
            " almost nothing sticks; lower them, raise P or the friction, or impose displacements"
        )
    advice = ADVICE if found.iterations >= max_iterations else EASIER  # more iterations would only cycle
    digits = TOO_FEW_DIGITS if solver.operator.dtype is np.float32 else ""
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
