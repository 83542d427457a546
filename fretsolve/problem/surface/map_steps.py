"""Prepare a measured map as the case asks: crop, spikes, fill, level, filter, in this order.

Each step takes a map and returns another, with a remark that says what it did.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from fretsolve.case.dimensions import cell_counts, counted, in_small_unit, percent
from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.surface.height_map import SNAP, HeightMap
from fretsolve.problem.surface.map_form import fitted
from fretsolve.system.arrays import BoolArray, DoubleArray

NEIGHBORS = 5
"""Side, in points, of the square whose median tells a spike."""

BLOCK = 2**16
"""Points whose neighbours are held in memory at a time: 13 MB."""

EPSILON = float(np.finfo(np.float64).eps)


def prepared(height_map: HeightMap, source: HeightsSurface, key: KeyPath) -> HeightMap:
    """Return the map after the steps that `source` asks for; its remarks say what each step did.

    key: place of the source in the case. Raises CaseError where a step cannot be done.
    """
    if source.crop is not None:
        height_map = cropped(height_map, source.crop, (*key, "crop"))
    if source.spikes is not None:
        height_map = without_spikes(height_map, source.spikes)
    if source.fill is not None:
        height_map = filled(height_map, source.fill, (*key, "fill"))
    if source.level not in (None, "none"):
        height_map = levelled(height_map, source.level, (*key, "level"))
    for name, cutoff in (("short_cutoff", source.short_cutoff), ("long_cutoff", source.long_cutoff)):
        if cutoff is not None:
            height_map = filtered(height_map, cutoff, (*key, name), keep_long=name == "short_cutoff")
    return height_map


def cropped(height_map: HeightMap, corners: Sequence[float], key: KeyPath) -> HeightMap:
    """Return the points between `corners`, [x0, y0, x1, y1] or of a profile [x0, x1], in mm from the lower left point.

    The part's middle becomes the map's centre.
    """
    axes = len(corners) // 2
    part = [slice(None), slice(None)]
    for axis, (low, high) in enumerate(zip(corners[:axes], corners[axes:], strict=True)):
        step, last = height_map.spacing[axis], height_map.values.shape[axis] - 1
        # as far as a point beyond the last one: programs give the width of all pixels
        if low < -SNAP * step or high > (last + 1.0 + SNAP) * step:
            spans = " x ".join(f"{span:g}" for span in height_map.span[:axes])
            raise CaseError(f"the part {list(corners)} mm is not all on the map, which spans {spans} mm", key)
        part[axis] = slice(math.ceil(low / step - SNAP), math.floor(high / step + SNAP) + 1)
    values = height_map.values[part[0], part[1]]
    if min(values.shape[:axes]) < 2:
        steps = " x ".join(in_small_unit(step) for step in height_map.spacing[:axes])
        raise CaseError(
            f"the part {list(corners)} mm holds {_size(values)} points, {steps} apart; at least"
            f" {'2 x 2' if axes == 2 else '2'} are needed",
            key,
        )
    if not np.isfinite(values).any():
        raise CaseError(f"all {_size(values)} points of the part {list(corners)} mm are lost; another is needed", key)
    return _changed(height_map, values.copy(), f"crop: {_size(values)} points kept")


def without_spikes(height_map: HeightMap, limit: float) -> HeightMap:
    """Return the map without points more than `limit` standard deviations off the median of the 5 x 5 around them.

    The standard deviation is 1.4826 times the median of those distances that are not zero. Where most are zero, as on
    maps that are coarsely rounded or made by a formula, the rest may well be spikes. The median step between neighbours
    of different heights then takes the place of the distance: a point within a few such steps is no spike.
    """
    values = height_map.values
    known = np.isfinite(values)
    rounding = 2.0 * EPSILON * float(np.max(np.abs(values[known])))  # of two heights
    distance = np.abs(values - _local_medians(values))
    apart, remark = distance[distance > rounding], ""
    if 2 * apart.size < known.sum():
        steps = np.abs(np.concatenate([np.diff(values, axis=axis).ravel() for axis in (0, 1)]))
        apart = steps[steps > rounding]
        remark = ", by the steps between neighbours, as most equal the median around them"
    spikes = distance > limit * 1.4826 * (float(np.median(apart)) if apart.size else math.inf)
    remark = f"spikes: {counted(int(spikes.sum()), 'point')} counted as lost{remark}"
    return _changed(height_map, np.where(spikes, np.nan, values), remark)


def filled(height_map: HeightMap, share: float, key: KeyPath) -> HeightMap:
    """Return the map with its holes filled by discrete Laplace equations, except for the holes that reach the rim.

    Planes are filled exactly; a hole of radius r in a ball of radius R is filled r^2/2R too flat. Raises CaseError if
    more than `share` of all points would be filled.
    """
    values = height_map.values
    inside, count, _ = holes(height_map)
    lost = int(inside.sum())
    if lost > share * values.size:
        raise CaseError(
            f"{percent(lost / values.size)} of the map's points are lost in its holes, more than {percent(share)};"
            " crop the map, or give a larger share",
            key,
        )
    at_rim = int((~np.isfinite(values)).sum()) - lost
    remark = f"fill: {counted(lost, 'point')} in {counted(count, 'hole')} filled"
    remark += f", {counted(at_rim, 'point')} at the rim left" if at_rim else ""
    return _changed(height_map, _harmonic(values, inside, height_map.spacing) if lost else values, remark)


def levelled(height_map: HeightMap, name: str, key: KeyPath) -> HeightMap:
    """Return the map less the form `name` that fits it best. Raises CaseError if too few points are known for it."""
    form = fitted(height_map, name)
    if not form.determined:
        known = counted(int(np.isfinite(height_map.values).sum()), "known point")
        raise CaseError(f"the {known} of the map allow more than one {name}; a simpler form is needed", key)
    if name == "offset":
        remark = f"level: offset of {in_small_unit(form.offset)} taken off"
    else:
        remark = f"level: {name} taken off, {_several('tilt', [round(tilt, 7) + 0.0 for tilt in form.tilts], '')}"
    if form.curvatures:
        radii = [1.0 / curvature if curvature else math.inf for curvature in form.curvatures]
        remark += f", {_several('radius', radii, ' mm')} of the paraboloid"
    done = _changed(height_map, height_map.values - form.heights, remark)
    if name == "sphere" and form.curvatures[0]:
        # a sphere of radius R rises by r^4/8R^3 above its paraboloid
        rise = (0.5 * math.hypot(*height_map.span)) ** 4 * abs(form.curvatures[0]) ** 3 / 8.0
        if rise > float(np.nanstd(done.values)):
            doubt = (
                f"the map is so wide that a sphere of its radius is no paraboloid, by {in_small_unit(rise, 2)} in its"
                " corners; crop it, or level its quadratic form"
            )
            done = replace(done, doubts=(*done.doubts, doubt))
    return done


def filtered(height_map: HeightMap, cutoff: float, key: KeyPath, *, keep_long: bool) -> HeightMap:
    """Return the waves of a map that are longer, or else shorter, than `cutoff` (mm), by a Gaussian filter.

    Source: ISO 16610-21 for profiles, ISO 16610-61 for areas: weights exp(-pi (r/(alpha cutoff))^2), with which a wave
    as long as the cut-off keeps half its height. At rims and holes the weights of the known points are scaled to a sum
    of 1; holes stay holes.
    """
    axes = [axis for axis, count in enumerate(height_map.values.shape) if count > 1]
    least, most = 2.0 * max(height_map.spacing[axis] for axis in axes), max(height_map.span)
    if not least <= cutoff <= most:
        raise CaseError(
            f"{in_small_unit(cutoff)} is no wave of the map; a cut-off between two points, {in_small_unit(least)}, and"
            f" the length of the map, {in_small_unit(most)}, is needed",
            key,
        )
    values = height_map.values
    known = np.isfinite(values)
    sums, weights = (
        _gaussian_sums(part, height_map.spacing, cutoff) for part in (np.where(known, values, 0.0), known.astype(float))
    )
    long_waves = np.where(known, sums / np.where(known, weights, 1.0), np.nan)
    remark = f"filter: waves {'shorter' if keep_long else 'longer'} than {in_small_unit(cutoff)} taken off"
    return _changed(height_map, long_waves if keep_long else values - long_waves, remark)


def holes(height_map: HeightMap) -> tuple[BoolArray, int, int]:
    """Return the lost points (mx, my) whose hole does not reach the rim, and the number of holes that do not and do.

    Points of a hole are neighbours along x or y.
    """
    from scipy.ndimage import label

    labels, count = label(~np.isfinite(height_map.values))
    rims = [np.take(labels, (0, -1), axis).ravel() for axis in (0, 1) if labels.shape[axis] > 1]
    at_rim = np.setdiff1d(np.concatenate(rims), 0)
    inside: BoolArray = (labels > 0) & ~np.isin(labels, at_rim)
    return inside, count - at_rim.size, at_rim.size


def _changed(height_map: HeightMap, values: DoubleArray, remark: str) -> HeightMap:
    return replace(height_map, values=values, remarks=(*height_map.remarks, remark))


def _size(values: DoubleArray) -> str:
    return cell_counts((values.shape[0], values.shape[1]))


def _several(noun: str, values: Sequence[float], unit: str) -> str:
    """Write one or two values, such as ``tilts 0.01 and -0.003``."""
    plural = {"tilt": "tilts", "radius": "radii"}[noun]
    return f"{noun if len(values) == 1 else plural} {' and '.join(f'{value:.6g}' for value in values)}{unit}"


def _local_medians(values: DoubleArray) -> DoubleArray:
    """Return the medians of the heights (mx, my) in a square about each known point.

    Near rims and holes only those neighbours count whose opposite neighbour is known, so that a tilt moves no median.
    """
    from scipy.ndimage import binary_dilation, median_filter

    square = NEIGHBORS, NEIGHBORS
    padded = np.pad(values, NEIGHBORS // 2, constant_values=np.nan)
    lost = np.isnan(padded)
    inner = (slice(NEIGHBORS // 2, -(NEIGHBORS // 2)),) * 2
    medians: DoubleArray = median_filter(np.where(lost, 0.0, padded), square)[inner]
    near = np.nonzero(binary_dilation(lost, np.ones(square))[inner])
    squares = sliding_window_view(padded, square)
    for first in range(0, len(near[0]), BLOCK):  # a part at a time, since each point takes 25 numbers
        part = near[0][first : first + BLOCK], near[1][first : first + BLOCK]
        heights = squares[part].reshape(-1, NEIGHBORS**2)
        heights[np.isnan(heights[:, ::-1])] = np.nan
        pairs = np.isfinite(heights).sum(axis=1) // 2
        medians[part] = np.sort(heights, axis=1)[np.arange(len(pairs)), pairs]
    return medians


def _harmonic(values: DoubleArray, inside: BoolArray, spacing: tuple[float, float]) -> DoubleArray:
    """Return the map with the points `inside` the means of their neighbours along x and y, weighted by 1/spacing^2."""
    from scipy.sparse import coo_array, eye_array
    from scipy.sparse.linalg import spsolve

    heights, unknown = values.copy().ravel(), np.flatnonzero(inside)
    count, number = unknown.size, np.full(values.size, -1)
    number[unknown] = np.arange(count)
    middle = float(np.nanmean(values))
    matrix, right_side = coo_array((count, count)).tocsc(), np.zeros(count)
    for axis, stride in enumerate((values.shape[1], 1)):
        weight = (min(spacing) / spacing[axis]) ** 2
        for neighbor in (unknown - stride, unknown + stride) if values.shape[axis] > 1 else ():
            known = number[neighbor] < 0
            right_side += np.where(known, weight * (heights[neighbor] - middle), 0.0)
            rows, columns = np.flatnonzero(~known), number[neighbor[~known]]
            entries = coo_array((np.full(rows.size, weight), (rows, columns)), shape=matrix.shape)
            matrix = matrix + weight * eye_array(count) - entries
    heights[unknown] = middle + spsolve(matrix.tocsc(), right_side, permc_spec="MMD_AT_PLUS_A")
    return heights.reshape(values.shape)


def _gaussian_sums(values: DoubleArray, spacing: tuple[float, float], cutoff: float) -> DoubleArray:
    """Return the sums of values (mx, my) times the filter's weights about each point; a point's own weight is 1.

    Weights that vanish in rounding are left out.
    """
    from scipy.signal import fftconvolve

    width = math.sqrt(math.log(2.0) / math.pi) * cutoff
    for axis, step in enumerate(spacing):
        reach = min(values.shape[axis] - 1, math.ceil(width / step * math.sqrt(-math.log(EPSILON) / math.pi)))
        weights = np.exp(-math.pi * (np.arange(-reach, reach + 1) * step / width) ** 2)
        values = fftconvolve(values, np.expand_dims(weights, 1 - axis), mode="same", axes=axis)
    return values
