"""Draw what lies below the surface: stresses, over a cycle as well, and fatigue parameters with the critical plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from fretsolve.case.keys.quantity_names import Invariant
from fretsolve.errors import CaseError, PictureError
from fretsolve.post.plots.canvas import BELOW_LABEL, PANEL_WIDTH, Target, canvas, scaled_height, title_of
from fretsolve.post.plots.labels import draw_lines, label_depth, set_increment_ticks
from fretsolve.post.plots.load_history import step_texts
from fretsolve.post.plots.pictures.maps import set_x_ticks
from fretsolve.post.plots.snapshot import Snapshot, cell_size, chosen_step, outer_edges, shown_place
from fretsolve.post.stress.cycles import chosen, cycles_of, states_of
from fretsolve.post.stress.influence import COMPONENTS, Body, point_influence
from fretsolve.post.stress.invariants import invariant, largest
from fretsolve.post.stress.request import StressRequest, WindowChoice, cell_centres, layers, least_depth, stress_request
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result import Result
from fretsolve.system.arrays import DoubleArray

SHOWN: dict[Invariant, str] = {"mises": "von Mises stress", "tension": "first principal stress"}

DEEPEST = 1.5
"""Depth of a section in contact radii."""

SIDE_MARGIN = 0.5
"""Width of the strip around the contact that is shown, over the contact radius."""


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
                image: Any = draw_section(axes, x, depths, values, request.bodies[0], **look)
            else:
                values, where = invariant(name, surface), " on the surface"
                image = draw_layer(axes, x, y, values, **_colors(values, name))
            drawn.colorbar(axes, image, "MPa")
            axes.set_title(SHOWN[name] + ("" if tractions.plane_strain else where))
        drawn.heading(title_of(result), f"body {request.bodies[0]}, {step_texts(result, [chosen])[0]}")
    return drawn.figure


def stress_cycle(
    result: Result, ax: Target = None, *, at: Sequence[float] | str | None = None, body: Body | None = None
) -> Figure:
    """Draw the stress components, and the invariants, at a point over the last cycle.

    Without a cycle in the load path it is over all increments with fields. at: the point (mm), x and y moved to the
    centre of their cell, with its depth if that is not 0; by default `TENSION`, the point of the surface where the
    tension is largest in these increments, since cracks begin there. body: by default 2, or 1 if that is
    rigid. Raises PictureError.
    """
    chosen_step(result, None)
    try:
        cycles = chosen(cycles_of(result), "last")
    except CaseError as error:
        raise PictureError(error.message) from error
    steps, over = states_of(cycles, result.steps), cycles[0].title
    tractions, request = _request(result, steps, body, "all")
    body = request.bodies[0]
    if at is None or isinstance(at, str):
        (i, j), depth, why = _largest_tension(tractions, request), 0.0, ", where the tension is largest"
    else:
        (i, j), depth, why = _cell(tractions, at[:2]), at[2] if len(at) > 2 else 0.0, ""
        _require_depth(tractions, depth)
    x, y = float(result.x[i]), float(result.y[j])
    stress = _stress_at(tractions, steps, (x, y, depth), body)
    with canvas(ax, 2, (PANEL_WIDTH, 2.8), columns=2) as drawn:
        symbols = (rf"$\sigma_{{{name}}}$" if name[0] == name[1] else rf"$\tau_{{{name}}}$" for name in COMPONENTS)
        components = list(zip(symbols, stress, strict=True))
        invariants = [(text, invariant(name, stress)) for name, text in SHOWN.items()]
        for axes, lines in zip(drawn.axes, (components, invariants), strict=False):
            draw_lines(axes, steps, lines)
            axes.set(xlabel="increment", ylabel="stress (MPa)")
            set_increment_ticks(axes)
            # below the panel, as curves may fill it
            axes.legend(ncols=3, **BELOW_LABEL)
        where = f"depth = {depth:.4g} mm" if depth else "on the surface"
        detail = f"body {body} at x = {x:.4g}, y = {y:.4g} mm, {where}{why}; over {over}"
        drawn.heading(title_of(result), detail)
    return drawn.figure


def _stress_at(
    tractions: TractionHistory, steps: Sequence[int], point: tuple[float, float, float], body: Body
) -> DoubleArray:
    """Return the components (6, steps) at a point: x and y of the centre of a cell, and depth (mm)."""
    nu, plane_strain = tractions.poisson_ratios[body], tractions.plane_strain
    influence = point_influence(tractions.grid, point, nu, body, plane_strain=plane_strain)
    whole = slice(None), slice(None)
    stress = np.empty((len(COMPONENTS), len(steps)))
    for index, step in enumerate(steps):
        stress[:, index] = influence.stress(tractions.read(step, whole))
        stress[[0, 1, 3], index] += tractions.bulk_stress(body, step)
    return stress


def _require_depth(tractions: TractionHistory, depth: float) -> None:
    """Raise PictureError for a depth where stresses show the steps between cells."""
    least = least_depth(tractions)
    if depth < 0.0 or 0.0 < depth < least:
        raise PictureError(f"depth {depth:g} mm: 0 or at least half a cell, {least:.4g} mm, is needed")


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


def draw_section(
    axes: Axes, x: DoubleArray, depths: Sequence[float] | DoubleArray, values: DoubleArray, body: int, **look: Any
) -> QuadMesh:
    """Draw values (nx, depths) on a section along x, with the depth downwards in body 2 and upwards in body 1."""
    image = axes.pcolormesh(x, depths, values.T, rasterized=True, **look)
    axes.grid(False)
    axes.set(aspect="equal", xlabel="x (mm)")
    label_depth(axes, body, depths[-1])
    return image


def draw_layer(axes: Axes, x: DoubleArray, y: DoubleArray, values: DoubleArray, **look: Any) -> AxesImage:
    """Draw values (nx, ny) on the surface."""
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


def _cell(tractions: TractionHistory, at: Sequence[float]) -> tuple[int, int]:
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
