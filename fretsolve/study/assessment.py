"""Errors of the runs, the runs worth their cost, and advice."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.load_components import PAIRS
from fretsolve.study.plan import Plan
from fretsolve.study.quantity import Observable
from fretsolve.study.run_trials import Outcome
from fretsolve.study.trial import Trial
from fretsolve.study.variation import Variation
from fretsolve.system.arrays import DoubleArray

SIGNED = frozenset(name for pair in PAIRS[1:] for name in pair)
"""Load components that go to and fro through 0: their errors are taken over the largest value on the path."""

LEAST_SHARE = 0.1
"""Part of its largest value on the path that any other quantity counts with at least, as where nothing sticks."""


@dataclass(frozen=True, eq=False)
class Row:
    """An outcome, its values and errors ``(n,)``, NaN where there are none, as a truth has no errors.

    best: no other is both cheaper and more accurate.
    """

    outcome: Outcome
    values: DoubleArray
    errors: DoubleArray
    is_truth: bool
    best: bool = False

    @property
    def worst(self) -> float:
        """The largest error; NaN where there is none."""
        return float(self.errors.max()) if self.errors.size else math.nan

    @property
    def compared(self) -> bool:
        """Whether it has errors."""
        return self.errors.size > 0 and bool(np.isfinite(self.errors).all())


@dataclass(frozen=True, eq=False)
class Assessment:
    """The runs by cost. truth: values ``(n,)`` of the observables; truth_words: whose; scales: that errors refer to.

    finest: the finest trial, which is the truth where nothing else is; left_out: observables that are 0 throughout.
    problem_keys: varied keys that change the problem itself. With them the truth is but a reference and the errors are
    changes, none of which is best.
    """

    variations: tuple[Variation, ...]
    problem_keys: tuple[str, ...]
    observables: tuple[Observable, ...]
    left_out: tuple[Observable, ...]
    truth: DoubleArray
    truth_words: str
    scales: DoubleArray
    finest: Trial
    rows: tuple[Row, ...]

    @property
    def difference(self) -> str:
        """What a run's distance from the truth is called."""
        return "change" if self.problem_keys else "error"

    @property
    def standard(self) -> str:
        """What the truth is called."""
        return "reference" if self.problem_keys else "truth"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the observables, each once."""
        return tuple(dict.fromkeys(observable.name for observable in self.observables))

    def error_of(self, row: Row, name: str) -> float:
        """The largest error of a quantity over its stages."""
        return float(max(error for one, error in zip(self.observables, row.errors, strict=True) if one.name == name))

    def stages_of(self, name: str) -> str:
        """The stages at whose ends a quantity is compared, such as ``1,3-6``."""
        stages = sorted(observable.stage for observable in self.observables if observable.name == name)
        groups = itertools.groupby(enumerate(stages), lambda pair: pair[1] - pair[0])
        runs = [[stage for _, stage in group] for _, group in groups]
        return ",".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ",".join(map(str, run)) for run in runs)

    @property
    def truth_is_run(self) -> bool:
        """Whether the truth is one of the runs."""
        return any(row.is_truth for row in self.rows)

    @property
    def finest_row(self) -> Row | None:
        """That of the finest trial, if it has run."""
        return next((row for row in self.rows if row.outcome.trial is self.finest), None)


def assess(plan: Plan, outcomes: Sequence[Outcome]) -> Assessment:
    """Compare `outcomes`, the first of which is that of the finest trial, with the plan's truth."""
    observables, reference = plan.observables, outcomes[0]
    truth = np.array([plan.known[one] for one in observables]) if plan.known is not None else reference.values
    if plan.known is None and reference.failure:
        truth = np.full(len(observables), np.nan)
    shares = [1.0 if one.name in SIGNED else LEAST_SHARE for one in observables]
    peaks = np.max([one.peaks for one in outcomes], axis=0) if reference.failure else reference.peaks
    scales = np.maximum(np.abs(truth), shares * peaks)
    kept = np.flatnonzero(peaks > 0.0).tolist()
    rows = []
    for outcome in sorted(outcomes, key=lambda outcome: outcome.seconds):
        is_truth = plan.known is None and outcome is reference
        errors = np.abs(outcome.values - truth)[kept] / scales[kept]
        if outcome.failure or is_truth:
            errors[:] = np.nan
        rows.append(Row(outcome, outcome.values[kept], errors, is_truth))
    candidates = [row for row in rows if row.compared]
    best = front([row.outcome.seconds for row in candidates], [row.worst for row in candidates])
    marked = {id(row) for row, is_best in zip(candidates, best, strict=True) if is_best and not plan.problem_keys}
    return Assessment(
        plan.variations,
        plan.problem_keys,
        tuple(observables[index] for index in kept),
        tuple(one for index, one in enumerate(observables) if index not in kept),
        truth[kept],
        plan.truth_words,
        scales[kept],
        plan.finest,
        tuple(replace(row, best=id(row) in marked) for row in rows),
    )


def front(costs: Sequence[float], errors: Sequence[float]) -> list[bool]:
    """Which points are on the Pareto front: none that costs no more has an error as small."""
    order = sorted(range(len(costs)), key=lambda index: (costs[index], errors[index]))
    least, found = math.inf, [False] * len(costs)
    for index in order:
        if errors[index] < least:
            least, found[index] = errors[index], True
    return found
