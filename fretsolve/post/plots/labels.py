"""Choose colours, dashes and markers of lines, and names, symbols and units on axes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from fretsolve.case.dimensions import smaller_unit
from fretsolve.case.history import BULK, COMPONENTS
from fretsolve.post.names import IN_WORDS, PARAMETERS
from fretsolve.post.plots.canvas import panel_height
from fretsolve.post.plots.snapshot import VECTORS
from fretsolve.result import Result
from fretsolve.result.layout import HISTORY, RIG_HISTORY
from fretsolve.system.arrays import DoubleArray

FIELD_NAMES = {
    "pressure": "pressure",
    "shear": "shear traction",
    "slip": "slip",
    "slip_path": "slip path",
    "work_density": "dissipated energy",
    "zone": "zone",
    "gap": "gap",
    "friction": "friction",
    "shear_bound": "friction limit",
    "wear_depth": "worn depth",
    "wear_depth_1": "worn depth of body 1",
    "wear_depth_2": "worn depth of body 2",
}
"""Fields in words, by their names in the case file."""

MOST_NAMED = 7
"""Most lines that a legend names; a colour bar shows more."""

MOST_INCREMENTS = 60
"""Markers on a line whose points are increments or cases; on a longer line some points have none."""

CLOSED_FORM: dict[str, Any] = {"color": "0.78", "linewidth": 5.0, "zorder": 1.5}
"""Options of the line of a closed form: a pale band, on which the line that agrees with it lies."""

UPWARDS: dict[str, Any] = {"marker": r"$\uparrow$", "markersize": 8.0, "linestyle": "", "clip_on": False}
"""Look of an arrow that stands for a value without a bound."""

_DASHES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (6, 1, 1, 1, 1, 1)), (0, (8, 3)), (0, (2, 1)))
_MARKERS = "osD^vPX"
_LETTERS = {"delta": r"\delta", "phi": r"\varphi", "actuator": "D", "actuator_phi": r"\Phi"}
_COMPONENTS = {name for names in (*COMPONENTS, *BULK.values()) for name in names}
_LONG_NAMES = {quantity.name: quantity.long_name for quantity in (*HISTORY, *RIG_HISTORY)}
_SHORT_NAMES = {
    "Mx": r"moment $\int y\,p\,dA$ =",
    "My": r"moment $\int x\,p\,dA$ =",
    "contact_radius": "contact radius",
    "stick_radius": "stick radius",
    "work_total": "dissipated energy",
    "friction": "coefficient of friction",
    "dissipated_energy": "energy dissipated in a cycle",
    **{f"stiffness_{axis}": f"stiffness of the rig along {axis}" for axis in "xyz"},
    **{f"stiffness_phi_{axis}": f"stiffness of the rig against turns about {axis}" for axis in "xyz"},
    **{name: f"bulk stress {name[-2:]} in body {body}" for body, names in BULK.items() for name in names},
    **PARAMETERS,
    **IN_WORDS,
}
"""Names that fit on an axis, of columns whose meaning is told at length."""


@dataclass(frozen=True)
class Mark:
    """Colour, dashes and marker of a line, which colour-blind readers and grey prints tell apart.

    index: number of the line; the markers of each line start at another point.
    """

    color: Any
    linestyle: Any
    marker: str
    index: int = 0

    def options(self, points: int, most: int = 12) -> dict[str, Any]:
        """Return the options of `Axes.plot` for a line of `points` points, with about `most` markers."""
        every = marker_spacing(points, most)
        return {
            "color": self.color,
            "linestyle": self.linestyle,
            "marker": self.marker,
            "markevery": (2 * self.index % every, every),
            "markerfacecolor": "white",
        }


def marker_spacing(points: int, most: int) -> int:
    """Return the number of points from one marker to the next on a line of `points` points."""
    return max(1, -(-points // most))


def line_colors() -> Colormap:
    """Return viridis from dark to light, also in grey, without the end that fades on white."""
    return ListedColormap(matplotlib.colormaps["viridis"](np.linspace(0.0, 0.8, 256)), "fretsolve lines")


def marks(count: int, chosen: Sequence[int] | None = None) -> list[Mark]:
    """Return the marks of `count` lines in an order, or of `chosen` ones; more than `MOST_NAMED` differ
    in colour alone.
    """
    indices = range(count) if chosen is None else chosen
    colors = [tuple(color) for color in line_colors()(np.array(indices) / max(count - 1, 1))]
    if count > MOST_NAMED:
        return [Mark(color, "-", "", index) for index, color in zip(indices, colors, strict=True)]
    return [Mark(color, _DASHES[index], _MARKERS[index], index) for index, color in zip(indices, colors, strict=True)]


def draw_lines(axes: Axes, x: ArrayLike, lines: Sequence[tuple[str, DoubleArray]], **look: Any) -> None:
    """Draw lines, each with its label, over `x`; look: further options of `Axes.plot`."""
    for (label, values), mark in zip(lines, marks(len(lines)), strict=True):
        axes.plot(x, values, label=label, **mark.options(len(values)) | look)


class Unit(NamedTuple):
    """A unit as printed, and the factor that converts to it from the result's own."""

    text: str
    factor: float


