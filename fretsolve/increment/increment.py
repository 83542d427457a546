"""One increment: solved on a window around the contact, proved on the whole grid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.elastic.convolution import RowSpace
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.errors import NotConvergedError
from fretsolve.increment.active_region import FREE_CELLS, Window, window_around
from fretsolve.increment.certificate import Evidence, Examiner, Solution
from fretsolve.increment.grid_hierarchy import Level
from fretsolve.increment.load_checks import require_inside, require_supported
from fretsolve.increment.staggered_iteration import ADVICE, TOO_FEW_DIGITS, Alternation
from fretsolve.increment.working_state import Iterate, Start
from fretsolve.model.grid import LARGE_GRID, Grid
from fretsolve.model.load_path import Increment
from fretsolve.result.state import Certificate, nothing
from fretsolve.solvers.rigid_modes import NormalModes, TangentialModes
from fretsolve.system.arrays import BoolArray, FloatArray, Vector

if TYPE_CHECKING:
    from fretsolve.model.required_terms import Model


MARGIN = 0.3
"""The solvers' own tolerance in units of the case's: their residuals and the certificate's differ a little."""

KEPT_WINDOWS = 2
"""A contact whose extent wavers between two sizes of window needs no new spectra at each increment."""

MOST_PROOFS = 12
"""How often an increment is taken up again after a window too small or a certificate not met."""


@dataclass(frozen=True)
class Solved:
    """A certified increment and what it took. normal, tangential: resultants (P, Mx, My) and (Qx, Qy, Mz).

    operator_applications: those on windows and coarser grids in parts of one on the whole grid, rounded up.
    """

    solution: Solution
    evidence: Evidence
    normal: Vector
    tangential: Vector
    iterations_normal: int
    iterations_tangential: int
    alternations: int
    operator_applications: int


