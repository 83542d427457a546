"""What the bodies and their friction are as materials: compliances, strains under bulk stress, orthotropic friction.

Sources of the compliances: Johnson, Contact Mechanics (1985), chapters 3 and 5; Dundurs (1969). Moduli are in MPa.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.case.keys.body_specs import Body, ElasticBody
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import DoubleArray, FloatArray, Vector


@dataclass(frozen=True)
class Compliances:
    """Sums over both bodies (1/MPa), with G_i = E_i / 2(1 + nu_i) (T4 of docs/theory.md). A rigid body adds nothing.

    A: sum (1 - nu_i)/G_i; B: sum nu_i/G_i; C: (1 - 2 nu_1)/G_1 - (1 - 2 nu_2)/G_2, which couples the normal and the
    tangential problem and changes sign if the bodies are swapped. layer_shear, layer_normal: displacement per traction
    at its place alone (mm/MPa), of a layer between the bodies.
    """

    A: float
    B: float
    C: float
    layer_shear: float = 0.0
    layer_normal: float = 0.0

    def of_layer(self, influence: str) -> float:
        """Return the layer's displacement per traction (mm/MPa) of an influence by its name, such as `zz`."""
        return {"zz": self.layer_normal, "xx": self.layer_shear, "yy": self.layer_shear}.get(influence, 0.0)

    @property
    def contact_modulus(self) -> float:
        """E* (MPa), 1/E* = sum (1 - nu_i^2)/E_i; infinite for two rigid bodies."""
        return 2.0 / self.A if self.A else math.inf

    @property
    def dundurs_constant(self) -> float:
        """Dundurs' second constant beta = (C/2)/A, 0 for two rigid bodies; |beta| <= 1/2 unless nu_i < 0."""
        return 0.5 * self.C / self.A if self.A else 0.0

    @property
    def tangential(self) -> float:
        """Tangential compliance sum (2 - nu_i)/G_i (1/MPa) of Cattaneo and Mindlin."""
        return 2.0 * self.A + self.B

    @property
    def torsional(self) -> float:
        """Torsional compliance sum 1/G_i (1/MPa) of Lubkin."""
        return self.A + self.B


def compliances(body_1: Body | None, body_2: Body | None) -> Compliances:
    """Return the compliances of a pair; body 1 is loaded, body 2 is held; None leaves out what a body adds."""
    A = B = C = 0.0
    for body, sign in ((body_1, 1.0), (body_2, -1.0)):
        if body is not None and body != "rigid":
            nu = body.poisson_ratio
            shear_modulus = body.young_modulus / (2.0 * (1.0 + nu))
            A += (1.0 - nu) / shear_modulus
            B += nu / shear_modulus
            C += sign * (1.0 - 2.0 * nu) / shear_modulus
    return Compliances(A, B, C)


@dataclass(frozen=True)
class BulkResponse:
    """The strains of the two surfaces under bulk stress, a uniform in-plane stress; plane_strain: in line contact.

    What counts in a contact is the mismatch, the strain of body 2's surface less the strain of body 1's surface:

        e_xx = (sxx - nu syy)/E,   e_yy = (syy - nu sxx)/E,   e_xy = (1 + nu) sxy/E       in plane stress
        e_xx = (1 - nu^2) sxx/E                                                          in plane strain, syy = nu sxx

    A free surface is in plane stress; a line contact, where nothing moves along y, in plane strain.
    """

    bodies: tuple[Body, Body]
    plane_strain: bool = False

    def mismatch(self, stresses: Mapping[str, float]) -> Vector:
        """Return De_xx, De_yy, De_xy, (3,), under bulk stresses (MPa) by their names; stresses not named are 0."""
        first, second = (
            surface_strain(kind, [stresses.get(name, 0.0) for name in BULK[body]], self.plane_strain)
            for body, kind in enumerate(self.bodies, start=1)
        )
        return second - first

    def with_constraint(self, stresses: Mapping[str, float]) -> dict[str, float]:
        """Return bulk stresses (MPa) by their names; in plane strain yy is nu times xx."""
        found = dict(stresses)
        for body, kind in enumerate(self.bodies, start=1) if self.plane_strain else ():
            along, across, _ = BULK[body]
            if along in found and isinstance(kind, ElasticBody):
                found[across] = kind.poisson_ratio * found[along]
        return found


