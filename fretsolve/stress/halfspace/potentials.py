"""Derivatives of the potentials of a rectangle with a uniform density, from which all stresses below it follow.

Sources: Love (1929); Johnson, Contact Mechanics (1985), sections 3.1 to 3.4. With rho the distance from a point of the
rectangle, the potentials of unit density are the integrals

    V = int 1/rho,   L = int ln(rho + z),   L1 = int [z ln(rho + z) - rho],   V = L_z = L1_zz

and are harmonic. `Lxx` is the second derivative of L by x, and so on. Each is the sum of an antiderivative at the
rectangle's corners, with alternating signs. These differences lose digits far away: the relative error is about 1e-13
at 10 sides of the rectangle, 1e-11 at 100 and 1e-9 at 1000, where the values themselves are small.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, cast

import numpy as np

from fretsolve.system.arrays import DoubleArray

Potential = Literal["Vz", "Lxx", "Lxy", "Vx", "Vy", "Vxx", "Vyy", "Vxy", "Vxz", "Vyz", "L1xyy", "L1xxy", "Lxyy", "Lxxy"]

Strip = Literal["angle", "ratio", "share_x", "log_x"]
"""Functions of a strip without end along y, see `strip`."""

Corner = Callable[[DoubleArray, DoubleArray, DoubleArray, float], DoubleArray]
"""Antiderivative at a corner: of X, Y, its distance r and the depth z."""


def _log_sum(X: DoubleArray, Y: DoubleArray, r: DoubleArray, z: float) -> DoubleArray:
    """Return ln(Y + r), without cancellation where Y < 0."""
    far = np.log(np.abs(Y) + r)
    return np.where(Y >= 0.0, far, np.log(X * X + z * z) - far)


def _over_sum(X: DoubleArray, Y: DoubleArray, r: DoubleArray, z: float) -> DoubleArray:
    """Return 1/(r (r + Y)), without cancellation where Y < 0."""
    far = r + np.abs(Y)
    return np.where(Y >= 0.0, 1.0 / far, far / (X * X + z * z)) / r


_CORNERS: dict[Potential, Corner] = {
    "Vz": lambda X, Y, r, z: -np.arctan2(X * Y, z * r),
    # r - z = (X^2 + Y^2)/(r + z)
    "Lxx": lambda X, Y, r, z: np.arctan2(X * Y * (X * X + Y * Y) / (r + z), X * X * r + z * Y * Y),
    "Lxy": lambda X, Y, r, z: np.log(r + z),
    "Vx": _log_sum,
    "Vxx": lambda X, Y, r, z: X * _over_sum(X, Y, r, z),
    "Vxy": lambda X, Y, r, z: 1.0 / r,
    "Vxz": lambda X, Y, r, z: z * _over_sum(X, Y, r, z),
    "L1xyy": lambda X, Y, r, z: -Y / (r + z),
    "Lxyy": lambda X, Y, r, z: Y / (r * (r + z)),
}

_EXCHANGED: dict[Potential, Potential] = {"Vy": "Vx", "Vyy": "Vxx", "Vyz": "Vxz", "L1xxy": "L1xyy", "Lxxy": "Lxyy"}
"""Derivatives that are another one with x and y exchanged."""


def is_odd(name: Potential | Strip, axis: Literal["x", "y"]) -> bool:
    """Return whether a derivative is odd in x or in y; otherwise it is even."""
    return name.count(axis) % 2 == 1


def strip(name: Strip, x: DoubleArray, z: float, dx: float) -> DoubleArray:
    """Return a function of a uniformly loaded strip of width `dx`, endless along y, at offsets x: (nx, 1).

    With X = x +- dx/2 and r^2 = X^2 + z^2 these are the differences of atan2(X, z), X z/r^2, z^2/r^2 and ln r^2
    (Johnson 1985, section 2.5). Those whose name ends in x are odd. At z = 0 no offset may lie on an edge.
    """
    X = np.append(x - 0.5 * dx, x[-1] + 0.5 * dx)
    squared = X * X + z * z
    values = {
        "angle": lambda: np.arctan2(X, z),
        "ratio": lambda: X * z / squared,
        "share_x": lambda: z * z / squared,
        "log_x": lambda: np.log(squared),
    }[name]()
    differences: DoubleArray = np.diff(values)[:, None]
    return differences


def potential(name: Potential, x: DoubleArray, y: DoubleArray, z: float, dx: float, dy: float) -> DoubleArray:
    """Return a derivative of the potentials of a rectangle ``dx`` by ``dy`` at offsets x, y from its middle: (nx, ny).

    x (nx,), y (ny,): ascending, a side of the rectangle apart (mm); z: depth (mm), >= 0. At z = 0 no offset may lie on
    an edge of the rectangle, where some of the derivatives are infinite.
    """
    if name in _EXCHANGED:
        return np.ascontiguousarray(potential(_EXCHANGED[name], y, x, z, dy, dx).T)
    X = np.append(x - 0.5 * dx, x[-1] + 0.5 * dx)[:, None]
    Y = np.append(y - 0.5 * dy, y[-1] + 0.5 * dy)[None, :]
    r = np.sqrt(X * X + Y * Y + z * z)
    values: DoubleArray = np.diff(np.diff(_CORNERS[name](X, Y, r, z), axis=0), axis=1)
    return values


def cell_values(name: Potential | Strip, x: DoubleArray, y: DoubleArray, z: float, dx: float, dy: float) -> DoubleArray:
    """Return a derivative of the potentials or a function of a strip; the latter does not depend on y."""
    if name in ("angle", "ratio", "share_x", "log_x"):
        return strip(name, x, z, dx)
    return potential(cast(Potential, name), x, y, z, dx, dy)
