"""The assessment of a study: errors of the runs against the reference, and which runs are worth their cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.study.plan import StudyPlan
from fretsolve.sweep.base_case import PreparedCase
from fretsolve.sweep.outcome import Outcome
from fretsolve.sweep.quantity import NAMES, StageQuantity
from fretsolve.system.arrays import DoubleArray

SIGNED = {*(name for pair in PAIRS[1:] for name in pair), *(name for name in NAMES if "_center_" in name)}
"""Quantities that go through 0: components of the load other than the normal one, and middles of the zones."""

ROUNDING = 1e-9
"""Part of the largest value on the path up to which a value counts as 0."""


@dataclass(frozen=True, eq=False)
class AssessedRun:
    """A case and its outcome with values and errors ``(n,)``; NaN if there are none: the reference has no errors.

    best: no other run is both cheaper and more accurate.
    """

    case: PreparedCase
    outcome: Outcome
    values: DoubleArray
    errors: DoubleArray
    is_reference: bool
    best: bool = False

    @property
    def worst(self) -> float:
        """The largest error; NaN if there is none."""
        return float(self.errors.max()) if self.errors.size else math.nan

    @property
    def compared(self) -> bool:
        """True if it has errors."""
        return self.errors.size > 0 and bool(np.isfinite(self.errors).all())


@dataclass(frozen=True, eq=False)
class Assessment:
    """The runs of a plan by cost. reference: values ``(n,)`` of the quantities; scales: of the errors.

    left_out: quantities that are 0 throughout, or of which the reference has no value.
    """

    plan: StudyPlan
    quantities: tuple[StageQuantity, ...]
    left_out: tuple[StageQuantity, ...]
    reference: DoubleArray
    scales: DoubleArray
    rows: tuple[AssessedRun, ...]

    @property
    def difference(self) -> str:
        """The word for the difference of a run from the reference."""
        return "change" if self.plan.problem_keys else "error"

    @property
    def largest(self) -> str:
        """The word for the largest of them."""
        return "largest" if self.plan.problem_keys else "worst"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities, each once."""
        return tuple(dict.fromkeys(quantity.name for quantity in self.quantities))

    def error_of(self, row: AssessedRun, name: str) -> float:
        """Return the largest error of a quantity over the ends of its stages."""
        return self.worst_of(row, name)[0]

    def worst_of(self, row: AssessedRun, name: str) -> tuple[float, int]:
        """Return the largest error of a quantity over the ends of its stages, and the stage."""
        found = [(row.errors[place], one.stage) for place, one in enumerate(self.quantities) if one.name == name]
        place = int(np.argmax([error for error, _ in found]))  # that of NaN, if there is one
        return float(found[place][0]), found[place][1]

    def stages_of(self, name: str) -> list[int]:
        """Return the stages at whose ends a quantity is compared."""
        return [quantity.stage for quantity in self.quantities if quantity.name == name]

    @property
    def finest(self) -> AssessedRun:
        """The finest run, which is made first."""
        return next(row for row in self.rows if row.case is self.plan.cases[0])


def assess(plan: StudyPlan, outcomes: Sequence[Outcome]) -> Assessment:
    """Compare `outcomes` of the first cases of the plan with its reference."""
    quantities, finest = plan.quantities, outcomes[0]
    reference = finest.values if not finest.failure else np.full(len(quantities), np.nan)
    if plan.known is not None:
        reference = np.array([plan.known[one] for one in quantities])
    peaks = np.max([one.peaks for one in outcomes], axis=0) if finest.failure else finest.peaks
    # An error is relative to the value there, or to the largest on the path if the quantity goes through 0, or is 0.
    signs = np.array([one.name in SIGNED for one in quantities])
    scales = np.where(signs | (np.abs(reference) <= ROUNDING * peaks), peaks, np.abs(reference))
    kept = np.flatnonzero((peaks > 0.0) & (np.isfinite(reference) | bool(finest.failure))).tolist()
    rows = []
    for case, outcome in sorted(zip(plan.cases, outcomes, strict=False), key=lambda pair: pair[1].seconds):
        is_reference = plan.known is None and outcome is finest
        errors = np.abs(outcome.values - reference)[kept] / scales[kept]
        if outcome.failure or is_reference:
            errors[:] = np.nan
        rows.append(AssessedRun(case, outcome, outcome.values[kept], errors, is_reference))
    worst = [row.worst if row.compared and not plan.problem_keys else math.inf for row in rows]
    best = front([row.outcome.seconds for row in rows], worst)
    return Assessment(
        plan,
        tuple(quantities[index] for index in kept),
        tuple(one for index, one in enumerate(quantities) if index not in kept),
        reference[kept],
        scales[kept],
        tuple(replace(row, best=is_best) for row, is_best in zip(rows, best, strict=True)),
    )


def front(costs: Sequence[float], errors: Sequence[float]) -> list[bool]:
    """Return which points are on the Pareto front: no other one that costs as little has an error as small."""
    least, found = math.inf, [False] * len(costs)
    for index in sorted(range(len(costs)), key=lambda index: (costs[index], errors[index])):
        if errors[index] < least:
            least, found[index] = errors[index], True
    return found
