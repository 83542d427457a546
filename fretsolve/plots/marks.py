"""Lines that can be told apart in colour, by the colour-blind and in grey print."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.colors import Colormap, ListedColormap

MOST_NAMED = 7
"""More lines than these are told by a colour bar, not by a legend."""

MOST_MARKERS = 12
"""Markers along a line; all points are marked where there are fewer."""

_DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (8, 3)), (0, (2, 1)))
_MARKERS = "osD^vPX"
_DARKEST, _LIGHTEST = 0.0, 0.8


@dataclass(frozen=True)
class Mark:
    """Colour, dashes and marker of a line; the markers of each `index` stand elsewhere along it."""

    color: Any
    linestyle: Any
    marker: str
    index: int = 0

    def options(self, points: int) -> dict[str, Any]:
        """For `Axes.plot` of a line of `points` points."""
        every = max(1, -(-points // MOST_MARKERS))
        return {
            "color": self.color,
            "linestyle": self.linestyle,
            "marker": self.marker,
            "markevery": (2 * self.index % every, every),
            "markerfacecolor": "white",
        }


def line_colors() -> Colormap:
    """Viridis without its end that fades on white: dark to light in grey as well."""
    viridis = matplotlib.colormaps["viridis"]
    count = 256
    shades = [viridis(_DARKEST + (_LIGHTEST - _DARKEST) * index / (count - 1)) for index in range(count)]
    return ListedColormap(shades, "fretsolve lines")


def marks(count: int) -> list[Mark]:
    """Marks of `count` lines in an order; dashes and markers repeat after `MOST_NAMED`."""
    colors = line_colors()
    return [
        Mark(
            colors(index / max(count - 1, 1)),
            _DASHES[index % MOST_NAMED] if count <= MOST_NAMED else "-",
            _MARKERS[index % MOST_NAMED] if count <= MOST_NAMED else "",
            index,
        )
        for index in range(count)
    ]


CLOSED_FORM: dict[str, Any] = {"color": "0.78", "linewidth": 5.0, "zorder": 1.5}
"""Options of the line of a closed form: a pale band, on which the line that agrees with it lies."""
