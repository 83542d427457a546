"""The assessment of a study: errors of the runs against the reference, and which runs are worth their cost."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.study.plan import StudyPlan
from fretsolve.study.runs import Outcome
from fretsolve.study.variation import Variation
from fretsolve.sweep.base_case import PreparedCase
from fretsolve.sweep.quantity import StageQuantity
from fretsolve.system.arrays import DoubleArray

SIGNED = frozenset(name for pair in PAIRS[1:] for name in pair)
"""Load components that cycle through 0: their errors are relative to the largest value on the path."""

LEAST_SHARE = 0.1
"""Errors of other quantities are relative to at least this part of the largest value; at full slip none sticks."""


@dataclass(frozen=True, eq=False)
class AssessedRun:
    """An outcome with its values and errors ``(n,)``; NaN if there are none: the reference has no errors.

    best: no other run is both cheaper and more accurate.
    """

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
        """Whether it has errors."""
        return self.errors.size > 0 and bool(np.isfinite(self.errors).all())


@dataclass(frozen=True, eq=False)
class Assessment:
    """The runs by cost. reference: values ``(n,)`` of the quantities; reference_words: whose; scales: of the errors.

    finest: the finest run, which is the reference unless one is known; left_out: quantities that are 0 throughout.
    problem_keys: varied keys that change the problem itself: differences are then changes, not errors.
    """

    variations: tuple[Variation, ...]
    problem_keys: tuple[str, ...]
    quantities: tuple[StageQuantity, ...]
    left_out: tuple[StageQuantity, ...]
    reference: DoubleArray
    reference_words: str
    scales: DoubleArray
    finest: PreparedCase
    rows: tuple[AssessedRun, ...]

    @property
    def difference(self) -> str:
        """What users read for the difference of a run from the reference."""
        return "change" if self.problem_keys else "error"

    @property
    def standard(self) -> str:
        """What users read for the reference: only one of the same problem is a truth."""
        return "reference" if self.problem_keys else "truth"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities, each once."""
        return tuple(dict.fromkeys(quantity.name for quantity in self.quantities))

    def error_of(self, row: AssessedRun, name: str) -> float:
        """Return the largest error of a quantity over its stages."""
        return float(max(error for one, error in zip(self.quantities, row.errors, strict=True) if one.name == name))

    def stages_of(self, name: str) -> str:
        """Return the stages at whose ends a quantity is compared, such as ``1,3-6``."""
        stages = sorted(quantity.stage for quantity in self.quantities if quantity.name == name)
        groups = itertools.groupby(enumerate(stages), lambda pair: pair[1] - pair[0])
        runs = [[stage for _, stage in group] for _, group in groups]
        return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ",".join(map(str, run)) for run in runs)

    @property
    def reference_is_run(self) -> bool:
        """Whether the reference is one of the runs."""
        return any(row.is_reference for row in self.rows)

    @property
    def finest_row(self) -> AssessedRun | None:
        """The row of the finest run, if it has been made."""
        return next((row for row in self.rows if row.outcome.trial is self.finest), None)


def assess(plan: StudyPlan, outcomes: Sequence[Outcome]) -> Assessment:
    """Compare `outcomes`, of which the first is the finest run, with the plan's reference."""
    quantities, finest = plan.quantities, outcomes[0]
    reference = np.array([plan.known[one] for one in quantities]) if plan.known is not None else finest.values
    if plan.known is None and finest.failure:
        reference = np.full(len(quantities), np.nan)
    shares = [1.0 if one.name in SIGNED else LEAST_SHARE for one in quantities]
    peaks = np.max([one.peaks for one in outcomes], axis=0) if finest.failure else finest.peaks
    scales = np.maximum(np.abs(reference), shares * peaks)
    kept = np.flatnonzero(peaks > 0.0).tolist()
    rows = []
    for outcome in sorted(outcomes, key=lambda outcome: outcome.seconds):
        is_reference = plan.known is None and outcome is finest
        errors = np.abs(outcome.values - reference)[kept] / scales[kept]
        if outcome.failure or is_reference:
            errors[:] = np.nan
        rows.append(AssessedRun(outcome, outcome.values[kept], errors, is_reference))
    candidates = [row for row in rows if row.compared]
    best = front([row.outcome.seconds for row in candidates], [row.worst for row in candidates])
    marked = {id(row) for row, is_best in zip(candidates, best, strict=True) if is_best and not plan.problem_keys}
    return Assessment(
        plan.variations,
        plan.problem_keys,
        tuple(quantities[index] for index in kept),
        tuple(one for index, one in enumerate(quantities) if index not in kept),
        reference[kept],
        plan.reference_words,
        scales[kept],
        plan.finest,
        tuple(replace(row, best=id(row) in marked) for row in rows),
    )


def front(costs: Sequence[float], errors: Sequence[float]) -> list[bool]:
    """Return which points are on the Pareto front: no other one that costs as little has an error as small."""
    order = sorted(range(len(costs)), key=lambda index: (costs[index], errors[index]))
    least, found = math.inf, [False] * len(costs)
    for index in order:
        if errors[index] < least:
            least, found[index] = errors[index], True
    return found
