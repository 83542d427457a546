"""Numbers and sentences about a study."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fretsolve.case.quantities import percent
from fretsolve.study.assessment import AssessedRun, Assessment
from fretsolve.study.variation import words

TARGETS = (0.01, 0.001)
"""Errors for which advice is given."""

ZONE_SIZES = ("contact_radius", "stick_radius", "contact_area", "stick_area")
"""Sizes of zones: on coarse grids their errors are larger than those of all else."""

MUCH_CHEAPER = 2.0
"""Ratio of costs for which a run is named that misses the target in the sizes of zones only."""

MOST_NAMED = 3
"""Quantities that a sentence of advice names, worst first."""


def two_digits(value: float) -> str:
    """Write a number >= 0 with two digits, without an exponent if it is large."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.0f}" if value >= 9.95 or value == 0.0 else f"{value:#.2g}"


def notes(study: Assessment) -> Iterator[str]:
    """Yield lines on how to read the table."""
    compared = any(row.compared for row in study.rows)
    if compared and study.problem_keys:
        keys = " and ".join(study.problem_keys)
        yield f"changes are against {study.reference_words}; not errors, since {keys} changes the problem itself"
    elif compared:
        yield f"* no other run is both cheaper and more accurate; errors are against {study.reference_words}"
    if compared and study.reference_is_run and not study.problem_keys:
        yield "that run has an unknown error of its own; errors smaller than that mean nothing"
    if study.left_out and not all(row.outcome.failure for row in study.rows):
        yield f"left out, since 0: {', '.join(map(str, study.left_out))}"
    for row in study.rows:
        if row.outcome.failure:
            yield f"failed: {words(row.outcome.trial.settings)}: {row.outcome.failure}"


def advice(study: Assessment) -> Iterator[str]:
    """Yield for each target the cheapest run that meets it in all quantities, how well, and what that saves.

    A run meets the target if its errors, as they are shown, are no larger. If only the size of a zone misses it, and a
    run that meets it otherwise is much cheaper, a second sentence names that. No advice if the problem itself changes.
    """
    targets: dict[str, list[str]] = {}
    for target in TARGETS if any(row.compared for row in study.rows) and not study.problem_keys else ():
        for sentence in _advice_for(study, target):
            targets.setdefault(sentence, []).append(percent(target))
    for sentence, met in targets.items():
        yield f"for {' and '.join(met)}{sentence}"


def _advice_for(study: Assessment, target: float) -> Iterator[str]:
    """Yield what follows the target's name in a sentence."""
    chosen = _cheapest(study, target, study.names)
    if chosen is not None:
        yield f": {_praise(study, chosen, study.names)}"
    else:
        nearest = min((row for row in study.rows if row.compared), key=lambda row: row.worst)
        yield f": no other run meets it; the nearest is {_praise(study, nearest, study.names)}"
    others = [name for name in study.names if name not in ZONE_SIZES]
    relieved = _cheapest(study, target, others) if others else None
    if relieved is not None and (chosen is None or MUCH_CHEAPER * relieved.outcome.seconds <= chosen.outcome.seconds):
        missed = [name for name in study.names if not _meets(study, relieved, target, [name])]
        errors = " and ".join(f"{name} ({two_digits(100.0 * study.error_of(relieved, name))} %)" for name in missed)
        yield f" in all but {errors}: {_praise(study, relieved, others)}"


def _cheapest(study: Assessment, target: float, names: Sequence[str]) -> AssessedRun | None:
    """Return the cheapest run that meets the target in the quantities `names`."""
    meeting = [row for row in study.rows if row.compared and _meets(study, row, target, names)]
    return min(meeting, key=lambda row: row.outcome.seconds, default=None)


def _meets(study: Assessment, row: AssessedRun, target: float, names: Sequence[str]) -> bool:
    """Return whether the errors, as they are shown, are no larger than the target."""
    return all(float(two_digits(100.0 * study.error_of(row, name))) <= 100.0 * target for name in names)


def _praise(study: Assessment, row: AssessedRun, names: Sequence[str]) -> str:
    worst_first = sorted(names, key=lambda name: -study.error_of(row, name))
    errors = ", ".join(
        f"{name} within {two_digits(100.0 * study.error_of(row, name))} %" for name in worst_first[:MOST_NAMED]
    )
    more = ", the rest closer" if len(worst_first) > MOST_NAMED else ""
    return f"{words(row.outcome.trial.settings)}: {errors}{more}; {_saving(study, row)}"


def _saving(study: Assessment, row: AssessedRun) -> str:
    cost = f"{two_digits(row.outcome.seconds)} s"
    finest = study.finest_row
    if finest is None or finest is row or finest.outcome.failure or not row.outcome.seconds:
        return cost
    times = finest.outcome.seconds / row.outcome.seconds
    return f"{cost}, " + (f"{two_digits(times)} times" if times >= 1.05 else "no") + " cheaper than the finest run"
