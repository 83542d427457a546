"""Bounds of a parameter on cells of planes, which are halved where a parameter may be largest.

Where stress is nearly uniform, the bounds of a scan hold thousands of points that may be the worst. Cells half as wide
have a quarter of the margin, and only cells in which some point may be the worst are halved again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.post.fatigue.planes import PlaneCriterion, evaluate, normals_at, plane_rings
from fretsolve.system.arrays import BoolArray, DoubleArray

BLOCK, PLANES_AT_ONCE = 20480, 8
"""States times points, and planes, on which stresses are computed at once, so that they stay in cache."""


def scan_margin(step: float) -> float:
    """Return by which share planes `step` degrees apart may miss a parameter that is not near 0.

    It is half as much again as on the worst of 2000 random histories, see docs/verification.md.
    """
    return 0.08 * (step / 10.0) ** 2


def with_margin(value: DoubleArray, step: float) -> DoubleArray:
    """Return the most that a parameter may be whose value is largest on planes `step` degrees apart."""
    return np.asarray(value + scan_margin(step) * np.abs(value))  # Findley's may be negative


def plane_bounds(rows: DoubleArray, stress: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Return upper bounds of the amplitude and the largest normal stress on planes, both (planes, points).

    rows: of the planes, (planes, 1 + k, 6); stress: (steps, 6, points) in MPa.
    """
    steps, _, points = stress.shape
    # (6, steps points), so that the stresses on all planes are one product of matrices
    columns = np.ascontiguousarray(stress.swapaxes(0, 1)).reshape(6, -1)
    amplitude, normal = np.empty((2, len(rows), points))
    for begin in range(0, len(rows), PLANES_AT_ONCE):
        some = slice(begin, begin + PLANES_AT_ONCE)
        squares = None
        for part, row in enumerate(rows[some].swapaxes(0, 1)):
            on_planes = (row @ columns).reshape(len(row), steps, points)
            highest = on_planes.max(axis=1)
            if part == 0:
                normal[some] = highest
                continue
            lowest = on_planes.min(axis=1)
            if len(rows[0]) == 2:  # one component: half of its range is exact
                amplitude[some] = 0.5 * (highest - lowest)
                continue
            on_planes -= 0.5 * (highest + lowest)[:, None]
            on_planes *= on_planes
            if squares is None:
                squares = on_planes
            else:
                squares += on_planes
        if squares is not None:
            amplitude[some] = np.sqrt(squares.max(axis=1))
    return amplitude, normal


@dataclass(frozen=True, eq=False)
class PlaneCells:
    """Cells of planes between circles of inclination and azimuth.

    step: degrees between planes; middles, sides: inclination and azimuth of each cell, (2, cells) in radians.
    """

    step: float
    middles: DoubleArray
    sides: DoubleArray

    @classmethod
    def of_half_sphere(cls, step: float) -> PlaneCells:
        """Return the cells around the planes of a scan."""
        middles, sides = [], []
        for ring in plane_rings(step):
            middles += [(ring.inclination, azimuth) for azimuth in ring.azimuths.tolist()]
            sides += [ring.sides] * len(ring.azimuths)
        # The cell around z is a cap, four sectors of which are cells as the others are.
        middles[:1] = [(0.25 * sides[0][0], (0.25 + 0.5 * k) * math.pi) for k in range(4)]
        sides[:1] = [(0.5 * sides[0][0], 0.5 * math.pi)] * 4
        return cls(step, np.transpose(middles), np.transpose(sides))

    def __len__(self) -> int:
        return int(self.middles.shape[1])

    @property
    def normals(self) -> DoubleArray:
        """Normals of the planes in the middles, (cells, 3)."""
        return normals_at(*self.middles)

    def halved(self) -> PlaneCells:
        """Return four cells for each."""
        corners = np.array([[-1, -1, 1, 1], [-1, 1, -1, 1]])
        middles = self.middles[:, :, None] + 0.25 * self.sides[:, :, None] * corners[:, None]
        return PlaneCells(0.5 * self.step, middles.reshape(2, -1), np.repeat(0.5 * self.sides, 4, axis=1))

    def bounds(self, criterion: PlaneCriterion, stress: DoubleArray, worst: float) -> tuple[DoubleArray, PlaneCells]:
        """Return the most that each point may have, (points,), and the cells in which one may have `worst` or more.

        A point may have `worst` in any case, since it may lie in cells that were left out before.
        """
        steps, _, points = stress.shape
        bound, kept = np.full(points, worst), np.zeros(len(self), bool)
        if not len(self):
            return bound, self
        rows, size = criterion.rows(self.normals), max(1, BLOCK // steps)
        for begin in range(0, points, size):
            block = slice(begin, begin + size)
            amplitude, normal = plane_bounds(rows, stress[:, :, block])
            upper = with_margin(criterion.combine(amplitude, normal), self.step)
            if criterion.ties:
                # The critical plane has the largest amplitude.
                highest = amplitude.argmax(axis=0)
                exact = evaluate(criterion, stress[:, :, block], self.normals[highest][:, None])[0][:, 0]
                upper[with_margin(amplitude, self.step) < exact] = -np.inf
            bound[block] = np.maximum(worst, upper.max(axis=0))
            kept |= (upper >= worst).any(axis=1)
        return bound, self._those(kept)

    def _those(self, kept: BoolArray) -> PlaneCells:
        return PlaneCells(self.step, self.middles[:, kept], self.sides[:, kept])
