"""Draw fields over the contact plane with the outlines of contact and stick zone, for one increment or as a film."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from fretsolve.post.plots.canvas import TWO_COLUMNS, Canvas, Target, canvas, own_style, panel_width, title_of
from fretsolve.post.plots.labels import FIELD_NAMES, unit_of
from fretsolve.post.plots.load_history import step_texts
from fretsolve.post.plots.sheet import Sheet
from fretsolve.post.plots.snapshot import (
    VECTORS,
    Snapshot,
    cell_size,
    chosen_fields,
    chosen_step,
    outer_edges,
    require_area,
    view_box,
)
from fretsolve.result import Result
from fretsolve.result.state import ZONE_NAMES
from fretsolve.system.arrays import BoolArray, DoubleArray, IndexArray
from fretsolve.system.files import PICTURE_MARK

MAP_FIELDS = ("pressure", "shear", "slip", "zone", "work_density")
"""The panels by default; an animation has the first two."""

ZONE_COLORS = ListedColormap(["white", "#3b5b92", "#f2c14e"], "fretsolve zones")
"""Open, stick, slip: they differ in luminance as well."""


@dataclass(frozen=True)
class FieldScale:
    """Colours of a field. factor: from the result's unit to the unit in `label`."""

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
    require_area(result)
    snapshot = Snapshot(result, chosen_step(result, step))
    names = chosen_fields([snapshot], MAP_FIELDS, fields)
    box = view_box(result, snapshot.contact)
    with map_canvas(ax, snapshot, len(names), box) as drawn:
        for axes, name in zip(drawn.axes, names, strict=False):
            draw_panel(drawn, axes, snapshot, scale_of(result, name, snapshot.magnitude(name).max()), box)
    return drawn.figure


@dataclass(frozen=True)
class Film:
    """Maps of increments in one figure. show: draws the frame of an increment."""

    figure: Figure
    steps: tuple[int, ...]
    show: Callable[[int], tuple[()]]


def film(result: Result, ax: Sheet | None = None, fields: Sequence[str] | None = None, most: int = 60) -> Film:
    """Return the frames of at most `most` increments with fields, all in the same colours and limits.

    ax: what the frames look like. fields: names of the case file; by default pressure and shear. Raises PictureError.
    """
    require_area(result)
    chosen_step(result, None)
    steps = few_steps(result, most)
    names = chosen_fields([Snapshot(result, step) for step in steps], MAP_FIELDS[:2], fields)
    # Find the limits. The fields of one increment are held at a time.
    largest = [0.0] * len(names)
    contact = np.zeros((len(result.x), len(result.y)), bool)
    for snapshot in (Snapshot(result, step) for step in steps):
        contact |= snapshot.contact
        largest = [max(size, snapshot.magnitude(name).max()) for size, name in zip(largest, names, strict=True)]
    scales = [scale_of(result, name, size) for name, size in zip(names, largest, strict=True)]
    some = "" if len(steps) == len(result.steps) else f"; one of {len(steps)} frames of {len(result.steps)} increments"
    texts = dict(zip(steps, step_texts(result, steps), strict=True))
    last, box = Snapshot(result, steps[-1]), view_box(result, contact)
    with own_style():
        with map_canvas(ax, last, len(names), box) as drawn:
            for axes, scale in zip(drawn.axes, scales, strict=False):
                draw_panel(drawn, axes, last, scale, box)
        # Lay the figure out once, so that the panels do not move from frame to frame.
        drawn.figure.draw_without_rendering()
        drawn.figure.set_layout_engine(None)

    def show(step: int) -> tuple[()]:
        """Draw one frame."""
        snapshot = Snapshot(result, step)
        for axes, scale in zip(drawn.axes, scales, strict=False):
            for artist in (*axes.images, *axes.collections):
                artist.remove()
            draw_field(axes, snapshot, scale, box)
        drawn.heading(title_of(result), texts[step] + some)
        return ()

    return Film(drawn.figure, steps, show)


def few_steps(result: Result, most: int) -> tuple[int, ...]:
    """Return the increments with fields, or `most` of them from the first to the last."""
    steps = result.steps
    if len(steps) <= most:
        return steps
    return tuple(steps[k] for k in np.linspace(0, len(steps) - 1, most).round().astype(int))


