"""Draw what lies below the surface: stresses, over a cycle as well, and fatigue parameters with the critical plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.transforms import Bbox

from fretsolve.errors import CaseError, PictureError
from fretsolve.post.fatigue.fatigue_file import BodyFatigue, fatigue_bodies
from fretsolve.post.names import Invariant, dataset_name, fatigue_path
from fretsolve.post.plots.canvas import BELOW_LABEL, PANEL_WIDTH, Canvas, Target, canvas, scaled_height, title_of
from fretsolve.post.plots.labels import draw_lines, increment_ticks, label_depth
from fretsolve.post.plots.load_history import step_text
from fretsolve.post.plots.pictures.maps import set_x_ticks
from fretsolve.post.plots.snapshot import Snapshot, cell_size, chosen_step, outer_edges, shown_place
from fretsolve.post.stress.computed_file import opened_computed
from fretsolve.post.stress.cycles import chosen, cycles_of, states_of
from fretsolve.post.stress.influence import COMPONENTS, Body, point_influence
from fretsolve.post.stress.invariants import invariant, largest
from fretsolve.post.stress.request import StressRequest, WindowChoice, cell_centres, layers, stress_request
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import Result
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

SHOWN: dict[Invariant, str] = {"mises": "von Mises stress", "tension": "first principal stress"}

DEEPEST = 1.5
"""Depth of a section in contact radii."""

SIDE_MARGIN = 0.5
"""Width of the strip around the contact that is shown, over the contact radius."""


_OUTLINE: list[AbstractPathEffect] = [withStroke(linewidth=2.4, foreground="black")]
"""Makes a white line visible on bright colours."""


def stress_map(result: Result, ax: Target = None, *, step: int | None = None, body: Body | None = None) -> Figure:
    """Draw von Mises stress and first principal stress on a section along x and on the surface, of an increment.

    step: by default the last one with fields; body: by default 2, or 1 if that is rigid, whose depth points upwards.
    A line contact has the section alone. Raises PictureError.
    """
    chosen = chosen_step(result, step)
    radius = float(result.history["contact_radius"][chosen])
    tractions, request = _request(result, (chosen,), body, SIDE_MARGIN * radius or "all")
    snapshot = Snapshot(result, chosen)
    row = int(np.abs(result.y - shown_place(snapshot)[1]).argmin())
    below = np.linspace(0.0, DEEPEST * (radius or 0.25 * tractions.grid.nx * tractions.grid.dx), 48)
    depths = [0.0, *below[below >= 0.5 * tractions.grid.dx].tolist()]  # the surface, then depths from half a cell on
    section = replace(request, depths=tuple(depths), target=(request.target[0], slice(row, row + 1)))
    below = np.stack([layer.stress[:, :, 0] for layer in layers(tractions, section)], axis=-1)  # (6, nx, depths)
    panels: list[tuple[str, Invariant]] = [("section", name) for name in SHOWN]
    surface = np.zeros((6, 0, 0))
    if not tractions.plane_strain:
        panels += [("surface", name) for name in SHOWN]
        surface = next(layers(tractions, replace(request, depths=(0.0,)))).stress
    x, y = cell_centres(tractions.grid, request.target)
    wide, deep, long = (outer[1] - outer[0] for outer in (outer_edges(x), (0.0, depths[-1]), outer_edges(y)))
    heights = [scaled_height((deep if place == "section" else long) / wide, PANEL_WIDTH) for place, _ in panels]
    with canvas(ax, len(panels), (PANEL_WIDTH, max(heights)), columns=2, heights=heights) as drawn:
        for axes, (place, name) in zip(drawn.axes, panels, strict=False):
            if place == "section":
                values, where = invariant(name, below), f" at y = {result.y[row]:.3g} mm"
                look = _colors(values, name) | {"shading": "nearest"}
                image: Any = _draw_section(axes, x, depths, values, request.bodies[0], **look)
            else:
                values, where = invariant(name, surface), " on the surface"
                image = _draw_layer(axes, x, y, values, **_colors(values, name))
            drawn.colorbar(axes, image, "MPa")
            axes.set_title(SHOWN[name] + ("" if tractions.plane_strain else where))
        drawn.heading(title_of(result), f"body {request.bodies[0]}, {step_text(result, chosen)}")
    return drawn.figure


def stress_cycle(
    result: Result, ax: Target = None, *, at: tuple[float, float] | None = None, body: Body | None = None
) -> Figure:
    """Draw the stress components, and the invariants, at a point of the surface over the last cycle.

    Without a cycle in the load path it is over all increments with fields. at: the point (mm), moved to the centre of
    its cell; by default where the tension is largest. body: by default 2, or 1 if that is rigid. Raises PictureError.
    """
    chosen_step(result, None)
    try:
        cycles = chosen(cycles_of(result), "last")
    except CaseError as error:
        raise PictureError(error.message) from error
    steps, over = states_of(cycles, result.steps), cycles[0].title
    tractions, request = _request(result, steps, body, "all")
    body = request.bodies[0]
    i, j = _cell(tractions, at) if at is not None else _largest_tension(tractions, request)
    x, y = float(result.x[i]), float(result.y[j])
    nu, plane_strain = tractions.poisson_ratios[body], tractions.plane_strain
    influence = point_influence(tractions.grid, (x, y, 0.0), nu, body, plane_strain=plane_strain)
    whole = slice(None), slice(None)
    stress = np.empty((len(COMPONENTS), len(steps)))
    for index, step in enumerate(steps):
        stress[:, index] = influence.stress(tractions.read(step, whole))
        stress[[0, 1, 3], index] += tractions.bulk_stress(body, step)
    with canvas(ax, 2, (PANEL_WIDTH, 2.8), columns=2) as drawn:
        symbols = (rf"$\sigma_{{{name}}}$" if name[0] == name[1] else rf"$\tau_{{{name}}}$" for name in COMPONENTS)
        components = list(zip(symbols, stress, strict=True))
        invariants = [(text, invariant(name, stress)) for name, text in SHOWN.items()]
        for axes, lines in zip(drawn.axes, (components, invariants), strict=False):
            draw_lines(axes, steps, lines)
            axes.set(xlabel="increment", ylabel="stress (MPa)")
            axes.xaxis.set_major_locator(increment_ticks())
            # below the panel, as curves may fill it
            axes.legend(ncols=3, **BELOW_LABEL)
        detail = f"body {body} at x = {x:.4g}, y = {y:.4g} mm on the surface, over {over}"
        drawn.heading(title_of(result), detail)
    return drawn.figure


def _request(
    result: Result, steps: Sequence[int], body: Body | None, window: WindowChoice
) -> tuple[TractionHistory, StressRequest]:
    """Return the tractions and the request for one body. Raises PictureError."""
    try:
        tractions = TractionHistory(result)
        return tractions, stress_request(
            tractions, steps, () if body is None else (body,), depths=(0.0,), window=window
        )
    except CaseError as error:
        raise PictureError(error.message) from error


def _draw_section(
    axes: Axes, x: DoubleArray, depths: Sequence[float] | DoubleArray, values: DoubleArray, body: int, **look: Any
) -> QuadMesh:
    """Draw values (nx, depths) on a section along x, with the depth downwards in body 2 and upwards in body 1."""
    image = axes.pcolormesh(x, depths, values.T, rasterized=True, **look)
    axes.grid(False)
    axes.set(aspect="equal", xlabel="x (mm)")
    label_depth(axes, body, depths[-1])
    return image


def _draw_layer(axes: Axes, x: DoubleArray, y: DoubleArray, values: DoubleArray, **look: Any) -> AxesImage:
    image = axes.imshow(values.T, origin="lower", extent=(*outer_edges(x), *outer_edges(y)), **look)
    axes.grid(False)
    axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
    set_x_ticks(axes)
    return image


def _colors(values: DoubleArray, name: Invariant) -> dict[str, Any]:
    """Return the colours of a panel: from 0 on, or about 0."""
    if name == "mises":
        return {"norm": Normalize(0.0, float(values.max()) or 1.0), "cmap": matplotlib.colormaps["cividis"]}
    size = float(np.abs(values).max()) or 1.0
    return {"norm": Normalize(-size, size), "cmap": matplotlib.colormaps["RdBu_r"]}


def _cell(tractions: TractionHistory, at: tuple[float, float]) -> tuple[int, int]:
    """Return the cell of a point (mm). Raises PictureError if it is off the grid."""
    found = []
    for axis, centres, value in zip("xy", (tractions.result.x, tractions.result.y), at, strict=True):
        low, high = outer_edges(centres)
        if not low - cell_size(centres) <= value <= high + cell_size(centres):
            raise PictureError(f"{axis} = {value:g} mm is off the grid, which reaches from {low:.4g} to {high:.4g} mm")
        found.append(int(np.abs(centres - value).argmin()))
    return found[0], found[1]


def _largest_tension(tractions: TractionHistory, request: StressRequest) -> tuple[int, int]:
    """Return the cell of the surface with the largest tension of all increments of a request."""
    found = (largest(layer.stress)["tension"] for layer in layers(tractions, request))
    _, (row, column) = max(found, key=lambda one: one[0])
    return request.target[0].start + row, request.target[1].start + column


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
        heights = [2.6 if box is None else scaled_height(box.height / box.width, PANEL_WIDTH) for box in boxes]
        with canvas(ax, len(panels), (PANEL_WIDTH, max(heights)), columns=2, heights=heights) as drawn:
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
    look: dict[str, Any] = {"norm": Normalize(0.0, float(values.max()) or 1.0), "cmap": matplotlib.colormaps["cividis"]}
    if panel.kind == "section":
        shown, across = values[:, :, j], body.depths
        _draw_section(axes, body.x, across, shown.T, panel.number, **look, shading="gouraud")
        label_depth(axes, panel.number, box.ymax)
        axes.set_title(panel.title if len(body.y) == 1 else f"{panel.title} at y = {body.y[j]:.3g} mm")
        worst = body.x[i], body.depths[depth]
        along = None if normal is None else (-normal[2] * (-1.0 if panel.number == 1 else 1.0), normal[0])
    else:
        shown, across = values[depth].T, body.y
        _draw_layer(axes, body.x, across, values[depth], **look)
        axes.set_ylim(box.intervaly)
        axes.set_title(f"{panel.title} at depth {body.depths[depth]:.3g} mm")
        worst = body.x[i], body.y[j]
        along = None if normal is None else (-normal[1], normal[0])
    axes.set_xlim(box.intervalx)
    set_x_ticks(axes)
    if limited and shown.min() < 1.0 < shown.max():
        axes.contour(body.x, across, shown, levels=[1.0], colors="white", linewidths=1.2).set_path_effects(_OUTLINE)
    drawn.colorbar(axes, ScalarMappable(**look), label)
    limits = axes.get_xlim(), axes.get_ylim()
    outline = [withStroke(linewidth=3.0, foreground="white")]
    axes.plot(*worst, "k+", markersize=9.0, clip_on=False, zorder=4.0, path_effects=outline)  # over the trace
    axes.set(xlim=limits[0], ylim=limits[1])
    if along is not None and np.hypot(*along) > 0.05:
        _draw_trace(axes, worst, along)


def _draw_trace(axes: Axes, place: tuple[float, float], along: tuple[float, float]) -> None:
    """Draw a short line through a place, in the direction (both axes in mm)."""
    low, high = axes.get_xlim()
    half = 0.08 * abs(high - low) / np.hypot(*along)
    ends = [[place[axis] - half * along[axis], place[axis] + half * along[axis]] for axis in (0, 1)]
    limits = axes.get_ylim()
    axes.plot(*ends, color="black", linewidth=2.0, path_effects=[withStroke(linewidth=3.4, foreground="white")])
    axes.set(xlim=(low, high), ylim=limits)
