"""Fields over the contact plane, with the outlines of the contact and of the stick zone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas, panel_width
from fretsolve.plots.load_history import step_text
from fretsolve.plots.quantities import Unit, readable
from fretsolve.plots.snapshot import (
    VECTORS,
    Snapshot,
    Window,
    chosen_step,
    common_window,
    has_field,
    require_field,
    stored_names,
)
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, DoubleArray

if TYPE_CHECKING:
    from fretsolve.result import Result


FIELDS = ("pressure", "shear", "slip", "zone", "work_density")
"""The panels where none are asked for."""

NAMES = {
    "pressure": "pressure",
    "shear": "shear |q|",
    "slip": "slip",
    "slip_path": "slip path",
    "work_density": "dissipated work",
    "zone": "zone",
    "gap": "gap",
}
AREA = 9.0
"""Of a panel, square inches; a narrow one has less."""

NARROWEST, WIDEST, TALLEST = 0.7, 5.5, 4.6
AROUND = (1.5, 0.7)
"""Width and height (inches) of colour bar, labels and titles around a panel."""

PAGE_WIDTH = 14.0
TICK_SPACE = 0.45
"""What a tick's label along x takes at least (inches)."""
ARROWS = 17
"""Arrows along the longer side of a panel."""

LEAST_ARROW = 0.03
"""Vectors shorter than this part of the longest have no arrow."""

ZONE_COLORS = ListedColormap(["white", "#3b5b92", "#f2c14e"], "fretsolve zones")
"""Open, stick, slip: apart in luminance as well."""

CONTACT_LINE: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": "-"}
STICK_LINE: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": (0, (3, 1.5))}


@dataclass(frozen=True)
class Scale:
    """How a field is coloured: its unit, limits and map."""

    name: str
    unit: Unit
    norm: Normalize
    colors: Colormap

    @property
    def label(self) -> str:
        """Name and unit."""
        return f"{NAMES[self.name]} ({self.unit.text})" if self.name != "zone" else "zone"

    def mappable(self) -> ScalarMappable:
        """For a colour bar."""
        return ScalarMappable(self.norm, self.colors)


def contact_map(
    result: Result, ax: Target = None, *, step: int | None = None, fields: Sequence[str] | None = None
) -> Figure:
    """Fields at an increment, by default the last with fields, zoomed to the contact, with the outlines of its zones.

    fields: by their names in the case file; by default pressure, shear, slip, zone and work density, as far as they
    are stored and not 0 all over. Arrows show the direction of vectors. Raises PictureError.
    """
    snapshot = Snapshot(result, chosen_step(result, step))
    names = checked_fields(result, fields) if fields else present_fields([snapshot], FIELDS)
    seen = common_window([snapshot])
    columns, rows = arrangement(len(names), seen)
    with canvas(ax, rows, columns, panel_size(seen)) as drawn:
        for axes, name in zip(drawn.axes, names, strict=False):
            scale = scale_of(result, name, float(finite_magnitude(snapshot, name).max()))
            draw_panel(drawn, axes, snapshot, scale, seen)
        hide_rest(drawn, len(names))
        drawn.heading(result, step_text(result, snapshot.step))
        drawn.legend(outline_key(snapshot), columns=2)
    return drawn.figure


def checked_fields(result: Result, names: Sequence[str]) -> list[str]:
    """`names` as they are. Raises PictureError for one that is no field, or not stored."""
    for name in names:
        if name not in NAMES:
            raise PictureError(f"there is no field {name!r}; stored are {', '.join(stored_names(result)) or 'none'}")
        require_field(result, name)
    return list(dict.fromkeys(names))


def present_fields(snapshots: Sequence[Snapshot], names: Sequence[str]) -> list[str]:
    """Those of `names` that are stored and not 0 all over; the first stored one if all are. Raises PictureError."""
    result = snapshots[0].result
    stored = [name for name in names if has_field(result, name)]
    if not stored:
        require_field(result, names[0])
    present = [name for name in stored if any(snapshot.field(name).any() for snapshot in snapshots)]
    return present or stored[:1]


def panel_size(seen: Window) -> tuple[float, float]:
    """Width and height of a panel with what is around it (inches)."""
    width = min(math.sqrt(AREA / seen.aspect), WIDEST, TALLEST / seen.aspect)
    width = max(width, NARROWEST)
    return width + AROUND[0], min(width * seen.aspect, TALLEST) + AROUND[1]


def arrangement(count: int, seen: Window) -> tuple[int, int]:
    """Columns and rows of `count` panels."""
    columns = max(1, min(count, int(PAGE_WIDTH / panel_size(seen)[0])))
    columns = 2 if (count, columns) == (4, 3) else columns
    return columns, -(-count // columns)


def finite_magnitude(snapshot: Snapshot, name: str) -> DoubleArray:
    """The values or lengths of a field, 0 where there is no material (the gap is infinite there)."""
    values = snapshot.magnitude(name)
    return np.where(np.isfinite(values), values, 0.0)


def scale_of(result: Result, name: str, largest: float) -> Scale:
    """The scale of a field from 0 to `largest`, in its own units."""
    if name == "zone":
        return Scale(name, Unit("1", 1.0), BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3), ZONE_COLORS)
    unit = readable(result.units(f"{name}_x" if name in VECTORS else name), largest)
    return Scale(name, unit, Normalize(0.0, (largest or 1.0) * unit.factor), matplotlib.colormaps["cividis"])


