"""Rigid-body modes on a grid, their resultants, and the small equations for their amplitudes.

Normal: the rigid displacement is ``delta_z + phi_x y + phi_y x``; resultants P, Mx = sum y p, My = sum x p.
Tangential: ``(delta_x - phi_z y, delta_y + phi_z x)``; resultants Qx, Qy, Mz = sum (x qy - y qx), as in (T1) to (T3)
of docs/theory.md. Vectors of three follow the orders (delta_z, phi_x, phi_y) and (delta_x, delta_y, phi_z).

The limit load is the tangential load at which the whole contact slips. Friction can carry the imposed loads F if and
only if F.v <= sum b |v(x, y)| dA for every rigid motion v, where b is the friction limit (T12). So the load factor is
the least value of that sum over all v with F.v = 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul

import numpy as np

from fretsolve.contact.kernels import ON_ANY_GRID, GridKernels
from fretsolve.elastic.rounding import circle_width
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import TINY, BoolArray, DoubleArray, FloatArray, Products, Sums, Vector

OPEN = 1e-6
"""Scale of gaps without contact, as a part of the rigid displacement: only rounding passes."""

SINGULAR = 1e-12
"""Eigenvalue of a Gram matrix with unit diagonal that counts as 0."""

NEARLY_SINGULAR = 1e-6
"""Eigenvalue below which the amplitude of a combination of modes means little."""

WELL_APART = 1e-2
"""Determinant of the Gram matrix of two or three modes, over the product of their own weights, above which they are
independent: with unit diagonal, no eigenvalue of that matrix is below 0.004 then."""


@dataclass(frozen=True)
class GapErrors:
    """Errors of a gap (mm): the deepest penetration outside of the contact, the largest error anywhere, and the scale
    of both errors."""

    penetration: float
    largest: float
    gap_scale: float

    @property
    def residual(self) -> float:
        """The largest error over the scale."""
        return self.largest / self.gap_scale


Inverse = tuple[tuple[float, ...], ...]
"""The inverse of a small matrix."""

SINGLE_MODES: Products = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
"""The amplitudes of each mode alone."""


CONTACT_STIFFNESS = 2.5
"""Load over displacement of a disk of n cells that move alike, times the compliance of one cell and over sqrt(n)."""


class _Modes:
    """Cells of a grid, their middle and moments.

    arms: of all six modes, (6,): half the grid's longer side `arm` (mm) for rotations, 1 for displacements. A rotation
    times its arm compares with displacements, a moment over its arm with forces.
    """

    def __init__(self, grid: Grid, kernels: GridKernels = ON_ANY_GRID):
        self._kernels = kernels
        self.x, self.y, self.cell_area, self.farthest = grid.x, grid.y, grid.cell_area, grid.farthest
        self.arm = half_side = max(grid.size) / 2.0
        self.arms = np.array([1.0, half_side, half_side, 1.0, 1.0, half_side])

    def middle(self, contact: BoolArray) -> tuple[float, float]:
        """Return x and y (mm) half way between the ends of `contact` (nx, ny); 0 without contact."""
        places = self.x[contact.any(axis=1)], self.y[contact.any(axis=0)]
        x, y = (0.5 * float(ends[0] + ends[-1]) if ends.size else 0.0 for ends in places)
        return x, y

    def missing(self, control: LoadControl, sums: Sums) -> Sums:
        """Return the imposed resultants less the traction's resultants `sums`, over a cell's area."""
        area, (one, two, three) = self.cell_area, sums
        loads = [value if forced else 0.0 for forced, value in zip(control.forced, control.values, strict=True)]
        return loads[0] / area - one, loads[1] / area - two, loads[2] / area - three

    def meet_rig(self, control: LoadControl, misfit: Vector, gram: Products, unit: float) -> tuple[Vector, Vector]:
        """Return the part of a misfit that the loads of the rig still take, and the change of these loads; 3 each.

        The rig gives way by C F, the cells by F/E with the stiffness E of a disk, roughly. So the cells take
        (1 + C E)^-1 m, little on a soft rig, whose motion by its law alone says nothing of stick and slip.
        misfit: m, the motion by the rig's law less the motion that fits the cells; imposed loads do not count.
        gram: of the cells, as from `gram`; unit: compliance of a cell (mm/MPa).
        """
        modes, left, loads = control.sprung_index, np.zeros(3), np.zeros(3)
        cells = max(gram[0][0], gram[1][1]) if self.y.size > 1 else gram[0][0] ** 2  # strips reach farther
        if cells > 0.0:
            weights = np.array([gram[mode][mode] for mode in modes])
            stiffness = weights * (CONTACT_STIFFNESS * self.cell_area / (unit * math.sqrt(cells)))
            compliance = control.matrix[np.ix_(modes, modes)]
            taken = np.linalg.solve(np.eye(len(modes)) + compliance * stiffness, misfit[modes])
            left[modes] = misfit[modes] - taken
            loads[modes] = stiffness * taken
        return left, loads

    def gram(self, weight: FloatArray | BoolArray) -> Products:
        """Return the weighted sums of products of the modes, 3 x 3; here of 1, y, x."""
        gram: Products = self._kernels.normal.gram(weight, self.x, self.y)
        return gram


class NormalModes(_Modes):
    """The modes (1, y, x) on a grid; integrals are over its cells' area."""

    def resultants(self, pressure: FloatArray) -> Vector:
        """Return P (N), Mx, My (N mm) of a pressure (MPa) (T3)."""
        return np.array(self.sums(pressure)) * self.cell_area

    def sums(self, field: FloatArray) -> Sums:
        """Return the sums of a field (nx, ny) times each mode over the cells."""
        sums: Sums = self._kernels.normal.sum_modes(field, self.x, self.y)
        return sums

    def gap(
        self, separation: FloatArray, uz: FloatArray, rigid: Vector, contact: BoolArray, out: FloatArray
    ) -> GapErrors:
        """Write the gap (nx, ny) between the surfaces at a rigid displacement into `out`; return its errors (T1).

        Their scale is the largest normal displacement in contact. For Hertz's contact it is delta_z, but it does not
        grow with an offset or a tilt of the surfaces.
        """
        in_contact, penetration, scale = self._kernels.normal.take_gap(
            separation, uz, rigid, self.x, self.y, contact, out
        )
        if scale <= 0.0 and not contact.any():
            scale = OPEN * (abs(float(rigid[0])) + self.tilted(rigid))
        return GapErrors(penetration, larger(in_contact, penetration), max(scale, TINY))

    def tilted(self, rigid: Vector) -> float:
        """Return the largest displacement of a cell (mm) that phi_x and phi_y may cause."""
        return float(abs(rigid[1]) * np.abs(self.y).max() + abs(rigid[2]) * np.abs(self.x).max())

    def gap_sums(self, separation: FloatArray, uz: FloatArray, rigid: Vector, contact: BoolArray) -> Sums:
        """Return the sums over the contact of the gap times each mode."""
        sums: Sums = self._kernels.normal.sum_gaps(separation, uz, rigid, self.x, self.y, contact)
        return sums

    def stretch(self, pressure: FloatArray, rigid: Vector) -> None:
        """Multiply the pressure (nx, ny) by 1 + a rigid displacement; negative values become 0."""
        self._kernels.normal.stretch(pressure, rigid, self.x, self.y)

    def displacement(self, rigid: Vector, out: FloatArray) -> None:
        """Write rigid[0] + rigid[1] y + rigid[2] x into `out` (nx, ny)."""
        np.add(rigid[0] + rigid[1] * self.y[None, :], rigid[2] * self.x[:, None], out=out, casting="same_kind")


