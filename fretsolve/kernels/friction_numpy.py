"""Kernels of the slip law in NumPy. TG1 to TG8 are the steps of the tangential problem in docs/theory.md.

Vectors are (2, nx, ny), planes (nx, ny); `x` (nx,) and `y` (ny,) are the cells' centres. A rigid motion of amplitudes
(a, b, c) is (a - c y, b + c x). `normal` is n = q/|q| in the slip zone and 0 elsewhere; the tangential part T v of a
vector is that across n. `weight` is positive in the contact and 0 elsewhere. `limit` is the friction limit mu p.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.system.arrays import BoolArray, FloatArray, Products, Sums, vector_lengths


def take_slip(
    slip: FloatArray,
    elastic_slip: FloatArray,
    rigid: FloatArray,
    x: FloatArray,
    y: FloatArray,
    normal: FloatArray,
    weight: FloatArray,
) -> tuple[Sums, Products]:
    """Compute ``slip = elastic_slip + rigid motion`` in the contact (TG2).

    Return the weighted sums of T slip times each of the rigid motions, and `gram`.
    """
    np.copyto(slip, elastic_slip)
    _add_motion(slip, rigid, x, y)
    slip *= weight > 0.0
    tangential = _tangential(slip, normal)
    tangential *= weight
    return sum_motions(tangential, x, y), gram(weight, normal, x, y)


def move(
    slip: FloatArray,
    rigid: FloatArray,
    x: FloatArray,
    y: FloatArray,
    normal: FloatArray,
    limit: FloatArray,
    slipping: BoolArray,
    stiffness: FloatArray,
    weight: FloatArray,
    unit: float,
    stiffest: float,
) -> tuple[float, float, float]:
    """Add a rigid motion to the slip in the contact; let cells stick that slip against their shear (TG3).

    ``stiffness = min(slip along n / limit / unit, stiffest)``, 0 where a cell sticks; ``weight = 1/(1 + stiffness)``.
    Return `violation`, which spares a call.
    """
    contact = weight > 0.0
    motion = np.zeros_like(slip)
    _add_motion(motion, rigid, x, y)
    motion *= contact
    slip += motion
    forward = slip[0] * normal[0] + slip[1] * normal[1]
    slipping &= forward > 0.0
    normal *= slipping
    forward *= slipping
    np.divide(forward, limit, out=forward, where=slipping)
    forward /= unit
    np.minimum(forward, stiffest, out=forward)
    stiffness[:] = forward
    forward += 1.0
    weight[:] = 0.0
    np.divide(1.0, forward, out=weight, where=contact, casting="same_kind")
    return violation(slip, normal, slipping)


def gram(weight: FloatArray, normal: FloatArray, x: FloatArray, y: FloatArray) -> Products:
    """Return the weighted sums of products of the tangential parts of the rigid motions, 3 x 3 (TG2)."""
    across_x, across_y = x[:, None], y[None, :]
    along = normal[1] * across_x - normal[0] * across_y
    w_x, w_y = weight * normal[0], weight * normal[1]
    total = weight.sum(dtype=np.float64)
    xx, yy, xy = total - (w_x * normal[0]).sum(), total - (w_y * normal[1]).sum(), -(w_x * normal[1]).sum()
    xt, yt = -(weight * across_y + w_x * along).sum(), (weight * across_x - w_y * along).sum()
    tt = (weight * (across_x**2 + across_y**2 - along**2)).sum()
    xx, yy, xy, xt, yt, tt = map(float, (xx, yy, xy, xt, yt, tt))
    return (xx, xy, xt), (xy, yy, yt), (xt, yt, tt)


def balance(
    shear: FloatArray, weight: FloatArray, normal: FloatArray, x: FloatArray, y: FloatArray
) -> tuple[Sums, Products]:
    """Return the sums of the shear times each of the rigid motions, and `gram` (TG7)."""
    return sum_motions(shear, x, y), gram(weight, normal, x, y)


def add_motion(
    shear: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray, weight: FloatArray, normal: FloatArray
) -> None:
    """Add the weighted tangential part of a rigid motion to the shear (TG7)."""
    motion = np.zeros_like(shear)
    _add_motion(motion, rigid, x, y)
    shear += weight * _tangential(motion, normal)


def sum_motions(field: FloatArray, x: FloatArray, y: FloatArray) -> Sums:
    """Return the sums of the field times each of the rigid motions."""
    along_y, along_x = field[0].sum(axis=0, dtype=np.float64), field[1].sum(axis=1, dtype=np.float64)
    return float(along_y.sum()), float(along_x.sum()), float(along_x @ x - along_y @ y)


def violation(slip: FloatArray, normal: FloatArray, slipping: BoolArray) -> tuple[float, float, float]:
    """Return the largest slip, the largest tangential part in the slip zone, and the largest slip outside."""
    tangential = _tangential(slip, normal)
    squared = np.einsum("kij,kij->ij", tangential, tangential)
    in_slip = float(np.max(squared, where=slipping, initial=0.0))
    in_stick = float(np.max(squared, where=~slipping, initial=0.0))
    largest = float(np.einsum("kij,kij->ij", slip, slip).max())
    return math.sqrt(largest), math.sqrt(in_slip), math.sqrt(in_stick)


def scale_tangential(slip: FloatArray, normal: FloatArray, factor: float, result: FloatArray) -> None:
    """Compute ``result = factor T slip``, in the precision of `result` (TG5)."""
    np.multiply(_tangential(slip, normal), factor, out=result, casting="same_kind")


def return_to_circle(
    shear: FloatArray, limit: FloatArray, contact: BoolArray, slipping: BoolArray, normal: FloatArray
) -> None:
    """Let cells slip whose shear is beyond the limit; scale slipping shear to it, and set n (TG6)."""
    length = vector_lengths(shear)
    slipping |= length > limit
    slipping &= contact
    np.divide(1.0, length, out=length, where=length > 0.0)
    np.multiply(shear, length, out=normal)
    normal *= slipping
    for part, direction in zip(shear, normal, strict=True):
        np.multiply(direction, limit, out=part, where=slipping)


def excess(shear: FloatArray, limit: FloatArray) -> float:
    """Return the largest length of the shear beyond the limit, negative if it is below everywhere."""
    return float((vector_lengths(shear) - limit).max())


def _add_motion(field: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray) -> None:
    """Add a rigid motion to the field."""
    field[0] += rigid[0] - rigid[2] * y[None, :]
    field[1] += rigid[1] + rigid[2] * x[:, None]


def _tangential(field: FloatArray, normal: FloatArray) -> FloatArray:
    """Return T field, the part across `normal`."""
    along = field[0] * normal[0] + field[1] * normal[1]
    result: FloatArray = field - along * normal
    return result
