"""The angle between slip and load over the slip zone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas
from fretsolve.plots.load_history import step_text
from fretsolve.plots.maps import draw_arrows, draw_cells, draw_outlines, frame, outline_key, panel_size
from fretsolve.plots.snapshot import Snapshot, Window, chosen_step, common_window
from fretsolve.result.state import Zone
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result import Result


LEAST_CHANGE = 1e-6
"""A change of the load below this part of it is none."""

LEAST_LIMIT = 1.0
"""Where all angles are round-off, the colours still reach this far (degrees)."""

WORST_SHARE = 0.01
"""The colours reach as far as all but this part of the cells."""


@dataclass(frozen=True)
class SlipAngle:
    """degrees: (nx, ny) from the direction of the load to that of the slip, NaN where nothing slips.

    against: what the angle is measured from, in words.
    """

    degrees: DoubleArray
    against: str


def slip_angle(result: Result, ax: Target = None, *, step: int | None = None) -> Figure:
    """A map of the angle from the direction of the load to that in which the slip zone slips in an increment.

    Slip is along the shear, by Coulomb's law. The load's direction is that of the change of (Qx, Qy); where that is
    none, or body 1 is turned, the motion of each point of body 1. By default at the last increment with fields.
    Raises PictureError where nothing slips, or no tangential load is moved.
    """
    snapshot = Snapshot(result, chosen_step(result, step))
    found = angle_of(snapshot)
    seen = common_window([snapshot])
    width, height = panel_size(seen)
    with canvas(ax, 1, 1, (1.35 * width, 1.25 * height)) as drawn:
        _draw(drawn, drawn.axes[0], snapshot, found, seen)
        drawn.heading(result, step_text(result, snapshot.step))
        drawn.legend(outline_key(snapshot), columns=2)
    return drawn.figure


def angle_of(snapshot: Snapshot) -> SlipAngle:
    """The angle of the slip in an increment. Raises PictureError."""
    slipping, shear = snapshot.field("zone") == Zone.SLIP, snapshot.field("shear")
    slipping &= snapshot.magnitude("shear") > 0.0
    if not slipping.any():
        raise PictureError(f"nothing slips in increment {snapshot.step}")
    direction, against = _direction(snapshot.result, snapshot.step)
    cross = direction[0] * shear[1] - direction[1] * shear[0]
    along = direction[0] * shear[0] + direction[1] * shear[1]
    return SlipAngle(np.where(slipping, np.degrees(np.arctan2(cross, along)), np.nan), against)


def _direction(result: Result, step: int) -> tuple[DoubleArray, str]:
    """A vector along the load, (2, 1, 1) or (2, nx, ny), and in words. Raises PictureError."""

    def change(name: str) -> float:
        column = result.history[name]
        return float(column[step] - (column[step - 1] if step else 0.0))

    force = np.array([change("Qx"), change("Qy")])
    shift = np.array([change("delta_x"), change("delta_y")])
    reach = float(result.history["contact_radius"][step])
    turn = change("phi_z")
    least = LEAST_CHANGE * float(np.abs(result.history["delta_z"]).max())
    if np.hypot(*force) > LEAST_CHANGE * float(result.history["P"][step]) and abs(turn) * reach <= least:
        return force[:, None, None], "the load"
    if max(float(np.hypot(*shift)), abs(turn) * reach) <= least:
        raise PictureError(f"no tangential load is moved in increment {step} to measure the angle against")
    x, y = np.meshgrid(result.x, result.y, indexing="ij")
    return np.stack([shift[0] - turn * y, shift[1] + turn * x]), "the motion of body 1"


def _draw(drawn: Canvas, axes: Axes, snapshot: Snapshot, found: SlipAngle, seen: Window) -> None:
    sizes = np.sort(np.abs(found.degrees[np.isfinite(found.degrees)]))
    limit = max(float(sizes[int((1.0 - WORST_SHARE) * (len(sizes) - 1))]), LEAST_LIMIT)
    result = snapshot.result
    draw_cells(axes, result, snapshot.contact, ~snapshot.contact, Normalize(0.0, 1.0), ListedColormap(["0.85"]))
    norm, colors = Normalize(-limit, limit), matplotlib.colormaps["RdBu_r"]
    draw_cells(axes, result, found.degrees, ~np.isfinite(found.degrees), norm, colors)
    draw_arrows(axes, result, np.where(np.isfinite(found.degrees), snapshot.field("shear"), 0.0), seen)
    draw_outlines(axes, snapshot)
    frame(axes, seen)
    axes.set_title(f"slip against {found.against}:\nat most {sizes[-1]:.3g}°, in the mean {sizes.mean():.3g}°")
    extend = "both" if sizes[-1] > limit else "neither"
    drawn.colorbar(axes, ScalarMappable(norm, colors), "angle, counter-clockwise (°)", extend)
