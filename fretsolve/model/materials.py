"""Elastic constants of a pair of bodies in the half-space solutions.

Sources: Johnson, Contact Mechanics (1985), chapters 3 and 5; Dundurs (1969). Moduli are in MPa.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretsolve.case.keys.body_spec import Body


@dataclass(frozen=True)
class Compliances:
    """Sums over both bodies (1/MPa), with G_i = E_i / 2(1 + nu_i) (T4 of docs/theory.md). A rigid body adds nothing.

    A: sum (1 - nu_i)/G_i; B: sum nu_i/G_i; C: (1 - 2 nu_1)/G_1 - (1 - 2 nu_2)/G_2, which couples the normal and the
    tangential problem and changes sign if the bodies are swapped.
    """

    A: float
    B: float
    C: float

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
