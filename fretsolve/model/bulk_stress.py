"""Bulk stress: a uniform in-plane stress in a body stretches its surface, which stays plane.

What counts in a contact is the mismatch, the strain of body 2's surface less that of body 1's:

    e_xx = (sxx - nu syy)/E,   e_yy = (syy - nu sxx)/E,   e_xy = (1 + nu) sxy/E       in plane stress
    e_xx = (1 - nu^2) sxx/E                                                          in plane strain, syy = nu sxx

A free surface is in plane stress; plane strain is that of line contact, where nothing moves along y. The mismatch moves
body 2's surface over body 1's by w = (De_xx x + De_xy y, De_xy x + De_yy y), 0 at the origin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.case.keys.body_spec import Body, ElasticBody
from fretsolve.model.grid import Grid
from fretsolve.system.arrays import FloatArray, Vector


@dataclass(frozen=True)
class BulkResponse:
    """The strains of the two surfaces under bulk stress; plane_strain: in line contact."""

    bodies: tuple[Body, Body]
    plane_strain: bool = False

    def mismatch(self, stresses: Mapping[str, float]) -> Vector:
        """Return De_xx, De_yy, De_xy, (3,), under bulk stresses (MPa) by their names; those not named are 0."""
        first, second = (
            surface_strain(kind, [stresses.get(name, 0.0) for name in BULK[body]], self.plane_strain)
            for body, kind in enumerate(self.bodies, start=1)
        )
        return second - first

    def with_constraint(self, stresses: Mapping[str, float]) -> dict[str, float]:
        """Return bulk stresses (MPa) by their names; in plane strain with that along y, nu times that along x."""
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
    """Return w at the cells' centres, (2, nx, ny) in mm, of a mismatch De_xx, De_yy, De_xy.

    followed: a rigid motion delta_x, delta_y, phi_z that is taken from it.
    """
    (xx, yy, xy), (along, across, turn) = mismatch, np.zeros(3) if followed is None else followed
    x, y = grid.x[:, None], grid.y
    return np.stack([xx * x + (xy + turn) * y - along, (xy - turn) * x + yy * y - across])
