"""Draw fields over the contact plane, with the outlines of the contact and of the stick zone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

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
from fretsolve.plots.labels import readable
from fretsolve.plots.load_history import step_text
from fretsolve.plots.snapshot import (
    VECTORS,
    Snapshot,
    ViewBox,
    cell_size,
    chosen_step,
    component,
    present_fields,
    require_field,
    stored_names,
    view_box,
)
from fretsolve.result import Result
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, DoubleArray, IndexArray

FIELDS = ("pressure", "shear", "slip", "zone", "work_density")
"""The panels by default."""

NAMES = {
    "pressure": "pressure",
    "shear": "shear traction",
    "slip": "slip",
    "slip_path": "slip path",
    "work_density": "dissipated energy",
    "zone": "zone",
    "gap": "gap",
}
AREA = 9.0
"""Square inches of a panel; a narrow one has less."""

NARROWEST, WIDEST, TALLEST = 0.7, 5.5, 4.6
AROUND = (1.5, 0.7)
"""Width and height (inches) of colour bar, labels and titles around a panel."""

PAGE_WIDTH = 14.0
TICK_SPACE = 0.45
"""Inches that the label of a tick on x needs."""

ARROWS = 17
"""Arrows along the longer side of a panel."""

LEAST_ARROW = 0.03
"""Vectors shorter than this part of the longest have no arrow."""

ZONE_COLORS = ListedColormap(["white", "#3b5b92", "#f2c14e"], "fretsolve zones")
"""Open, stick, slip: they differ in luminance as well."""

CONTACT_LINE: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": "-"}
STICK_LINE: dict[str, Any] = {"color": "black", "linewidth": 1.3, "linestyle": (0, (3, 1.5))}


@dataclass(frozen=True)
class FieldScale:
    """How a field is coloured. factor: from the result's unit to that of `label`."""

    name: str
    label: str
    factor: float
    norm: Normalize
    colors: Colormap


def contact_map(
    result: Result, ax: Target = None, *, step: int | None = None, fields: Sequence[str] | None = None
) -> Figure:
    """Draw fields at an increment, zoomed to the contact, with the outlines of its zones.

    step: by default the last one with fields. fields: names of the case file; by default pressure, shear, slip, zone
    and work_density, if they are stored and not 0 everywhere. Arrows show the direction of vectors. Raises
    PictureError.
    """
    snapshot = Snapshot(result, chosen_step(result, step))
    names = chosen_fields([snapshot], fields, FIELDS)
    box = view_box(result, snapshot.contact)
    with map_canvas(ax, snapshot, len(names), box) as drawn:
        for axes, name in zip(drawn.axes, names, strict=False):
            draw_panel(drawn, axes, snapshot, scale_of(result, name, largest_of(snapshot, name)), box)
    return drawn.figure


