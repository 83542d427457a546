"""Planes through a point: their normals, and the stresses on them.

A plane is a row (6,) that gives a stress on it as its product with xx, yy, zz, xy, xz, yz.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.system.arrays import DoubleArray


def scan_normals(step: float) -> DoubleArray:
    """Return normals (planes, 3) that cover the half sphere z >= 0 about `step` degrees apart.

    Rings of equal inclination are `step` apart; on each of them the normals are as far apart as that.
    """
    rings = max(1, round(90.0 / step))
    normals = [np.array([[0.0, 0.0, 1.0]])]
    for ring in range(1, rings + 1):
        inclination = 0.5 * math.pi * ring / rings
        turn = math.pi if ring == rings else 2.0 * math.pi  # at the equator, opposite normals are the same plane
        count = max(1, round(math.sin(inclination) * turn / math.radians(step)))
        angle = turn * np.arange(count) / count
        sine, cosine = math.sin(inclination), math.cos(inclination)
        normals.append(np.stack([sine * np.cos(angle), sine * np.sin(angle), np.full(count, cosine)], axis=1))
    return np.concatenate(normals)


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
    maximises, one function after the other, each from the plane that the one before found; by default the parameter.
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
