"""Kernels of the slip law over the rows `first` to `stop`, compiled by numba, as those in `friction_numpy`."""

from __future__ import annotations

import math

import numpy as np

from fretsolve.kernels.numba_options import inlined, kernel, larger, largest_of


@inlined
def gram(first, stop, weight, normal, x, y):
    """Return the weighted sums of products of the tangential parts of the rigid motions, 3 x 3 (TG2)."""
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


@inlined
def sum_motions(first, stop, field, x, y):
    """Return the sums of the field times each of the rigid motions."""
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


@inlined
def violation(first, stop, slip, normal, slipping):
    """Return the largest slip, the largest tangential part in the slip zone, and the largest slip outside."""
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


@kernel
def take_slip(first, stop, slip, elastic_slip, rigid, x, y, normal, weight):
    """Compute ``slip = elastic_slip + rigid motion`` in the contact (TG2)."""
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
    return (all_x, all_y, all_turned), gram(first, stop, weight, normal, x, y)


@kernel
def move(first, stop, slip, rigid, x, y, normal, limit, slipping, stiffness, weight, unit, stiffest):
    """Add a rigid motion to the slip in the contact; let cells stick that slip against their shear (TG3).

    Return `violation`.
    """
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
    return violation(first, stop, slip, normal, slipping)


@kernel
def balance(first, stop, shear, weight, normal, x, y):
    """Return the sums of the shear times each of the rigid motions, and `gram` (TG7)."""
    return sum_motions(first, stop, shear, x, y), gram(first, stop, weight, normal, x, y)


@kernel
def add_motion(first, stop, shear, rigid, x, y, weight, normal):
    """Add the weighted tangential part of a rigid motion to the shear (TG7)."""
    _, ny = weight.shape
    for i in range(first, stop):
        for j in range(ny):
            w, n_x, n_y = weight[i, j], normal[0, i, j], normal[1, i, j]
            m_x, m_y = rigid[0] - rigid[2] * y[j], rigid[1] + rigid[2] * x[i]
            along = m_x * n_x + m_y * n_y
            shear[0, i, j] += w * (m_x - along * n_x)
            shear[1, i, j] += w * (m_y - along * n_y)


@kernel
def scale_tangential(first, stop, slip, normal, factor, result):
    """Compute ``result = factor T slip``, in the precision of `result` (TG5)."""
    _, _, ny = slip.shape
    for i in range(first, stop):
        for j in range(ny):
            s_x, s_y, n_x, n_y = slip[0, i, j], slip[1, i, j], normal[0, i, j], normal[1, i, j]
            along = s_x * n_x + s_y * n_y
            result[0, i, j] = factor * (s_x - along * n_x)
            result[1, i, j] = factor * (s_y - along * n_y)


@kernel
def return_to_circle(first, stop, shear, limit, contact, slipping, normal):
    """Let cells slip whose shear is beyond the limit; scale slipping shear to it, and set n (TG6)."""
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


@kernel
def excess(first, stop, shear, limit):
    """Return the largest length of the shear beyond the limit, negative if it is below everywhere."""
    _, ny = limit.shape
    largest = np.full(ny, -math.inf)
    for i in range(first, stop):
        for j in range(ny):
            q_x, q_y = shear[0, i, j], shear[1, i, j]
            largest[j] = larger(math.sqrt(q_x * q_x + q_y * q_y) - limit[i, j], largest[j])
    return float(largest_of(largest))
