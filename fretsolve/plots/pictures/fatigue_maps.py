"""Draw fatigue parameters: a section through the worst place and its layer, with the critical plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.transforms import Bbox

from fretsolve.errors import PictureError
from fretsolve.fatigue.fatigue_file import BodyFatigue, fatigue_bodies
from fretsolve.fatigue.names import dataset_name, fatigue_path
from fretsolve.plots.canvas import Canvas, Target, canvas, scaled_height, title_of
from fretsolve.plots.labels import label_depth
from fretsolve.plots.pictures.maps import set_x_ticks
from fretsolve.plots.pictures.stresses import DEEPEST, SIDE_MARGIN, WIDTH
from fretsolve.plots.snapshot import outer_edges
from fretsolve.result import Result
from fretsolve.stress.computed_file import opened_computed
from fretsolve.stress.influence import Body
from fretsolve.system.arrays import DoubleArray

NAMES = {
    "crossland": "Crossland",
    "dang_van": "Dang Van",
    "findley": "Findley",
    "mcdiarmid": "McDiarmid",
    "fatemi_socie": "Fatemi-Socie",
    "swt": "Smith-Watson-Topper",
}
"""Authors of the criteria, by their datasets."""

CURVE_HEIGHT = 2.6
"""Inches of the panel of a curve."""

TRACE = 0.08
"""Length of the critical plane's trace on either side of the worst place, over the width of a panel."""


@dataclass(frozen=True)
class _Panel:
    """A criterion of a body, drawn as a section, a layer or a curve (`kind`)."""

    number: int
    body: BodyFatigue
    name: str
    kind: str
    title: str

    @property
    def values(self) -> DoubleArray:
        """The parameter over depth, x and y."""
        return self.body.field(self.name)

    @property
    def worst_place(self) -> tuple[int, int, int]:
        """Indices of the largest parameter over depth, x and y."""
        depth, i, j = (int(part) for part in np.unravel_index(int(self.values.argmax()), self.values.shape))
        return depth, i, j

    def shown(self) -> tuple[DoubleArray, bool, str]:
        """Return the utilisation, or the parameter if it has no limit; which of them; and their label."""
        limited = f"{self.name}_utilisation" in self.body.group
        units = str(self.body.attribute(self.name, "units"))
        label = "utilisation" if limited else f"parameter ({units})" if units != "1" else "parameter"
        return self.body.field(f"{self.name}_utilisation") if limited else self.values, limited, label


def fatigue_map(
    result: Result, ax: Target = None, *, fields: Sequence[str] | None = None, body: Body | None = None
) -> Figure:
    """Draw the parameters that `fretsolve fatigue` wrote beside the result, each in a section and a layer.

    fields: criteria; body: by default all in the file. Section and layer go through the worst place, where a line is
    the trace of the critical plane; depth points upwards in body 1. Shown is the utilisation with its contour 1, or the
    parameter if it has no limit. Raises PictureError, FileError if the file is damaged.
    """
    path = fatigue_path(result.path)
    with opened_computed(path) as computed:
        if computed is None or computed.kind != "fatigue":
            raise PictureError(f"there are no fatigue parameters in {path.name}; `fretsolve fatigue` writes them")
        if computed.attributes.get("effective_case") != result.attributes["effective_case"]:
            raise PictureError(f"{path.name} is not of this result; `fretsolve fatigue --overwrite` writes it again")
        bodies = _bodies(fatigue_bodies(computed), body)
        panels = [
            _Panel(number, found, name, kind, f"body {number}, {NAMES[name]}" if len(bodies) > 1 else NAMES[name])
            for number, found in reversed(bodies.items())
            for name in _chosen(found, fields)
            for kind in _kinds(found)
        ]
        boxes = [_box(result, panel) for panel in panels]
        heights = [CURVE_HEIGHT if box is None else scaled_height(box.height / box.width, WIDTH) for box in boxes]
        with canvas(ax, len(panels), (WIDTH, max(heights)), columns=2, heights=heights) as drawn:
            for axes, panel, box in zip(drawn.axes, panels, boxes, strict=False):
                if box is None:
                    _draw_curve(axes, panel)
                else:
                    _draw(drawn, axes, panel, box)
            average = str(computed.attributes.get("average", ""))
            of_body = " and ".join(f"body {number}" for number in bodies)
            drawn.heading(title_of(result), of_body + (f", {average}" if average else ""))
            drawn.legend(
                [
                    Line2D([], [], color="black", marker="+", linestyle="", label="worst place"),
                    Line2D([], [], color="black", linewidth=2.0, label="trace of the critical plane"),
                    Line2D([], [], color="white", linewidth=1.2, label="utilisation 1", path_effects=_OUTLINE),
                ],
                columns=3,
            )
        return drawn.figure


_OUTLINE: list[AbstractPathEffect] = [withStroke(linewidth=2.4, foreground="black")]


def _bodies(found: Mapping[int, BodyFatigue], body: Body | None) -> dict[int, BodyFatigue]:
    """Return the bodies to draw, by number. Raises PictureError."""
    if body is None:
        return dict(found)
    if body not in found:
        there = " and ".join(f"body {number}" for number in found)
        raise PictureError(f"the file has no parameters of body {body}, only of {there}")
    return {body: found[body]}


def _kinds(body: BodyFatigue) -> list[str]:
    """Return the panels of a criterion: a section and a layer, or a curve where neither is there."""
    there = [("section", len(body.depths) > 1), ("layer", len(body.y) > 1)]
    return [kind for kind, is_there in there if is_there] or ["curve"]


