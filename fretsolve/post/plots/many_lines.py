"""Draw what an eye can see of very many lines: the first and last ones, some between, and the range of all between."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from fretsolve.system.arrays import BoolArray, DoubleArray

MOST_LINES, END_LINES = 40, 8
"""Lines of which all are drawn, as one for each cycle, and how many of the first and of the last of more; the others
are at equal distances between these."""

MOST_POINTS = 2000
"""Points of which each has its error bar and its value of a closed form."""

PLACES = 512
"""Places along x and along y that an eye tells apart in a panel: fewer than lines are wide."""

BAND: dict[str, Any] = {"color": "#b5d5d8", "linewidth": 1.6, "zorder": 1.7}
"""Look of the range that lines fill which are not drawn one by one."""


def drawn_lines(count: int) -> list[int]:
    """Return which of `count` lines to draw: all of at most `MOST_LINES`, else the first and last ones and some."""
    if count <= MOST_LINES:
        return list(range(count))
    inner = np.linspace(END_LINES, count - 1 - END_LINES, MOST_LINES - 2 * END_LINES).round().astype(int)
    return [*range(END_LINES), *inner.tolist(), *range(count - END_LINES, count)]


def draw_range(axes: Axes, x: DoubleArray, y: DoubleArray, **look: Any) -> None:
    """Draw the range that a very long line through the points (x, y) fills, as pixels; look: of the line.

    Pieces of the line that an eye does not tell apart are drawn once.
    """
    points = np.stack([x, y], axis=1)
    known: BoolArray = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return
    low, size = points[known].min(axis=0), np.ptp(points[known], axis=0)
    scale = np.where(size > 0.0, size, 1.0) / PLACES
    places = np.where(known[:, None], np.rint((points - low) / scale), 0.0).astype(np.int64)
    keys = places @ (PLACES + 1, 1)
    ends = np.sort(np.stack([keys[:-1], keys[1:]], axis=1), axis=1)[known[:-1] & known[1:]]
    ends = np.unique(ends, axis=0)
    pieces = low + scale * np.stack(np.divmod(ends, PLACES + 1), axis=-1)
    axes.add_collection(LineCollection(pieces, capstyle="round", rasterized=True, **look))
    axes.autoscale_view()
