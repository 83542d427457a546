"""Search the critical plane of each point.

1. Scan planes `step` degrees apart at every point. The circle around a shear path is bounded from above by its largest
   distance from the middle of its bounding box. Exact circles are found in the order of these bounds, until no plane
   of the scan can be better. One parabola through planes around the best one then improves it; where planes without
   tension are worth nothing, some more rounds of the search of step 3 do.
2. What a scan may miss is less than `scan_margin`: a parameter is the largest of many smooth functions of the plane, so
   its maximum is a smooth hill, and the error of a scan grows with the square of its step.
3. Refine points in the order of their bounds, from several planes of a finer scan, until no other point can beat the
   worst. The other points keep the value of the first scan, which is at most that share too small.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.post.fatigue.planes import (
    Combine,
    PlaneCriterion,
    in_plane_axes,
    scan_normals,
    smallest_ball,
    traction_rows,
    upright,
)
from fretsolve.system.arrays import BoolArray, DoubleArray, IndexArray

SCAN_STEP = 10.0
"""Degrees between the planes of the scan of all points."""

CANDIDATES = 6
"""Planes of the scan from which a point is refined."""

FINEST_TURN = 2e-5
"""Radians to which the plane of a refined point is found; a parameter is then off by the square of this angle."""

BLOCK = 20480
"""States times points that are scanned at once, so that the stresses on some planes stay in the processor's cache."""

PLANES_AT_ONCE = 8
"""Planes of the scan, and planes around a refined plane, on which stresses are computed at once."""

TIE = 1e-6
"""Amplitudes that differ by this share are equal."""


@dataclass(frozen=True)
class PlaneField:
    """A parameter at each point on its critical plane.

    value: (points,); normal: (3, points), towards z >= 0; refined: (points,), False where the value comes from
    the scan and may be too small.
    """

    value: DoubleArray
    normal: DoubleArray
    refined: BoolArray


def scan_margin(step: float) -> float:
    """Return by which share a scan may miss a parameter that is not near 0.

    It is half as much again as on the worst of 2000 random histories, see docs/verification.md.
    """
    return 0.08 * (step / 10.0) ** 2


