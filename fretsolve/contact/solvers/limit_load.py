"""The limit load: the tangential load at which the whole contact slips.

Friction can carry the imposed loads F if and only if F.v <= sum b |v(x, y)| dA for every rigid motion v, where b is the
friction limit (T12 of docs/theory.md). So the load factor is the least value of that sum over all v with F.v = 1.
"""

from __future__ import annotations

import math

import numpy as np

from fretsolve.contact.solvers.rigid_modes import TangentialModes, inverse_of, solve_modes
from fretsolve.elastic.rounding import circle_width
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import FloatArray, Vector

AT_THE_LIMIT = 1e-9
"""Relative distance from the limit load that counts as gross slip: at the limit the displacement is unbounded."""


def at_the_limit(precision: type[np.floating]) -> float:
    """Return `AT_THE_LIMIT`, or more where tractions stored in `precision` resolve the friction limit less well."""
    return max(AT_THE_LIMIT, circle_width(precision))


def load_factor(
    friction_limit: FloatArray, control: LoadControl, modes: TangentialModes, enough: float = math.inf
) -> float:
    """Return the factor on the imposed tangential loads at which all cells slip; inf if no load is imposed.

    friction_limit: (nx, ny), MPa. If Mz is not imposed the factor is exact; else it is found by iteratively reweighted
    least squares, and is never too small. It is no longer improved once it is surely above `enough`.
    """
    load = control.imposed_resultant
    if not load.any():
        return np.inf
    capacity = float(friction_limit.sum(dtype=np.float64)) * modes.cell_area
    if not control.forced[2]:
        return capacity / float(np.hypot(load[0], load[1]))
    forced = control.forced_index
    if np.count_nonzero(friction_limit) < 2 and not _carried_by_a_cell(friction_limit, load, forced, modes):
        return 0.0
    size = float(np.abs(load).max())
    return _least_dissipation(friction_limit * modes.cell_area, load / size, forced, modes, enough * size) / size


def _carried_by_a_cell(friction_limit: FloatArray, load: Vector, forced: list[int], modes: TangentialModes) -> bool:
    """Return whether a force on the only cell in contact balances the loads. It has no torque about the cell."""
    if not friction_limit.any():
        return False
    i, j = np.unravel_index(int(friction_limit.argmax()), friction_limit.shape)
    arm = max(abs(float(modes.x[i])), abs(float(modes.y[j])), float(np.sqrt(modes.cell_area)))
    resultants = np.array([[1.0, 0.0], [0.0, 1.0], [-modes.y[j] / arm, modes.x[i] / arm]])[forced]
    imposed = (load / np.array([1.0, 1.0, arm]))[forced]
    force = np.linalg.lstsq(resultants, imposed, rcond=None)[0]
    return bool(np.abs(resultants @ force - imposed).max() <= 1e-9 * np.abs(imposed).max())


def _least_dissipation(
    weight: FloatArray, load: Vector, forced: list[int], modes: TangentialModes, enough: float
) -> float:
    """Return the least of sum weight |v| over the rigid motions v with load.v = 1 (T12), or one of these sums once the
    least is surely above `enough`.
    """
    last, speed, reweighted = np.ones_like(weight), np.empty_like(weight), np.empty_like(weight)
    motion = np.empty((2, *weight.shape))
    best = np.inf
    for _ in range(100):
        # least squares with the weights b / |v| of the last motion
        np.divide(weight, last, out=reweighted)
        gram = modes.gram(reweighted)
        direction = solve_modes(gram, load, forced)
        carried = 1.0 / (direction @ load)
        direction *= carried
        # the energy that this motion dissipates: an upper bound of the least, which must fall
        modes.displacement(direction, motion)
        np.hypot(motion[0], motion[1], out=speed)
        dissipation = float(np.vdot(weight, speed))
        if dissipation > best * (1.0 - 1e-12):
            break
        best = dissipation
        # the shear traction of the least squares carries the loads `carried` times; over its largest part of the
        # friction limit, |v| over that before, this is a lower bound
        part = np.divide(speed, last, out=motion[0])
        part *= weight > 0.0
        if carried > enough * part.max() and inverse_of(gram, forced) is not None:
            break
        np.maximum(speed, 1e-9 * float(speed.max()), out=last)
    return best
