"""Influence coefficients of stress: the components at a point of a body from uniform tractions on one cell.

Sources: Love (1929); Johnson, Contact Mechanics (1985), sections 3.1 to 3.4. In a body's own frame z >= 0 points into
the body, and the tractions (p, qx, qy) act on it along +z, +x, +y. Stress is positive in tension, so that zz = -p,
xz = -qx, yz = -qy at z = 0. With rho the distance from a point of the rectangle, the potentials of unit density are

    V = int 1/rho,   L = int ln(rho + z),   L1 = int [z ln(rho + z) - rho],   V = L_z = L1_zz

and are harmonic. `Lxx` is the second derivative of L by x, and so on. Times 2 pi the stresses are

          from p                                from qx
    xx    2 nu Vz - (1 - 2 nu) Lxx - z Vxx      2 Vx - 2 nu L1xyy - z Lxxx
    yy    2 nu Vz - (1 - 2 nu) Lyy - z Vyy      2 nu (Vx + L1xyy) - z Lxyy
    zz    Vz + z (Vxx + Vyy)                    -z Vxz
    xy    -(1 - 2 nu) Lxy - z Vxy               Vy + 2 nu L1xxy - z Lxxy
    xz    -z Vxz                                Vz - z Vxx
    yz    -z Vyz                                -z Vxy

with Lyy = -Lxx - Vz and Lxxx = -Lxyy - Vxz. Stresses from qy follow by exchanging x and y. Each derivative is the sum
of an antiderivative at the rectangle's corners, with alternating signs. These differences lose digits far away: the
relative error is about 1e-13 at 10 sides of the rectangle, 1e-11 at 100 and 1e-9 at 1000, where the values are small.

Below a strip that is endless along y, in plane strain, the stresses times pi are, with the functions of `strip`:

          from p             from qx            from qy
    xx    -(angle - ratio)   -(log + share)
    yy    nu (xx + zz)       nu (xx + zz)
    zz    -(angle + ratio)   share
    xy                                          -log/2
    xz    share              -(angle - ratio)
    yz                                          -angle

Body 2 is in this frame. Body 1 has z < 0; the shear acts on it the other way, and so do its xz and yz in the frame of
body 2, in which all results are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import DoubleArray

Potential = Literal["Vz", "Lxx", "Lxy", "Vx", "Vy", "Vxx", "Vyy", "Vxy", "Vxz", "Vyz", "L1xyy", "L1xxy", "Lxyy", "Lxxy"]

Strip = Literal["angle", "ratio", "share_x", "log_x"]
"""Functions of a strip without end along y, see `strip`."""

Depth = float | DoubleArray

Corner = Callable[[DoubleArray, DoubleArray, DoubleArray, Depth], DoubleArray]
"""Antiderivative at a corner: of X, Y, its distance r and the depth z."""


def _log_sum(X: DoubleArray, Y: DoubleArray, r: DoubleArray, z: Depth) -> DoubleArray:
    """Return ln(Y + r), without cancellation where Y < 0."""
    far = np.log(np.abs(Y) + r)
    return np.where(Y >= 0.0, far, np.log(X * X + z * z) - far)


def _over_sum(X: DoubleArray, Y: DoubleArray, r: DoubleArray, z: Depth) -> DoubleArray:
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
    differences: DoubleArray = np.diff(strip_edge(name, X, z))[:, None]
    return differences


def strip_edge(name: Strip, X: DoubleArray, z: Depth) -> DoubleArray:
    """Return the value of a function of a strip that one of its edges gives, at the offsets X from the edge."""
    if name == "angle":
        return np.asarray(np.arctan2(X, z))
    squared = X * X + z * z
    if name == "log_x":
        return np.asarray(np.log(squared))
    return np.asarray((X if name == "ratio" else z) * z / squared)


def corner(name: Potential, X: DoubleArray, Y: DoubleArray, r: DoubleArray, z: Depth) -> DoubleArray:
    """Return the antiderivative of a derivative at offsets X, Y from a corner, with the distance r from it."""
    if name in _EXCHANGED:
        return _CORNERS[_EXCHANGED[name]](Y, X, r, z)
    return _CORNERS[name](X, Y, r, z)


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


Component = Literal["xx", "yy", "zz", "xy", "xz", "yz"]
Traction = Literal["p", "qx", "qy"]
Body = Literal[1, 2]

COMPONENTS: tuple[Component, ...] = ("xx", "yy", "zz", "xy", "xz", "yz")
TRACTIONS: tuple[Traction, ...] = ("p", "qx", "qy")

Terms = Mapping[Potential | Strip, float]
"""Derivatives of the potentials, or functions of a strip, with their factors; terms with a factor of 0 are left out."""


def stress_terms(
    component: Component, traction: Traction, depth: float, nu: float, body: Body = 2, *, plane_strain: bool = False
) -> Terms:
    """Return the terms of a stress component (MPa) at `depth` (mm) in a body from a unit traction (1 MPa).

    plane_strain: on a strip instead of a rectangle.
    """
    if plane_strain:
        terms = {name: 2.0 * factor for name, factor in _from_strip(component, traction, nu).items()}
    elif traction == "qy":
        mirrored = {"xx": "yy", "yy": "xx", "xz": "yz", "yz": "xz"}
        terms = _from_qx(mirrored.get(component, component), depth, nu)
        terms = _without_dependent({_exchanged(name): factor for name, factor in terms.items()})
    else:
        terms = _without_dependent((_from_p if traction == "p" else _from_qx)(component, depth, nu))
    mirrored_part = body == 1 and (traction == "p") == (component in ("xz", "yz"))
    sign = -1.0 if mirrored_part else 1.0
    return {name: sign * factor / (2.0 * math.pi) for name, factor in terms.items() if factor}  # type: ignore[misc]


def _from_strip(component: str, traction: str, nu: float) -> dict[str, float]:
    if traction == "qy":
        return {"xy": {"log_x": -0.5}, "yz": {"angle": -1.0}}.get(component, {})
    if traction == "p":
        found = {"xx": {"angle": -1.0, "ratio": 1.0}, "zz": {"angle": -1.0, "ratio": -1.0}, "xz": {"share_x": 1.0}}
        return (found | {"yy": {"angle": -2.0 * nu}}).get(component, {})
    found = {"xx": {"log_x": -1.0, "share_x": -1.0}, "zz": {"share_x": 1.0}, "xz": {"angle": -1.0, "ratio": 1.0}}
    return (found | {"yy": {"log_x": -nu}}).get(component, {})


def _from_p(component: str, z: float, nu: float) -> dict[str, float]:
    elastic = 1.0 - 2.0 * nu
    return {
        "xx": {"Vz": 2.0 * nu, "Lxx": -elastic, "Vxx": -z},
        "yy": {"Vz": 2.0 * nu, "Lyy": -elastic, "Vyy": -z},
        "zz": {"Vz": 1.0, "Vxx": z, "Vyy": z},
        "xy": {"Lxy": -elastic, "Vxy": -z},
        "xz": {"Vxz": -z},
        "yz": {"Vyz": -z},
    }[component]


def _from_qx(component: str, z: float, nu: float) -> dict[str, float]:
    return {
        "xx": {"Vx": 2.0, "L1xyy": -2.0 * nu, "Lxxx": -z},
        "yy": {"Vx": 2.0 * nu, "L1xyy": 2.0 * nu, "Lxyy": -z},
        "zz": {"Vxz": -z},
        "xy": {"Vy": 1.0, "L1xxy": 2.0 * nu, "Lxxy": -z},
        "xz": {"Vz": 1.0, "Vxx": -z},
        "yz": {"Vxy": -z},
    }[component]


def _exchanged(name: str) -> str:
    """Return a derivative with x and y exchanged; indices are in the order x, y, z."""
    base = name.rstrip("xyz")
    indices = name[len(base) :].translate(str.maketrans("xy", "yx"))
    return base + "".join(sorted(indices))


def _without_dependent(terms: Mapping[str, float]) -> dict[str, float]:
    """Replace the derivatives that follow from others, since the potentials are harmonic."""
    dependent = {"Lyy": ("Lxx", "Vz"), "Lxxx": ("Lxyy", "Vxz"), "Lyyy": ("Lxxy", "Vyz")}
    found: dict[str, float] = {}
    for name, factor in terms.items():
        for other, sign in ((one, -1.0) for one in dependent[name]) if name in dependent else ((name, 1.0),):
            found[other] = found.get(other, 0.0) + sign * factor
    return found


@dataclass(frozen=True, eq=False)
class PointInfluence:
    """Coefficients of the six components at a point from each cell, ``(6, tractions, nx, ny)``."""

    values: DoubleArray
    tractions: Sequence[Traction]

    def stress(self, tractions: Mapping[Traction, DoubleArray]) -> DoubleArray:
        """Return the six components (MPa) from tractions (nx, ny), ``(6,)``."""
        fields = np.stack([tractions[name] for name in self.tractions])
        total: DoubleArray = np.einsum("ctxy,txy->c", self.values, fields)
        return total


def point_influence(
    grid: Grid,
    point: tuple[float, float, float],
    nu: float,
    body: Body,
    tractions: Sequence[Traction] = TRACTIONS,
    *,
    plane_strain: bool = False,
) -> PointInfluence:
    """Return the coefficients at a point: x, y and depth (mm); at depth 0 it may not lie on the edge of a cell.

    plane_strain: cells are strips without end along y, in one row.
    """
    x, y, depth = point
    known: dict[Potential | Strip, DoubleArray] = {}

    def values(name: Potential | Strip) -> DoubleArray:
        if name not in known:
            # The offsets from the cells descend with their index.
            ascending = cell_values(name, (x - grid.x)[::-1], (y - grid.y)[::-1], depth, grid.dx, grid.dy)
            known[name] = ascending[::-1, ::-1]
        return known[name]

    found = np.zeros((len(COMPONENTS), len(tractions), *grid.shape))
    for row, component in enumerate(COMPONENTS):
        for column, traction in enumerate(tractions):
            for name, factor in stress_terms(component, traction, depth, nu, body, plane_strain=plane_strain).items():
                found[row, column] += factor * values(name)
    return PointInfluence(found, tuple(tractions))
