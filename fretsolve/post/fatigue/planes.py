"""Planes through a point, with the stresses on them, and the smallest ball around the stresses of a cycle.

A plane is a row (6,) that gives a stress on it as its product with xx, yy, zz, xy, xz, yz. The centre of the smallest
ball around points is the mean of a few points on its surface, with weights w >= 0 that add up to 1 and maximise

    R^2(w) = sum_i w_i |p_i|^2 - |sum_i w_i p_i|^2

An active-set method (Lawson & Hanson 1974, ch. 23, whose steps are numbered below) finds them in finitely many steps:
it takes up the point farthest from the centre and drops points whose weight would become negative.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.system.arrays import BoolArray, DoubleArray, IndexArray


@dataclass(frozen=True, eq=False)
class PlaneRing:
    """Planes of equal inclination, and the cells around them.

    inclination: of the normals from z; azimuths: (planes,); sides: of a cell in inclination and azimuth. In radians.
    """

    inclination: float
    azimuths: DoubleArray
    sides: tuple[float, float]


def plane_rings(step: float) -> list[PlaneRing]:
    """Return rings of planes about `step` degrees apart whose cells cover the half sphere z >= 0.

    Rings of equal inclination are `step` apart; on each of them the normals are as far apart as that.
    """
    rings = max(1, round(90.0 / step))
    side = 0.5 * math.pi / rings
    found = [PlaneRing(0.0, np.zeros(1), (side, 2.0 * math.pi))]
    for ring in range(1, rings + 1):
        turn = math.pi if ring == rings else 2.0 * math.pi  # at the equator, opposite normals are the same plane
        count = max(1, round(math.sin(ring * side) * turn / math.radians(step)))
        found.append(PlaneRing(ring * side, turn * np.arange(count) / count, (side, turn / count)))
    return found


def normals_at(inclination: DoubleArray, azimuth: DoubleArray) -> DoubleArray:
    """Return unit vectors (planes, 3) at angles (planes,) in radians, from z and from x towards y."""
    sine = np.sin(inclination)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(inclination)], axis=1)


def scan_normals(step: float) -> DoubleArray:
    """Return normals (planes, 3) that cover the half sphere z >= 0 about `step` degrees apart, ring by ring."""
    rings = plane_rings(step)
    return np.concatenate([normals_at(np.full(len(one.azimuths), one.inclination), one.azimuths) for one in rings])


def in_plane_axes(normals: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Return two unit vectors (..., 3) in each plane, at right angles."""
    # the axis farthest from the normal gives the first one
    helper = np.eye(3)[np.abs(normals).argmin(axis=-1)]
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return first, np.cross(normals, first)


def traction_rows(along: DoubleArray, normals: DoubleArray) -> DoubleArray:
    """Return the rows (..., 6) of the traction along unit vectors (..., 3) on planes of normals (..., 3)."""
    a, n = np.moveaxis(along, -1, 0), np.moveaxis(normals, -1, 0)
    mixed = [a[i] * n[j] + a[j] * n[i] for i, j in ((0, 1), (0, 2), (1, 2))]
    return np.stack([a[0] * n[0], a[1] * n[1], a[2] * n[2], *mixed], axis=-1)


def upright(normals: DoubleArray) -> DoubleArray:
    """Return normals (..., 3) turned to z >= 0; in the plane z = 0 to y > 0, or to x > 0 along x."""
    x, y, z = np.moveaxis(np.where(np.abs(normals) < 1e-12, 0.0, normals), -1, 0)
    downwards = (z < 0.0) | ((z == 0.0) & ((y < 0.0) | ((y == 0.0) & (x < 0.0))))
    return np.where(downwards[..., None], -normals, normals)


Combine = Callable[[DoubleArray, DoubleArray], DoubleArray]
"""From amplitude and largest normal stress, both (...,), to a parameter (...,)."""


@dataclass(frozen=True)
class PlaneCriterion:
    """A parameter on the plane where it, or what ranks the planes, is largest.

    amplitude_rows: from normals (..., 3) to the rows (..., k, 6) of the components whose path has the amplitude; it is
    the radius of the smallest ball around the path in k dimensions. combine: the parameter. ranks: what the plane
    maximises, one function after the other, each from the plane of the function before; by default the parameter.
    ties: the plane of largest amplitude counts, and among equal ones the plane of largest normal stress. rounds: of the
    search from the best plane of a scan; one parabola leads to the top of a smooth hill, not of one cut off at 0.
    """

    amplitude_rows: Callable[[DoubleArray], DoubleArray]
    combine: Combine
    ranks: tuple[Combine, ...]
    ties: bool = False
    rounds: int = 1

    def rows(self, normals: DoubleArray) -> DoubleArray:
        """Return rows (..., 1 + k, 6): first the row of the normal stress, then the rows of the amplitude."""
        normal = traction_rows(normals, normals)[..., None, :]
        return np.concatenate([normal, self.amplitude_rows(normals)], axis=-2)


ROUNDING = 1e-10
"""A point is inside if it is not farther from the centre than R (1 + ROUNDING)."""

RIDGE = 1e-13
"""Added to the equations of the weights, relative to the size of the set, so that points in one plane can be solved."""


