"""Draw directions: streamlines of shear traction and slip, and the angle between slip and load."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from scipy.ndimage import binary_erosion

from fretsolve.errors import PictureError
from fretsolve.post.export.selection import stored_names
from fretsolve.post.plots.canvas import Target
from fretsolve.post.plots.labels import line_colors
from fretsolve.post.plots.pictures import maps
from fretsolve.post.plots.snapshot import VECTORS, Snapshot, chosen_fields, chosen_step, require_area, view_box
from fretsolve.result import Result
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, DoubleArray

LEAST_CHANGE = 1e-6
"""A smaller relative change of the load is round-off."""


def streamlines(result: Result, ax: Target = None, *, step: int | None = None) -> Figure:
    """Draw lines along the shear traction and along the slip at an increment, by default the last with fields.

    Colours show the length of the vectors. A narrow ring, in which no lines find place, has arrows. Raises PictureError
    if there are none.
    """
    require_area(result)
    snapshot = Snapshot(result, chosen_step(result, step))
    names = chosen_fields([snapshot], VECTORS)
    if min(len(result.x), len(result.y)) < 2:
        raise PictureError("lines need two cells or more along x and along y")
    if not snapshot.field(names[0]).any():
        stored = [name for name in VECTORS if name in stored_names(result)]
        raise PictureError(f"{' and '.join(stored)} are 0 everywhere in increment {snapshot.step}")
    box = view_box(result, snapshot.contact)
    i, j = maps.cells_inside(result, box)
    inside = np.ix_(i, j)
    # streamplot asks for coordinates that are evenly spaced to the last bit
    x, y = (np.linspace(centres[0], centres[-1], len(centres)) for centres in (result.x[i], result.y[j]))
    with maps.map_canvas(ax, snapshot, len(names), box) as drawn:
        for axes, name in zip(drawn.axes, names, strict=False):
            length = snapshot.magnitude(name)
            scale = maps.scale_of(result, name, float(length.max()))
            # the direction of vectors that are short against the longest one is round-off
            short = length <= 1e-3 * length.max()
            if _is_narrow(~short):
                maps.draw_panel(drawn, axes, snapshot, scale, box)
                continue
            u, v = (np.ma.masked_where(short, values) for values in snapshot.field(name))
            lines = axes.streamplot(
                x,
                y,
                u[inside].T,
                v[inside].T,
                color=(length * scale.factor)[inside].T,
                cmap=line_colors(),
                norm=Normalize(0.0, scale.norm.vmax),
                density=1.3,
                linewidth=1.0,
                arrowsize=0.8,
                minlength=0.03,
            ).lines
            maps.draw_outlines(axes, snapshot)
            maps.draw_frame(axes, box, scale.label)
            drawn.colorbar(axes, lines)
    return drawn.figure


def _is_narrow(cells: BoolArray) -> bool:
    """Return whether the region of the cells (nx, ny) is too narrow for lines: few have all neighbours among them."""
    return bool(binary_erosion(cells).sum() < 0.4 * cells.sum())


def slip_angle(result: Result, ax: Target = None, *, step: int | None = None) -> Figure:
    """Draw a map of the angle from the direction of the load to the direction of the slip in an increment.

    By Coulomb's law slip is along the shear traction. The load's direction is the change of (Qx, Qy); if
    that is 0 or body 1 turns, it is the motion of each point of body 1. step: by default the last increment with
    fields. Raises PictureError if nothing slips or no tangential load changes.
    """
    require_area(result)
    snapshot = Snapshot(result, chosen_step(result, step))
    degrees, reference = angle_of(snapshot)
    slipping = np.isfinite(degrees)
    sizes = np.sort(np.abs(degrees[slipping]))
    # the worst hundredth of the cells may lie beyond the colours; if all angles are round-off, they reach a degree
    limit = max(float(sizes[int(0.99 * (len(sizes) - 1))]), 1.0)
    box, contact = view_box(result, snapshot.contact), snapshot.contact
    with maps.map_canvas(ax, snapshot, 1, box, larger=(1.0, 1.0)) as drawn:
        axes = drawn.axes[0]
        maps.draw_cells(axes, result, contact, ~contact, Normalize(0.0, 1.0), ListedColormap(["0.85"]))
        colors = matplotlib.colormaps["RdBu_r"]
        image = maps.draw_cells(axes, result, degrees, ~slipping, Normalize(-limit, limit), colors)
        maps.draw_arrows(axes, result, np.where(slipping, snapshot.field("shear"), 0.0), box)
        maps.draw_outlines(axes, snapshot)
        title = f"slip against {reference}:\nat most {sizes[-1]:.3g}°, on average {sizes.mean():.3g}°"
        maps.draw_frame(axes, box, title)
        extend = "both" if sizes[-1] > limit else "neither"
        drawn.colorbar(axes, image, "angle, counter-clockwise (°)", extend)
    return drawn.figure


def angle_of(snapshot: Snapshot) -> tuple[DoubleArray, str]:
    """Return the angle (degrees) from the load to the slip, ``(nx, ny)``, NaN where nothing slips, and which load.

    Raises PictureError.
    """
    slipping, shear = snapshot.field("zone") == Zone.SLIP, snapshot.field("shear")
    slipping &= snapshot.magnitude("shear") > 0.0
    if not slipping.any():
        raise PictureError(f"nothing slips in increment {snapshot.step}")
    load, reference = _load_direction(snapshot.result, snapshot.step)
    across = load[0] * shear[1] - load[1] * shear[0]
    along = load[0] * shear[0] + load[1] * shear[1]
    return np.where(slipping, np.degrees(np.arctan2(across, along)), np.nan), reference


def _load_direction(result: Result, step: int) -> tuple[DoubleArray, str]:
    """Return a vector along the load, (2, 1, 1) or (2, nx, ny), and its name. Raises PictureError."""

    def change(name: str) -> float:
        column = result.history[name]
        return float(column[step] - (column[step - 1] if step else 0.0))

    force = np.array([change("Qx"), change("Qy")])
    shift = np.array([change("delta_x"), change("delta_y")])
    turn = change("phi_z")
    turned = abs(turn) * float(result.history["contact_radius"][step])
    least = LEAST_CHANGE * float(np.abs(result.history["delta_z"]).max())
    if np.hypot(*force) > LEAST_CHANGE * float(result.history["P"][step]) and turned <= least:
        return force[:, None, None], "the load"
    if max(float(np.hypot(*shift)), turned) <= least:
        raise PictureError(f"no tangential load changes in increment {step}, so that the angle has no reference")
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    return np.stack([shift[0] - turn * y, shift[1] + turn * x]), "the motion of body 1"
