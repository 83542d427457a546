"""The normal contact problem: find pressure and normal rigid displacements at a given shear.

    gap = separation + A_zz p - (delta_z + phi_x y + phi_y x),   p >= 0, gap >= 0, p gap = 0,

with P, Mx, My imposed or delta_z, phi_x, phi_y. `separation` is the separation of the undeformed surfaces plus the
normal displacement by the shear; +inf where there is no material. The method is a primal-dual active set with conjugate
gradients inside; N1 to N8 are its steps in docs/theory.md.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fretsolve.contact.kernels import kernels_of
from fretsolve.contact.solvers.incremental_update import Workspace, add_correction, add_displacement
from fretsolve.contact.solvers.projected_cg import ProjectedCG, springs_of
from fretsolve.contact.solvers.rigid_modes import (
    SINGLE_MODES,
    GapErrors,
    NormalModes,
    is_singular,
    largest_error,
    solve_modes,
)
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import ROUNDING, rounding_of
from fretsolve.errors import ContactLostError
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.system.arrays import BoolArray, FloatArray, Products, Vector, grown

REDUCTION, SETTLED_REDUCTION = 0.2, 0.03
"""Factors by which CG reduces the gap (N5): while cells still join or leave the zone, and once none do, since then a
better solution needs fewer new displacements. With the latter mode I.3 takes a tenth fewer applications."""


@dataclass(frozen=True)
class SolverResult:
    """Result of a normal or tangential solve.

    rigid: the three rigid displacements, tangential ones as increments; iterations: of CG; residual: largest violation
    of the contact conditions over its scale; scale: length (mm) that gaps are measured against, or the smaller one of
    the two for slips; converged: to the tolerance, or to rounding.
    """

    rigid: Vector
    iterations: int
    residual: float
    scale: float
    converged: bool


class NormalSolver:
    """Solves the normal problem on one grid, any number of times.

    workspace: arrays shared with another solver; uz: (1, nx, ny), normal displacement at the present pressure.
    """

    def __init__(self, operator: ElasticOperator, grid: Grid, workspace: Workspace | None = None):
        self.operator = operator
        self.modes = NormalModes(grid, kernels_of(operator))
        self._workspace = workspace or Workspace(1, grid.shape, operator.inner.dtype)
        self._cg = ProjectedCG(self._workspace, 1, kernels_of(operator))
        self._gap, self.uz = self._workspace.double[0], np.zeros((1, *grid.shape))
        self._contact = self._cg.zone
        self._no_material: BoolArray = np.zeros(grid.shape, dtype=bool)
        self._gram: Products = ((0.0, 0.0, 0.0),) * 3

    def solve(
        self,
        separation: FloatArray,
        control: LoadControl,
        pressure: FloatArray,
        tolerance: float,
        max_iterations: int,
        rigid: Vector,
        last_tolerance: float | None = None,
        known: bool = False,
    ) -> SolverResult:
        """Solve in place for `pressure` (nx, ny), which holds the first estimate.

        separation: (nx, ny), mm; control: of (P|delta_z, Mx|phi_x, My|phi_y); tolerance: on the residual; rigid:
        estimate of the rigid displacements, used while there is no contact; last_tolerance: tightest tolerance of the
        later solves that reuse this displacement; known: whether `uz` holds the displacement of the estimate.
        """
        iterations, rounds, caution, rigid = 0, 0, 0.0, rigid.copy()
        least, since_halved = np.inf, 0
        last_tolerance = tolerance if last_tolerance is None else last_tolerance
        # N1: contact zone and displacement of the estimate
        np.copyto(self._gap, pressure)
        self._start_zone(separation, control, pressure)
        if known:
            size = float(np.max(self.uz[0], where=self._contact, initial=0.0))
            self._update_displacement(pressure, last_tolerance * size)
        else:
            self.operator.normal(pressure, self.uz)
        cells = self._gram[0][0] if known else None
        while True:
            # N2: forced rigid displacements by least squares of the gap, N' g = 0
            by_law, misfit, missing = self._meet_rig(separation, control, pressure)
            rigid = self._rigid_displacement(separation, control, rigid, by_law - misfit)
            # N3: gap by (T1); cells that penetrate join the zone
            errors = self._update_gap_and_zone(separation, rigid, tolerance, caution)
            # N4: stop at the tolerance, or where rounding allows no better
            residual, scale = errors.residual, errors.gap_scale
            least, since_halved = (residual, 0) if residual < 0.5 * least else (least, since_halved + 1)
            stalled = since_halved >= 4
            accurate = residual <= tolerance or (stalled and errors.largest <= self._rounding(separation, rigid))
            loads = control.with_springs_at(self.modes.resultants(pressure) + missing) if accurate else control
            solved = accurate and self._unbalance(loads, pressure) <= tolerance
            if solved or max(iterations, rounds) >= max_iterations or not np.isfinite(residual):
                return SolverResult(rigid, iterations, residual, scale, solved)
            if stalled:  # the zone cycles, as on rough surfaces: from now on only the deepest cells join in N3
                caution, since_halved = 1.0 - 0.4 * (1.0 - caution), 0
            # N5: CG1 to CG6 reduce the gap on the fixed zone (T10); if only imposed loads are missed, it is widened
            of_rig = accurate and errors.largest > 0.0 and self._unbalance(control, pressure) <= tolerance
            if residual > tolerance or of_rig:
                self._prepare_cg(control, errors.largest, misfit)
                settled, cells = self._gram[0][0] == cells, self._gram[0][0]
                reduction = max(SETTLED_REDUCTION if settled else REDUCTION, min(0.3 * tolerance / residual, 0.3))
                elastic, inverse = self.operator.inner.normal, self.operator.preconditioner.normal
                iterations += self._cg.solve(elastic, inverse, reduction, 0.0, max_iterations - iterations)
                fields = pressure[None], self._gap[None], self.uz
                add_correction(self.operator, self._cg.found, errors.largest, *fields, last_tolerance * scale)
                balanced = self._kept_by_springs(control, pressure)
                # N6: cells under tension leave the zone
                self._release_tension(control, pressure)
            else:
                np.copyto(self._gap, pressure)
                balanced = self._kept_by_springs(control, pressure)
                self._widen(control, pressure)
            # N7: restore the imposed loads, and loads of a rig
            self._restore_balance(balanced, pressure)
            # N8: displacement of the change of the pressure
            self._update_displacement(pressure, last_tolerance * scale)
            rounds += 1

    def _kept_by_springs(self, control: LoadControl, pressure: FloatArray) -> LoadControl:
        """Return the control that keeps the present loads of a rig, while the zone changes."""
        return control if control.compliance is None else control.with_springs_at(self.modes.resultants(pressure))

    def _update_displacement(self, pressure: FloatArray, allowed: float) -> None:
        """Update uz from the pressure in `_gap` to `pressure`, with an error of less than `allowed` (mm)."""
        np.subtract(pressure, self._gap, out=self._gap)
        change = self._workspace.double[:1]
        add_displacement(self.operator, type(self.operator).normal, self.uz, change, self._workspace, allowed)

    def _start_zone(self, separation: FloatArray, control: LoadControl, pressure: FloatArray) -> None:
        """Start with contact where the estimate is positive, or everywhere if a load is imposed and it is nowhere."""
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
            if self._unbalance(control, pressure) > ROUNDING:  # else the estimate, and its displacement, are kept
                pressure *= load / (pressure.sum(dtype=np.float64) * self.modes.cell_area)
                self._restore_balance(control, pressure)
        self._press_on_one_side(control, pressure)
        self._gram = self.modes.gram(self._contact)

    def _press_on_one_side(self, control: LoadControl, pressure: FloatArray) -> None:
        """Let the side that imposed moments press down touch, if no cell is in contact (N1, N6)."""
        _, mx, my = control.imposed_resultant
        if not (mx or my) or self._contact.any():
            return
        self.modes.displacement(np.array([0.0, mx, my]), pressure)
        np.maximum(pressure, 0.0, out=pressure)
        pressure[self._no_material] = 0.0
        pressure /= float(pressure.sum()) * self.modes.cell_area or 1.0
        np.greater(pressure, 0.0, out=self._contact)
        self._restore_balance(control, pressure)

    def _meet_rig(
        self, separation: FloatArray, control: LoadControl, pressure: FloatArray
    ) -> tuple[Vector, Vector, Vector]:
        """Return the imposed motion by the law of a rig, the part of it that its loads still take, and their change.

        Without a rig the last two are 0.
        """
        if control.compliance is None:
            return control.imposed_displacement, np.zeros(3), np.zeros(3)
        imposed = control.displacement(self.modes.resultants(pressure))
        gaps = self.modes.gap_sums(separation, self.uz[0], imposed, self._contact)
        misfit = -solve_modes(self._gram, gaps, control.fitted_index)
        return imposed, *self.modes.meet_rig(control, misfit, self._gram, self.operator.unit)

    def _rigid_displacement(
        self, separation: FloatArray, control: LoadControl, rigid: Vector, imposed: Vector
    ) -> Vector:
        """Return the rigid displacements, forced ones by least squares of the gap over the contact zone.

        Without contact a forced delta_z lets the surfaces just touch, and forced tilts stay.
        """
        forced = control.forced_index
        found = np.where(control.forced, rigid, imposed)
        if self._gram[0][0]:
            if is_singular(self._gram, forced):
                imposed = found  # a row of cells keeps its tilt
            gaps = self.modes.gap_sums(separation, self.uz[0], imposed, self._contact)
            return imposed + solve_modes(self._gram, gaps, forced)
        found[0] = 0.0
        self.modes.gap(separation, self.uz[0], found, self._contact, self._gap)
        found[0] = self._gap.min() if control.forced[0] else imposed[0]
        return found

    def _update_gap_and_zone(
        self, separation: FloatArray, rigid: Vector, threshold: float, caution: float
    ) -> GapErrors:
        """Compute the gap and return its errors; then let cells join the contact that penetrate.

        caution: part of the deepest penetration that a cell must have to join; 0 for all.
        """
        gap, contact = self._gap, self._contact
        errors = self.modes.gap(separation, self.uz[0], rigid, contact, gap)
        if errors.penetration > threshold * errors.gap_scale:
            deep = max(0.5 * threshold * errors.gap_scale, caution * errors.penetration)
            np.logical_or(contact, gap < -deep, out=contact)
            self._gram = self.modes.gram(contact)
        return errors

    def _rounding(self, separation: FloatArray, rigid: Vector) -> float:
        """Return the rounding error of gaps (mm)."""
        height = float(np.max(np.abs(separation), where=self._contact, initial=0.0))
        elastic = rounding_of(self.operator.dtype) * float(np.abs(self.uz).max())
        return max(elastic, ROUNDING * max(height, abs(float(rigid[0])), self.modes.tilted(rigid)))

    def _unbalance(self, control: LoadControl, pressure: FloatArray) -> float:
        """Return the largest error of an imposed resultant over the load (a moment: times its arm)."""
        if not control.forced_index:
            return 0.0
        if not self._contact.any():
            return np.inf if control.imposed_resultant[1:].any() else 0.0
        found = self.modes.resultants(pressure)
        load = max(float(found[0]), float(control.imposed_resultant[0]))
        if load <= 0.0:
            return np.inf if (found != control.imposed_resultant).any() else 0.0
        return largest_error(found, control, load, self.modes.arms)

    def _prepare_cg(self, control: LoadControl, largest: float, misfit: Vector) -> None:
        """Give CG the gap over its `largest` value (mm), the zone, and the rigid motions of the imposed loads (T10).

        misfit: the motion that the loads of a rig are to take, which has been left out of the gap.
        """
        with np.errstate(over="ignore"):  # outside of the contact, where CG does not look, in single precision
            np.multiply(self._gap, -1.0 / largest, out=self._cg.residual[0], casting="same_kind")
        np.copyto(self._cg.weight, self._contact)
        motions = list(SINGLE_MODES)
        if control.forced[0] and any(control.forced[1:]):
            # With P imposed, tilts may be about the contact's middle: they are not nearly dependent.
            middle_x, middle_y = self.modes.middle(self._contact)
            motions[1:] = (-middle_y, 1.0, 0.0), (-middle_x, 0.0, 1.0)
        springs = springs_of(control, self.modes.cell_area / self.operator.unit)
        self._cg.constrain([motions[mode] for mode in control.forced_index], self.modes.x, self.modes.y, springs)
        if springs is not None:
            self._cg.push(misfit / largest)

    def _release_tension(self, control: LoadControl, pressure: FloatArray) -> None:
        """Open the cells under tension.

        If all others lie on one side of the point where the load acts, the first row of them beyond it stays.
        """
        tension = pressure < 0.0
        if not tension.any():
            return
        pressure[tension] = 0.0
        self._contact &= ~tension
        for axis, places, point, side in self._loaded_sides(control, self._contact):
            beyond = tension.any(axis=axis) & (side * (places - point) >= 0.0)
            if beyond.any():
                nearest = np.argmin(np.where(beyond, np.abs(places - point), np.inf))
                needed = tension & np.expand_dims(np.arange(places.size) == nearest, axis)
                pressure[needed] = float(pressure.max()) or 1.0
                self._contact |= needed
                break
        self._press_on_one_side(control, pressure)
        self._gram = self.modes.gram(self._contact)

    def _loaded_sides(self, control: LoadControl, contact: BoolArray) -> Iterator[tuple[int, Vector, float, int]]:
        """Yield each direction in which the load acts outside of `contact`.

        Yielded are the axis to sum over, the cells' places along the other axis, the place of the load there, and the
        side (-1 or 1) on which it lies.
        """
        load, mx, my = control.imposed_resultant
        for mode, moment, axis, places in ((1, mx, 0, self.modes.y), (2, my, 1, self.modes.x)):
            if not (control.forced[mode] and load > 0.0):
                continue
            ends = places[contact.any(axis=axis)]
            if ends.size:
                point = float(moment / load)
                if not ends.min() <= point <= ends.max():
                    yield axis, places, point, 1 if point > ends.max() else -1

    def _widen(self, control: LoadControl, pressure: FloatArray) -> None:
        """Let neighbours of the cells in contact join, up to where the load acts, if the cells cannot balance it."""
        if not any(self._loaded_sides(control, self._contact)) and not is_singular(self._gram, control.forced_index):
            return
        wider = grown(self._contact)
        while not wider.all() and any(self._loaded_sides(control, wider & ~self._no_material)):
            wider = grown(wider)
        fresh = wider & ~self._contact & ~self._no_material
        pressure[fresh] = float(np.mean(pressure, where=self._contact))
        self._contact |= fresh
        self._gram = self.modes.gram(self._contact)

    def _restore_balance(self, control: LoadControl, pressure: FloatArray) -> None:
        """Add p (a + b y + c x) to the pressure p, so that it has the imposed resultants."""
        forced = control.forced_index
        if not forced:
            return
        gram = self.modes.gram(pressure)
        self.modes.stretch(pressure, solve_modes(gram, self.modes.missing(control, gram[0]), forced))