class TangentialModes(_Modes):
    """The modes (1, 0), (0, 1), (-y, x) on a grid; integrals are over its cells' area."""

    def sums(self, field: FloatArray) -> Sums:
        """Return the sums of field (2, nx, ny) times each mode over the cells."""
        sums: Sums = self._kernels.friction.sum_motions(field, self.x, self.y)
        return sums

    def resultants(self, shear: FloatArray) -> Vector:
        """Return Qx, Qy (N), Mz (N mm) of a shear traction (MPa) (T3)."""
        return np.array(self.sums(shear)) * self.cell_area

    def gram(self, weight: FloatArray | BoolArray) -> Products:
        """Return the weighted sums of products of the modes, 3 x 3."""
        (total, y, x), (_, yy, _), (_, _, xx) = super().gram(weight)
        return (total, 0.0, -y), (0.0, total, x), (-y, x, xx + yy)

    def displacement(self, rigid: Vector, out: FloatArray) -> None:
        """Write (rigid[0] - rigid[2] y, rigid[1] + rigid[2] x) into `out` (2, nx, ny)."""
        out[0] = rigid[0] - rigid[2] * self.y[None, :]
        out[1] = rigid[1] + rigid[2] * self.x[:, None]


def solve_modes(gram: Products | DoubleArray, right: Sums | Vector, forced: list[int]) -> Vector:
    """Return the amplitudes of the forced modes from their Gram matrix (3 x 3) and right side, 0 for the others.

    Singular directions get no amplitude: a contact of one cell, for example, cannot resist rotation.
    """
    amplitudes = [0.0, 0.0, 0.0]
    if len(forced) == 1:
        (mode,) = forced
        amplitudes[mode] = right[mode] / gram[mode][mode] if gram[mode][mode] > 0.0 else 0.0
    elif (inverse := inverse_of(gram, forced)) is not None:
        loads = [right[mode] for mode in forced]
        for mode, row in zip(forced, inverse, strict=True):
            amplitudes[mode] = sum(map(mul, row, loads))
    elif forced:
        block, scale = _with_unit_diagonal(gram, forced)
        values, vectors = np.linalg.eigh(block)
        kept = values > SINGULAR
        components = (np.asarray(right)[forced] / scale) @ vectors
        components = np.divide(components, values, out=np.zeros_like(values), where=kept)
        for mode, amplitude in zip(forced, vectors @ components / scale, strict=True):
            amplitudes[mode] = amplitude
    return np.array(amplitudes)