@contextmanager
def map_canvas(
    target: Target, snapshot: Snapshot, count: int, box: ViewBox, larger: tuple[float, float] = (1.0, 1.0)
) -> Iterator[Canvas]:
    """Return a canvas of `count` maps with a heading and the key of the outlines; larger: factors on width, height."""
    width, height = panel_size(box)
    columns = max(1, min(count, int(PAGE_WIDTH / width)))
    columns = 2 if (count, columns) == (4, 3) else columns
    with canvas(target, -(-count // columns), columns, (larger[0] * width, larger[1] * height)) as drawn:
        yield drawn
        drawn.hide_rest(count)
        drawn.heading(snapshot.result, step_text(snapshot.result, snapshot.step))
        drawn.legend(_outline_key(snapshot), columns=2)


def chosen_fields(snapshots: Sequence[Snapshot], asked: Sequence[str] | None, usual: Sequence[str]) -> list[str]:
    """Return the fields that are asked for, or the usual ones that are present. Raises PictureError."""
    result = snapshots[0].result
    for name in asked or ():
        if name not in NAMES:
            raise PictureError(f"there is no field {name!r}; stored are {stored_names(result)}")
        require_field(result, name)
    return list(dict.fromkeys(asked)) if asked else present_fields(snapshots, usual)


def panel_size(box: ViewBox) -> tuple[float, float]:
    """Return width and height of a panel with what is around it (inches)."""
    width = min(math.sqrt(AREA / box.aspect), WIDEST, TALLEST / box.aspect)
    width = max(width, NARROWEST)
    return width + AROUND[0], min(width * box.aspect, TALLEST) + AROUND[1]


def scale_of(result: Result, name: str, largest: float) -> FieldScale:
    """Return the scale of a field from 0 to `largest`, which is in its own units."""
    if name == "zone":
        return FieldScale(name, "", 1.0, BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3), ZONE_COLORS)
    unit = readable(result.units(component(name)), largest)
    norm = Normalize(0.0, (largest or 1.0) * unit.factor)
    return FieldScale(name, f"{NAMES[name]} ({unit.text})", unit.factor, norm, matplotlib.colormaps["cividis"])


def largest_of(snapshot: Snapshot, name: str) -> float:
    """Return the largest finite value or length of a field."""
    return float(_finite_magnitude(snapshot, name).max())


def draw_panel(drawn: Canvas, axes: Axes, snapshot: Snapshot, scale: FieldScale, box: ViewBox) -> None:
    """Draw one field with its frame and its colour bar, in equal scales along x and y."""
    draw_field(axes, snapshot, scale, box)
    draw_frame(axes, box)
    axes.set_title(NAMES[scale.name])
    bar = drawn.colorbar(axes, ScalarMappable(scale.norm, scale.colors), scale.label)
    if scale.name == "zone":
        bar.set_ticks([zone.value for zone in Zone], labels=[zone.name.lower() for zone in Zone])
        bar.ax.minorticks_off()


def draw_field(axes: Axes, snapshot: Snapshot, scale: FieldScale, box: ViewBox) -> None:
    """Draw one field with arrows and outlines."""
    values = _finite_magnitude(snapshot, scale.name) * scale.factor
    shown = np.ones_like(values, bool) if scale.name in ("zone", "gap") else snapshot.contact | (values > 0.0)
    draw_cells(axes, snapshot.result, values, ~shown, scale.norm, scale.colors)
    if scale.name in VECTORS:
        draw_arrows(axes, snapshot.result, snapshot.field(scale.name), box)
    draw_outlines(axes, snapshot)


def draw_cells(
    axes: Axes, result: Result, values: NDArray[Any], hidden: BoolArray, norm: Normalize, colors: Colormap
) -> None:
    """Draw the cells (nx, ny) in their colours, except those `hidden`."""
    half_x, half_y = 0.5 * cell_size(result.x), 0.5 * cell_size(result.y)
    axes.imshow(
        np.ma.masked_where(hidden, values).T,
        origin="lower",
        extent=(result.x[0] - half_x, result.x[-1] + half_x, result.y[0] - half_y, result.y[-1] + half_y),
        norm=norm,
        cmap=colors,
    )


def draw_frame(axes: Axes, box: ViewBox) -> None:
    """Set limits, labels and equal scales of a map."""
    axes.grid(False)
    axes.set_aspect("equal")
    axes.set_xlim(box.x)
    axes.set_ylim(box.y)
    most_ticks = max(1, int(panel_width(axes) / TICK_SPACE))
    axes.xaxis.set_major_locator(MaxNLocator(most_ticks, steps=[1, 2, 5, 10], min_n_ticks=1))
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")


def draw_outlines(axes: Axes, snapshot: Snapshot) -> None:
    """Draw the edge of the contact, and that of the stick zone if it is known."""
    x, y = (_padded(centres) for centres in (snapshot.result.x, snapshot.result.y))
    for mask, line in ((snapshot.contact, CONTACT_LINE), (snapshot.stick, STICK_LINE)):
        if mask is not None and mask.any():
            options: dict[str, Any] = {f"{name}s": [value] for name, value in line.items()}
            drawn = axes.contour(x, y, np.pad(mask, 1).T.astype(float), levels=[0.5], **options)
            drawn.set_path_effects([withStroke(linewidth=2.4, foreground="white", alpha=0.7)])


def draw_arrows(axes: Axes, result: Result, vectors: DoubleArray, box: ViewBox) -> None:
    """Draw arrows of equal length along those of `vectors` (2, nx, ny) that are not small."""
    inside = cells_inside(result, box)
    every = max(1, -(-max(len(indices) for indices in inside) // ARROWS))
    i, j = np.meshgrid(*(indices[(len(indices) - 1) % every // 2 :: every] for indices in inside), indexing="ij")
    length = np.hypot(vectors[0], vectors[1])
    long = length[i, j] > LEAST_ARROW * length.max()
    if not long.any():
        return
    i, j = i[long], j[long]
    size = every * cell_size(result.x)
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


def cells_inside(result: Result, box: ViewBox) -> tuple[IndexArray, IndexArray]:
    """Return the indices along x and along y of the cells whose centres lie in `box`."""
    found = [
        np.flatnonzero((centres >= low) & (centres <= high))
        for centres, (low, high) in ((result.x, box.x), (result.y, box.y))
    ]
    return found[0], found[1]


def _finite_magnitude(snapshot: Snapshot, name: str) -> DoubleArray:
    """Return the values or lengths of a field; 0 where there is no material, as the gap is infinite there."""
    values = snapshot.magnitude(name)
    return np.where(np.isfinite(values), values, 0.0)


def _outline_key(snapshot: Snapshot) -> list[Line2D]:
    lines = [("contact", snapshot.contact, CONTACT_LINE), ("stick zone", snapshot.stick, STICK_LINE)]
    return [
        Line2D([], [], label=f"edge of the {name}", **line)
        for name, mask, line in lines
        if mask is not None and mask.any()
    ]


def _padded(centres: DoubleArray) -> DoubleArray:
    """Return cell centres with one more cell at each end, so that outlines close at the edge of the grid."""
    cell = cell_size(centres)
    return np.concatenate([[centres[0] - cell], centres, [centres[-1] + cell]])
