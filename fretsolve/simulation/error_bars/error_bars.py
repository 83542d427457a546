"""Error bars: estimates of how far a run's values lie from those of the continuum, and values corrected for increments.

They add three errors as independent ones. The error of the cells follows from coarse runs on half and on a third of the
points per side, by Richardson's extrapolation. Three grids show what two hide when their errors agree by chance, and a
least value stands for what all three hide (`least_errors`). The error of the increments is what other increments
change on the coarsest grid. It is added to the run's values, which gives the corrected ones; a part of it stays in
their error bars. The error of the iteration is the certificate's worst residual.
``benchmarks/calibrate_error_bars.py`` calibrates the constants. docs/error_bar_estimates.md has all rules, and
docs/error_bars.md the outcome.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from fretsolve.case.history import BULK, EXTENTS, PAIRS
from fretsolve.case.models import Case, too_few_points
from fretsolve.errors import CaseError
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import ESTIMATED, State, Summary, SummaryErrors
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.error_bars.coarse_counts import presses_unlike_bodies, sheared_stages
from fretsolve.simulation.error_bars.coarse_runs import CORRECTABLE, FIRST_ORDER, CoarseRuns, values_of
from fretsolve.simulation.error_bars.few_increments import (
    early_edge,
    energy_of_fall,
    pressed_energy,
    pressed_radius,
    sheared_energy,
)
from fretsolve.simulation.error_bars.increment_factors import (
    CORRECTED_LINKED,
    SHIFTED,
    HiddenNearSliding,
    Steps,
    moved_sideways,
)
from fretsolve.simulation.error_bars.least_errors.least_errors import LeastErrors
from fretsolve.simulation.error_bars.missed_motion import (
    NOTHING_MISSED,
    MissedMotion,
    edge_of_unloading,
    of_unloading,
    pressed_up_to,
)
from fretsolve.simulation.error_bars.path_points import at_point
from fretsolve.simulation.error_bars.quantity_estimates import (
    ALL,
    CONTACT,
    LINKED,
    LOAD,
    MX,
    MY,
    ORDER,
    PRESSED,
    SHEAR_LOADS,
    SHOWN,
    SMOOTH_ORDER,
    SMOOTH_SHOWN,
    STICK,
    TOTAL,
    WIDTHS_ALONG_X,
    WORK,
    room,
    width,
)
from fretsolve.simulation.error_bars.shear_path import LEAST_LEFT, TORQUE_ARM, UNSHEARED, ShearPath, share_of_limit
from fretsolve.simulation.simulation import run
from fretsolve.system.arrays import BoolArray, DoubleArray

LIKE_BODIES = 0.5
"""What like bodies add to the order of the dissipated energy: unlike ones slip already as they are pressed, in a
contact that grows."""

LIKE_SHOWN = 0.8
"""Factor on the errors that two grids show of smooth like bodies, whose pressure does not depend on where they slip."""

UNLIKE_BODIES = 0.15
"""What unlike bodies take from the orders of `PRESSED`: their pressure has a kink where slip ends."""


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
    setup = case if isinstance(case, ProblemSetup) else set_up(_with_room(case))
    few = too_few_points(setup.grid.shape[: len(setup.grid.axes)])
    if few is not None:
        raise CaseError(few, ("grid", "points"))
    bars = ErrorBars(setup, history, threads)
    for state in run(setup, start, history, threads):
        errors = bars.of(state)
        failure = bars.failure
        if failure is not None and warn is not None:
            warn(f"no error bars from increment {state.summary.step} on: {failure}")
            warn = None
        yield replace(state, errors=errors)


def _with_room(case: Case) -> Case:
    """Return a case that asks for error bars, whose automatic area leaves room for the coarse runs."""
    solver = case.solver.model_copy(update={"error_bars": True})
    return case if case.solver.error_bars else case.model_copy(update={"solver": solver})


class ErrorBars:
    """The error bars of a problem, summary after summary. history: the summaries so far."""

    def __init__(self, setup: ProblemSetup, history: Sequence[Summary] = (), threads: int = 1):
        self._setup, self._runs = setup, CoarseRuns(setup, threads)
        self._least_errors = LeastErrors.of(setup)
        self._finer = tuple(self._runs.refinement(coarse) for coarse in (self._runs.half, self._runs.third))
        self._summaries: list[Summary] = []
        self._largest, self._shear_path, self._missed = np.zeros(len(ESTIMATED)), ShearPath(), NOTHING_MISSED
        self._at_once, self._frictions = presses_unlike_bodies(setup, 1), frictions_of(setup)
        self._changes_before, self._corrected_totals = np.zeros(len(ESTIMATED)), [0.0]
        self._pressing_stages = sheared_stages(setup).count(False)
        self._pressing_increments = sum(setup.load_path.counts[: self._pressing_stages])
        self._askew, self._near_sliding, self._pressed_energy = False, HiddenNearSliding(), 0.0
        self._path = setup.load_path
        for summary in history:
            self._add(summary)
        if history:
            self._follow(self._path.followed(history))
            # Catch up now: the cost of the increments that are there already is not that of the next one.
            for end in (end for end in self._path.last_steps if end <= history[-1].step):
                self._changes_before = self._largest_change(self._change_by_increments(end, 1.0))
            self._runs.change_by_increments(history[-1].step)
            self._runs.half_less_third(self._runs.point(history[-1].step))

    @property
    def failure(self) -> str | None:
        """Reason why a coarse run stopped, in one line; None if none did."""
        return self._runs.failure()

    def of(self, state: State) -> SummaryErrors:
        """Return the error bars of the state that follows the summaries so far."""
        summary, cost_before = state.summary, self._runs.cost()
        self._add(summary)
        values, imposed, scales = values_of(summary), self._imposed(summary.step), self._scales(summary)
        residuals = np.where(imposed, summary.residual_load, summary.worst_residual)
        cells, iteration = self._cells(state, imposed), residuals * scales
        change = self._change_by_increments(summary.step, FIRST_ORDER)
        # The bars hold it as if all of it were of first order, which the energy of few increments may still be.
        most = self._change_by_increments(summary.step, 1.0)
        safety, corrected_safety = self._steps(summary.step).factors()
        largest_change = self._largest_change(most)
        held = np.where(imposed, most, largest_change)
        if not summary.P:  # without a load there are no moments
            held[[MX, MY]] = most[[MX, MY]]
        linked = np.where(imposed, 0.0, self._linked(most))
        hidden = np.where(imposed, 0.0, self._near_sliding.least(self._largest))
        if self._shear_path.left <= LEAST_LEFT or not summary.P:  # then the loads are those of the friction limit
            most_left = self._left_to_limit(summary)
            held[SHEAR_LOADS] = np.minimum(held[SHEAR_LOADS], np.maximum(np.abs(most[SHEAR_LOADS]), most_left))
            for part in (hidden, linked):
                part[SHEAR_LOADS] = np.minimum(part[SHEAR_LOADS], most_left)
        left = np.where(imposed, safety, corrected_safety) * held
        # The change is a multiple of a difference, which holds the errors of the coarse runs' iteration.
        unsolved = self._runs.magnified(summary.step) * self._runs.tolerance * ((change != 0.0) & ~imposed) * scales
        factor = width(self._setup.model)
        parts = [cells, safety * held, hidden, linked]
        corrected_parts = [cells, left, unsolved, hidden, CORRECTED_LINKED * linked]
        errors, corrected = (
            np.hypot(factor * np.linalg.norm(each, axis=0), iteration) for each in (parts, corrected_parts)
        )
        if self._setup.model.line:  # there the radii are half-widths
            errors[WIDTHS_ALONG_X] = np.maximum(errors[WIDTHS_ALONG_X], errors[[CONTACT, STICK]])
        change[imposed] = 0.0
        if summary.step in self._path.last_steps:
            self._changes_before = largest_change
        self._follow(self._path.after(self._summaries))
        return SummaryErrors(
            *errors.tolist(),
            *(values + change)[CORRECTABLE].tolist(),
            *corrected[CORRECTABLE].tolist(),
            *(self._runs.cost() - cost_before).tolist(),
        )

    @property
    def _before(self) -> Summary | None:
        """The summary of the increment before the last one."""
        return self._summaries[-2] if len(self._summaries) > 1 else None

    def _add(self, summary: Summary) -> None:
        self._summaries.append(summary)
        self._largest = np.fmax(self._largest, np.abs(values_of(summary)))  # NaN stands for the middle of no zone
        pressed = self._least_errors.sheared_by_pressing(summary)
        count = self._setup.load_path.counts[summary.stage - 1]
        carried = self._carried(summary)
        at_edge = math.hypot(
            self._least_errors.energy_at_edge(summary, count),
            energy_of_fall(self._before, summary, share_of_limit(summary, carried)),
        )
        at_edge = min(at_edge, ALL * summary.work)
        self._shear_path = self._shear_path.after(
            summary, carried, pressed, at_edge, count, known=room(self._setup.model)
        )
        if self._setup.model.coupled:
            pressed_alone = summary.stage <= self._pressing_stages
            self._askew = self._askew or (pressed_alone and moved_sideways(summary, carried))
        if self._setup.model.coupled or self._shear_path.turned > UNSHEARED:
            self._near_sliding = self._near_sliding.after(self._shear_path, summary)
        if summary.stage == 1:
            self._pressed_energy = pressed_energy(self._setup.model, summary)
        if summary.stage == self._pressing_stages + 1 and self._shear_path.left > LEAST_LEFT:  # sliding is known
            sheared = sheared_energy(self._setup.model, summary, self._pressing_increments)
            self._pressed_energy = max(self._pressed_energy, sheared)
        middle = self._least_errors.unseen_middle(summary)
        increments = pressed_up_to(self._summaries, float(self._largest[LOAD]))
        edge = max(
            early_edge(self._setup.model, summary, self._pressing_increments),
            edge_of_unloading(self._setup.model, summary, increments),
        )
        radius = max(
            of_unloading(self._setup.model, increments),
            pressed_radius(self._setup.model, summary, self._pressing_increments),
        )
        self._missed = self._missed.after(middle, edge, radius)
        self._missed = self._with_late_contact(summary, count)

    def _with_late_contact(self, summary: Summary, count: int) -> MissedMotion:
        """Return what has been missed, with that of an increment that presses and shears, or pulls a body meanwhile.

        `ShearPath` follows loads in all of them, but not bulk stress; of a single one the coarse runs show no order.
        """
        before = self._before
        modulus = self._setup.model.compliances.contact_modulus
        pulled = self._mismatch(summary, before) * modulus * summary.contact_radius
        if not summary.contact_radius or (count > 1 and not pulled):
            return self._missed
        return self._missed.after_late_contact(before, summary, self._frictions[summary.stage - 1], pulled)

    def _carried(self, summary: Summary) -> float:
        """Return what friction carries at most (N), where it varies by an estimate."""
        limit, shear_limit = self._frictions[summary.stage - 1] * summary.P, self._setup.case.friction.shear_limit
        return limit if shear_limit is None else min(limit, shear_limit * summary.contact_area)

    def _left_to_limit(self, summary: Summary) -> DoubleArray:
        """Return how far Qx, Qy (N) and Mz (N mm) are from the friction limit, (3,), as `ShearPath` adds them up."""
        force = self._shear_path.to_limit * self._carried(summary)
        return force * np.array([1.0, 1.0, summary.contact_radius / TORQUE_ARM])

    def _follow(self, path: LoadPath) -> None:
        """Let the coarse runs leave out the cycles that the run leaves out."""
        if path is not self._path:
            self._runs.leave_out({stage.number for stage in set(self._path.stages) - set(path.stages)})
            self._path = path

    def _imposed(self, step: int) -> BoolArray:
        """Return which of the values the path imposes."""
        increment = self._path.increment(step, self._summaries)
        forced = (*increment.normal.forced, *increment.tangential.forced)
        names = {pair[0] if force else pair[1] for pair, force in zip(PAIRS, forced, strict=True)}
        return np.array([name in names for name in ESTIMATED])

    def _cells(self, state: State, imposed: BoolArray) -> DoubleArray:
        """Return the error of the discretisation."""
        summary = state.summary
        smooth = not (self._least_errors.ends or self._setup.case.friction_varies)
        orders = (SMOOTH_ORDER if smooth else ORDER).copy()
        if self._setup.model.coupled:
            orders[PRESSED] -= UNLIKE_BODIES
        else:
            orders[[WORK, TOTAL]] += LIKE_BODIES
        less_half, less_third = self._finer[0] ** orders - 1.0, self._finer[1] ** orders - 1.0
        apart = less_third - less_half  # 0 where both have as few points as a coarse run may have
        over = np.divide(less_third, apart, out=np.zeros_like(apart), where=apart > 0.0)
        from_third, half_less_third = self._differences(summary.step, over)
        half = (from_third - half_less_third) / less_half
        third = from_third / less_third
        least = self._least_errors.values(state, self._largest, self._shear_path)
        self._missed.add_to(least, summary)
        least[imposed] = 0.0
        shown = SMOOTH_SHOWN * (1.0 if self._setup.model.coupled else LIKE_SHOWN) if smooth else SHOWN
        found: DoubleArray = np.linalg.norm([shown * half, shown * third, least], axis=0)
        return found

    def _differences(self, step: int, over: DoubleArray) -> DoubleArray:
        """Return the differences of `_from_third`, (2, values).

        Those of the energy of an increment are of what is dissipated up to its ends: coarse increments are longer.
        """
        found = np.array(self._from_third(step, over))
        found[:, WORK] = found[:, TOTAL]
        if step:
            found[:, WORK] -= np.array(self._from_third(step - 1, over))[:, TOTAL]
        return found

    def _from_third(self, step: int, over_half_less_third: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        """Return the run's values less those on a third of the points, and those on half less those on a third.

        over_half_less_third: ratio of the two by the orders. After the last increment that the run on a third of the
        points has too, the difference is taken to change by as much of the other one, which is known at all increments;
        where that is none, as both have the same points, values on a third of the points are interpolated.
        """
        here, known = self._runs.point(step), self._runs.last_known(step)
        if not over_half_less_third.any():
            known = here
        from_third = at_point(self._run_values, self._path, known) - self._runs.third_at(known)
        half_less_third = self._runs.half_less_third(here)
        if known != here:
            from_third += over_half_less_third * (half_less_third - self._runs.half_less_third(known))
        return from_third, half_less_third

    def _run_values(self, step: int) -> DoubleArray:
        """Return the run's values after `step`, zeros before the first one."""
        return values_of(self._summaries[step]) if step >= 0 else np.zeros(len(ESTIMATED))

    def _change_by_increments(self, step: int, order: float) -> DoubleArray:
        """Return what infinitely many increments would add to the values; order: of the energy of the first stage."""
        change = self._runs.change_by_increments(step, order)
        change[TOTAL], before = (self._change_of_total(one, order) for one in (step, step - 1))
        change[WORK] = change[TOTAL] - before
        return change

    def _largest_change(self, change: DoubleArray) -> DoubleArray:
        """Return the sizes of a change by the increments, of values that slip shifts at least the largest one at the
        ends of stages so far: later ones may take it back by chance."""
        found: DoubleArray = np.where(SHIFTED, np.maximum(np.abs(change), self._changes_before), np.abs(change))
        return found

    def _change_of_total(self, step: int, order: float) -> float:
        """Return what they would add to all that is dissipated.

        The corrected energy never falls. Bars, which take the first stage as of another order, count all of the change.
        """
        if step < 0:
            return 0.0
        if order != FIRST_ORDER:
            return float(self._runs.change_by_increments(step, order)[TOTAL])
        known = self._corrected_totals
        for at in range(len(known) - 1, step + 1):
            total = self._summaries[at].work_total + float(self._runs.change_by_increments(at, order)[TOTAL])
            known.append(max(total, known[-1]))
        return known[step + 1] - self._summaries[step].work_total

    def _steps(self, step: int) -> Steps:
        """Return what makes the increments up to `step` too long."""
        counts = self._path.counts
        stage = next(place for place, last in enumerate(self._path.last_steps) if step <= last)
        at_once = self._at_once and 1 in counts[1 : stage + 1]
        return Steps(
            alone=counts[stage] == 1,
            pressed_at_once=self._at_once,
            sheared_at_once=at_once,
            coarsest=self._shear_path.coarsest,
            askew=self._askew,
            ends=self._least_errors.ends,
        )

    def _linked(self, change: DoubleArray) -> DoubleArray:
        """Return the least errors by the increments that their change of the dissipated energy lets expect.

        That of this energy is what few increments that press dissipate too much, whatever change is seen.
        """
        total = float(self._largest[TOTAL])
        scales = self._largest.copy()
        # Where few cells of the coarse grid stick, they may be the same ones with more increments.
        scales[STICK] = 0.0 if change[STICK] else scales[CONTACT]
        found: DoubleArray = LINKED * (min(abs(float(change[TOTAL])) / total, 1.0) if total else 0.0) * scales
        found[TOTAL] = self._pressed_energy
        return found

    def _mismatch(self, summary: Summary, before: Summary | None = None) -> float:
        """Return the largest strain by which bulk stress stretches one body more than the other, less that before."""
        bulk = self._setup.model.bulk
        if bulk is None:
            return 0.0
        one, other = (
            bulk.mismatch({name: getattr(row, name) for name in (*BULK[1], *BULK[2])}) if row is not None else 0.0
            for row in (summary, before)
        )
        return float(np.abs(one - other).max())

    def _scales(self, summary: Summary) -> DoubleArray:
        """Return what residuals refer to: load or friction limit, largest displacement of its kind, or the value."""
        half, limit = 0.5 * max(self._setup.grid.size), self._carried(summary)
        normal = max(abs(summary.delta_z), half * abs(summary.phi_x), half * abs(summary.phi_y))
        tangential = max(abs(summary.delta_x), abs(summary.delta_y), half * abs(summary.phi_z))
        if self._setup.model.line:  # whose displacements have a free constant
            normal = tangential = self._setup.model.compliances.A * summary.P
        tangential = max(tangential, self._mismatch(summary) * summary.contact_radius)
        scales = {name: abs(getattr(summary, name)) for name in ESTIMATED}
        scales |= dict.fromkeys(EXTENTS, summary.contact_radius)
        scales |= {"P": summary.P, "Mx": half * summary.P, "My": half * summary.P}
        scales |= {"Qx": limit, "Qy": limit, "Mz": half * limit}
        scales |= {"delta_z": normal, "phi_x": normal / half, "phi_y": normal / half}
        scales |= {"delta_x": tangential, "delta_y": tangential, "phi_z": tangential / half}
        scales |= dict.fromkeys(("work", "work_total"), limit * tangential)
        return np.array([scales[name] for name in ESTIMATED])
