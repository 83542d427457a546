"""Points of a load path at which runs with different numbers of increments are compared."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from fretsolve.model.load_path import LoadPath
from fretsolve.system.arrays import DoubleArray


class PathPoint(NamedTuple):
    """A point of the load path: the share `part` of the stage `stage` (0-based)."""

    stage: int
    part: float


def at_point(values: Callable[[int], DoubleArray], path: LoadPath, point: PathPoint) -> DoubleArray:
    """Return `values` of increments of `path` at a point of it, interpolated between them."""
    step = sum(path.counts[: point.stage]) + point.part * path.counts[point.stage] - 1.0
    low, high = around(step)
    before = values(low)
    return before + (step - low) * (values(high) - before) if high > low else before


def around(position: float) -> tuple[int, int]:
    """Return the whole numbers below and above a position, twice the same one if it is one but for rounding."""
    return math.floor(position + 1e-9), math.ceil(position - 1e-9)


def common_points(one: LoadPath, other: LoadPath, point: PathPoint) -> tuple[PathPoint, PathPoint, float]:
    """Return the points around `point` at which the path with fewer increments has one, and the share between them.

    The first may be the end of the stage before, or the start of the path (the share 0 of its first stage).
    """
    stage, part = point
    common = min(one.counts[stage], other.counts[stage])
    low, high = around(part * common)
    first = PathPoint(stage - 1, 1.0) if stage and not low else PathPoint(stage, low / common)
    return first, PathPoint(stage, high / common), part * common - low if high > low else 0.0


def between_common_points(
    value: Callable[[PathPoint], DoubleArray], one: LoadPath, other: LoadPath, point: PathPoint
) -> DoubleArray:
    """Return `value` at a point, interpolated between those at which the path with fewer increments has one."""
    first, second, share = common_points(one, other, point)
    end = value(second)
    if not share:
        return end
    start = value(first)
    return start + share * (end - start)