def is_singular(gram: Products | DoubleArray, forced: list[int]) -> bool:
    """Return whether some combination of the forced modes has almost no weight in their Gram matrix (3 x 3)."""
    if len(forced) < 2:
        return bool(forced) and not gram[forced[0]][forced[0]] > 0.0
    if inverse_of(gram, forced) is not None:
        return False
    return bool(np.linalg.eigvalsh(_with_unit_diagonal(gram, forced)[0])[0] < NEARLY_SINGULAR)


def larger(value: float, other: float) -> float:
    """Return the larger of two numbers, or NaN if one is. NumPy takes ten times as long for two."""
    return value if value > other or value != value else other


def largest_error(found: Sums | Vector, control: LoadControl, scale: float, arms: Vector) -> float:
    """Return the largest error of the imposed ones of three resultants over `scale`, a moment: times its arm."""
    errors = [abs(float(found[mode]) - control.values[mode]) / float(arms[mode]) for mode in control.forced_index]
    return max(errors) / scale


def inverse_of(gram: Products | DoubleArray, modes: Sequence[int]) -> Inverse | None:
    """Return the inverse of the rows and columns of one to three `modes`, in order, of the Gram matrix, which is
    positive semidefinite. None unless the modes are well apart.

    It is computed by hand, because a call of LAPACK takes as long as an iteration on a small grid: mode III takes a
    twentieth less time on 96 x 96 points.
    """
    if len(modes) == 1:
        own = gram[modes[0]][modes[0]]
        return ((1.0 / own,),) if own > 0.0 else None
    if len(modes) == 2:
        one, other = modes
        a, b, c = gram[one][one], gram[one][other], gram[other][other]
        determinant = a * c - b * b
        if not determinant > WELL_APART * a * c:
            return None
        b = -b / determinant
        return (c / determinant, b), (b, a / determinant)
    return _inverse_of_three(gram) if modes else None


def _inverse_of_three(gram: Products | DoubleArray) -> Inverse | None:
    """Return the inverse of the Gram matrix of all three modes, None unless they are well apart."""
    (a, ab, ac), (_, b, bc), (_, _, c) = gram
    if not (a > 0.0 and b > 0.0 and c > 0.0):
        return None
    # the matrix with unit diagonal, in which rotations and displacements compare, and its cofactors
    p, q, r = 1.0 / math.sqrt(a), 1.0 / math.sqrt(b), 1.0 / math.sqrt(c)
    d, e, f = ab * p * q, ac * p * r, bc * q * r
    determinant = 1.0 + 2.0 * d * e * f - d * d - e * e - f * f
    if not determinant > WELL_APART:
        return None
    s = 1.0 / determinant
    one, two, three = (e * f - d) * s * p * q, (d * f - e) * s * p * r, (d * e - f) * s * q * r
    ones = (1.0 - f * f) * s * p * p, (1.0 - e * e) * s * q * q, (1.0 - d * d) * s * r * r
    if max(ones) == math.inf:  # a weight next to 0
        return None
    return (ones[0], one, two), (one, ones[1], three), (two, three, ones[2])