def draw_panel(drawn: Canvas, axes: Axes, snapshot: Snapshot, scale: Scale, seen: Window) -> None:
    """One field with its frame and its colour bar, in equal scales along x and y."""
    draw_field(axes, snapshot, scale, seen)
    frame(axes, seen)
    axes.set_title(NAMES[scale.name])
    bar = drawn.colorbar(axes, scale.mappable(), scale.label)
    if scale.name == "zone":
        bar.set_ticks([zone.value for zone in Zone], labels=[zone.name.lower() for zone in Zone])
        bar.set_label("")
        bar.ax.minorticks_off()


def draw_field(axes: Axes, snapshot: Snapshot, scale: Scale, seen: Window) -> None:
    """One field with arrows and outlines."""
    result = snapshot.result
    values = finite_magnitude(snapshot, scale.name) * scale.unit.factor
    shown = np.ones_like(values, bool) if scale.name in ("zone", "gap") else snapshot.contact | (values > 0.0)
    draw_cells(axes, result, values, ~shown, scale.norm, scale.colors)
    if scale.name in VECTORS:
        draw_arrows(axes, result, snapshot.field(scale.name), seen)
    draw_outlines(axes, snapshot)


def draw_cells(
    axes: Axes, result: Result, values: NDArray[Any], hidden: BoolArray, norm: Normalize, colors: Colormap
) -> None:
    """Cells (nx, ny) in their colours, but for those `hidden`."""
    half_x, half_y = 0.5 * _cell(result.x), 0.5 * _cell(result.y)
    axes.imshow(
        np.ma.masked_where(hidden, values).T,
        origin="lower",
        extent=(result.x[0] - half_x, result.x[-1] + half_x, result.y[0] - half_y, result.y[-1] + half_y),
        norm=norm,
        cmap=colors,
    )


def frame(axes: Axes, seen: Window) -> None:
    """Limits, labels and equal scales of a map."""
    axes.grid(False)
    axes.set_aspect("equal")
    axes.set_xlim(seen.x)
    axes.set_ylim(seen.y)
    most_ticks = max(1, int(panel_width(axes) / TICK_SPACE))
    axes.xaxis.set_major_locator(MaxNLocator(most_ticks, steps=[1, 2, 5, 10], min_n_ticks=1))
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")


def draw_outlines(axes: Axes, snapshot: Snapshot) -> None:
    """The edge of the contact, and that of the stick zone where it is known."""
    _draw_outline(axes, snapshot, snapshot.contact, CONTACT_LINE)
    if snapshot.stick is not None:
        _draw_outline(axes, snapshot, snapshot.stick, STICK_LINE)


def outline_key(snapshot: Snapshot) -> list[Line2D]:
    """Handles of the outlines for a legend."""
    handles = [Line2D([], [], label="edge of the contact", **CONTACT_LINE)]
    if snapshot.stick is not None and snapshot.stick.any():
        handles.append(Line2D([], [], label="edge of the stick zone", **STICK_LINE))
    return handles


def hide_rest(drawn: Canvas, used: int) -> None:
    """Take away the panels that nothing is drawn on."""
    for axes in drawn.axes[used:] if drawn.own else ():
        axes.set_axis_off()


def _draw_outline(axes: Axes, snapshot: Snapshot, mask: BoolArray, options: dict[str, Any]) -> None:
    if not mask.any():
        return
    x, y = (_padded(centres) for centres in (snapshot.result.x, snapshot.result.y))
    lines = axes.contour(
        x,
        y,
        np.pad(mask, 1).T.astype(float),
        levels=[0.5],
        colors=options["color"],
        linewidths=options["linewidth"],
        linestyles=[options["linestyle"]],
    )
    lines.set_path_effects([withStroke(linewidth=2.4, foreground="white", alpha=0.7)])


def _padded(centres: DoubleArray) -> DoubleArray:
    """Cell centres with one more cell at either end, so that outlines close at the grid's edge."""
    cell = _cell(centres)
    return np.concatenate([[centres[0] - cell], centres, [centres[-1] + cell]])


def _cell(centres: DoubleArray) -> float:
    """The side of a cell (mm); 1 where there is one cell alone."""
    return float(centres[1] - centres[0]) if len(centres) > 1 else 1.0


def draw_arrows(axes: Axes, result: Result, vectors: DoubleArray, seen: Window) -> None:
    """Arrows of equal length in the direction of those of `vectors` (2, nx, ny) that are not small."""
    inside = [
        np.flatnonzero((centres >= low) & (centres <= high))
        for centres, (low, high) in ((result.x, seen.x), (result.y, seen.y))
    ]
    every = max(1, -(-max(len(indices) for indices in inside) // ARROWS))
    chosen = (indices[(len(indices) - 1) % every // 2 :: every] for indices in inside)
    i, j = np.meshgrid(*chosen, indexing="ij")
    length = np.hypot(vectors[0], vectors[1])
    long = length[i, j] > LEAST_ARROW * length.max()
    if not long.any():
        return
    i, j = i[long], j[long]
    size = every * _cell(result.x)
    axes.quiver(
        result.x[i],
        result.y[j],
        *(vectors[:, i, j] / length[i, j]),
        pivot="middle",
        angles="xy",
        units="xy",
        scale_units="xy",
        scale=1.0 / (0.75 * size),
        width=0.12 * size,
        facecolor="white",
        edgecolor="black",
        linewidth=0.4,
    )