def _chosen(body: BodyFatigue, fields: Sequence[str] | None) -> tuple[str, ...]:
    """Return the datasets to draw."""
    names = tuple(dataset_name(name) for name in fields or ())
    if unknown := [name for name in names if name not in body.criteria]:
        raise PictureError(f"{unknown[0]!r} is not in the file, which has {', '.join(body.criteria)}")
    return names or body.criteria


def _box(result: Result, panel: _Panel) -> Bbox | None:
    """Return what a section or a layer shows (mm): where bodies touch at any time, a margin, and the worst place.

    None for a curve.
    """
    if panel.kind == "curve":
        return None
    body, worst = panel.body, panel.worst_place
    sides = []
    for axis, centres, at in (("x", body.x, worst[1]), ("y", body.y, worst[2])):
        half, middle = (result.history[f"contact_{part}_{axis}"] for part in ("half_width", "center"))
        low, high = outer_edges(centres)
        if np.isfinite(middle[half > 0.0]).any():
            half, middle = half[half > 0.0], middle[half > 0.0]
            margin = SIDE_MARGIN * float(half.max())
            least, most = float(np.nanmin(middle - half)), float(np.nanmax(middle + half))
            low, high = max(low, min(least, centres[at]) - margin), min(high, max(most, centres[at]) + margin)
        sides.append((low, high))
    if panel.kind == "section":
        deep = max(
            0.5 * DEEPEST / (1.0 + SIDE_MARGIN) * (sides[0][1] - sides[0][0]), 1.2 * float(body.depths[worst[0]])
        )
        sides[1] = (0.0, min(deep, float(body.depths[-1])))
    return Bbox(np.transpose(sides))


def _draw_curve(axes: Axes, panel: _Panel) -> None:
    """Draw a criterion over x, at the only depth and y."""
    body, (values, limited, label) = panel.body, panel.shown()
    curve = values[0, :, 0]
    axes.plot(body.x, curve, color="black")
    worst = int(curve.argmax())
    axes.plot(body.x[worst], curve[worst], "k+", markersize=8.0)
    if limited:
        axes.axhline(1.0, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlabel="x (mm)", ylabel=label, title=f"{panel.title} at depth {body.depths[0]:.3g} mm")


def _draw(drawn: Canvas, axes: Axes, panel: _Panel, box: Bbox) -> None:
    """Draw a section or a layer. The depth of body 1 is along -z."""
    body, (values, limited, label) = panel.body, panel.shown()
    place = depth, i, j = panel.worst_place
    normal = body.field(f"{panel.name}_normal")[place] if f"{panel.name}_normal" in body.group else None
    if panel.kind == "section":
        shown, across = values[:, :, j], body.depths
        axes.pcolormesh(body.x, across, shown, shading="gouraud", rasterized=True, norm=_norm(values), cmap="cividis")
        axes.set(aspect="equal", xlabel="x (mm)")
        label_depth(axes, panel.number, box.ymax)
        axes.set_title(panel.title if len(body.y) == 1 else f"{panel.title} at y = {body.y[j]:.3g} mm")
        worst = body.x[i], body.depths[depth]
        along = None if normal is None else (-normal[2] * (-1.0 if panel.number == 1 else 1.0), normal[0])
    else:
        shown, across = values[depth].T, body.y
        extent = (*outer_edges(body.x), *outer_edges(body.y))
        axes.imshow(shown, origin="lower", extent=extent, norm=_norm(values), cmap="cividis")
        axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)", ylim=box.intervaly)
        axes.set_title(f"{panel.title} at depth {body.depths[depth]:.3g} mm")
        worst = body.x[i], body.y[j]
        along = None if normal is None else (-normal[1], normal[0])
    axes.grid(False)
    axes.set_xlim(box.intervalx)
    set_x_ticks(axes)
    if limited and shown.min() < 1.0 < shown.max():
        axes.contour(body.x, across, shown, levels=[1.0], colors="white", linewidths=1.2).set_path_effects(_OUTLINE)
    bar = matplotlib.cm.ScalarMappable(_norm(values), matplotlib.colormaps["cividis"])
    drawn.colorbar(axes, bar, label)
    limits = axes.get_xlim(), axes.get_ylim()
    outline = [withStroke(linewidth=3.0, foreground="white")]
    axes.plot(*worst, "k+", markersize=9.0, clip_on=False, zorder=4.0, path_effects=outline)  # over the trace
    axes.set(xlim=limits[0], ylim=limits[1])
    if along is not None and np.hypot(*along) > 0.05:
        _draw_trace(axes, worst, along)


def _norm(values: DoubleArray) -> Normalize:
    return Normalize(0.0, float(values.max()) or 1.0)


def _draw_trace(axes: Axes, place: tuple[float, float], along: tuple[float, float]) -> None:
    """Draw a short line through a place, in the direction (both axes in mm)."""
    low, high = axes.get_xlim()
    half = TRACE * abs(high - low) / np.hypot(*along)
    ends = [[place[axis] - half * along[axis], place[axis] + half * along[axis]] for axis in (0, 1)]
    limits = axes.get_ylim()
    axes.plot(*ends, color="black", linewidth=2.0, path_effects=[withStroke(linewidth=3.4, foreground="white")])
    axes.set(xlim=(low, high), ylim=limits)
