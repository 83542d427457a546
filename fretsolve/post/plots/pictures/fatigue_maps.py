"""Draw fatigue parameters and lives about the place where cracks may begin, with the trace of the critical plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.ticker import LogLocator, MaxNLocator

from fretsolve.case.keys.quantity_names import dataset_name
from fretsolve.errors import PictureError
from fretsolve.post.fatigue.fatigue_file import BodyFatigue, fatigue_bodies
from fretsolve.post.names import fatigue_path
from fretsolve.post.plots.canvas import PANEL_WIDTH, Canvas, Target, canvas, scaled_height, title_of
from fretsolve.post.plots.labels import label_depth
from fretsolve.post.plots.pictures.beside import chosen_bodies, file_beside
from fretsolve.post.plots.pictures.fatigue_panel import PARTS, WHITE, Panel, panels_of
from fretsolve.post.plots.pictures.maps import set_x_ticks
from fretsolve.post.plots.pictures.stresses import draw_layer, draw_section
from fretsolve.post.stress.influence import Body
from fretsolve.result import Result

CONTACT: dict[str, Any] = {"color": "black", "linewidth": 3.0}
EDGE: dict[str, Any] = {"color": "white", "linewidth": 1.2, "linestyle": "--"}
"""Looks of the contact in a section, and of its edge in a layer."""


def _outlined(color: str, width: float) -> list[AbstractPathEffect]:
    """Return an outline of a line, which makes it visible on dark and on bright colours."""
    return [withStroke(linewidth=width, foreground=color)]


def fatigue_map(
    result: Result, ax: Target = None, *, fields: Sequence[str] | None = None, body: Body | None = None
) -> Figure:
    """Draw what `fretsolve fatigue` wrote beside the result about the worst place, in a section and a layer.

    fields: criteria, or swt_life and the like; body: by default all in the file. Section and layer go through the worst
    place, where a line is the trace of the critical plane, and show the region where the parameter is a notable share
    of its largest value, with the nearest edge of contact. A line contact has two sections, of which one shows the
    whole contact. Depth points upwards in body 1. Of a criterion the utilisation is drawn, with its contour 1, or the
    parameter if it has no limit. Raises PictureError, FileError if the file is damaged.
    """
    with file_beside(result, fatigue_path(result.path), "fatigue") as computed:
        bodies = chosen_bodies(fatigue_bodies(computed), body, "parameters")
        panels = [
            panel
            for number, found in reversed(list(bodies.items()))
            for name in _chosen(found, fields)
            for panel in panels_of(result, number, found, name, named=len(bodies) > 1)
        ]
        heights = [
            2.6 if panel.kind == "curve" else 0.2 + scaled_height(panel.box.height / panel.box.width, PANEL_WIDTH)
            for panel in panels
        ]
        with canvas(ax, len(panels), (PANEL_WIDTH, max(heights)), columns=2, heights=heights) as drawn:
            for axes, panel in zip(drawn.axes, panels, strict=False):
                if panel.kind == "curve":
                    _draw_curve(axes, panel)
                else:
                    _draw(drawn, axes, panel)
            average = str(computed.attributes.get("average", ""))
            of_body = " and ".join(f"body {number}" for number in bodies)
            drawn.heading(title_of(result), of_body + (f", {average}" if average else ""))
            drawn.legend(list(_key(panels)), columns=3)
        return drawn.figure


def _chosen(body: BodyFatigue, fields: Sequence[str] | None) -> tuple[str, ...]:
    """Return the datasets to draw, by default the utilisations of the criteria, or the parameters without a limit."""
    there = {name: [part for part in PARTS if f"{name}_{part}" in body.group] for name in body.criteria}
    usual = {name: f"{name}_utilisation" if "utilisation" in parts else name for name, parts in there.items()}
    known = (*usual, *(f"{name}_{part}" for name, parts in there.items() for part in parts))
    names = tuple(dataset_name(name) for name in fields or ())
    if unknown := [name for name in names if name not in known]:
        raise PictureError(f"{unknown[0]!r} is not in the file, which has {', '.join(known)}")
    return tuple(usual.get(name, name) for name in names or usual)


def _key(panels: Sequence[Panel]) -> Iterator[Any]:
    """Yield the entries of the legend."""
    kinds, parts = {panel.kind for panel in panels}, {panel.part for panel in panels}
    yield Line2D([], [], color="black", marker="+", linestyle="", label="worst place")
    if any(panel.kind != "curve" and f"{panel.criterion}_normal" in panel.body.group for panel in panels):
        yield Line2D([], [], color="black", linewidth=2.0, label="trace of the critical plane")
    if "section" in kinds:
        yield Line2D([], [], label="contact", **CONTACT)
    if "layer" in kinds:
        yield Line2D([], [], label="edge of contact", path_effects=_outlined("black", 2.4), **EDGE)
    if "utilisation" in parts and kinds != {"curve"}:
        yield Line2D([], [], color="white", linewidth=1.6, label="at the limit", path_effects=_outlined("black", 2.8))
    for part, meaning in WHITE.items():
        if part in parts:
            if kinds == {"curve"}:
                yield Line2D([], [], linestyle="", label=f"no line: {meaning}")
            else:
                yield Patch(facecolor="white", edgecolor="0.5", label=f"white: {meaning}")


def _draw_curve(axes: Axes, panel: Panel) -> None:
    """Draw a curve along x, of a body with one depth and one row of cells."""
    curve = panel.values[0, :, 0]
    axes.plot(panel.body.x, curve, color="black")
    if panel.part in WHITE:
        axes.set_yscale("log")
    worst = panel.worst_place[1]
    axes.plot(panel.body.x[worst], curve[worst], "k+", markersize=8.0)
    if panel.part == "utilisation":
        axes.axhline(1.0, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel="x (mm)", ylabel=panel.label, title=panel.title)


def _draw(drawn: Canvas, axes: Axes, panel: Panel) -> None:
    """Draw a section or a layer with contours. The depth of body 1 is along -z."""
    box, x, across = panel.box, panel.body.x, panel.across
    values = np.ma.masked_invalid(panel.plane(panel.values))
    log = panel.part in WHITE
    look = _colors(values, log=log)
    if panel.kind == "section":
        shading = "nearest" if log else "gouraud"  # which has no places without a colour
        draw_section(axes, x, across, values, panel.number, shading=shading, **look)
        label_depth(axes, panel.number, box.ymax)
        row = panel.contact[:, panel.worst_place[2]]
        axes.plot(x, np.where(row, 0.0, np.nan), solid_capstyle="butt", path_effects=_outlined("white", 4.6), **CONTACT)
    else:
        draw_layer(axes, x, across, values, **look)
        axes.set_ylim(box.intervaly)
        if panel.contact.any() and not panel.contact.all():
            lines = axes.contour(
                x, across, panel.contact.T, levels=[0.5], colors="white", linewidths=1.2, linestyles="--"
            )
            lines.set_path_effects(_outlined("black", 2.4))
    axes.set_title(panel.title, pad=9.0)  # above the mark of a worst place on the surface
    axes.set_xlim(box.intervalx)
    set_x_ticks(axes)
    bar = drawn.colorbar(axes, ScalarMappable(**look), panel.label)
    levels = [level for level in _levels(values, log=log) if values.min() < level < values.max()]
    if panel.whole:
        spot = panel.hot_spot
        frame = Rectangle(spot.p0, spot.width, spot.height, fill=False, edgecolor="white", linewidth=1.0)
        axes.add_patch(frame)
    elif levels:
        bar.add_lines(
            axes.contour(x, across, values.T, levels=levels, colors="0.35" if log else "0.75", linewidths=0.7)
        )
    if panel.part == "utilisation" and values.min() < 1.0 < values.max():
        limit = axes.contour(x, across, values.T, levels=[1.0], colors="white", linewidths=1.6)
        limit.set_path_effects(_outlined("black", 2.8))
    axes.set(xlim=axes.get_xlim(), ylim=axes.get_ylim())
    _draw_worst(axes, panel)


def _colors(values: Any, *, log: bool) -> dict[str, Any]:
    """Return the colours of a panel: from 0 on, or of a logarithm, where short lives are bright."""
    if not log:
        return {"norm": Normalize(0.0, float(values.max()) or 1.0), "cmap": matplotlib.colormaps["cividis"]}
    colors = matplotlib.colormaps["cividis_r"].with_extremes(bad="white")
    some = values.compressed() if values.count() else np.ones(1)
    return {"norm": LogNorm(some.min(), some.max()), "cmap": colors}


def _levels(values: Any, *, log: bool) -> Any:
    """Return the levels of contours."""
    if not values.count():
        return []
    locator = LogLocator(numticks=8) if log else MaxNLocator(8)
    return locator.tick_values(float(values.min()), float(values.max()))


def _draw_worst(axes: Axes, panel: Panel) -> None:
    """Mark the worst place, with a short line along the trace of its critical plane if there is a plane."""
    i, k = panel.worst
    place = panel.body.x[i], panel.across[k]
    limits = axes.get_xlim(), axes.get_ylim()
    axes.plot(*place, "k+", markersize=9.0, clip_on=False, zorder=4.0, path_effects=_outlined("white", 3.0))
    name = f"{panel.criterion}_normal"
    if name in panel.body.group:
        normal = panel.body.field(name)[panel.worst_place]
        upwards = -1.0 if panel.number == 1 else 1.0
        along = np.array([-normal[2] * upwards, normal[0]] if panel.kind == "section" else [-normal[1], normal[0]])
        if (length := float(np.hypot(*along))) > 0.05:
            half = 0.08 * abs(limits[0][1] - limits[0][0]) * along / length
            ends = [[place[axis] - half[axis], place[axis] + half[axis]] for axis in (0, 1)]
            axes.plot(*ends, color="black", linewidth=2.0, path_effects=_outlined("white", 3.4))
    axes.set(xlim=limits[0], ylim=limits[1])