def surface_strain(body: Body, stress: list[float], plane_strain: bool = False) -> Vector:
    """Return e_xx, e_yy, e_xy, (3,), of a body's surface under the bulk stress xx, yy, xy (MPa)."""
    if not isinstance(body, ElasticBody):
        return np.zeros(3)
    (xx, yy, xy), modulus, nu = stress, body.young_modulus, body.poisson_ratio
    if plane_strain:
        return np.array([(1.0 - nu**2) * xx / modulus, 0.0, 0.0])
    return np.array([xx - nu * yy, yy - nu * xx, (1.0 + nu) * xy]) / modulus


def mismatch_displacement(mismatch: Vector, grid: Grid, followed: Vector | None = None) -> FloatArray:
    """Return w at the cells' centres, (2, nx, ny) in mm, by which a mismatch moves body 2's surface over body 1's.

    w = (De_xx x + De_xy y, De_xy x + De_yy y), 0 at the origin.

    followed: a rigid motion delta_x, delta_y, phi_z that is taken from it.
    """
    (xx, yy, xy), (along, across, turn) = mismatch, np.zeros(3) if followed is None else followed
    x, y = grid.x[:, None], grid.y
    return np.stack([xx * x + (xy + turn) * y - along, (xy - turn) * x + yy * y - across])


@dataclass(frozen=True)
class Orthotropy:
    """Friction with two coefficients, along two axes: the matrix M, symmetric and of determinant 1, by its entries.

    The shear traction satisfies (q_1/mu_1)^2 + (q_2/mu_2)^2 <= p^2, and the slip follows (q_1/mu_1^2, q_2/mu_2^2). M
    has the axes of friction and there the values mu_i/mu, mu = sqrt(mu_1 mu_2). The scaled traction q' = M^-1 q and
    slip s' = M s obey isotropic friction with the coefficient mu, and q.s = q'.s'.
    """

    xx: float
    xy: float
    yy: float

    @classmethod
    def of(cls, pair: tuple[float, float], angle: float) -> Orthotropy:
        """Return M for coefficients along two axes; angle: from x to the first (rad)."""
        first = math.sqrt(pair[0] / pair[1])
        cosine, sine = (0.0 if abs(part) < 1e-15 else part for part in (math.cos(angle), math.sin(angle)))
        xx, yy = first * cosine**2 + sine**2 / first, first * sine**2 + cosine**2 / first
        return cls(xx, (first - 1.0 / first) * cosine * sine, yy)

    @property
    def matrix(self) -> DoubleArray:
        """M of motions along x, along y and of rotations, (3, 3)."""
        return np.array([[self.xx, self.xy, 0.0], [self.xy, self.yy, 0.0], [0.0, 0.0, 1.0]])

    @property
    def inverse(self) -> Orthotropy:
        """M^-1."""
        return Orthotropy(self.yy, -self.xy, self.xx)

    def times(self, field: FloatArray) -> FloatArray:
        """Return M times a field of vectors (2, ...), a new array of its precision."""
        result = np.empty_like(field)
        result[0] = self.xx * field[0] + self.xy * field[1]
        result[1] = self.xy * field[0] + self.yy * field[1]
        return result

    def times_motion(self, motion: Vector) -> Vector:
        """Return the motion (..., delta_x, delta_y, phi_z) with its displacements along x and y times M."""
        result = motion.copy()
        result[-3:-1] = self.times(motion[-3:-1])
        return result

    def scaled(self, control: LoadControl) -> LoadControl:
        """Return what is imposed of Qx|delta_x, Qy|delta_y, phi_z on the scaled problem.

        Without an angle forces and displacements may be mixed; with one both are of one kind.
        """
        force, motion = (matrix.times(np.array(control.values[:2])) for matrix in (self.inverse, self))
        x, y = (float(force[i] if control.forced[i] else motion[i]) for i in (0, 1))
        scaled = replace(control, values=(x, y, control.values[2]))
        return (
            scaled if control.compliance is None else scaled.with_compliance(self.matrix @ control.matrix @ self.matrix)
        )