def search(
    criterion: PlaneCriterion,
    stress: DoubleArray,
    step: float = SCAN_STEP,
    refine_all: bool = False,
    known: float = -np.inf,
) -> PlaneField:
    """Return the parameter and the critical plane of each point; stress: (steps, 6, points) in MPa.

    step: degrees between the planes of the scan; refine_all: also refine points that cannot be the worst. known: the
    largest value of points that were searched before, so that only worse ones are refined.
    """
    steps, _, points = stress.shape
    value, bound = np.empty(points), np.empty(points)
    normal, refined = np.empty((3, points)), np.zeros(points, bool)
    scan = Scan(criterion, step)
    for block in _blocks(points, BLOCK // steps):
        value[block], normal[:, block], bound[block] = scan.best(np.ascontiguousarray(stress[:, :, block]))
    bound = np.maximum(bound, value)
    bound += scan_margin(step) * np.abs(bound)  # Findley's may be negative
    order = np.argsort(-bound)
    scan = Scan(criterion, min(step, 5.0))
    worst = known
    for block in _blocks(points, BLOCK // PLANES_AT_ONCE // steps):
        some = order[block]
        if not refine_all:
            some = some[bound[some] >= worst]
        if not some.size:
            break
        value[some], normal[:, some] = scan.refined(np.ascontiguousarray(stress[:, :, some]))
        refined[some] = True
        worst = max(worst, float(value[some].max()))
    return PlaneField(value, upright(normal.T).T, refined)


def _blocks(points: int, size: int) -> list[slice]:
    size = max(size, 1)
    return [slice(begin, begin + size) for begin in range(0, points, size)]


class Scan:
    """The planes `step` degrees apart, and what they give at some points."""

    def __init__(self, criterion: PlaneCriterion, step: float):
        self.criterion = criterion
        self.step = step
        self.normals = scan_normals(step)
        self.rows = criterion.rows(self.normals)  # (planes, 1 + k, 6)

    def bounds(self, stress: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        """Return upper bounds of the amplitude and the largest normal stress, both (planes, points)."""
        steps, _, points = stress.shape
        # (6, steps points), so that the stresses on all planes are one product of matrices
        columns = np.ascontiguousarray(stress.swapaxes(0, 1)).reshape(6, -1)
        amplitude, normal = np.empty((2, len(self.rows), points))
        for begin in range(0, len(self.rows), PLANES_AT_ONCE):
            some = slice(begin, begin + PLANES_AT_ONCE)
            squares = None
            for part, row in enumerate(self.rows[some].swapaxes(0, 1)):
                on_planes = (row @ columns).reshape(len(row), steps, points)
                highest = on_planes.max(axis=1)
                if part == 0:
                    normal[some] = highest
                    continue
                lowest = on_planes.min(axis=1)
                if len(self.rows[0]) == 2:  # one component: half of its range is exact
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

    def best(self, stress: DoubleArray, improve: bool = True) -> tuple[DoubleArray, DoubleArray, DoubleArray]:
        """Return the parameter (points,) on the best plane, its normal (3, points), and a bound for all planes.

        improve: go on from the best plane, to the top of a parabola around it if that is better.
        """
        amplitude, normal = self.bounds(stress)
        rank, combine = self.criterion.ranks[0], self.criterion.combine
        above = rank(amplitude, normal)
        points = stress.shape[2]
        planes, highest = np.zeros(points, np.intp), np.full(points, -np.inf)
        going = np.arange(points)
        # Evaluate the planes of each point in the order of their bounds, until no other bound beats the best value.
        for _ in range(len(above)):
            tried = above[:, going].argmax(axis=0)
            going, tried = _where(
                above[tried, going] > highest[going] + 1e-9 * np.abs(above[tried, going]), going, tried
            )
            if not going.size:
                break
            exact = evaluate(self.criterion, stress[:, :, going], self.normals[tried][:, None])
            reached = rank(*exact)[:, 0]
            above[tried, going] = -np.inf
            moved, plane, reached = _where(reached > highest[going], going, tried, reached)
            planes[moved], highest[moved] = plane, reached
        normals = self.normals[planes]
        if improve:
            rounds = self.criterion.rounds
            normals = _climb(self.criterion, rank, stress, normals, np.radians(0.4 * self.step), rounds)
        exact = evaluate(self.criterion, stress, normals[:, None])
        return combine(*exact)[:, 0], normals.T, combine(amplitude, normal).max(axis=0)

    def candidates(self, stress: DoubleArray) -> DoubleArray:
        """Return the normals (points, CANDIDATES, 3) of the best planes that lie apart."""
        everywhere = np.broadcast_to(self.normals, (stress.shape[2], *self.normals.shape))
        score = self.criterion.ranks[0](*evaluate(self.criterion, stress, everywhere))
        near = np.abs(self.normals @ self.normals.T) > np.cos(np.radians(2.5 * self.step))
        chosen = np.empty((len(score), CANDIDATES), np.intp)
        for place in range(CANDIDATES):
            chosen[:, place] = score.argmax(axis=1)
            score[near[chosen[:, place]]] = -np.inf
        return np.asarray(self.normals[chosen])

    def refined(self, stress: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        """Return the parameter (points,) on the critical plane and its normal (3, points)."""
        criterion, turn = self.criterion, np.radians(0.4 * self.step)
        candidates = self.candidates(stress)
        points, count, _ = candidates.shape
        history, normals = np.repeat(stress, count, axis=2), candidates.reshape(-1, 3)
        if criterion.ties:
            # The plane across the shear has nearly the same amplitude, and another normal stress.
            normals = _climb(criterion, criterion.ranks[0], history, normals, turn)
            across = _shear_direction(history, normals)
            normals = np.stack([normals, across], axis=1).reshape(-1, 3)
            count, history = 2 * count, np.repeat(history, 2, axis=2)
        for rank in criterion.ranks:
            normals = _climb(criterion, rank, history, normals, turn)
        amplitude, normal = (found.reshape(points, count) for found in evaluate(criterion, history, normals[:, None]))
        value = criterion.combine(amplitude, normal)
        largest = amplitude.max(axis=1)[:, None]
        score = np.where(amplitude >= largest * (1.0 - TIE), normal, -np.inf) if criterion.ties else value
        best = (np.arange(points), score.argmax(axis=1))
        return value[best], normals.reshape(points, count, 3)[best].T


def _where(mask: BoolArray, *arrays: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    return tuple(array[mask] for array in arrays)


def evaluate(criterion: PlaneCriterion, stress: DoubleArray, normals: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Return the exact amplitude and the largest normal stress, both (points, m), on planes (points, m, 3)."""
    steps, _, points = stress.shape
    count = normals.shape[1]
    rows = criterion.rows(normals)  # (points, m, 1 + k, 6)
    parts = rows.shape[2]
    on_planes = rows.reshape(points, count * parts, 6) @ stress.transpose(2, 1, 0)
    on_planes = on_planes.reshape(points, count, parts, steps)
    path = np.ascontiguousarray(on_planes[:, :, 1:].transpose(3, 2, 0, 1)).reshape(steps, parts - 1, points * count)
    return smallest_ball(path)[0].reshape(points, count), on_planes[:, :, 0].max(axis=2)


def _shear_direction(stress: DoubleArray, normals: DoubleArray) -> DoubleArray:
    """Return unit vectors (points, 3) along the largest shear stress, from its path's middle, on planes (points, 3)."""
    axes = np.stack(in_plane_axes(normals), axis=1)  # (points, 2, 3)
    path = (traction_rows(axes, normals[:, None]) @ stress.transpose(2, 1, 0)).transpose(2, 1, 0)
    away = path - smallest_ball(np.ascontiguousarray(path))[1]
    farthest = np.square(away).sum(axis=1).argmax(axis=0)
    along = away[farthest, :, np.arange(len(normals))]  # (points, 2)
    direction = (along[:, :, None] * axes).sum(axis=1)
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    return np.where(length > 0.0, direction / np.where(length > 0.0, length, 1.0), normals)


def _climb(
    criterion: PlaneCriterion, rank: Combine, stress: DoubleArray, normals: DoubleArray, turn: float, rounds: int = 500
) -> DoubleArray:
    """Return the planes (points, 3) of largest rank near `normals`; turn: radians of the first step.

    rounds: some dozens are usual, more where planes tie along a curve.
    A pattern search: to the best of eight planes around or to the top of the parabola through them; half as far if none
    is better.
    """
    normals = normals.copy()
    height = rank(*evaluate(criterion, stress, normals[:, None]))[:, 0]
    turns = np.full(len(normals), turn)
    angles = 0.25 * np.pi * np.arange(8)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for _ in range(rounds):
        going = np.flatnonzero(turns > FINEST_TURN)
        if not going.size:
            break
        history = stress[:, :, going]
        around = _turned(normals[going], turns[going, None, None] * circle)
        heights = rank(*evaluate(criterion, history, around))
        to_top = _top_of_parabola(height[going], heights, turns[going])
        top = _turned(normals[going], to_top[:, None])
        around = np.concatenate([around, top], axis=1)
        heights = np.concatenate([heights, rank(*evaluate(criterion, history, top))], axis=1)
        best: IndexArray = heights.argmax(axis=1)
        reached = heights[np.arange(len(going)), best]
        better = reached > height[going]
        moved = going[better]
        normals[moved], height[moved] = around[better, best[better]], reached[better]
        # Near the top its distance is the next turn; without progress half of the last one is.
        onwards = better & (best == 8)
        near = np.hypot(*to_top[onwards].T)
        turns[going[onwards]] = np.clip(near, 0.25 * turns[going[onwards]], 2.0 * turns[going[onwards]])
        turns[going[~better]] *= 0.5
    return normals


def _turned(normals: DoubleArray, turns: DoubleArray) -> DoubleArray:
    """Return normals (points, m, 3) turned by `turns` (points, m, 2), radians along both axes of their planes."""
    first, second = in_plane_axes(normals)
    towards = turns[..., :1] * first[:, None] + turns[..., 1:] * second[:, None]
    angle = np.hypot(turns[..., :1], turns[..., 1:])
    return np.asarray(normals[:, None] * np.cos(angle) + towards * np.sinc(angle / np.pi))


def _top_of_parabola(height: DoubleArray, heights: DoubleArray, turns: DoubleArray) -> DoubleArray:
    """Return where a parabola through a plane and eight around it is highest, (points, 2), at most four turns away.

    height: (points,); heights: (points, 8), counterclockwise from the first axis. Zero where it has no top.
    """
    # Derivatives by the turn, in units of `turns`; the points between the axes give the mixed one.
    slope = 0.5 * np.stack([heights[:, 0] - heights[:, 4], heights[:, 2] - heights[:, 6]], axis=1)
    along = heights[:, 0] + heights[:, 4] - 2.0 * height
    across = heights[:, 2] + heights[:, 6] - 2.0 * height
    mixed = 0.5 * (heights[:, 1] + heights[:, 5] - heights[:, 3] - heights[:, 7])
    determinant = along * across - mixed**2
    has_top = (along < 0.0) & (determinant > 0.0)
    determinant = np.where(has_top, determinant, 1.0)
    top = np.stack([mixed * slope[:, 1] - across * slope[:, 0], mixed * slope[:, 0] - along * slope[:, 1]], axis=1)
    top = np.where(has_top[:, None], top / determinant[:, None], 0.0)
    far = np.maximum(np.hypot(top[:, 0], top[:, 1]) / 4.0, 1.0)
    return np.asarray(top * (turns / far)[:, None])
