"""Kernels of the slip law. TG1 to TG8 are the steps of the tangential problem in docs/theory.md.

Vectors are (2, nx, ny), planes (nx, ny); `x` (nx,) and `y` (ny,) are the cells' centres. A rigid motion of amplitudes
(a, b, c) is (a - c y, b + c x). `normal` is n = q/|q| in the slip zone and 0 elsewhere; the tangential part T v of a
vector is the part across n. `weight` is positive in the contact and 0 elsewhere. `limit` is the friction limit mu p.
Loops are over the rows `first` to `stop`.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.elastic.kernels.compiling import compiled, inlined, larger, largest_of
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


@compiled
def take_slip_loops(first, stop, slip, elastic_slip, rigid, x, y, normal, weight):
    _, ny = weight.shape
    all_x, all_y, all_turned = 0.0, 0.0, 0.0
    for i in range(first, stop):
        sum_x, sum_y, turned = 0.0, 0.0, 0.0
        for j in range(ny):
            w = weight[i, j]
            inside = 1.0 if w > 0.0 else 0.0
            s_x = inside * (rigid[0] - rigid[2] * y[j] + elastic_slip[0, i, j])
            s_y = inside * (rigid[1] + rigid[2] * x[i] + elastic_slip[1, i, j])
            slip[0, i, j], slip[1, i, j] = s_x, s_y
            n_x, n_y = normal[0, i, j], normal[1, i, j]
            along = s_x * n_x + s_y * n_y
            t_x, t_y = w * (s_x - along * n_x), w * (s_y - along * n_y)
            sum_x += t_x
            sum_y += t_y
            turned -= y[j] * t_x
        all_x += sum_x
        all_y += sum_y
        all_turned += turned + x[i] * sum_y
    return (all_x, all_y, all_turned), gram_loops(first, stop, weight, normal, x, y)


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


@compiled
def move_loops(first, stop, slip, rigid, x, y, normal, limit, slipping, stiffness, weight, unit, stiffest):
    _, ny = weight.shape
    along_x, along_y, turn = rigid[0], rigid[1], rigid[2]
    for i in range(first, stop):
        across = along_y + turn * x[i]
        for j in range(ny):  # without branches, so that vector instructions do it
            touches = weight[i, j] > 0.0
            s_x = slip[0, i, j] + (along_x - turn * y[j] if touches else 0.0)
            s_y = slip[1, i, j] + (across if touches else 0.0)
            slip[0, i, j], slip[1, i, j] = s_x, s_y
            n_x, n_y = normal[0, i, j], normal[1, i, j]
            forward = s_x * n_x + s_y * n_y
            slips = touches & slipping[i, j] & (forward > 0.0)
            resistance = forward / limit[i, j] / unit
            resistance = resistance if resistance < stiffest else stiffest
            resistance = resistance if slips else 0.0
            share = 1.0 / (1.0 + resistance)
            slipping[i, j] = slips
            normal[0, i, j], normal[1, i, j] = n_x if slips else 0.0, n_y if slips else 0.0
            stiffness[i, j] = resistance
            weight[i, j] = share if touches else 0.0
    return violation_loops(first, stop, slip, normal, slipping)


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


@inlined
def gram_loops(first, stop, weight, normal, x, y):
    _, ny = weight.shape
    all_xx, all_yy, all_xy, all_xt, all_yt, all_tt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(first, stop):
        xx, yy, xy, xt, yt, tt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(ny):
            w, n_x, n_y = float(weight[i, j]), normal[0, i, j], normal[1, i, j]
            along = n_y * x[i] - n_x * y[j]
            xx += w * (1.0 - n_x * n_x)
            yy += w * (1.0 - n_y * n_y)
            xy -= w * n_x * n_y
            xt -= w * (y[j] + n_x * along)
            yt += w * (x[i] - n_y * along)
            tt += w * (x[i] * x[i] + y[j] * y[j] - along * along)
        all_xx += xx
        all_yy += yy
        all_xy += xy
        all_xt += xt
        all_yt += yt
        all_tt += tt
    return (all_xx, all_xy, all_xt), (all_xy, all_yy, all_yt), (all_xt, all_yt, all_tt)


def balance(
    shear: FloatArray, weight: FloatArray, normal: FloatArray, x: FloatArray, y: FloatArray
) -> tuple[Sums, Products]:
    """Return the sums of the shear times each of the rigid motions, and `gram` (TG7)."""
    return sum_motions(shear, x, y), gram(weight, normal, x, y)


@compiled
def balance_loops(first, stop, shear, weight, normal, x, y):
    return sum_motions_loops(first, stop, shear, x, y), gram_loops(first, stop, weight, normal, x, y)


def add_motion(
    shear: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray, weight: FloatArray, normal: FloatArray
) -> None:
    """Add the weighted tangential part of a rigid motion to the shear (TG7)."""
    motion = np.zeros_like(shear)
    _add_motion(motion, rigid, x, y)
    shear += weight * _tangential(motion, normal)


@compiled
def add_motion_loops(first, stop, shear, rigid, x, y, weight, normal):
    _, ny = weight.shape
    for i in range(first, stop):
        for j in range(ny):
            w, n_x, n_y = weight[i, j], normal[0, i, j], normal[1, i, j]
            m_x, m_y = rigid[0] - rigid[2] * y[j], rigid[1] + rigid[2] * x[i]
            along = m_x * n_x + m_y * n_y
            shear[0, i, j] += w * (m_x - along * n_x)
            shear[1, i, j] += w * (m_y - along * n_y)


def sum_motions(field: FloatArray, x: FloatArray, y: FloatArray) -> Sums:
    """Return the sums of the field times each of the rigid motions."""
    along_y, along_x = field[0].sum(axis=0, dtype=np.float64), field[1].sum(axis=1, dtype=np.float64)
    return float(along_y.sum()), float(along_x.sum()), float(along_x @ x - along_y @ y)


@inlined
def sum_motions_loops(first, stop, field, x, y):
    _, _, ny = field.shape
    all_x, all_y, all_turned = 0.0, 0.0, 0.0
    for i in range(first, stop):
        sum_x, sum_y, turned = 0.0, 0.0, 0.0
        for j in range(ny):
            sum_x += field[0, i, j]
            sum_y += field[1, i, j]
            turned -= y[j] * field[0, i, j]
        all_x += sum_x
        all_y += sum_y
        all_turned += turned + x[i] * sum_y
    return all_x, all_y, all_turned


def violation(slip: FloatArray, normal: FloatArray, slipping: BoolArray) -> tuple[float, float, float]:
    """Return the largest slip, the largest tangential part in the slip zone, and the largest slip outside."""
    tangential = _tangential(slip, normal)
    squared = np.einsum("kij,kij->ij", tangential, tangential)
    in_slip = float(np.max(squared, where=slipping, initial=0.0))
    in_stick = float(np.max(squared, where=~slipping, initial=0.0))
    largest = float(np.einsum("kij,kij->ij", slip, slip).max())
    return math.sqrt(largest), math.sqrt(in_slip), math.sqrt(in_stick)


@inlined
def violation_loops(first, stop, slip, normal, slipping):
    _, ny = slipping.shape
    largest, in_slip, in_stick = np.zeros(ny), np.zeros(ny), np.zeros(ny)
    for i in range(first, stop):
        for j in range(ny):
            s_x, s_y, n_x, n_y = slip[0, i, j], slip[1, i, j], normal[0, i, j], normal[1, i, j]
            squared = s_x * s_x + s_y * s_y
            along = s_x * n_x + s_y * n_y
            t_x, t_y = s_x - along * n_x, s_y - along * n_y
            across = t_x * t_x + t_y * t_y
            slips = slipping[i, j]
            largest[j] = larger(squared, largest[j])
            in_slip[j] = larger(across if slips else 0.0, in_slip[j])
            in_stick[j] = larger(0.0 if slips else squared, in_stick[j])
    return math.sqrt(largest_of(largest)), math.sqrt(largest_of(in_slip)), math.sqrt(largest_of(in_stick))


def scale_tangential(slip: FloatArray, normal: FloatArray, factor: float, result: FloatArray) -> None:
    """Compute ``result = factor T slip``, in the precision of `result` (TG5)."""
    np.multiply(_tangential(slip, normal), factor, out=result, casting="same_kind")


@compiled
def scale_tangential_loops(first, stop, slip, normal, factor, result):
    _, _, ny = slip.shape
    for i in range(first, stop):
        for j in range(ny):
            s_x, s_y, n_x, n_y = slip[0, i, j], slip[1, i, j], normal[0, i, j], normal[1, i, j]
            along = s_x * n_x + s_y * n_y
            result[0, i, j] = factor * (s_x - along * n_x)
            result[1, i, j] = factor * (s_y - along * n_y)


def return_map(
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


@compiled
def return_map_loops(first, stop, shear, limit, contact, slipping, normal):
    _, ny = limit.shape
    for i in range(first, stop):
        for j in range(ny):
            q_x, q_y, most = shear[0, i, j], shear[1, i, j], limit[i, j]
            length = math.sqrt(q_x * q_x + q_y * q_y)  # faster than hypot
            slips = contact[i, j] & (slipping[i, j] | (length > most))
            inverse = 1.0 / length
            inverse = inverse if slips & (length > 0.0) else 0.0
            n_x, n_y = q_x * inverse, q_y * inverse
            slipping[i, j] = slips
            normal[0, i, j], normal[1, i, j] = n_x, n_y
            shear[0, i, j], shear[1, i, j] = n_x * most if slips else q_x, n_y * most if slips else q_y


def excess(shear: FloatArray, limit: FloatArray) -> float:
    """Return the largest length of the shear beyond the limit, negative if it is below everywhere."""
    return float((vector_lengths(shear) - limit).max())


@compiled
def excess_loops(first, stop, shear, limit):
    _, ny = limit.shape
    largest = np.full(ny, -math.inf)
    for i in range(first, stop):
        for j in range(ny):
            q_x, q_y = shear[0, i, j], shear[1, i, j]
            largest[j] = larger(math.sqrt(q_x * q_x + q_y * q_y) - limit[i, j], largest[j])
    return float(largest_of(largest))


def _add_motion(field: FloatArray, rigid: FloatArray, x: FloatArray, y: FloatArray) -> None:
    field[0] += rigid[0] - rigid[2] * y[None, :]
    field[1] += rigid[1] + rigid[2] * x[:, None]


def _tangential(field: FloatArray, normal: FloatArray) -> FloatArray:
    along = field[0] * normal[0] + field[1] * normal[1]
    result: FloatArray = field - along * normal
    return result
