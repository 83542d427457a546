"""Rigid-body modes on a grid and the resultants that belong to them.

Normal: the rigid displacement is ``delta_z + phi_x y + phi_y x``; resultants P, Mx = sum y p, My = sum x p.
Tangential: ``(delta_x - phi_z y, delta_y + phi_z x)``; resultants Qx, Qy, Mz = sum (x qy - y qx). [2.1]
Vectors of three follow the orders (delta_z, phi_x, phi_y) and (delta_x, delta_y, phi_z).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.rounding import TINY
from fretsolve.kernels import normal as kernels
from fretsolve.model.grid import Grid
from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray, Vector

OPEN = 1e-6
"""Part of the rigid displacement that gaps are measured against where there is no contact."""


SINGULAR = 1e-12
"""Eigenvalue of a Gram matrix with unit diagonal that counts as 0."""

NEARLY_SINGULAR = 1e-6
"""Eigenvalue below which the amplitude of a combination of modes says little."""

WELL_APART = 1e-2
"""Part of a mode's own weight that is left to it beside the other modes, from which on they count as independent."""


@dataclass(frozen=True)
class GapErrors:
    """Of a gap (mm): its largest size in contact, the deepest penetration out of it, and the length that both are
    measured against."""

    in_contact: float
    penetration: float
    approach: float

    @property
    def residual(self) -> float:
        """The larger one over that length."""
        return float(np.maximum(self.in_contact, self.penetration)) / self.approach


class _Modes:
    """Where the cells of a grid are."""

    def __init__(self, grid: Grid):
        self.x, self.y, self.cell_area = grid.x, grid.y, grid.cell_area

    def middle(self, contact: BoolArray) -> tuple[float, float]:
        """x and y (mm) half way between the ends of `contact` (nx, ny); 0 without contact."""
        return _middle(self.x, contact, 0), _middle(self.y, contact, 1)


class NormalModes(_Modes):
    """The modes (1, y, x) on a grid; integrals are over its cells' area."""

    def sums(self, field: FloatArray) -> Vector:
        """Sums of field (nx, ny) times each mode over the cells."""
        sums = np.zeros(3)
        kernels.sum_modes(field, self.x, self.y, sums)
        return sums

    def resultants(self, pressure: FloatArray) -> Vector:
        """P (N), Mx, My (N mm) of a pressure (MPa)."""
        return self.sums(pressure) * self.cell_area

    def gram(self, weight: FloatArray | BoolArray) -> DoubleArray:
        """Weighted sums of products of the modes, 3 x 3."""
        result = np.zeros((3, 3))
        kernels.gram(weight, self.x, self.y, result)
        return result

    def gap(
        self, separation: FloatArray, uz: FloatArray, rigid: Vector, contact: BoolArray, out: FloatArray
    ) -> GapErrors:
        """``out`` = the gap (nx, ny) between surfaces at a rigid displacement, and what is wrong with it."""
        in_contact, penetration, highest = kernels.take_gap(separation, uz, rigid, self.x, self.y, contact, out)
        return GapErrors(in_contact, penetration, self._approach(highest, contact, rigid))

    def gap_sums(
        self, separation: FloatArray, uz: FloatArray, rigid: Vector, contact: BoolArray
    ) -> Vector:
        """Sums over the contact of the same gap times each mode."""
        sums = np.zeros(3)
        kernels.sum_gaps(separation, uz, rigid, self.x, self.y, contact, sums)
        return sums

    def stretch(self, pressure: FloatArray, rigid: Vector) -> None:
        """Add to the pressure (nx, ny) itself times a rigid displacement; none becomes negative."""
        kernels.stretch(pressure, rigid, self.x, self.y)

    def approach(self, uz: FloatArray, contact: BoolArray, rigid: Vector) -> float:
        """Length (mm) that gaps are measured against: the largest normal displacement in the contact.

        For Hertz's contact it is delta_z, but it does not grow with an offset or a tilt of the surfaces. Without
        contact it is `OPEN` of the rigid displacement, whose rounding is all there can be.
        """
        return self._approach(float(np.max(uz, where=contact, initial=0.0)), contact, rigid)

    def _approach(self, highest: float, contact: BoolArray, rigid: Vector) -> float:
        if highest > 0.0 or contact.any():
            return max(highest, TINY)
        dz, tilt_x, tilt_y = np.abs(rigid)
        return max(OPEN * float(dz + tilt_x * np.abs(self.y).max() + tilt_y * np.abs(self.x).max()), TINY)

    def displacement(self, rigid: Vector, out: FloatArray) -> None:
        """``out`` = rigid[0] + rigid[1] y + rigid[2] x."""
        kernels.rigid_displacement(rigid, self.x, self.y, out)


class TangentialModes(_Modes):
    """The modes (1, 0), (0, 1), (-y, x) on a grid; integrals are over its cells' area."""

    def sums(self, field: FloatArray) -> Vector:
        """Sums of field (2, nx, ny) times each mode over the cells."""
        x_along_y = field[0].sum(axis=0, dtype=np.float64)
        y_along_x = field[1].sum(axis=1, dtype=np.float64)
        return np.array([x_along_y.sum(), y_along_x.sum(), y_along_x @ self.x - x_along_y @ self.y])

    def resultants(self, shear: FloatArray) -> Vector:
        """Qx, Qy (N), Mz (N mm) of a shear (MPa)."""
        return self.sums(shear) * self.cell_area

    def displacement(self, rigid: Vector, out: FloatArray) -> None:
        """``out`` (2, nx, ny) = (rigid[0] - rigid[2] y, rigid[1] + rigid[2] x)."""
        out[0] = rigid[0] - rigid[2] * self.y[None, :]
        out[1] = rigid[1] + rigid[2] * self.x[:, None]


def _middle(places: Vector, contact: BoolArray, axis: int) -> float:
    ends = np.flatnonzero(contact.any(axis=1 - axis))
    return 0.5 * float(places[ends[0]] + places[ends[-1]]) if ends.size else 0.0


def solve_modes(gram: DoubleArray, right: Vector, forced: list[int]) -> Vector:
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


def _eliminated(gram: DoubleArray, right: Vector, forced: list[int]) -> list[float] | None:
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


def is_singular(gram: DoubleArray, forced: list[int]) -> bool:
    """Whether some combination of the forced modes has next to no weight in their Gram matrix (3 x 3)."""
    if not forced or _eliminated(gram, np.zeros(3), forced) is not None:
        return False
    block = gram[forced][:, forced]
    scale = np.sqrt(np.maximum(block.diagonal(), TINY))
    return bool(np.linalg.eigvalsh(block / scale / scale[:, None])[0] < NEARLY_SINGULAR)