class IncrementSolver:
    """Solvers and operator of one scene: a grid, a model and the undeformed surfaces (nx, ny)."""

    def __init__(
        self,
        grid: Grid,
        separation: FloatArray,
        model: Model,
        tolerance: float,
        max_iterations: int,
        threads: int = 1,
        map_border: BoolArray | None = None,
        precision: type[np.floating] = np.float64,
    ):
        self._map_border = map_border
        self.grid, self.separation, self.model = grid, separation, model
        self.tolerance, self.max_iterations, self._threads = tolerance, max_iterations, ThreadTeam(threads)
        self._space = RowSpace()
        self._precision = precision
        self.level = Level(grid, model, self._threads, self._space, precision)
        self._examiner = Examiner(
            separation, model.friction, NormalModes(grid), TangentialModes(grid), tolerance, model.may_slip, precision
        )
        self._alternations: dict[Window, Alternation] = {}
        self._spent = 0.0
        self._large = grid.nx * grid.ny > LARGE_GRID

    def solve(self, increment: Increment, start: Start) -> Solved:
        """Solve an increment from `start` and prove it.

        Raises SlidingError, ContactLostError, GridEdgeError or NotConvergedError.
        """
        before = self.applications
        require_supported(increment.normal, self.separation, self.grid)
        work = Iterate(np.array(start.pressure, np.float64), self._own(start.shear), start.rigid.copy())
        if start.normal != increment.normal:
            self._estimate(increment, work)
            work.at_start = False
        target = MARGIN * self.tolerance
        expected = work.pressure > 0.0
        free = FREE_CELLS
        for _ in range(MOST_PROOFS):
            alternation, window = self._window_for(expected, free)
            self._pass_in_window(alternation, window, increment, start, work, target)
            expected |= work.pressure > 0.0
            if not window.holds(expected):
                free *= 4
                continue
            if self._single:  # what is stored is what is proved
                work.pressure = _rounded(work.pressure)
                work.shear = _rounded(work.shear) if self.model.may_slip else work.shear
            solution = self._solution(start, work)
            evidence = self._examiner.examine(solution, increment.normal, increment.tangential)
            if evidence.certificate.worst <= self.tolerance:
                require_inside(work.pressure, self.grid, self._map_border)
                return self._solved(solution, evidence, work, math.ceil(round(self.applications - before, 6)))
            rounding = self._examiner.lost_in_rounding(solution, evidence)
            if rounding:
                break
            expected |= evidence.gap < 0.0
            if window.holds(expected):
                target *= MARGIN
        raise NotConvergedError(_unproved(evidence.certificate, self.tolerance, rounding, self._single))

    @property
    def applications(self) -> float:
        """Operator applications so far, in parts of one on the whole grid."""
        inside = sum(
            alternation.level.applications * self._share(window)
            for window, alternation in self._alternations.items()
            if alternation.level is not self.level
        )
        return self.level.applications + inside + self._spent

    def _estimate(self, increment: Increment, work: Iterate) -> None:
        """Pressure from coarser grids, at the shear's normal displacement where it counts."""
        separation = self.separation
        if self.model.terms.normal_tangential_coupling and work.shear.any():
            uz = np.empty_like(work.pressure)
            self.level.operator.normal_from_shear(work.shear, uz)
            separation = np.add(separation, uz, out=uz)
        self.level.estimate_normal(separation, increment.normal, work.pressure, work.rigid[:3])
        self._release(self.level)

    def _release(self, level: Level) -> None:
        """Give back the memory of one part of an increment before the next needs its own."""
        if self._large:
            level.release()
            self._space.release()

    def _share(self, window: Window) -> float:
        """Cells of the window over those of the grid."""
        return window.count / (self.grid.nx * self.grid.ny)

    def _window_for(self, expected: BoolArray, free: int) -> tuple[Alternation, Window]:
        """A window that holds the expected contact, with the solvers on it; those of the last ones are kept."""
        if self.level.coarser is None:
            expected = np.ones_like(expected)  # too small a grid to gain by a part of it
        window = window_around(expected, free)
        alternation = self._alternations.pop(window, None)
        if alternation is None:
            if len(self._alternations) == (1 if self._large else KEPT_WINDOWS):
                before = self.applications
                del self._alternations[next(iter(self._alternations))]
                self._spent += before - self.applications
            whole = window.count == self.grid.nx * self.grid.ny
            level = self.level if whole else Level(
                window.part_of(self.grid), self.model, self._threads, self._space, self._precision
            )
            alternation = Alternation(
                level, self.separation[window.cells], self.model, self.max_iterations, self.tolerance
            )
        self._alternations[window] = alternation
        return alternation, window

    def _pass_in_window(
        self,
        alternation: Alternation,
        window: Window,
        increment: Increment,
        start: Start,
        work: Iterate,
        target: float,
    ) -> None:
        """Run the passes on the window's part of `start` and `work`, and write the tractions back."""
        cells, vectors = window.cells, window.vector_cells
        part_of_start = Start(
            start.pressure[cells],
            start.shear[vectors],
            start.displacement[vectors],
            start.rigid,
            start.normal,
            None if work.at_start or not self._single else -self._moved(start, work)[vectors],
        )
        work.pressure, work.shear = work.pressure[cells].copy(), self._own(work.shear[vectors])
        alternation.run(increment, part_of_start, work, target)
        self._release(alternation.level)
        work.pressure = self._on_whole(work.pressure, cells)
        work.shear = self._on_whole(work.shear, vectors) if self.model.may_slip else nothing((2, *self.grid.shape))

    def _own(self, shear: FloatArray) -> FloatArray:
        """A copy to work in, where there may be shear."""
        return np.array(shear, np.float64) if self.model.may_slip else shear

    def _on_whole(self, part: FloatArray, cells: tuple[slice, ...]) -> FloatArray:
        """A field of a window on the whole grid."""
        whole = np.zeros((*part.shape[:-2], *self.grid.shape))
        whole[cells] = part
        return whole

    def _solution(self, start: Start, work: Iterate) -> Solution:
        """Tractions with their displacements, computed afresh on the whole grid."""
        uz, displacement = np.zeros(self.grid.shape), nothing((2, *self.grid.shape))
        terms, operator = self.model.terms, self.level.operator
        if terms.tangential or terms.normal_tangential_coupling:
            displacement = np.zeros(displacement.shape)
        if self.model.has_shear and (terms.normal_tangential_coupling or work.shear.any()):
            operator.all(work.pressure, work.shear, uz, displacement)
        else:
            operator.normal(work.pressure, uz)
            if terms.normal_tangential_coupling:
                operator.tangential_from_pressure(work.pressure, displacement)
        previous = displacement - self._moved(start, work) if self._single else start.displacement
        if self._large:
            self._space.release()
        motion = work.rigid - start.rigid
        return Solution(work.pressure, work.shear, uz, displacement, work.rigid, motion, previous)

    @property
    def _single(self) -> bool:
        return self._precision is np.float32

    def _moved(self, start: Start, work: Iterate) -> FloatArray:
        """Change (2, nx, ny) of the tangential displacement since the start, from the change of the tractions.

        In single precision the difference of two displacements would have lost it.
        """
        moved, operator = work.shear - start.shear, self.level.operator
        if moved.any():
            operator.tangential(moved, moved)
        if self.model.terms.normal_tangential_coupling:
            sideways = np.empty_like(moved)
            operator.tangential_from_pressure(work.pressure - start.pressure, sideways)
            moved += sideways
        return moved

    def _solved(self, solution: Solution, evidence: Evidence, work: Iterate, applications: int) -> Solved:
        return Solved(
            solution,
            evidence,
            self._examiner.normal.resultants(work.pressure),
            self._examiner.tangential.resultants(work.shear),
            work.iterations_normal,
            work.iterations_tangential,
            work.alternations,
            applications,
        )


def _rounded(field: FloatArray) -> FloatArray:
    """`field` with values that single precision holds."""
    return field.astype(np.float32).astype(np.float64)


def _unproved(certificate: Certificate, tolerance: float, rounding: str, single: bool) -> str:
    """Why an increment is given up; rounding: what keeps it from being any better, if it is that."""
    residuals = {name: getattr(certificate, name) for name in ("gap", "stick", "slip", "bound", "load")}
    name = max(residuals, key=lambda key: residuals[key])
    missed = f"the certificate is not met: residual_{name} is {residuals[name]:.2g}, {tolerance:.2g} is needed"
    if rounding:
        return f"{missed}; the error is {rounding}, so more iterations do not help: loosen solver.tolerance"
    return f"{missed}; {TOO_FEW_DIGITS if single else ''}{ADVICE}"
