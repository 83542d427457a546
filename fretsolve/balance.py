"""What is imposed on three rigid modes, force or displacement, and the amplitudes of those whose force is imposed.

Vectors of three follow the orders (delta_z, phi_x, phi_y) and (delta_x, delta_y, phi_z), and (P, Mx, My) and
(Qx, Qy, Mz).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.rounding import TINY

Vector = NDArray[np.float64]

SINGULAR = 1e-12
"""Eigenvalue of a Gram matrix with unit diagonal that counts as 0."""

NEARLY_SINGULAR = 1e-6
"""Eigenvalue below which the amplitude of a combination of modes says little."""

WELL_APART = 1e-2
"""Part of a mode's own weight that is left to it beside the other modes, from which on they count as independent."""


@dataclass(frozen=True)
class Balance:
    """What is imposed for three rigid modes: ``forced[i]`` tells a resultant from a displacement.

    values: the imposed resultant (N, N mm) where forced, the imposed displacement (mm, rad) elsewhere.
    """

    forced: tuple[bool, bool, bool]
    values: tuple[float, float, float]

    def relative_to(self, rigid: Vector) -> Balance:
        """The same with the imposed displacements counted from `rigid`."""
        x, y, z = (v if f else v - float(r) for f, v, r in zip(self.forced, self.values, rigid, strict=True))
        return Balance(self.forced, (x, y, z))

    def with_loads_scaled(self, factor: float) -> Balance:
        """The same with the imposed resultants multiplied by `factor`."""
        x, y, z = (factor * v if f else v for f, v in zip(self.forced, self.values, strict=True))
        return Balance(self.forced, (x, y, z))

    @property
    def forced_index(self) -> list[int]:
        """Modes whose resultant is imposed."""
        return [mode for mode in range(3) if self.forced[mode]]

    @property
    def imposed_displacement(self) -> Vector:
        """The imposed displacements, 0 where the resultant is imposed."""
        return np.array([0.0 if f else v for f, v in zip(self.forced, self.values, strict=True)])

    @property
    def imposed_resultant(self) -> Vector:
        """The imposed resultants, 0 where the displacement is imposed."""
        return np.array([v if f else 0.0 for f, v in zip(self.forced, self.values, strict=True)])


def solve_modes(gram: NDArray[np.float64], right: Vector, forced: list[int]) -> Vector:
    """Amplitudes of the forced modes from their Gram matrix (3 x 3) and right side, 0 for the others.

    Singular directions (a contact of one cell cannot resist rotation) get no amplitude.
    """
    amplitudes = np.zeros(3)
    if len(forced) == 1:
        (mode,) = forced
        amplitudes[mode] = right[mode] / gram[mode, mode] if gram[mode, mode] > 0.0 else 0.0
        return amplitudes
    eliminated = _eliminated(gram, right, forced)
    if eliminated is not None:
        amplitudes[forced] = eliminated
    else:
        block = gram[forced][:, forced]
        scale = np.sqrt(np.maximum(block.diagonal(), 0.0))
        scale[scale == 0.0] = 1.0
        values, vectors = np.linalg.eigh(block / scale / scale[:, None])
        kept = values > SINGULAR
        components = (right[forced] / scale) @ vectors
        components = np.divide(components, values, out=np.zeros_like(values), where=kept)
        amplitudes[forced] = vectors @ components / scale
    return amplitudes


def _eliminated(gram: NDArray[np.float64], right: Vector, forced: list[int]) -> list[float] | None:
    """Amplitudes of the forced modes by elimination; None where the modes are anywhere near dependent.

    By hand, since calls of LAPACK would take longer than a pass over a small grid.
    """
    rows = [[*row, value] for row, value in zip(gram[forced][:, forced].tolist(), right[forced].tolist(), strict=True)]
    for k, pivot in enumerate(rows):
        if not pivot[k] > WELL_APART * gram[forced[k], forced[k]]:
            return None
        for row in rows[k + 1 :]:
            share = row[k] / pivot[k]
            row[k:] = [value - share * above for value, above in zip(row[k:], pivot[k:], strict=True)]
    amplitudes = [0.0] * len(rows)
    for k in reversed(range(len(rows))):
        known = sum(a * b for a, b in zip(rows[k][k + 1 : -1], amplitudes[k + 1 :], strict=True))
        amplitudes[k] = (rows[k][-1] - known) / rows[k][k]
    return amplitudes


def is_singular(gram: NDArray[np.float64], forced: list[int]) -> bool:
    """Whether some combination of the forced modes has next to no weight in their Gram matrix (3 x 3)."""
    if not forced or _eliminated(gram, np.zeros(3), forced) is not None:
        return False
    block = gram[forced][:, forced]
    scale = np.sqrt(np.maximum(block.diagonal(), TINY))
    return bool(np.linalg.eigvalsh(block / scale / scale[:, None])[0] < NEARLY_SINGULAR)
