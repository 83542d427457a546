"""Put lists of points on a grid: x, y, z of a map in any order, and x, z of a profile."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.quantities import LARGEST_MAGNITUDE, LEAST_MAGNITUDE
from fretsolve.problem.surface.files.raw_map import MOST_HEIGHTS
from fretsolve.system.arrays import DoubleArray

MOST_OFFSET = 0.25
"""Largest distance of a coordinate from its place on the grid, over the step."""

MOST_BARE_LINES = 0.05
"""Largest share of lines of the grid without any point; coordinates rounded to about a step leave more of them bare."""

MOST_LIMITS = 6
"""Limits between noise and steps that are tried."""

LEAST_NOISE = 0.02
"""Differences of coordinates below this share of the largest are surely none of two rows."""

EVEN = 1e-3
"""Largest distance of an x of a profile from its place on an even line, over the step."""


def gridded(
    points: DoubleArray, lines: NDArray[np.integer]
) -> tuple[DoubleArray, tuple[float, float], tuple[float, float], str | None]:
    """Return the heights (mx, my) of points x, y, z (n, 3), NaN where one is missing, and what the grid is.

    That is its spacing, its least x and y, and a remark on missing points. The points may come in any order, with
    coordinates that are rounded or noisy. lines: (n,) of the file. Raises ValueError if they are no grid.
    """
    kept = _located(points, lines, "x or y")
    found = points[kept]
    try:
        (column, nx, dx), (row, ny, dy) = (_places(found[:, axis], "xy"[axis], lines[kept]) for axis in (0, 1))
        if nx * ny > min(2 * len(found), MOST_HEIGHTS):
            raise ValueError(f"a grid for them has {nx} x {ny} points, they are {len(found)}, less than half")
        place = column * ny + row
        count = np.bincount(place, minlength=nx * ny)
        if count.max() > 1:
            two = np.flatnonzero(place == np.argmax(count > 1))[:2]
            first, second = lines[kept[two]]
            raise ValueError(
                f"lines {first} and {second} give one place, x = {found[two[0], 0]:g}, y = {found[two[0], 1]:g}"
            )
    except ValueError as error:
        raise ValueError(f"its 3 columns are read as x y z, which are no grid: {error}") from None
    values = np.full(nx * ny, np.nan)
    values[place] = found[:, 2]
    missing = int(np.count_nonzero(~np.isfinite(values)))
    if 2 * missing > nx * ny:
        raise ValueError(f"{missing} of the {nx} x {ny} points of its grid x y z are missing, more than half")
    remark = f"{missing} of {nx * ny} points are missing: holes" if missing else None
    start = (float(found[:, 0].min()), float(found[:, 1].min()))
    return values.reshape(nx, ny), (dx, dy), start, remark


def evened(points: DoubleArray, lines: NDArray[np.integer]) -> tuple[DoubleArray, float, str | None]:
    """Return the heights (n,) of a profile x, z (n, 2) at even x, their spacing, and a remark if x was not even.

    Heights at uneven x are interpolated linearly. lines: (n,) of the file. Raises ValueError if points are too few, or
    share an x.
    """
    kept = _located(points, lines, "x")
    if len(kept) < 2:
        raise ValueError(f"it has {len(kept)} points x z of a profile; at least 2 are needed")
    order = kept[np.argsort(points[kept, 0], kind="stable")]
    x, z = points[order].T
    steps = np.diff(x)
    if steps.min() == 0.0:
        first, second = sorted(lines[order[(at := int(steps.argmin())) : at + 2]])
        raise ValueError(
            f"lines {first} and {second} have the same x, {x[at]:g}; a profile x z has one height for each x"
        )
    with suppress(ValueError):  # points of an even line, of which some are missing
        place, count, step = _places(x, "x", lines[order])
        if np.unique(place).size == len(x) and np.abs(x - x[0] - step * place).max() <= EVEN * step:
            values = np.full(count, np.nan)
            values[place] = z
            missing = count - len(x)
            return values, step, f"{missing} of {count} points are missing: holes" if missing else None
    even = np.linspace(x[0], x[-1], len(x))
    step = float((x[-1] - x[0]) / (len(x) - 1))
    if np.abs(x - even).max() <= EVEN * step:
        return z, step, None
    remark = (
        f"x of the profile is not even: steps of {steps.min():.6g} to {steps.max():.6g} are resampled to {step:.6g}"
    )
    return np.interp(even, x, z), step, remark


def _located(points: DoubleArray, lines: NDArray[np.integer], what: str) -> NDArray[np.intp]:
    """Return the indices of the points that have coordinates; raises ValueError where one has a height but no place."""
    located = np.isfinite(points[:, :-1]).all(axis=1)
    far = np.flatnonzero(located & (np.abs(points[:, :-1]) > LARGEST_MAGNITUDE).any(axis=1))
    if far.size:
        raise ValueError(f"line {lines[far[0]]} holds no possible {what}")
    stray = np.flatnonzero(~located & np.isfinite(points[:, -1]))
    if stray.size:
        raise ValueError(f"line {lines[stray[0]]} has a height, but its {what} is lost")
    return np.flatnonzero(located)


def _places(values: DoubleArray, name: str, lines: NDArray[np.integer]) -> tuple[NDArray[np.intp], int, float]:
    """Return the index of each coordinate on an even line, the number of places of the line, and its step.

    lines: of the points in the file, for messages. Raises ValueError if a coordinate is off the line.
    """
    ordered = np.sort(values)
    if not ordered.size or ordered[-1] - ordered[0] < LEAST_MAGNITUDE:
        raise ValueError(f"all have the same {name}" if ordered.size else "all are lost")
    # Coordinates of a row differ by rounding or noise, less than those of two rows; a large ratio of successive sizes
    # of the gaps may part the two. The likeliest limit whose rows make an even line is taken.
    gaps = np.diff(ordered)
    sizes = np.sort(np.append(np.maximum(gaps, LEAST_NOISE * gaps.max()), LEAST_NOISE * gaps.max()))
    limits = sizes[1:][np.argsort(sizes[:-1] / sizes[1:], kind="stable")[:MOST_LIMITS]]
    least, reason = len(values) + 1, ""
    for limit in limits:
        place, rows, step = _along_line(limit, ordered, values)
        off = np.abs(place - np.round(place))
        astray = int(np.count_nonzero(off > MOST_OFFSET))
        found = (np.round(place) - np.round(place.min())).astype(np.intp)
        count = int(found.max()) + 1
        bare = count - np.unique(found).size
        if astray == 0 and bare <= MOST_BARE_LINES * count:
            return found, count, step
        if astray < least:
            worst, least = int(off.argmax()), astray
            reason = (
                f"{bare} of {count} lines along {name}, {step:.4g} apart, have no point; are the coordinates rounded"
                " too coarsely?"
            )
            if astray:
                reason = (
                    f"the {name} in line {lines[worst]}, {values[worst]:g}, is {off[worst]:.2f} of a step off a"
                    f" regular line of {rows} places, {step:.4g} apart"
                )
    raise ValueError(reason)


def _along_line(limit: float, ordered: DoubleArray, values: DoubleArray) -> tuple[DoubleArray, int, float]:
    """Return coordinates in steps of the even line that fits best, the number of rows on it, and the step.

    Successive coordinates less than `limit` apart belong to one row.
    """
    starts = np.concatenate([[0], np.flatnonzero(np.diff(ordered) >= limit) + 1])
    weights = np.diff(np.append(starts, len(ordered)))
    middles = np.add.reduceat(ordered, starts) / weights
    # The step of the most rows is a first guess; rounding along the line and least squares make it exact.
    between = np.diff(middles)
    step = float(np.median(between[between <= 1.5 * between.min()]))
    index = np.concatenate([[0.0], np.cumsum(np.round(between / step))])
    for _ in range(2):
        mean, center = np.average(index, weights=weights), np.average(middles, weights=weights)
        step = float(weights @ ((index - mean) * (middles - center)) / (weights @ (index - mean) ** 2))
        index = np.round((middles - middles[0]) / step)
    return (values - np.average(middles - step * index, weights=weights)) / step, len(middles), step
