"""Load checks: loads that no contact can carry, found before iterating, and contact at the edge of the grid."""

from __future__ import annotations

import numpy as np

from fretsolve.errors import ContactLostError, GridEdgeError, SlidingError
from fretsolve.model.grid import Grid, HalfGrid
from fretsolve.model.load_control import LoadControl
from fretsolve.system.arrays import BoolArray, FloatArray


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
    imposed: LoadControl, factor: float, capacity: float, line: bool = False, varied: bool = False
) -> SlidingError:
    """Return the error for tangential loads of which friction carries `factor`; capacity: mu P (N).

    line: for a line contact, whose loads are per mm and whose motion cannot be imposed; varied: the capacity is the sum
    of a friction limit that is not mu P.
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
    instead = "" if line else f", or impose {' and '.join(motion for _, _, motion in named)} instead"
    return SlidingError(
        f"gross slip under {', '.join(load for _, load, _ in named)}: friction carries {carried} ({limit} ="
        f" {capacity:.6g} {unit}); lower the load, {'' if instead else 'or '}raise P or the friction{instead}",
        named[0][0],
    )