def animation(result: Result, ax: Sheet | None = None, *, fields: Sequence[str] | None = None) -> FuncAnimation:
    """Draw fields over the increments with fields, in at most 60 frames; ``.save`` or ``.to_jshtml`` shows them.

    ax: what the frames look like. fields: names of the case file; by default pressure and shear. All frames have the
    same colours and limits. Raises PictureError.
    """
    drawn = film(result, ax, fields)
    rate = min(max(round(len(drawn.steps) / 10.0), 2), 12)  # frames per second, for a film of ten seconds
    return FuncAnimation(
        drawn.figure,
        drawn.show,
        frames=drawn.steps,
        interval=1000.0 / rate,
        init_func=lambda: (),
        cache_frame_data=False,
    )


def saved_film(moving: FuncAnimation, file_format: str, dpi: int) -> bytes:
    """Return an animation as the content of a gif or mp4 file."""
    with tempfile.TemporaryDirectory() as folder, own_style():
        target = Path(folder) / f"film.{file_format}"
        if file_format == "mp4":
            moving.save(target, writer="ffmpeg", dpi=dpi, metadata={"comment": PICTURE_MARK})
            return target.read_bytes()
        moving.save(target, writer="pillow", dpi=dpi)
        # A comment as GIF89a has it, which Matplotlib cannot write.
        comment = b"\x21\xfe" + bytes([len(PICTURE_MARK)]) + PICTURE_MARK.encode() + b"\x00"
        return target.read_bytes().removesuffix(b";") + comment + b";"


@contextmanager
def map_canvas(
    target: Target, snapshot: Snapshot, count: int, box: Bbox, larger: tuple[float, float] = (1.0, 1.0)
) -> Iterator[Canvas]:
    """Return a canvas of `count` maps with a heading and the key of the outlines; larger: factors on width, height."""
    aspect = box.height / box.width
    # some five square inches for the cells, within limits, and space for colour bar, labels and title
    width = max(min(math.sqrt(4.8 / aspect), 6.0, 4.0 / aspect), 0.5)
    width, height = width + 1.4, min(width * aspect, 4.0) + 0.75
    columns = max(1, min(count, int((1.2 if aspect > 2.0 else 1.05) * TWO_COLUMNS / width)))
    columns = 2 if (count, columns) == (4, 3) else columns
    with canvas(
        target, count, (larger[0] * width, larger[1] * height), columns, narrowest=0.72 if aspect > 2.0 else 0.83
    ) as drawn:
        yield drawn
        drawn.heading(title_of(snapshot.result), *step_texts(snapshot.result, [snapshot.step]))
        drawn.legend(outline_key(snapshot), columns=2)
        for axes in drawn.axes if drawn.own else ():
            place = axes.get_subplotspec()
            if place is not None and not place.is_first_col():
                axes.set_ylabel("")  # the first panel of the row has the label


def scale_of(result: Result, name: str, largest: float) -> FieldScale:
    """Return the scale of a field from 0 to `largest`, which is in its own units."""
    if name == "zone":
        return FieldScale(name, FIELD_NAMES[name], 1.0, BoundaryNorm([-0.5, 0.5, 1.5, 2.5], 3), ZONE_COLORS)
    unit = unit_of(result, name, largest)
    norm = Normalize(0.0, (largest or 1.0) * unit.factor)
    return FieldScale(name, f"{FIELD_NAMES[name]} ({unit.text})", unit.factor, norm, matplotlib.colormaps["cividis"])


def draw_panel(drawn: Canvas, axes: Axes, snapshot: Snapshot, scale: FieldScale, box: Bbox) -> None:
    """Draw one field with its frame and its colour bar, in equal scales along x and y."""
    image = draw_field(axes, snapshot, scale, box)
    draw_frame(axes, box, scale.label)
    bar = drawn.colorbar(axes, image)
    if scale.name == "zone":
        bar.set_ticks(range(len(ZONE_NAMES)), labels=ZONE_NAMES)
        bar.ax.minorticks_off()


def draw_field(axes: Axes, snapshot: Snapshot, scale: FieldScale, box: Bbox) -> AxesImage:
    """Draw one field with arrows and outlines, and return its image."""
    values = snapshot.magnitude(scale.name) * scale.factor
    shown = np.ones_like(values, bool) if scale.name in ("zone", "gap") else snapshot.contact | (values > 0.0)
    image = draw_cells(axes, snapshot.result, values, ~shown, scale.norm, scale.colors)
    if scale.name in VECTORS:
        draw_arrows(axes, snapshot.result, snapshot.field(scale.name), box)
    draw_outlines(axes, snapshot)
    return image


