"""A circular contact with a layer that shears between the bodies: u = K q + L q, K of the half-spaces, L of the layer.

Lengths in mm, compliances in 1/MPa, L in mm/MPa. Compliances are defined in `fretsolve.problem.model.materials`; the
tangential one, S, is the one of Cattaneo and Mindlin, who neglect that shear along x moves the surfaces along y.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from fretsolve.reference.tangential import full_stick_compliance

TERMS = 120
"""Polynomials of the traction in full stick: it moves by less than 1e-5 with more of them, 1e-8 from L = S a/400 on."""


def onset_compliance(contact_radius: float, tangential_compliance: float, layer: float) -> float:
    """Return the S (1/MPa) with which Mindlin's displacement at gross slip is the layered contact's of a sphere.

    The middle of a Hertz contact sticks last. There the bodies give 3 S mu P/16a, and the layer L mu p0.
    """
    return tangential_compliance + 8.0 * layer / (math.pi * contact_radius)


@lru_cache
def layered_stick_compliance(contact_radius: float, tangential_compliance: float, layer: float) -> float:
    """Return the rigid displacement per shear force (mm/N) of a circular contact without slip; exact for nu = 0.

    With t = sqrt(1 - r^2/a^2) the traction is q = sum a_n P_2n(t)/t, of which the half-spaces make the displacement
    sum (pi S a/4) [(2n)!/(2^2n n!^2)]^2 a_n P_2n(t). Its equation is multiplied by t and projected on the P_2n over t
    from 0 to 1; the force is 2 pi a^2 a_0.
    """
    if not layer:
        return full_stick_compliance(contact_radius, tangential_compliance)
    nodes, weights = np.polynomial.legendre.leggauss(2 * TERMS + 2)
    t, order = 0.5 * (1.0 + nodes), np.arange(TERMS)
    polynomials = np.polynomial.legendre.legvander(t, 2 * TERMS - 2)[:, ::2]
    product = polynomials.T @ (0.5 * (weights * t)[:, None] * polynomials)
    eigenvalues = np.cumprod(np.concatenate([[1.0], 1.0 - 0.5 / order[1:]])) ** 2
    half_spaces = 0.25 * math.pi * tangential_compliance * contact_radius * product * eigenvalues
    first = np.linalg.solve(half_spaces + np.diag(layer / (4.0 * order + 1.0)), product[0])[0]
    return 1.0 / (2.0 * math.pi * contact_radius**2 * float(first))
