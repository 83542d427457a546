"""Warnings of measured maps: before the run of what map and cells cannot show, after it of holes in the contact."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fretsolve.case.dimensions import cell_counts, counted
from fretsolve.errors import dotted
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.surface.separation import placed_maps
from fretsolve.system.arrays import BoolArray, grown


def about_maps(setup: ProblemSetup) -> Iterator[str]:
    """Warn of rough surfaces that are steep, have few points per wave, or are finer than the cells.

    Where an accuracy judges error bars, they have what the cells miss.
    """
    kinds = {surface.kind for surface in setup.case.surface}
    if not kinds & {"heights", "roughness"}:
        return
    from fretsolve.problem.surface.map_measures import measures_of, point_warnings  # other cases do not need it

    grid, heights, rough = setup.grid, setup.heights(), "height map" if "heights" in kinds else "roughness"
    if "roughness" in kinds and (slope := heights.slope()) > 1.0:
        yield (
            f"surface: the root mean square slope of the {rough} is {slope:.2g}: half-spaces and linear elasticity hold"
            " for slopes small against 1"
        )
    for place, height_map in placed_maps(setup.case.surface):
        for text in (*height_map.doubts, *point_warnings(measures_of(height_map))):
            yield f"{_typed_map(setup, place)}: {text}"
    if setup.case.solver.accuracy is not None and setup.case.solver.error_bars:
        return
    if (needed := heights.flattening_pressure((grid.dx, grid.dy))) > 0.0:
        resolving = cell_counts(heights.resolving_points(grid.size, grid.shape))
        coarse = " as far as the map does, which has few points per wave itself" if heights.too_coarse() else ""
        yield (
            f"grid.points: {cell_counts(grid.shape)} cells miss waves of the {rough} that take {needed:.3g} MPa to"
            f" flatten; {resolving} points would resolve them{coarse}"
        )


def hole_warnings(setup: ProblemSetup, contact: BoolArray) -> Iterator[str]:
    """Warn of each map whose holes the contact (nx, ny) reaches."""
    for place, height_map in placed_maps(setup.case.surface):
        x0, y0 = setup.case.surface[place].center
        x, y = setup.grid.x - x0, setup.grid.y - y0
        known, whole = (np.isfinite(one.sample(x, y)) for one in (height_map, height_map.without_holes()))
        beside = grown(whole & ~known) & contact
        if beside.any():
            cells = counted(int(beside.sum()), "cell")
            yield (
                f"{_typed_map(setup, place)}: {cells} in contact lie beside holes of the map, where the pressure is"
                " infinite and the largest one depends on the grid; fill mends lost points"
            )


def _typed_map(setup: ProblemSetup, place: int) -> str:
    """Return the key of the surface at `place` as one types it."""
    return dotted(setup.case.source.typed(("surface", place, setup.case.surface[place].kind)))
