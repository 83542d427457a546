"""Search the critical plane of each point.

1. Scan planes `step` degrees apart at every point. The circle around a shear path is bounded from above by its largest
   distance from the middle of its bounding box. Exact circles are found in the order of these bounds, until no plane
   of the scan can be better. One parabola through planes around the best one then improves it; where planes without
   tension are worth nothing, some more rounds of the search of step 4 do.
2. What a scan may miss is less than `scan_margin`: a parameter is the largest of many smooth functions of the plane, so
   its maximum is a smooth hill, and the error of a scan grows with the square of its step.
3. Where the bounds of the scan leave many points, as in nearly uniform stress, halve the cells of planes in which some
   point may be the worst, until few points are left or refining them costs less.
4. Refine points in the order of their bounds, from several planes of a finer scan, until no other point can beat the
   worst. The other points keep the value of the first scan, which is at most that share too small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.post.fatigue.plane_cells import BLOCK, PLANES_AT_ONCE, PlaneCells, plane_bounds, with_margin
from fretsolve.post.fatigue.planes import (
    Combine,
    PlaneCriterion,
    evaluate,
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

FIRST_REFINED = 8
"""Points that are refined before bounds become closer, where no worst value is known."""

ACCURACY = 1e-6
"""Share by which the worst value may be too small, beside the error of a refined plane."""

MOST_CELLS = 1000
"""Cells of planes from which on refining a point costs less than bounding it."""

SAME_PLANE = 1e-3
"""Radians within which planes are the same; from there the search leads to the same top."""

LEAST_GAIN = 1e-13
"""Share by which a plane must be better: along a ridge of nearly equal planes the search would creep for less."""

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
    bound = with_margin(np.maximum(bound, value), step)
    fine, most = Scan(criterion, min(step, 5.0)), max(1, BLOCK // PLANES_AT_ONCE // steps)
    if refine_all:
        for block in _blocks(points, most):
            value[block], normal[:, block] = fine.refined(np.ascontiguousarray(stress[:, :, block]))
        return PlaneField(value, upright(normal.T).T, ~refined)
    worst, left, cells = known, np.arange(points), PlaneCells.of_half_sphere(step)
    count = min(FIRST_REFINED, most)
    while True:
        if worst > -np.inf:
            left = left[bound[left] > worst + ACCURACY * abs(worst)]
            if left.size > count and len(cells) < MOST_CELLS:
                # Many are left where stress is nearly uniform: bound them on smaller cells of planes.
                history = np.ascontiguousarray(stress[:, :, left])
                if cells.step == step:
                    cells = cells.bounds(criterion, history, worst)[1]
                closer, cells = cells.halved().bounds(criterion, history, worst)
                bound[left] = np.minimum(bound[left], closer)
                value[left] = np.minimum(value[left], bound[left])  # the plane of a scan may be wrong where planes tie
                continue
        if not left.size:
            break
        # Refine the points that may be worst, in the order of their bounds.
        left = left[np.argsort(-bound[left], kind="stable")]
        some, left = left[:count], left[count:]
        value[some], normal[:, some] = fine.refined(np.ascontiguousarray(stress[:, :, some]))
        refined[some] = True
        worst, count = max(worst, float(value[some].max())), most
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

    def best(self, stress: DoubleArray, improve: bool = True) -> tuple[DoubleArray, DoubleArray, DoubleArray]:
        """Return the parameter (points,) on the best plane, its normal (3, points), and a bound for all planes.

        improve: go on from the best plane, to the top of a parabola around it if that is better.
        """
        amplitude, normal = plane_bounds(self.rows, stress)
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
            first, same = _distinct(normals.reshape(points, count, 3))
            normals = _climb(criterion, rank, history[:, :, first], normals[first], turn)[same]
        amplitude, normal = (found.reshape(points, count) for found in evaluate(criterion, history, normals[:, None]))
        value = criterion.combine(amplitude, normal)
        largest = amplitude.max(axis=1)[:, None]
        score = np.where(amplitude >= largest * (1.0 - TIE), normal, -np.inf) if criterion.ties else value
        best = (np.arange(points), score.argmax(axis=1))
        return value[best], normals.reshape(points, count, 3)[best].T


def _where(mask: BoolArray, *arrays: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    return tuple(array[mask] for array in arrays)


def _distinct(normals: DoubleArray) -> tuple[IndexArray, IndexArray]:
    """Return the places of planes that differ from those before them, and the place among these that each one has.

    normals: (points, m, 3); places: in (points m).
    """
    points, count, _ = normals.shape
    near = np.abs(normals @ normals.swapaxes(1, 2)) > math.cos(SAME_PLANE)
    first = (near.argmax(axis=2) + count * np.arange(points)[:, None]).ravel()
    return np.unique(first, return_inverse=True)


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
    criterion: PlaneCriterion, rank: Combine, stress: DoubleArray, normals: DoubleArray, turn: float, rounds: int = 150
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
        better = reached > height[going] + LEAST_GAIN * np.abs(height[going])
        moved = going[better]
        normals[moved], height[moved] = around[better, best[better]], reached[better]
        # Near the top its distance is the next turn; without progress half of the last one is.
        onwards = better & (best == 8)
        near = np.hypot(*to_top[onwards].T)
        turns[going[onwards]] = np.clip(near, 0.25 * turns[going[onwards]], 2.0 * turns[going[onwards]])
        turns[going[~better]] *= 0.5
        along = going[better & (best != 8)]
        turns[along] = np.minimum(2.0 * turns[along], turn)  # along a ridge steps grow again
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
