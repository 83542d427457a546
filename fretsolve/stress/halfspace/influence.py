"""Influence coefficients of stress: the components at a point of a body from uniform tractions on one cell.

Source: Johnson, Contact Mechanics (1985), sections 3.1 to 3.4. In a body's own frame z >= 0 points into the body, and
the tractions (p, qx, qy) act on it along +z, +x, +y. Stress is positive in tension, so that zz = -p, xz = -qx, yz = -qy
at z = 0. Times 2 pi, with the derivatives of `fretsolve.stress.halfspace.potentials`:

          from p                                from qx
    xx    2 nu Vz - (1 - 2 nu) Lxx - z Vxx      2 Vx - 2 nu L1xyy - z Lxxx
    yy    2 nu Vz - (1 - 2 nu) Lyy - z Vyy      2 nu (Vx + L1xyy) - z Lxyy
    zz    Vz + z (Vxx + Vyy)                    -z Vxz
    xy    -(1 - 2 nu) Lxy - z Vxy               Vy + 2 nu L1xxy - z Lxxy
    xz    -z Vxz                                Vz - z Vxx
    yz    -z Vyz                                -z Vxy

with Lyy = -Lxx - Vz and Lxxx = -Lxyy - Vxz. Those from qy follow by exchanging x and y.

Below a strip that is endless along y, in plane strain, times pi, with the functions of `strip` there:

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
from collections.abc import Mapping
from typing import Literal

from fretsolve.stress.halfspace.potentials import Potential, Strip

Component = Literal["xx", "yy", "zz", "xy", "xz", "yz"]
Traction = Literal["p", "qx", "qy"]
Body = Literal[1, 2]

COMPONENTS: tuple[Component, ...] = ("xx", "yy", "zz", "xy", "xz", "yz")
TRACTIONS: tuple[Traction, ...] = ("p", "qx", "qy")

Terms = Mapping[Potential | Strip, float]
"""Derivatives of the potentials, or functions of a strip, with their factors; those with a factor of 0 are left out."""


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
    """Return the terms of a strip, times pi."""
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
