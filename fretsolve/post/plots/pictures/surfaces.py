"""Draw measured maps and rough surfaces: the map, two profiles through its middle, and its spectrum."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from fretsolve.case.keys.body_specs import Surface
from fretsolve.errors import FretsolveError, PictureError
from fretsolve.post.plots.canvas import PANEL_WIDTH, Canvas, Target, canvas, scaled_height, title_of
from fretsolve.post.plots.labels import draw_lines, readable
from fretsolve.post.plots.pictures.maps import draw_frame
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_measures import ADVISED_POINTS, MapMeasures, measures_of, spectrum
from fretsolve.problem.surface.roughness import waves_of
from fretsolve.problem.surface.separation import height_maps
from fretsolve.result import Result
from fretsolve.system.arrays import DoubleArray

MOST_PIXELS = 1024
"""Points of a map per side that are drawn; a page shows no more."""


@dataclass(frozen=True)
class ShownMap:
    """A map with what it is called and its middle (mm)."""

    name: str
    center: tuple[float, float]
    heights: HeightMap

    @cached_property
    def measures(self) -> MapMeasures:
        """Size, roughness and waves of the map, which several panels need."""
        return measures_of(self.heights)


def measured_surface(result: Result, ax: Target = None) -> Figure:
    """Draw the measured maps and the roughness of a result's case. Raises PictureError where it has none."""
    if result.case is None:
        raise PictureError("the case of the result is not one of this version")
    try:
        maps = list(_shown_maps(result.case.surface))
    except FretsolveError as error:
        raise PictureError(str(error)) from error
    if not maps:
        raise PictureError("the surface of the case has neither heights nor roughness")
    return draw_maps(maps, title_of(result), ax)


def _shown_maps(surfaces: Sequence[Surface]) -> Iterator[ShownMap]:
    """Yield the measured maps among the surfaces, and one period of each roughness, with enough points per wave."""
    for center, height_map in height_maps(surfaces):
        yield ShownMap("heights", center, height_map)
    for surface in surfaces:
        if surface.kind == "roughness":
            count = min(math.ceil(ADVISED_POINTS * surface.period / surface.cutoff), 2 * MOST_PIXELS)
            step = surface.period / count
            places = np.linspace(-0.5, 0.5, count, endpoint=False) * surface.period + 0.5 * step
            across = np.zeros(1) if surface.of_line else places
            heights = waves_of(surface).heights(places, across)
            yield ShownMap("roughness", surface.center, HeightMap(heights, (step, step)))


def draw_maps(maps: Sequence[ShownMap], title: str, ax: Target = None) -> Figure:
    """Draw each map: seen from above, along two profiles through its middle, and its spectrum."""
    panels, heights = [], []
    for one in maps:
        wide, long = one.heights.span
        if one.heights.values.shape[1] > 1:
            panels.append((_draw_map, one))
            heights.append(scaled_height(long / wide, PANEL_WIDTH))
        panels += [(_draw_profiles, one), (_draw_spectrum, one)]
        heights += [2.6, 2.6]
    with canvas(ax, len(panels), (PANEL_WIDTH, max(heights)), heights=heights) as drawn:
        for axes, (draw, one) in zip(drawn.axes, panels, strict=False):
            draw(drawn, axes, one)
        drawn.heading(title, "; ".join(_words(one) for one in maps))
    return drawn.figure


def _words(one: ShownMap) -> str:
    found = one.measures
    unit = readable("mm", [found.sq])
    return f"{one.name}: Sq = {unit.factor * found.sq:.3g} {unit.text}, Sdq = {found.sdq:.3g}"


def _axes_of(one: ShownMap) -> tuple[DoubleArray, DoubleArray]:
    """Return the places of the points along x and y (mm), at the surface's center."""
    x, y = (center + one.heights.points(axis) for axis, center in enumerate(one.center))
    return x, y


def _draw_map(drawn: Canvas, axes: Axes, one: ShownMap) -> None:
    """Draw the separation of the points as pixels, with x to the right and y up."""
    x, y = _axes_of(one)
    values = one.heights.values
    shown = values[:: -(-len(x) // MOST_PIXELS), :: -(-len(y) // MOST_PIXELS)] - np.nanmean(values)
    unit = readable("mm", shown)
    dx, dy = (0.5 * step for step in one.heights.spacing)
    box = Bbox.from_extents(x[0] - dx, y[0] - dy, x[-1] + dx, y[-1] + dy)
    image = axes.imshow(
        np.ma.masked_invalid(unit.factor * shown).T,
        origin="lower",
        extent=(box.x0, box.x1, box.y0, box.y1),
        cmap="viridis",
    )
    draw_frame(axes, box, f"{one.name}: separation less its mean ({unit.text})")
    drawn.colorbar(axes, image)


def _draw_profiles(drawn: Canvas, axes: Axes, one: ShownMap) -> None:
    """Draw the separation along x and along y through the middle of the map."""
    places, values = _axes_of(one), one.heights.values
    middle = tuple(count // 2 for count in values.shape)
    cuts = [values[:, middle[1]], values[middle[0]]]
    unit = readable("mm", np.concatenate(cuts) - np.nanmean(values))
    for name, place, cut in list(zip("xy", places, cuts, strict=True))[: 1 + (values.shape[1] > 1)]:
        axes.plot(place, unit.factor * (cut - np.nanmean(values)), label=f"along {name}", linewidth=0.9)
    axes.set(xlabel="x or y (mm)", ylabel=f"separation ({unit.text})", title=f"{one.name}: through the middle")
    axes.legend()


def _draw_spectrum(drawn: Canvas, axes: Axes, one: ShownMap) -> None:
    """Draw the power spectra of profiles along x and y over the wavelength, short waves to the right."""
    found = one.measures
    for axis, name in enumerate("xy"[: 1 + (one.heights.values.shape[1] > 1)]):
        waves, power = spectrum(one.heights, axis)
        if (power > 0.0).any():
            draw_lines(axes, waves, [(f"along {name}", power)], marker="", color=f"C{axis}")
    if np.isfinite(found.shortest_wave):
        axes.axvline(found.shortest_wave, color="0.4", linestyle=":", label="shortest wave")
    axes.set(xlabel="wavelength (mm)", ylabel="spectrum C (mm³)", title=f"{one.name}: spectrum of profiles")
    if axes.lines:
        axes.set(xscale="log", yscale="log")
        axes.invert_xaxis()
        axes.legend()
    else:
        axes.text(0.5, 0.5, "no waves", transform=axes.transAxes, ha="center")
