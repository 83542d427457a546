"""Draw stresses below the surface: a section through the contact with the surface, and a point over the cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from fretsolve.errors import CaseError, PictureError
from fretsolve.plots.canvas import BELOW_LABEL, Canvas, Target, canvas, scaled_height, title_of
from fretsolve.plots.labels import increment_ticks, label_depth, marks
from fretsolve.plots.load_history import step_text
from fretsolve.plots.pictures.maps import set_x_ticks
from fretsolve.plots.snapshot import Snapshot, cell_size, chosen_step, outer_edges, shown_place
from fretsolve.result import Result
from fretsolve.stress.evaluate import layers
from fretsolve.stress.influence import COMPONENTS, Body, point_influence
from fretsolve.stress.invariants import invariant
from fretsolve.stress.names import Invariant
from fretsolve.stress.request import StressRequest, WindowChoice, cell_centres, stress_request
from fretsolve.stress.tractions import TractionHistory, last_cycle
from fretsolve.system.arrays import DoubleArray

SHOWN: dict[Invariant, str] = {"mises": "von Mises stress", "tension": "first principal stress"}

SECTION_DEPTHS = 48
"""Depths of a section, the deepest at `DEEPEST` contact radii."""

DEEPEST = 1.5

WIDTH = 3.7
"""Inches of a panel."""

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
    depths = _section_depths(tractions, chosen)
    section = replace(request, depths=tuple(depths), target=(request.target[0], slice(row, row + 1)))
    below = np.stack([layer.stress[:, :, 0] for layer in layers(tractions, section)], axis=-1)  # (6, nx, depths)
    panels: list[tuple[str, Invariant]] = [("section", name) for name in SHOWN]
    surface = None
    if not tractions.plane_strain:
        panels += [("surface", name) for name in SHOWN]
        surface = next(layers(tractions, replace(request, depths=(0.0,)))).stress
    x, y = cell_centres(tractions.grid, request.target)
    wide, deep, long = (outer[1] - outer[0] for outer in (outer_edges(x), (0.0, depths[-1]), outer_edges(y)))
    heights = [scaled_height((deep if place == "section" else long) / wide, WIDTH) for place, _ in panels]
    with canvas(ax, len(panels), (WIDTH, max(heights)), columns=2, heights=heights) as drawn:
        for axes, (place, name) in zip(drawn.axes, panels, strict=False):
            if place == "section":
                _draw_section(drawn, axes, x, depths, invariant(name, below), name, request.bodies[0])
                where = "" if tractions.plane_strain else f" at y = {result.y[row]:.3g} mm"
                axes.set_title(f"{SHOWN[name]}{where}")
            elif surface is not None:
                _draw_surface(drawn, axes, x, y, invariant(name, surface), name)
                axes.set_title(f"{SHOWN[name]} on the surface")
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
        steps, over = last_cycle(result), "the last cycle"
    except CaseError:
        steps, over = result.steps, "all increments with fields"
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
    with canvas(ax, 2, (WIDTH, 2.8), columns=2) as drawn:
        curves: list[list[tuple[str, DoubleArray]]] = [
            [(component_symbol(name), values) for name, values in zip(COMPONENTS, stress, strict=True)],
            [(text, invariant(name, stress)) for name, text in SHOWN.items()],
        ]
        for axes, lines in zip(drawn.axes, curves, strict=False):
            for (label, values), mark in zip(lines, marks(len(lines)), strict=True):
                axes.plot(steps, values, label=label, **mark.options(len(steps)))
            axes.set(xlabel="increment", ylabel="stress (MPa)")
            axes.xaxis.set_major_locator(increment_ticks())
            # below the panel, as curves may fill it
            axes.legend(ncols=3, **BELOW_LABEL)
        detail = f"body {body} at x = {x:.4g}, y = {y:.4g} mm on the surface, over {over}"
        drawn.heading(title_of(result), detail)
    return drawn.figure


def component_symbol(name: str) -> str:
    """Return a stress component, such as ``xx``, as a symbol."""
    return rf"$\sigma_{{{name}}}$" if name[0] == name[1] else rf"$\tau_{{{name}}}$"


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


def _section_depths(tractions: TractionHistory, step: int) -> list[float]:
    """Return depths a section shows: the surface, then those from half a cell on."""
    grid = tractions.grid
    radius = float(tractions.result.history["contact_radius"][step]) or 0.25 * grid.nx * grid.dx
    depths = np.linspace(0.0, DEEPEST * radius, SECTION_DEPTHS)
    return [0.0, *depths[depths >= 0.5 * grid.dx].tolist()]


def _draw_section(
    drawn: Canvas, axes: Axes, x: DoubleArray, depths: Sequence[float], values: DoubleArray, name: Invariant, body: Body
) -> None:
    image = axes.pcolormesh(x, depths, values.T, shading="nearest", rasterized=True, **_colors(values, name))
    axes.grid(False)
    axes.set(aspect="equal", xlabel="x (mm)")
    label_depth(axes, body, depths[-1])
    drawn.colorbar(axes, image, "MPa")


def _draw_surface(
    drawn: Canvas, axes: Axes, x: DoubleArray, y: DoubleArray, values: DoubleArray, name: Invariant
) -> None:
    extent = (*outer_edges(x), *outer_edges(y))
    image = axes.imshow(values.T, origin="lower", extent=extent, **_colors(values, name))
    axes.grid(False)
    axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
    set_x_ticks(axes)
    drawn.colorbar(axes, image, "MPa")


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
    best, cell = -np.inf, (0, 0)
    for layer in layers(tractions, request):
        values = invariant("tension", layer.stress)
        if float(values.max()) > best:
            best = float(values.max())
            row, column = np.unravel_index(int(values.argmax()), values.shape)
            cell = request.target[0].start + int(row), request.target[1].start + int(column)
    return cell