def draw_cells(
    axes: Axes, result: Result, values: NDArray[Any], hidden: BoolArray, norm: Normalize, colors: Colormap
) -> AxesImage:
    """Draw the cells (nx, ny) in their colours, except `hidden` cells."""
    return axes.imshow(
        np.ma.masked_where(hidden, values).T,
        origin="lower",
        extent=(*outer_edges(result.x), *outer_edges(result.y)),
        norm=norm,
        cmap=colors,
    )


def draw_frame(axes: Axes, box: Bbox, title: str) -> None:
    """Set title, limits, labels and equal scales of a map."""
    axes.grid(False)
    axes.set(aspect="equal", xlim=box.intervalx, ylim=box.intervaly, xlabel="x (mm)", ylabel="y (mm)", title=title)
    set_x_ticks(axes)


def set_x_ticks(axes: Axes) -> None:
    """Set as many ticks along x as have space for their labels, which are upright on a narrow panel."""
    width, label_width, label_height = panel_width(axes), 0.45, 0.2  # inches
    narrow = width < 3.0 * label_width
    most_ticks = max(4, int(width / label_height)) if narrow else int(width / label_width)
    axes.xaxis.set_major_locator(MaxNLocator(most_ticks, steps=[1, 2, 5, 10], min_n_ticks=2))
    axes.tick_params(axis="x", labelrotation=90.0 if narrow else 0.0)


def draw_outlines(axes: Axes, snapshot: Snapshot) -> None:
    """Draw the edges of the contact and, if it is known, of the stick zone."""
    # one more cell at each end, so that outlines close at the edge of the grid
    grid = snapshot.result.x, snapshot.result.y
    x, y = (centres[0] + cell_size(centres) * np.arange(-1, len(centres) + 1) for centres in grid)
    for _, mask, line in _outlines(snapshot):
        cells = np.pad(mask, 1).T.astype(float)
        drawn = axes.contour(x, y, cells, levels=[0.5], colors="black", linewidths=1.3, linestyles=[line])
        drawn.set_path_effects([withStroke(linewidth=2.4, foreground="white", alpha=0.7)])


def draw_arrows(axes: Axes, result: Result, vectors: DoubleArray, box: Bbox) -> None:
    """Draw arrows of equal length along `vectors` (2, nx, ny), except where they are below 3 % of the longest."""
    inside = cells_inside(result, box)
    # 17 arrows along the longer side, or 7 along the shorter one, at about equal distances, whatever the cells
    cells = cell_size(result.x), cell_size(result.y)
    apart = max(*cells, min(max(box.size) / 17.0, min(box.size) / 7.0))
    every = [max(1, math.ceil(apart / cell - 0.3)) for cell in cells]
    chosen = [indices[(len(indices) - 1) % n // 2 :: n] for indices, n in zip(inside, every, strict=True)]
    i, j = np.meshgrid(*chosen, indexing="ij")
    length = np.hypot(vectors[0], vectors[1])
    long = length[i, j] > 0.03 * length.max()
    if not long.any():
        return
    i, j = i[long], j[long]
    size = min(n * cell for n, cell in zip(every, cells, strict=True))
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


def cells_inside(result: Result, box: Bbox) -> list[IndexArray]:
    """Return the indices along x and along y of the cells whose centres lie in `box`."""
    sides = ((result.x, box.intervalx), (result.y, box.intervaly))
    return [np.flatnonzero((centres >= low) & (centres <= high)) for centres, (low, high) in sides]


def outline_key(snapshot: Snapshot) -> list[Line2D]:
    """Return the lines of a legend that name the outlines of the zones."""
    return [
        Line2D([], [], color="black", linewidth=1.3, linestyle=line, label=f"edge of the {name}")
        for name, _, line in _outlines(snapshot)
    ]


def _outlines(snapshot: Snapshot) -> Iterator[tuple[str, BoolArray, Any]]:
    """Yield name, cells and style of line of the contact and of the stick zone, unless they are empty or unknown."""
    for name, mask, line in (("contact", snapshot.contact, "-"), ("stick zone", snapshot.stick, (0, (3, 1.5)))):
        if mask is not None and mask.any():
            yield name, mask, line
