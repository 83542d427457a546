"""Surfaces that the shear deforms, between which the normal problem is solved (ST1, ST7), with their acceleration.

Without Anderson's acceleration the fixed-point iterations converge slowly or not at all. Sources: Anderson, J. ACM 12
(1965); Walker & Ni, SIAM J. Numer. Anal. 49 (2011).
"""

from __future__ import annotations

import numpy as np

from fretsolve.contact.increment.grid_hierarchy import GridLevel
from fretsolve.contact.increment.states import WorkingState
from fretsolve.contact.kernels import kernels_of
from fretsolve.contact.solvers.incremental_update import add_displacement
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


class ShearedSurfaces:
    """The separation of surfaces that shear deforms.

    undeformed: separation without shear and pressure, (nx, ny), on the grid of `level`. Methods that take a `borrowed`
    array (nx, ny) overwrite it.
    """

    def __init__(self, level: GridLevel, undeformed: FloatArray):
        self._level, self._undeformed = level, undeformed
        self.separation = np.array(undeformed)
        self._uz, self._shear = np.zeros((1, *undeformed.shape)), np.zeros((2, *undeformed.shape))
        self._acceleration: AndersonAcceleration | None = None

    @property
    def accelerated(self) -> bool:
        """True if the separation is extrapolated from the last iterations, which would magnify rounding."""
        return self._acceleration is not None

    def begin(self, work: WorkingState, borrowed: FloatArray) -> None:
        """Deform the surfaces by the shear in `work`, without acceleration."""
        self._acceleration = None
        self._level.operator.normal_from_shear(work.shear, self._uz[0])
        self._update(work, borrowed)

    def follow(self, work: WorkingState, allowed: float, borrowed: FloatArray) -> float:
        """Deform the surfaces by the new shear; allowed: error of its displacement (mm).

        Returns the largest change of the separation in the contact, over the scale of gaps.
        """
        workspace, operator = self._level.tangential.workspace, self._level.operator
        change = np.subtract(work.shear, self._shear, out=workspace.double)
        add_displacement(operator, type(operator).normal_from_shear, self._uz, change, workspace, allowed)
        return self._update(work, borrowed)

    def accelerate(self) -> None:
        """Extrapolate the separation from now on."""
        if self._acceleration is None:
            self._acceleration = AndersonAcceleration()

    def _update(self, work: WorkingState, image: FloatArray) -> float:
        """Take up `_uz` in the separation, extrapolated where that has begun. Returns as `follow`."""
        np.copyto(self._shear, work.shear)
        separation = self.separation
        np.add(self._undeformed, self._uz[0], out=image)
        contact = work.pressure > 0.0
        if not contact.any():
            contact = np.isfinite(separation)
        change: float = kernels_of(self._level.operator).normal.largest_change(separation, image, contact)
        if self._acceleration is not None:
            material = np.isfinite(image)
            image[material] = self._acceleration.next(
                separation[material], image[material], contact[material].astype(np.float64)
            )
        separation[:] = image
        return change / (work.gap_scale or 1.0)
