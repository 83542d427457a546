"""The normal contact problem: pressure and rigid approach at a given shear [2.2].

    gap = separation + A p - (delta_z + phi_x y + phi_y x),   p >= 0, gap >= 0, p gap = 0,

with P, Mx, My imposed or delta_z, phi_x, phi_y. `separation` holds the undeformed surfaces and the normal
displacement that the shear causes; +inf where there is no material.

Primal-dual active set with conjugate gradients inside: on a fixed contact zone the gap is driven towards 0 by CG
preconditioned with the inverse of the half-space's symbol (after Vollebregt, JOTA 162, 2014), in the balance of
forces; then cells under tension leave the zone, cells that penetrate enter it, and the true gap is computed anew.
Forced rigid displacements are the multipliers of the balance [25], [26].
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.incremental_update import Room
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import ROUNDING, rounding_of
from fretsolve.errors import ContactLostError
from fretsolve.kernels import cg
from fretsolve.kernels import normal as kernels
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.solvers.projected_cg import ProjectedCG, Space
from fretsolve.solvers.rigid_modes import GapErrors, NormalModes, is_singular, solve_modes
from fretsolve.system.arrays import BoolArray, FloatArray, Vector

REDUCTION = 0.2
"""By how much CG reduces the gap on a fixed zone before the zone is looked at again."""

PATIENCE = 4
"""Passes without halving the residual after which the contact zone is taken to run in circles ..."""

CAUTION = 0.6
"""... and from which on only cells that penetrate by this part of the deepest join it (next time by this part of what
is left to 1): on a rough surface those beside them need not."""


@dataclass(frozen=True)
class NormalResult:
    """rigid: (delta_z, phi_x, phi_y); residual: largest |gap| in contact or penetration, over `scale` (mm);
    converged: to the tolerance, or to rounding."""

    rigid: Vector
    iterations: int
    residual: float
    scale: float
    converged: bool


class NormalSolver:
    """Working arrays of the normal problem on one grid; `solve` may be called any number of times.

    space: arrays of another solver to work in, which is not in use at the same time.
    """

    def __init__(self, operator: ElasticOperator, grid: Grid, space: Space | None = None):
        self.operator = operator
        self.modes = NormalModes(grid)
        shape = grid.shape
        if space is None:
            space = Space(np.zeros((1, *shape)), ProjectedCG(1, shape, operator.inner.dtype))
        self._cg = space.cg
        self._gap = space.planes[0]
        self._room = Room(space.planes[:1], space.cg.spare)
        self._uz = np.zeros((1, *shape))
        self._update = operator.incremental_normal
        self._contact = self._cg.zone
        self._no_material: BoolArray = np.zeros(shape, dtype=bool)
        self._gram = np.zeros((3, 3))

    def solve(
        self,
        separation: FloatArray,
        control: LoadControl,
        pressure: FloatArray,
        tolerance: float,
        max_iterations: int,
        rigid: Vector,
        last_tolerance: float | None = None,
        approach: float = 0.0,
    ) -> NormalResult:
        """Solve in place for `pressure` (nx, ny), which holds the first estimate.

        separation: (nx, ny), mm; balance: of (P|delta_z, Mx|phi_x, My|phi_y); tolerance: on the residual;
        max_iterations: of CG; rigid: estimate of the rigid displacements, used while there is no contact.
        approach: `scale` of the last solve, where the first estimate is its pressure and uz goes on from there;
        last_tolerance: of the solves that go on so from this one, for which the rounding of uz must be small enough.
        """
        iterations, passes, rigid = 0, 0, rigid.copy()
        least, since, caution = np.inf, 0, 0.0
        last_tolerance = tolerance if last_tolerance is None else last_tolerance
        np.copyto(self._gap, pressure)
        self._start_zone(separation, control, pressure)
        if approach:
            self._follow(pressure, last_tolerance * approach)
        else:
            self.operator.normal(pressure, self._uz[0])
        while True:
            rigid = self._rigid_displacement(separation, control, rigid)
            errors = self._update_gap_and_zone(separation, rigid, tolerance, caution)
            residual, scale = errors.residual, errors.approach
            least, since = (residual, 0) if residual < 0.5 * least else (least, since + 1)
            unbalanced = self._unbalance(control, pressure)
            if since >= PATIENCE:
                if residual * scale <= self._rounding(separation, rigid) and unbalanced <= tolerance:
                    return NormalResult(rigid, iterations, residual, scale, True)
                caution, since = 1.0 - (1.0 - caution) * (1.0 - CAUTION), 0
            if residual <= tolerance and unbalanced <= tolerance:
                return NormalResult(rigid, iterations, residual, scale, True)
            if iterations >= max_iterations or passes >= max_iterations or not np.isfinite(residual):
                return NormalResult(rigid, iterations, residual, scale, False)
            largest = max(errors.in_contact, errors.penetration) or 1.0
            kernels.take_residual(self._gap, self._contact, -1.0 / largest, self._cg.residual[0])
            np.copyto(self._gap, pressure)
            if residual > tolerance:
                target = max(REDUCTION, 0.3 * tolerance / residual)
                iterations += self._reduce_gap(control, pressure, largest, target, max_iterations - iterations)
                self._release_tension(control, pressure)
            else:
                self._widen(control, pressure)
            self._restore_balance(control, pressure)
            self._follow(pressure, last_tolerance * scale)
            passes += 1

    def _follow(self, pressure: FloatArray, bearable: float) -> None:
        """Bring uz from the pressure in `_gap` up to `pressure`."""
        np.subtract(pressure, self._gap, out=self._gap)
        self._update.add(self._uz, self._room, bearable)

    def _start_zone(self, separation: FloatArray, control: LoadControl, pressure: FloatArray) -> None:
        """Contact where the estimate presses; everywhere at an even pressure if a load finds none."""
        np.isinf(separation, out=self._no_material)
        np.maximum(pressure, 0.0, out=pressure)
        pressure[self._no_material] = 0.0
        load = control.values[0]
        if control.forced[0] and load <= 0.0:
            pressure[:] = 0.0
        np.greater(pressure, 0.0, out=self._contact)
        if control.forced[0] and load > 0.0:
            if not self._contact.any():
                np.logical_not(self._no_material, out=self._contact)
                pressure[self._contact] = load
            if not self._contact.any():
                raise ContactLostError("the surfaces nowhere face each other on the grid", "P")
            pressure *= load / (pressure.sum(dtype=np.float64) * self.modes.cell_area)
            self._restore_balance(control, pressure)
        self._press_on_one_side(control, pressure)
        self._gram = self.modes.gram(self._contact)

    def _press_on_one_side(self, control: LoadControl, pressure: FloatArray) -> None:
        """Moments without contact: they tilt the body until it touches on the side that they press on."""
        _, mx, my = control.imposed_resultant
        if not (mx or my) or self._contact.any():
            return
        self.modes.displacement(np.array([0.0, mx, my]), pressure)
        np.maximum(pressure, 0.0, out=pressure)
        pressure[self._no_material] = 0.0
        pressure /= float(pressure.sum()) * self.modes.cell_area or 1.0
        np.greater(pressure, 0.0, out=self._contact)
        self._restore_balance(control, pressure)

    def _rigid_displacement(self, separation: FloatArray, control: LoadControl, rigid: Vector) -> Vector:
        """Forced displacements by least squares of the gap over the contact zone [25]."""
        imposed, forced = control.imposed_displacement, control.forced_index
        if not self._gram[0, 0]:
            return self._rigid_displacement_when_open(separation, control, rigid)
        if is_singular(self._gram, forced):
            imposed = np.where(control.forced, rigid, imposed)  # a row of cells keeps the tilt that it had
        gaps = self.modes.gap_sums(separation, self._uz[0], imposed, self._contact)
        return imposed + solve_modes(self._gram, gaps, forced)

    def _rigid_displacement_when_open(self, separation: FloatArray, control: LoadControl, rigid: Vector) -> Vector:
        """Without contact: a forced delta_z just lets the surfaces touch, and forced tilts stay."""
        imposed = control.imposed_displacement
        found = np.where(control.forced, rigid, imposed)
        found[0] = 0.0
        self.modes.gap(separation, self._uz[0], found, self._contact, self._gap)
        found[0] = self._gap.min() if control.forced[0] else imposed[0]
        return found

    def _update_gap_and_zone(
        self, separation: FloatArray, rigid: Vector, threshold: float, caution: float
    ) -> GapErrors:
        """True gap; cells that penetrate by `caution` of the most, or any, join the contact.

        Returns what was wrong with the gap before.
        """
        gap, contact = self._gap, self._contact
        errors = self.modes.gap(separation, self._uz[0], rigid, contact, gap)
        if errors.penetration > threshold * errors.approach:
            deep = max(0.5 * threshold * errors.approach, caution * errors.penetration)
            np.logical_or(contact, gap < -deep, out=contact)
            self._gram = self.modes.gram(contact)
        return errors

    def _rounding(self, separation: FloatArray, rigid: Vector) -> float:
        """What is lost of gaps in rounding (mm)."""
        height = float(np.max(np.abs(separation), where=self._contact, initial=0.0))
        dz, tilt_x, tilt_y = np.abs(rigid)
        tilted = tilt_x * np.abs(self.modes.y).max() + tilt_y * np.abs(self.modes.x).max()
        elastic = rounding_of(self.operator.dtype) * float(np.abs(self._uz).max())
        return max(elastic, ROUNDING * float(max(height, dz, tilted)))

    def _unbalance(self, control: LoadControl, pressure: FloatArray) -> float:
        """Worst imposed resultant's error over the load (and over the load times the contact's reach)."""
        if not control.forced_index:
            return 0.0
        if not self._contact.any():
            return np.inf if control.imposed_resultant[1:].any() else 0.0
        found, imposed = self.modes.resultants(pressure), control.imposed_resultant
        error = np.abs(found - imposed)
        load = max(float(found[0]), float(imposed[0]))
        if load <= 0.0:
            return np.inf if error.any() else 0.0
        reach = np.array([1.0, np.ptp(self.modes.y) or 1.0, np.ptp(self.modes.x) or 1.0])
        return float(np.max((error / (reach * load))[control.forced_index], initial=0.0))

    def _reduce_gap(
        self, control: LoadControl, pressure: FloatArray, largest: float, reduction: float, limit: int
    ) -> int:
        """Correct the pressure on the contact zone until the gap's largest value (mm) is down by `reduction`."""
        np.copyto(self._cg.weight, self._contact)
        tilts = self._tilts_about_the_contact() if control.forced[0] else np.eye(3)
        self._cg.constrain(control.forced_index, lambda mode, out: self.modes.displacement(tilts[mode], out[0]))
        iterations = self._cg.solve(self.operator.inner.normal, reduction, 0.0, limit)
        cg.add(pressure[None], self._cg.solution, largest / self.operator.inner.unit)
        return iterations

    def _tilts_about_the_contact(self) -> FloatArray:
        """The modes with tilts about the contact's middle: beside P the same set, but not nearly dependent."""
        middle_x, middle_y = self.modes.middle(self._contact)
        return np.array([[1.0, 0.0, 0.0], [-middle_y, 1.0, 0.0], [-middle_x, 0.0, 1.0]])

    def _release_tension(self, control: LoadControl, pressure: FloatArray) -> None:
        """Cells under tension leave the contact, but for the nearest ones that the load needs on its other side."""
        tension = pressure < 0.0
        if tension.any():
            needed = self._needed(control, self._contact & ~tension, tension)
            pressure[tension] = 0.0
            self._contact &= ~tension
            if needed is not None:
                pressure[needed] = float(pressure.max()) or 1.0
                self._contact |= needed
            self._press_on_one_side(control, pressure)
            self._gram = self.modes.gram(self._contact)

    def _needed(self, control: LoadControl, left: BoolArray, tension: BoolArray) -> BoolArray | None:
        """Cells of `tension` in the first row beyond the point where the load acts, if those `left` all lie on one
        side of it."""
        for axis, places, point, side in self._loaded_sides(control, left):
            held = tension.any(axis=axis) & (side * (places - point) >= 0.0)
            if held.any():
                nearest = np.zeros_like(held)
                nearest[np.argmin(np.where(held, np.abs(places - point), np.inf))] = True
                needed: BoolArray = tension & np.expand_dims(nearest, axis)
                return needed
        return None

    def _loaded_sides(self, control: LoadControl, contact: BoolArray) -> Iterator[tuple[int, Vector, float, int]]:
        """Axis to sum over, places along the other one, point where the load acts, and the side (-1, 1) on which it
        lies beyond all of `contact`."""
        load, mx, my = control.imposed_resultant
        for mode, moment, axis, places in ((1, mx, 0, self.modes.y), (2, my, 1, self.modes.x)):
            ends = places[contact.any(axis=axis)]
            if control.forced[mode] and load > 0.0 and ends.size:
                point = float(moment / load)
                if not ends.min() <= point <= ends.max():
                    yield axis, places, point, 1 if point > ends.max() else -1

    def _widen(self, control: LoadControl, pressure: FloatArray) -> None:
        """The cells beside the contact join it, up to where the load acts, if those in contact cannot balance it."""
        beyond = any(True for _ in self._loaded_sides(control, self._contact))
        if not beyond and not is_singular(self._gram, control.forced_index):
            return
        wider = grown(self._contact)
        while not wider.all() and any(True for _ in self._loaded_sides(control, wider & ~self._no_material)):
            wider = grown(wider)
        fresh = wider & ~self._contact & ~self._no_material
        pressure[fresh] = float(np.mean(pressure, where=self._contact))
        self._contact |= fresh
        self._gram = self.modes.gram(self._contact)

    def _restore_balance(self, control: LoadControl, pressure: FloatArray) -> None:
        """Correct the pressure by p (a + b y + c x) so that the imposed resultants hold [26]."""
        forced = control.forced_index
        if not forced or not self._contact.any():
            return
        gram = self.modes.gram(pressure) * self.modes.cell_area
        missing = control.imposed_resultant - gram[0]
        self.modes.stretch(pressure, solve_modes(gram, missing, forced))


def grown(contact: BoolArray) -> BoolArray:
    """`contact` and the cells beside it."""
    wider = contact.copy()
    for axis in (0, 1):
        along = np.moveaxis(wider, axis, 0)
        before = along.copy()
        along[1:] |= before[:-1]
        along[:-1] |= before[1:]
    return wider
