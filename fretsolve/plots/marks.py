"""Lines that can be told apart in colour, by the colour-blind and in grey print."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.colors import Colormap, ListedColormap

MOST_NAMED = 7
"""More lines than these are told by a colour bar, not by a legend."""

MOST_MARKERS = 12
"""Markers along a line that only tell it from others; all points are marked where there are fewer."""

MOST_INCREMENTS = 60
"""Markers along a line on which each stands for an increment, or a case, so that none is left out up to here."""

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

    def options(self, points: int, most: int = MOST_MARKERS) -> dict[str, Any]:
        """For `Axes.plot` of a line of `points` points, of which about `most` may have a marker."""
        every = spacing(points, most)
        return {
            "color": self.color,
            "linestyle": self.linestyle,
            "marker": self.marker,
            "markevery": (2 * self.index % every, every),
            "markerfacecolor": "white",
        }


def spacing(points: int, most: int) -> int:
    """From one marker to the next along a line of `points` points."""
    return max(1, -(-points // most))


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
