"""The limit load: the tangential load at which the whole contact slips.

By the kinematic theorem of limit analysis some |q| <= b, with b the friction limit, can carry the imposed loads F if
and only if no rigid motion v of the forced modes has F.v > sum b |v(x, y)| dA. The load factor is the least value of
that sum over all v with F.v = 1 (T12 of docs/theory.md).
"""

from __future__ import annotations

import numpy as np

from fretsolve.elastic.rounding import circle_width
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.rigid_modes import TangentialModes, solve_modes
from fretsolve.system.arrays import FloatArray, Vector

ITERATIONS = 100
AT_THE_LIMIT = 1e-9
"""Relative distance from the limit load that counts as gross slip: at the limit the displacement is unbounded."""


def at_the_limit(precision: type[np.floating]) -> float:
    """Return the same for tractions stored in `precision`, which resolve the friction limit no better than that."""
    return max(AT_THE_LIMIT, circle_width(precision))


def load_factor(friction_limit: FloatArray, control: LoadControl, modes: TangentialModes) -> float:
    """Return the factor on the forced tangential loads at which everything slips; inf where none is imposed.

    friction_limit: (nx, ny), MPa. Without a torque to balance the factor is exact; else it is found by iteratively
    reweighted least squares, all of whose iterates are upper bounds.
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
    return _least_dissipation(friction_limit * modes.cell_area, load / size, forced, modes) / size


def _carried_by_a_cell(friction_limit: FloatArray, load: Vector, forced: list[int], modes: TangentialModes) -> bool:
    """Return whether some force on the only cell in contact has the imposed loads. It has not where it would have to
    carry a torque about itself, or where there is no contact."""
    if not friction_limit.any():
        return False
    i, j = np.unravel_index(int(friction_limit.argmax()), friction_limit.shape)
    arm = max(abs(float(modes.x[i])), abs(float(modes.y[j])), float(np.sqrt(modes.cell_area)))
    resultants = np.array([[1.0, 0.0], [0.0, 1.0], [-modes.y[j] / arm, modes.x[i] / arm]])[forced]
    imposed = (load / np.array([1.0, 1.0, arm]))[forced]
    force = np.linalg.lstsq(resultants, imposed, rcond=None)[0]
    return bool(np.abs(resultants @ force - imposed).max() <= 1e-9 * np.abs(imposed).max())


def _least_dissipation(weight: FloatArray, load: Vector, forced: list[int], modes: TangentialModes) -> float:
    """Return the least of sum weight |v| over the rigid motions v with load.v = 1."""
    speed, reweighted = np.ones_like(weight), np.empty_like(weight)
    motion = np.empty((2, *weight.shape))
    best = np.inf
    for _ in range(ITERATIONS):
        # least squares with the weights b / |v| of the last motion
        np.divide(weight, speed, out=reweighted)
        direction = solve_modes(modes.gram(reweighted), load, forced)
        direction /= direction @ load
        # what that motion dissipates: an upper bound, which must fall
        modes.displacement(direction, motion)
        np.hypot(motion[0], motion[1], out=speed)
        dissipation = float(np.vdot(weight, speed))
        if dissipation > best * (1.0 - 1e-12):
            break
        best = dissipation
        np.maximum(speed, 1e-9 * float(speed.max()), out=speed)
    return best
