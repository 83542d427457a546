"""Error bars: estimates of how far a run's values lie from the continuum's values, and values corrected for increments.

A bar is the root of the squares of four errors: of the cells, as coarse runs on half and on a third of the points per
side show it by Richardson's extrapolation of first order; a least one for what all grids hide (`floors`); of the
increments, as other ones change the values on the coarsest grid; of the iteration, by the certificate. The change by
the increments is added to the run's values, which gives the corrected ones. What belongs to a rig follows from motions
of the contact and loads, and has the sum of their errors. docs/error_bars.md has the outcome of
``benchmarks/calibrate_error_bars.py``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import accumulate

import numpy as np

from fretsolve.case.history import ACTUATORS, BULK, EXTENTS, TANGENTIAL
from fretsolve.case.models import Case, too_few_points
from fretsolve.errors import CaseError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.rig import MOTIONS, RESULTANTS, Rig
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.history import History
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX, ESTIMATED, State, Summary, SummaryErrors
from fretsolve.result.verdict import LEFT_OVER
from fretsolve.simulation.error_bars.coarse_runs import (
    CORRECTABLE,
    TOTAL,
    CoarseRuns,
    at_point,
    slipping_stages,
    values_of,
)
from fretsolve.simulation.error_bars.floors import Cells, ShearPath, floors, hidden_in_annulus, torque_arm
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import BoolArray, DoubleArray

INCREMENTS = 2.0
"""Factor on the error of the increments that coarse runs show, doubled where a stage has one increment. Errors of first
order would take 1."""

LINKED = 0.1
"""Least relative error of tangential values and of the stick radius over the energy's error by the increments."""

PRESSED = 0.3
"""Least relative error of the energy of dissimilar bodies over k^(-3/2) with the fewest increments k of a stage so far:
they slip as they are pressed, and few increments and twice as many hide alike what pressing leaves in the surfaces."""

SLIDING = 0.01
"""Part of the friction limit that is left, up to which loads cannot err by more than this part."""

STICK, WORK = map(ESTIMATED.index, ("stick_radius", "work"))
SHEAR_LOADS = [ESTIMATED.index(name) for name in ("Qx", "Qy", "Mz")]
MOVED = np.array([name in TANGENTIAL for name in ESTIMATED])
REMEMBERED = MOVED | np.isin(ESTIMATED, ("Mx", "My", "work_total"))
"""Places in `ESTIMATED`: of tangential loads and motions, and of all values to which slip adds in each increment. Their
error at a reversal stays, even if later increments hide it by chance."""


OF_LOADS, OF_MOTIONS = ([ESTIMATED.index(name) for name in names] for names in (RESULTANTS, MOTIONS))
IN_RIG = frozenset(ACTUATORS.values())


def frictions_of(setup: ProblemSetup) -> list[float]:
    """Return the coefficient of friction in each stage, an estimate where it varies by place or with slip."""
    own = setup.case.friction.coefficient
    friction, found = own if isinstance(own, float) else setup.model.friction, []
    for stage in setup.case.stages():
        friction = dict(stage.targets).get("friction", friction)
        found.append(friction)
    return found


def run_with_error_bars(
    case: Case | ProblemSetup,
    start: State | None = None,
    history: Sequence[Summary] = (),
    threads: int = 1,
    warn: Callable[[str], object] | None = None,
) -> Iterator[State]:
    """Solve `case` as `run` does, and yield each state with its error bars.

    If a coarse run has no solution, the error bars are NaN from there on, and `warn` is called with one line.
    Raises NoSolutionError if the run itself has none, and CaseError on too few points for coarse runs.
    """
    if not isinstance(case, ProblemSetup) and not case.solver.error_bars:  # an automatic area leaves room for them
        case = case.model_copy(update={"solver": case.solver.model_copy(update={"error_bars": True})})
    setup = case if isinstance(case, ProblemSetup) else set_up(case)
    few = too_few_points(setup.grid.shape[: len(setup.grid.axes)])
    if few is not None:
        raise CaseError(few, ("grid", "points"))
    history = history if isinstance(history, History) else History(history)
    bars = ErrorBars(setup, history, threads)
    for state in run(setup, start, history, threads):
        errors = bars.of(state)
        failure = bars.runs.failure()
        if failure is not None and warn is not None:
            warn(f"no error bars from increment {state.summary.step} on: {failure}")
            warn = None
        yield replace(state, errors=errors)


