"""Streamlines of shear and of slip."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas
from fretsolve.plots.load_history import step_text
from fretsolve.plots.maps import (
    NAMES,
    arrangement,
    draw_outlines,
    frame,
    outline_key,
    panel_size,
    scale_of,
)
from fretsolve.plots.marks import line_colors
from fretsolve.plots.snapshot import VECTORS, Snapshot, Window, chosen_step, common_window, has_field, require_field

if TYPE_CHECKING:
    from fretsolve.result import Result

DENSITY = 1.3
NOTHING = 1e-3
"""Vectors shorter than this part of the longest one carry no line: their direction is round-off."""


def streamlines(result: Result, ax: Target = None, *, step: int | None = None) -> Figure:
    """Lines along the shear and along the slip at an increment (by default the last with fields).

    Colour tells the length of the vectors. Raises PictureError where there is neither.
    """
    snapshot = Snapshot(result, chosen_step(result, step))
    stored = [name for name in VECTORS if has_field(result, name)]
    if not stored:
        require_field(result, VECTORS[0])
    if min(len(result.x), len(result.y)) < 2:
        raise PictureError("lines need two cells or more along x and along y")
    names = [name for name in stored if snapshot.field(name).any()]
    if not names:
        raise PictureError(f"{' and '.join(stored)} are 0 all over in increment {snapshot.step}")
    seen = common_window([snapshot])
    columns, rows = arrangement(len(names), seen)
    with canvas(ax, rows, columns, panel_size(seen)) as drawn:
        for axes, name in zip(drawn.axes, names, strict=False):
            _draw(drawn, axes, snapshot, name, seen)
        drawn.heading(result, step_text(result, snapshot.step))
        drawn.legend(outline_key(snapshot), columns=2)
    return drawn.figure


def _draw(drawn: Canvas, axes: Axes, snapshot: Snapshot, name: str, seen: Window) -> None:
    result, length = snapshot.result, snapshot.magnitude(name)
    scale = scale_of(result, name, float(length.max()))
    nothing = length <= NOTHING * length.max()
    x, y = (np.flatnonzero((c >= low) & (c <= high)) for c, (low, high) in ((result.x, seen.x), (result.y, seen.y)))
    part = np.ix_(x, y)
    u, v = (np.ma.masked_where(nothing, component)[part].T for component in snapshot.field(name))
    values = (length * scale.unit.factor)[part].T
    norm = Normalize(0.0, scale.norm.vmax)
    # evenly spaced to the last bit, as streamplot asks for it
    along_x, along_y = (np.linspace(c[0], c[-1], len(c)) for c in (result.x[x], result.y[y]))
    axes.streamplot(
        along_x,
        along_y,
        u,
        v,
        color=values,
        cmap=line_colors(),
        norm=norm,
        density=DENSITY,
        linewidth=1.0,
        arrowsize=0.8,
    )
    draw_outlines(axes, snapshot)
    frame(axes, seen)
    axes.set_title(NAMES[name])
    drawn.colorbar(axes, ScalarMappable(norm, line_colors()), scale.label)