def readable(unit: str, values: ArrayLike) -> Unit:
    """Return the unit in which the largest of `values`, given in `unit`, has few zeros."""
    sizes = np.abs(np.asarray(values, dtype=float))
    text, factor = smaller_unit(unit, float(np.max(sizes, where=np.isfinite(sizes), initial=0.0)))
    return Unit(re.sub("^u", "µ", text).replace("^2", "²"), factor)


def unit_of(result: Result, name: str, largest: float | None = None) -> Unit:
    """Return the readable unit of a column of the history, or of a field whose largest value is `largest`."""
    stored = f"{name}_x" if name in VECTORS else name
    return readable(result.units(stored), result.history[name] if largest is None else largest)


def axis_label(name: str, unit: Unit) -> str:
    """Return meaning, symbol and unit of a load, such as ``normal approach $\\delta_z$ (µm)``."""
    return f"{physical_name(name)} ({unit.text})"


def physical_name(name: str) -> str:
    """Return a column of the history or a key in words, with its symbol if it is a load component or a bulk stress."""
    meaning = _SHORT_NAMES.get(name) or _LONG_NAMES.get(name) or name.replace("_", " ")
    return f"{meaning} {symbol(name)}" if name in _COMPONENTS else meaning


def quantity_label(words: str, units: str) -> str:
    """Return an axis label with its unit, without one where a number needs none; a parameter of fatigue has "-"."""
    if units in ("", "1"):
        return f"{words} (-)" if words.endswith("parameter") else words
    return f"{words} ({units.replace('um', 'µm').replace('^2', '²')})"


def symbol(name: str) -> str:
    """Return the symbol of a load component or a bulk stress, such as ``$\\delta_z$``."""
    if name.startswith("bulk_"):
        _, body, part = name.split("_")
        return rf"$\sigma_{{{part},{body}}}$"
    stem, axis = name.rstrip("xyz").rstrip("_"), name[1:][-1:]
    return f"${_LETTERS.get(stem, stem)}" + (f"_{axis}$" if axis else "$")


def set_increment_ticks(axes: Axes) -> None:
    """Set ticks of x at whole increments, each with its whole number."""
    axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10], min_n_ticks=1))
    axes.ticklabel_format(axis="x", style="plain", useOffset=False)


def short_number(value: float, scale: float) -> str:
    """Return `value` in four digits; 0 if it is round-off of `scale`."""
    return f"{value:.4g}" if abs(value) > 1e-9 * scale else "0"


def label_depth(axes: Axes, body: int, deepest: float) -> None:
    """Make y the depth, from the surface to `deepest` (mm): downwards in body 2, and upwards in body 1 above it."""
    axes.set_ylim((0.0, deepest) if body == 1 else (deepest, 0.0))
    axes.set_ylabel("depth (mm)" if panel_height(axes) < 1.1 else f"depth in body {body} (mm)")  # inches
