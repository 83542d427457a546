"""Measures of a measured map: size, roughness, form, holes, waves.

Roughness (Sq, Sa, Sdq of ISO 25178-2) is of the whole map after its best plane is taken off, with slopes by differences
between neighbours. Waves are of the map less its best quadratic, along whole lines: lines with lost points are left
out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.dimensions import in_small_unit
from fretsolve.problem.surface.height_map import HeightMap
from fretsolve.problem.surface.map_form import fitted
from fretsolve.problem.surface.map_steps import holes
from fretsolve.system.arrays import DoubleArray

SHORT_SHARE = 0.01
"""Share of the mean square slope that lies beyond the shortest wave."""

STEEP = 0.5
"""Root mean square slope above which a map is likelier misread than rough."""

ADVISED_POINTS = 10
"""Points per wave with which differences show 98 % of its slope."""


@dataclass(frozen=True)
class MapMeasures:
    """Measures of a map; lengths in mm. Pairs are along x and y; of a profile, one value along x.

    height_range: largest less least height; sq, sa: root mean square and mean absolute height; sdq: root mean square
    slope; tilts: slopes of the best plane; radius: of the best sphere, negative if concave, infinite if flat;
    lost_points lie in holes_inside and holes_at_rim; shortest_waves: along each axis, beyond which only 1 % of the
    mean square slope of the waves lies; infinite without waves, NaN without a whole line.
    """

    points: tuple[int, int]
    spacing: tuple[float, float]
    span: tuple[float, float]
    height_range: float
    sq: float
    sa: float
    sdq: float
    tilts: tuple[float, ...]
    radius: float
    lost_points: int
    holes_inside: int
    holes_at_rim: int
    shortest_waves: tuple[float, ...]

    @property
    def shortest_wave(self) -> float:
        """The shorter one of the shortest waves along x and y (mm), NaN if there is no whole line."""
        return min((wave for wave in self.shortest_waves if not math.isnan(wave)), default=math.nan)


def measures_of(height_map: HeightMap) -> MapMeasures:
    """Return the measures of a map."""
    values = height_map.values
    plane, sphere = fitted(height_map, "plane"), fitted(height_map, "sphere")
    rough = values - plane.heights
    known = rough[np.isfinite(rough)]
    _, holes_inside, holes_at_rim = holes(height_map)
    axes = _axes(height_map)
    return MapMeasures(
        points=(values.shape[0], values.shape[1]),
        spacing=height_map.spacing,
        span=height_map.span,
        height_range=float(np.nanmax(values) - np.nanmin(values)),
        sq=math.sqrt(np.mean(known**2)),
        sa=float(np.mean(np.abs(known))),
        sdq=math.sqrt(sum(_mean_square_slope(rough, axis, height_map.spacing[axis]) for axis in axes)),
        tilts=plane.tilts,
        radius=_radius(sphere.curvatures[0], height_map) if sphere.determined else math.inf,
        lost_points=values.size - known.size,
        holes_inside=holes_inside,
        holes_at_rim=holes_at_rim,
        shortest_waves=_shortest_waves(height_map),
    )


def spectrum(height_map: HeightMap, axis: int) -> tuple[DoubleArray, DoubleArray]:
    """Return the wavelengths (mm), the longest first, and the spectral density C (mm^3) of the lines along an axis.

    C is the mean over whole lines of the map less its best quadratic, each about its mean in a Hann window of mean
    square 1. The integral of C dq/pi over the wave numbers q = 2 pi/wavelength is the mean square height Sq^2 in the
    window. Both arrays are empty without a whole line.
    """
    waves = height_map.values - fitted(height_map, "quadratic").heights
    waves[np.abs(waves) <= _rounding(height_map)] = 0.0
    lines = np.moveaxis(waves, axis, -1)
    lines = lines[np.isfinite(lines).all(axis=1)]
    lines = lines - lines.mean(axis=1, keepdims=True)
    count, step = lines.shape[1], height_map.spacing[axis]
    if not len(lines):
        return np.empty(0), np.empty(0)
    hann = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** 2  # nowhere 0: lines of two points have a spectrum too
    hann /= math.sqrt(np.mean(hann**2))
    density = np.mean(np.abs(np.fft.rfft(hann * lines, axis=1)) ** 2, axis=0) * step / count
    if count % 2 == 0:
        density[-1] *= 0.5  # the last wave number ends the integral
    return count * step / np.arange(1, density.size), density[1:]


def point_warnings(measures: MapMeasures) -> tuple[str, ...]:
    """Return warnings of a map that is steep, and of too few points per shortest wave."""
    steep: tuple[str, ...] = ()
    if measures.sdq > STEEP:
        steep = (
            f"its root mean square slope is {measures.sdq:.2g}: half-spaces and linear elasticity hold for slopes small"
            " against 1; are unit and spacing right, and missing points nan?",
        )
    waves = zip(measures.shortest_waves, measures.spacing, strict=False)
    points, wave = min(((wave / step, wave) for wave, step in waves if not math.isnan(wave)), default=(math.inf, 0.0))
    if points >= ADVISED_POINTS:
        return steep
    found = f"the shortest wave of the map, {in_small_unit(wave, 2)}, has {points:.2g} points"
    return (*steep, f"{found}; ten are needed for its slope")


def _axes(height_map: HeightMap) -> tuple[int, ...]:
    return (0,) if height_map.values.shape[1] == 1 else (0, 1)


def _mean_square_slope(values: DoubleArray, axis: int, step: float) -> float:
    """Return the mean square of the differences between known neighbours over their distance; 0 if there are none."""
    slopes = np.diff(values, axis=axis) / step
    known = slopes[np.isfinite(slopes)]
    return float(np.mean(known**2)) if known.size else 0.0


def _rounding(height_map: HeightMap) -> float:
    """Return what the heights (mm) of a form that was taken off may be wrong by, as sums of rounded terms."""
    return 16.0 * float(np.finfo(np.float64).eps * np.nanmax(np.abs(height_map.values)))


def _radius(curvature: float, height_map: HeightMap) -> float:
    """Return the radius (mm) of a sphere, infinite where its height on the map vanishes in rounding."""
    height = 0.125 * abs(curvature) * max(height_map.span) ** 2
    return 1.0 / curvature if height > _rounding(height_map) else math.inf


def _shortest_waves(height_map: HeightMap) -> tuple[float, ...]:
    """Return the wavelength (mm) along each axis beyond which `SHORT_SHARE` of the mean square slope lies.

    The mean square slope is the mean of both directions, so that noise along the lay of a ground surface does not pass
    for waves. Slopes below `SHORT_SHARE` of the form's do not count: on a smooth ball they are rounding in the file.
    """
    axes, form = _axes(height_map), fitted(height_map, "quadratic").heights
    lines = []
    for axis in axes:
        wavelengths, density = spectrum(height_map, axis)
        numbers = 2.0 * np.pi / wavelengths
        lines.append((numbers, np.cumsum(numbers**2 * density) * (numbers[:1] / np.pi)))
    of_waves = [slopes[-1] for _, slopes in lines if slopes.size]
    of_form = [np.var(np.diff(form, axis=axis)) / height_map.spacing[axis] ** 2 for axis in axes]
    beyond = SHORT_SHARE * max(np.mean(of_waves or 0.0), SHORT_SHARE * np.mean(of_form))
    return tuple(_length_below(numbers, slopes, float(beyond)) for numbers, slopes in lines)


def _length_below(numbers: DoubleArray, slopes: DoubleArray, beyond: float) -> float:
    """Return the wavelength (mm) of the wave number at which sums of mean square slope lack `beyond` of the last."""
    if not slopes.size:
        return math.nan
    if slopes[-1] <= beyond:
        return math.inf
    return float(2.0 * np.pi / np.interp(slopes[-1] - beyond, slopes, numbers))