def _with_unit_diagonal(gram: Products | DoubleArray, forced: list[int]) -> tuple[DoubleArray, Vector]:
    """Return the block of the forced modes, scaled so that its diagonal is 1 or 0, and the scale of each mode."""
    block = np.asarray(gram)[forced][:, forced]
    scale = np.sqrt(np.maximum(block.diagonal(), 0.0))
    scale[scale == 0.0] = 1.0
    return block / scale / scale[:, None], scale


AT_THE_LIMIT = 1e-9
"""Relative distance from the limit load that counts as gross slip: at the limit the displacement is unbounded."""


def at_the_limit(precision: type[np.floating]) -> float:
    """Return `AT_THE_LIMIT`, or more where tractions stored in `precision` resolve the friction limit less well."""
    return max(AT_THE_LIMIT, circle_width(precision))


def load_factor(
    friction_limit: FloatArray, control: LoadControl, modes: TangentialModes, enough: float = math.inf
) -> float:
    """Return the factor on the imposed tangential loads at which all cells slip; inf if no load is imposed.

    friction_limit: (nx, ny), MPa. If Mz is not imposed the factor is exact; else it is found by iteratively reweighted
    least squares, and is never too small. It is no longer improved once it is surely above `enough`.
    """
    load = control.imposed_resultant
    if not load.any():
        return np.inf
    capacity = float(friction_limit.sum(dtype=np.float64)) * modes.cell_area
    if not control.forced[2]:
        return capacity / float(np.hypot(load[0], load[1]))
    forced = control.forced_index
    if np.count_nonzero(friction_limit) < 2 and not _carried_by_a_cell(friction_limit, load, forced, modes):
        return 0.0
    size = float(np.abs(load).max())
    return _least_dissipation(friction_limit * modes.cell_area, load / size, forced, modes, enough * size) / size


def _carried_by_a_cell(friction_limit: FloatArray, load: Vector, forced: list[int], modes: TangentialModes) -> bool:
    """Return whether a force on the only cell in contact balances the loads. It has no torque about the cell."""
    if not friction_limit.any():
        return False
    i, j = np.unravel_index(int(friction_limit.argmax()), friction_limit.shape)
    arm = max(abs(float(modes.x[i])), abs(float(modes.y[j])), float(np.sqrt(modes.cell_area)))
    resultants = np.array([[1.0, 0.0], [0.0, 1.0], [-modes.y[j] / arm, modes.x[i] / arm]])[forced]
    imposed = (load / np.array([1.0, 1.0, arm]))[forced]
    force = np.linalg.lstsq(resultants, imposed, rcond=None)[0]
    return bool(np.abs(resultants @ force - imposed).max() <= 1e-9 * np.abs(imposed).max())


def _least_dissipation(
    weight: FloatArray, load: Vector, forced: list[int], modes: TangentialModes, enough: float
) -> float:
    """Return the least of sum weight |v| over the rigid motions v with load.v = 1 (T12), or one of these sums once the
    least is surely above `enough`.
    """
    last, speed, reweighted = np.ones_like(weight), np.empty_like(weight), np.empty_like(weight)
    motion = np.empty((2, *weight.shape))
    best = np.inf
    for _ in range(100):
        # least squares with the weights b / |v| of the last motion
        np.divide(weight, last, out=reweighted)
        gram = modes.gram(reweighted)
        direction = solve_modes(gram, load, forced)
        carried = 1.0 / (direction @ load)
        direction *= carried
        # the energy that this motion dissipates: an upper bound of the least, which must fall
        modes.displacement(direction, motion)
        np.hypot(motion[0], motion[1], out=speed)
        dissipation = float(np.vdot(weight, speed))
        if dissipation > best * (1.0 - 1e-12):
            break
        best = dissipation
        # the shear traction of the least squares carries the loads `carried` times; over its largest part of the
        # friction limit, |v| over that before, this is a lower bound
        part = np.divide(speed, last, out=motion[0])
        part *= weight > 0.0
        if carried > enough * part.max() and inverse_of(gram, forced) is not None:
            break
        np.maximum(speed, 1e-9 * float(speed.max()), out=last)
    return best
