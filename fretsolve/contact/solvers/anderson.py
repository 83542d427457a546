"""Anderson acceleration of fixed-point iterations, which without it converge slowly or not at all.

Sources: Anderson, J. ACM 12 (1965); Walker & Ni, SIAM J. Numer. Anal. 49 (2011).
"""

from __future__ import annotations

import numpy as np

from fretsolve.system.arrays import FloatArray

DEPTH = 6
"""Number of differences of earlier iterates in use. More gain nothing; fewer are worse at strong friction."""

LEAST_SINGULAR_VALUE = 1e-6
"""Singular value, over the largest, below which a combination of differences is ignored."""


class AndersonAcceleration:
    """Finds x = g(x) from earlier iterates x and their images g(x)."""

    def __init__(self) -> None:
        self._iterates: list[FloatArray] = []
        self._residuals: list[FloatArray] = []

    def next(self, iterate: FloatArray, image: FloatArray, weight: FloatArray) -> FloatArray:
        """Return the next x from x and g(x), both (n,); weight: of each entry of the residual, (n,)."""
        residual = image - iterate
        self._iterates.append(iterate.copy())
        self._residuals.append(residual)
        del self._iterates[: -DEPTH - 1], self._residuals[: -DEPTH - 1]
        if len(self._residuals) == 1:
            return image
        steps, moves = np.diff(self._residuals, axis=0), np.diff(self._iterates, axis=0)
        shares = np.linalg.lstsq((steps * weight).T, residual * weight, rcond=LEAST_SINGULAR_VALUE)[0]
        result: FloatArray = image - shares @ (moves + steps)
        return result