def smallest_ball(points: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Return the radii (sets,) and the centres (dimensions, sets) of the smallest balls.

    points: (points of a set, dimensions, sets).
    """
    _, dimensions, sets = points.shape
    radii, centers = np.empty(sets), np.empty((dimensions, sets))
    # Start from two points far apart. For most paths of a cycle they are a diameter.
    middle = 0.5 * (points.max(axis=0) + points.min(axis=0))
    first = _farthest(points, middle)[0]
    everywhere = np.arange(sets)
    second = _farthest(points, points[first, :, everywhere].T)[0]
    state = _Search(points, first, second)
    running = everywhere
    for _ in range(200):  # after so many steps the ball holds all points, but may be not quite the smallest
        farthest, distance = _farthest(state.points, state.centers)
        done = distance <= state.radii * (1.0 + ROUNDING) + state.negligible
        radii[running], centers[:, running] = distance, state.centers
        if done.all():
            break
        running, farthest = running[~done], farthest[~done]
        state.keep(~done)
        state.take_up(farthest)
    return radii, centers


def _farthest(points: DoubleArray, centers: DoubleArray) -> tuple[IndexArray, DoubleArray]:
    """Return the point farthest from the centre of each set, (sets,), and its distance, (sets,)."""
    squares = np.zeros((len(points), points.shape[2]))
    for along, center in zip(points.swapaxes(0, 1), centers, strict=True):
        away = along - center
        away *= away
        squares += away
    farthest = squares.argmax(axis=0)
    return farthest, np.sqrt(squares[farthest, np.arange(len(farthest))])


class _Search:
    """The active points of each set with their weights.

    active: (sets, dimensions + 2) indices of points; weights: likewise, 0 in the places that are not taken.
    """

    def __init__(self, points: DoubleArray, first: IndexArray, second: IndexArray):
        self.points = points
        places = points.shape[1] + 2
        sets = len(first)
        self.active = np.repeat(first[:, None], places, axis=1)
        self.active[:, 1] = second
        self.taken = np.zeros((sets, places), bool)
        self.taken[:, :2] = True
        self.taken[:, 1] = first != second
        self.weights = np.zeros((sets, places))
        self.weights[:, :2] = 0.5
        self.weights[~self.taken[:, 1], :2] = 1.0, 0.0
        self.negligible = 1e-14 * np.abs(points).max(axis=(0, 1), initial=0.0)
        self.centers, self.radii = self._ball(self._corners())

    def keep(self, kept: BoolArray) -> None:
        """Go on with some of the sets."""
        self.points = self.points[:, :, kept]
        for name in ("active", "taken", "weights", "radii", "negligible"):
            setattr(self, name, getattr(self, name)[kept])
        self.centers = self.centers[:, kept]

    def take_up(self, farthest: IndexArray) -> None:
        """Make one more point of each set active, and find the weights of the smallest ball around the active ones."""
        everywhere = np.arange(len(farthest))
        free = self.taken.argmin(axis=1)
        self.active[everywhere, free] = farthest
        self.taken[everywhere, free] = True
        corners = self._corners()
        wrong = everywhere
        for _ in range(2 * self.taken.shape[1]):
            # 6. Weights of the ball that all active points lie on.
            best = self._best_weights(corners[wrong], self.taken[wrong])
            # 7. to 9. Go towards them until a weight becomes 0.
            now = self.weights[wrong]
            falls = self.taken[wrong] & (best <= 0.0)
            with np.errstate(divide="ignore", invalid="ignore"):
                reach = np.where(falls, now / (now - best), np.inf)
            reach[np.isnan(reach)] = 0.0
            step = np.minimum(reach.min(axis=1), 1.0)
            now = now + step[:, None] * (best - now)
            # 10. and 11. Drop the points whose weight is 0.
            dropped = falls & (reach <= step[:, None])
            now[dropped] = 0.0
            self.weights[wrong] = now
            self.taken[wrong] &= ~dropped
            wrong = wrong[dropped.any(axis=1)]
            if not wrong.size:
                break
        self.centers, self.radii = self._ball(corners)

    def _corners(self) -> DoubleArray:
        """Return the active points relative to the first of each set, (sets, places, dimensions)."""
        everywhere = np.arange(len(self.active))
        return np.asarray(self.points[self.active, :, everywhere[:, None]])

    def _best_weights(self, corners: DoubleArray, taken: BoolArray) -> DoubleArray:
        """Return the weights for which all taken points are as far from the centre, (sets, places)."""
        sets, places, _ = corners.shape
        middle = (corners * taken[:, :, None]).sum(axis=1) / taken.sum(axis=1)[:, None]
        away = np.where(taken[:, :, None], corners - middle[:, None], 0.0)
        squares = (away * away).sum(axis=2)
        scale = np.maximum(squares.max(axis=1), np.finfo(float).tiny)
        # 2 P P^T w + m = |p|^2 for the taken points, w = 0 for the others, sum w = 1
        matrix = np.zeros((sets, places + 1, places + 1))
        matrix[:, :places, :places] = 2.0 * away @ away.swapaxes(1, 2) / scale[:, None, None]
        diagonal = np.arange(places)
        matrix[:, diagonal, diagonal] += np.where(taken, RIDGE, 1.0)
        matrix[:, :places, places] = matrix[:, places, :places] = taken
        right = np.concatenate([squares / scale[:, None], np.ones((sets, 1))], axis=1)
        return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :places, 0])

    def _ball(self, corners: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        centers = np.einsum("sp,spd->sd", self.weights, corners)
        squares = np.square(corners - centers[:, None]).sum(axis=2)
        return centers.T, np.sqrt((self.weights * squares).sum(axis=1))


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