class ErrorBars:
    """The error bars of a problem, summary after summary. runs: the coarse ones.

    history: the summaries so far, to which the run adds each one before its error bars are asked for.
    """

    def __init__(self, setup: ProblemSetup, history: History, threads: int = 1):
        self._setup, self.runs, self._cells = setup, CoarseRuns(setup, threads), Cells.of(setup)
        self._finer = tuple(self.runs.refinement(coarse) for coarse in (self.runs.half, self.runs.third))
        self._summaries = history
        self._largest, self._shear_path, self._in_annuli = np.zeros(len(ESTIMATED)), ShearPath(), 0.0
        self._pressed, self._remembered, self._corrected_totals = 0.0, np.zeros(len(ESTIMATED)), [0.0]
        self._frictions, self._path = frictions_of(setup), setup.load_path
        # up to each stage the fewest increments of one in which something may slip; once one does, all later ones do
        counts, first = setup.load_path.counts, slipping_stages(setup).count(False)
        self._fewest = [*counts[:first], *accumulate(counts[first:], min)]
        for summary in history:
            self._add(summary)
        if history:
            self._follow(self._path.followed(history))
            # Catch up now: the next increment is not charged with the cost of the increments that are there already.
            for end in (end for end in self._path.last_steps if end <= history[-1].step):
                self._remember(self._change_by_increments(end))
            self._change_by_increments(history[-1].step)
            self.runs.half_less_third(self.runs.point(history[-1].step))

    def of(self, state: State) -> SummaryErrors:
        """Return the error bars of the state that follows the summaries so far."""
        summary, cost_before = state.summary, self.runs.cost()
        self._add(summary)
        values, imposed = values_of(summary), self._imposed(summary.step)
        residuals = np.where(imposed, summary.residual_load, summary.worst_residual)
        iteration = residuals * self._scales(summary)
        largest = dict(zip(ESTIMATED, self._largest.tolist(), strict=True))
        least = floors(self._cells, state, largest, self._shear_path, self._in_annuli)
        change = self._change_by_increments(summary.step)
        held = np.maximum(np.abs(change), self._remembered if summary.P else 0.0)
        if self._path.ends_stage(summary.step):
            self._remember(change)
        held *= INCREMENTS * (1.0 + 1.0 / self._fewest[summary.stage - 1])
        parts = np.array([self._by_cells(summary.step), least, self._linked(change), held])
        if self._shear_path.left <= SLIDING or not summary.P:  # then the friction limit gives the loads
            left = self._shear_path.left * self._carried(summary) * np.array([1.0, 1.0, torque_arm(summary)])
            parts[:, SHEAR_LOADS] = np.minimum(parts[:, SHEAR_LOADS], left)
            change[SHEAR_LOADS] = np.clip(change[SHEAR_LOADS], -left, left)
        parts[:, imposed] *= 0.0  # where a coarse run has failed, it stays NaN
        change[imposed] = 0.0
        errors, corrected = (
            np.hypot(np.linalg.norm([*parts[:2], *(left * parts[2:])], axis=0), iteration) for left in (1.0, LEFT_OVER)
        )
        self._follow(self._path.after(self._summaries))
        rig = self._setup.model.rig
        return SummaryErrors(
            *errors.tolist(),
            *(values + change)[CORRECTABLE].tolist(),
            *corrected[CORRECTABLE].tolist(),
            *(self.runs.cost() - cost_before).tolist(),
            **({} if rig is None else self._of_rig(rig, values + change, errors, corrected)),
        )

    def _of_rig(
        self, rig: Rig, values: DoubleArray, errors: DoubleArray, errors_of_values: DoubleArray
    ) -> dict[str, float]:
        """Return the columns of the rig; values: corrected; errors: of the values as run, and of the corrected ones."""
        summary = self._summaries[-1]
        as_run = np.array([getattr(summary, name) for name in RESULTANTS])
        held = {name: getattr(summary, name) for name in IN_RIG & self._path.imposed_at(summary.step)}
        motions, loads = values[OF_MOTIONS], values[OF_LOADS]
        found = rig.actuator(motions, loads) | held | {"spring_energy": rig.energy(loads)}
        columns = {name + CORRECTED_SUFFIX: value for name, value in found.items()}
        for suffix, forces, bars in (("", as_run, errors), (CORRECTED_SUFFIX, loads, errors_of_values)):
            at_rig = rig.errors(forces, bars[OF_MOTIONS], bars[OF_LOADS]) | dict.fromkeys(held, 0.0)
            columns |= {name + suffix + ERROR_SUFFIX: value for name, value in at_rig.items()}
        return columns

    def _add(self, summary: Summary) -> None:
        self._largest = np.fmax(self._largest, np.abs(values_of(summary)))  # NaN stands for the middle of no zone
        count = self._setup.load_path.counts[summary.stage - 1]
        self._shear_path = self._shear_path.after(summary, self._carried(summary), count)
        self._in_annuli += hidden_in_annulus(self._cells, summary)
        if self._shear_path.left > SLIDING:  # what slides is known
            self._pressed += self._few(summary) * summary.work

    def _carried(self, summary: Summary) -> float:
        """Return what friction carries at most (N), where it varies by an estimate."""
        limit, shear_limit = self._frictions[summary.stage - 1] * summary.P, self._setup.case.friction.shear_limit
        return limit if shear_limit is None else min(limit, shear_limit * summary.contact_area)

    def _follow(self, path: LoadPath) -> None:
        """Let the coarse runs leave out the cycles that the run leaves out."""
        if path is not self._path:
            self.runs.leave_out({stage.number for stage in set(self._path.stages) - set(path.stages)})
            self._path = path

    def _imposed(self, step: int) -> BoolArray:
        """Return which values are imposed: neither load nor motion where the actuator is, unless the rig is rigid."""
        names, rig = set(self._path.imposed_at(step)), self._setup.model.rig
        if rig is not None:
            rigid = zip(ACTUATORS.items(), rig.compliance, strict=True)
            names |= {motion for (motion, actuator), row in rigid if actuator in names and not row.any()}
        return np.array([name in names for name in ESTIMATED])

    def _by_cells(self, step: int) -> DoubleArray:
        """Return the larger error of the cells that a coarse grid shows, if it is of first order.

        What an increment dissipates is compared by what is dissipated up to its ends: coarse increments are longer.
        """
        found = np.array(self._differences(step))
        found[:, WORK] = found[:, TOTAL]
        if step:
            found[:, WORK] -= np.array(self._differences(step - 1))[:, TOTAL]
        return np.asarray(np.max(np.abs(found) / (np.array(self._finer)[:, None] - 1.0), axis=0))

    def _differences(self, step: int) -> tuple[DoubleArray, DoubleArray]:
        """Return the run's values less the values on half and on a third of the points.

        After the last increment that the run on a third of the points has too, its difference is taken to change in
        proportion to the difference of the coarse runs, by first order. The latter is known at all increments. Where
        both have the same points, values on a third of the points are interpolated.
        """
        half, third = self._finer
        over = (third - 1.0) / (third - half) if third > half else 0.0
        here = self.runs.point(step)
        known = self.runs.last_known(step) if over else here
        from_third = at_point(self._run_values, self._path, known) - self.runs.third_at(known)
        half_less_third = self.runs.half_less_third(here)
        if known != here:
            from_third += over * (half_less_third - self.runs.half_less_third(known))
        return from_third - half_less_third, from_third

    def _run_values(self, step: int) -> DoubleArray:
        return values_of(self._summaries[step]) if step >= 0 else np.zeros(len(ESTIMATED))

    def _change_by_increments(self, step: int) -> DoubleArray:
        """Return what infinitely many increments would add to the values."""
        change = self.runs.change_by_increments(step)
        change[TOTAL], before = (self._change_of_total(one) for one in (step, step - 1))
        change[WORK] = change[TOTAL] - before
        return change

    def _remember(self, change: DoubleArray) -> None:
        """Keep the largest change by the increments at an end of a stage, along x and y alike."""
        sizes = dict(zip(ESTIMATED, np.abs(change).tolist(), strict=True))
        for one, other in (("Qx", "Qy"), ("delta_x", "delta_y")):
            known = [size for size in (sizes[one], sizes[other]) if not math.isnan(size)]  # delta_y of a line is not
            sizes[one] = sizes[other] = math.hypot(*known)
        found = np.where(REMEMBERED, list(sizes.values()), 0.0)
        self._remembered = np.maximum(self._remembered, found)

    def _change_of_total(self, step: int) -> float:
        """Return what they would add to all that is dissipated: the corrected energy never falls."""
        if step < 0:
            return 0.0
        known = self._corrected_totals
        for at in range(len(known) - 1, step + 1):
            total = self._summaries[at].work_total + float(self.runs.change_by_increments(at)[TOTAL])
            known.append(max(total, known[-1]))
        return known[step + 1] - self._summaries[step].work_total

    def _few(self, summary: Summary) -> float:
        return PRESSED / self._fewest[summary.stage - 1] ** 1.5 if self._setup.model.coupled else 0.0

    def _linked(self, change: DoubleArray) -> DoubleArray:
        """Return the least errors by the increments: of the energy, and of what its change lets expect."""
        summary, total = self._summaries[-1], float(self._largest[TOTAL])
        shown = min(abs(float(change[TOTAL])) / total, 1.0) if total else 0.0
        scales = np.where(MOVED, self._largest, 0.0)
        scales[STICK] = summary.contact_radius
        found: DoubleArray = LINKED * math.hypot(shown, self._few(summary)) * scales
        found[[TOTAL, WORK]] = self._pressed, min(self._few(summary) * summary.work, self._pressed)
        return found

    def _scales(self, summary: Summary) -> DoubleArray:
        """Return what residuals refer to: load or friction limit, largest displacement of its kind, or the value."""
        half, limit = 0.5 * max(self._setup.grid.size), self._carried(summary)
        normal = max(abs(summary.delta_z), half * abs(summary.phi_x), half * abs(summary.phi_y))
        tangential = max(abs(summary.delta_x), abs(summary.delta_y), half * abs(summary.phi_z))
        if self._setup.model.line:  # whose displacements have a free constant
            pair, mean = self._setup.model.compliances, 0.5 * summary.P / (summary.contact_radius or math.inf)
            normal, tangential = (pair.A * summary.P + layer * mean for layer in (pair.layer_normal, pair.layer_shear))
        if self._setup.model.bulk is not None:  # which stretches one body more than the other
            stresses = {name: getattr(summary, name) for name in (*BULK[1], *BULK[2])}
            strain = float(np.abs(self._setup.model.bulk.mismatch(stresses)).max())
            tangential = max(tangential, strain * summary.contact_radius)
        scales = {name: abs(getattr(summary, name)) for name in ESTIMATED}
        scales |= dict.fromkeys(EXTENTS, summary.contact_radius)
        scales |= {"P": summary.P, "Mx": half * summary.P, "My": half * summary.P}
        scales |= {"Qx": limit, "Qy": limit, "Mz": half * limit}
        scales |= {"delta_z": normal, "phi_x": normal / half, "phi_y": normal / half}
        scales |= {"delta_x": tangential, "delta_y": tangential, "phi_z": tangential / half}
        scales |= dict.fromkeys(("work", "work_total"), limit * tangential)
        return np.array([scales[name] for name in ESTIMATED])
