"""Friction with two coefficients, along two axes: the change of variables that makes it isotropic.

The shear traction satisfies (q_1/mu_1)^2 + (q_2/mu_2)^2 <= p^2, and the slip follows (q_1/mu_1^2, q_2/mu_2^2). With the
symmetric matrix M whose axes are those of friction and whose values there are mu_i/mu, mu = sqrt(mu_1 mu_2), the scaled
traction q' = M^-1 q and slip s' = M s obey isotropic friction with the coefficient mu, and q.s = q'.s'.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.model.load_control import LoadControl
from fretsolve.system.arrays import FloatArray, Vector


@dataclass(frozen=True)
class Orthotropy:
    """The matrix M, symmetric and of determinant 1, by its entries."""

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
        return LoadControl(control.forced, (x, y, control.values[2]))
