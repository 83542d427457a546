"""The table of a study on the console, and the sentences below it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from fretsolve.case.dimensions import percent
from fretsolve.post.export.report_tables import TextColumn
from fretsolve.sweep.manifest import index_list
from fretsolve.sweep.quantity import ENERGIES, LAST_STAGE, listed, place_of
from fretsolve.sweep.study.assessment import AssessedRun, Assessment

TARGETS = (0.01, 0.001)
"""Errors for which advice is given."""


def two_digits(value: float) -> str:
    """Write a number >= 0 with two digits, without an exponent if it is large."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.0f}" if value >= 9.95 or value == 0.0 else f"{value:#.2g}"


def notes(study: Assessment) -> Iterator[str]:
    """Yield lines on how to read the table."""
    plan, failed = study.plan, list(failures(study))
    if any(row.compared for row in study.rows):
        if plan.problem_keys:
            keys = " and ".join(plan.problem_keys)
            yield f"changes are against {plan.reference_words}; not errors, since {keys} changes the problem itself"
        else:
            yield f"* no other run is both cheaper and more accurate; errors are against {plan.reference_words}"
            if plan.known is None:
                own = "an error of its own, as its bars say" if plan.corrected else "an unknown error of its own"
                yield f"that run has {own}; errors smaller than that mean nothing"
        names_at: dict[str, list[str]] = {}
        for name in study.names:
            if len(stages := study.stages_of(name)) > 1:
                names_at.setdefault(place_of(name, stages), []).append(name)
        if names_at:
            named = [f"{place} ({', '.join(names)})" for place, names in names_at.items()]
            places = named if len(named) > 1 else list(names_at)
            yield f"the {study.difference} of a quantity is the {study.largest} over the ends of {'; '.join(places)}"
    if plan.corrected:
        as_run = ", ".join(dict.fromkeys(one.name for one in study.quantities if plan.column(one) == str(one)))
        but = f", but for {as_run}, which no correction helps" if as_run else ""
        yield f"values are corrected for the number of increments{but}; costs include the coarse runs"
    if study.left_out and len(failed) < len(study.rows):
        unknown = any(np.isnan(study.finest.outcome.values))  # as displacements of a line contact
        yield f"left out, since 0{' or not known' if unknown else ''}: {listed(study.left_out)}"
    yield from failed
    for row in study.rows if study.plan.corrected else ():
        if row.outcome.without_bars and np.isnan(row.values).any():
            yield f"not corrected: {row.words}: {row.outcome.without_bars}"


def failures(study: Assessment) -> Iterator[str]:
    """Yield a line on each case without a solution."""
    for row in study.rows:
        if row.outcome.failure:
            yield f"failed: {row.words}: {row.outcome.failure}"


def advice(study: Assessment) -> Iterator[str]:
    """Yield for each target the cheapest run that meets it in all quantities, how well, and what the choice saves.

    A run meets the target if its errors, as they are shown, are no larger. If only sizes of zones and energies miss it,
    and a run that meets it otherwise costs half as much, a second sentence names it. No advice if the problem itself
    changes.
    """
    targets: dict[str, list[str]] = {}
    for target in TARGETS if any(row.compared for row in study.rows) and not study.plan.problem_keys else ():
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
    # Errors of sizes of zones on coarse grids, and of the energy of pressing, are larger than all others.
    others = [name for name in study.names if not name.endswith(("_radius", "_area")) and name not in ENERGIES]
    relieved = _cheapest(study, target, others) if others else None
    if relieved is not None and (chosen is None or 2.0 * relieved.outcome.seconds <= chosen.outcome.seconds):
        missed = [name for name in study.names if not _meets(study, relieved, target, [name])]
        errors = " and ".join(f"{name} ({_error_and_place(study, relieved, name)})" for name in missed)
        yield f" in all but {errors}: {_praise(study, relieved, others)}"


def _cheapest(study: Assessment, target: float, names: Sequence[str]) -> AssessedRun | None:
    meeting = [row for row in study.rows if row.compared and _meets(study, row, target, names)]
    return min(meeting, key=lambda row: row.outcome.seconds, default=None)


def _meets(study: Assessment, row: AssessedRun, target: float, names: Sequence[str]) -> bool:
    """Return whether the errors, as they are shown, are no larger than the target."""
    return all(float(two_digits(100.0 * study.error_of(row, name))) <= 100.0 * target for name in names)


def _praise(study: Assessment, row: AssessedRun, names: Sequence[str]) -> str:
    worst_first = sorted(names, key=lambda name: -study.error_of(row, name))
    errors = ", ".join(f"{name} within {two_digits(100.0 * study.error_of(row, name))} %" for name in worst_first[:3])
    more = ", the rest closer" if len(worst_first) > 3 else ""
    return f"{row.words}: {errors}{more}; {_saving(study, row)}"


def _error_and_place(study: Assessment, row: AssessedRun, name: str) -> str:
    """Return the error of a quantity, and at the end of which of its stages it is."""
    error, stage = study.worst_of(row, name)
    several = len(study.stages_of(name)) > 1
    return f"{two_digits(100.0 * error)} %" + (f", {place_of(name, [stage])}" if several else "")


def _saving(study: Assessment, row: AssessedRun) -> str:
    cost, finest = f"{two_digits(row.outcome.seconds)} s", study.finest
    if finest is row or finest.outcome.failure or not row.outcome.seconds:
        return cost
    times = finest.outcome.seconds / row.outcome.seconds
    return f"{cost}, " + (f"{two_digits(times)} times" if times >= 1.05 else "no") + " cheaper than the finest run"


def tables(study: Assessment, width: int) -> Iterator[Table]:
    """Yield tables of at most `width` characters, as many as the quantities need; a row per run, by cost."""
    fixed = list(_fixed(study))
    part: list[TextColumn] = []
    for column in _errors(study):
        if part and sum(max(map(len, one)) + 2 for one in (*fixed, *part, column)) > width:
            yield _table(study, [*fixed, *part])
            part = []
        part.append(column)
    yield _table(study, [*fixed, *part])


def key_names(keys: Iterable[str]) -> list[str]:
    """Return the last parts of the varied keys, or the whole key if another one ends alike."""
    last = {key: key.rpartition(".")[2] for key in keys}
    return [name if list(last.values()).count(name) == 1 else key for key, name in last.items()]


def _fixed(study: Assessment) -> Iterator[TextColumn]:
    for index, (name, key) in enumerate(zip(key_names(study.plan.variations), study.plan.variations, strict=True)):
        values = [row.case.settings[key] for row in study.rows]
        if not index:
            width = max(map(len, values))
            marks = ["* " if row.best else " " for row in study.rows]
            values = [f"{mark}{value:>{width}}" for mark, value in zip(marks, values, strict=True)]
        yield "", name, "", *values
    yield "", "time", "s", *(two_digits(row.outcome.seconds) for row in study.rows)


def _errors(study: Assessment) -> Iterator[TextColumn]:
    yield study.largest, study.difference, "%", *(_cell(row, row.worst) for row in study.rows)
    differ = len({tuple(study.stages_of(name)) for name in study.names}) > 1
    for name in study.names:
        first, _, second = name.rpartition("_")
        numbers = [one for one in study.stages_of(name) if one != LAST_STAGE]
        last = ["last"] if LAST_STAGE in study.stages_of(name) else []
        stages, units = f"@{','.join([*([index_list(numbers)] if numbers else []), *last])}", "%"
        if len(second) > 1 and first:
            heading, units = (first, second), f"{stages} %" if differ else "%"
        else:
            heading = name, stages
        yield *heading, units, *(_cell(row, study.error_of(row, name)) for row in study.rows)


def _cell(row: AssessedRun, error: float) -> str:
    if row.outcome.failure:
        return "failed"
    return "reference" if row.is_reference else two_digits(100.0 * error)


def _table(study: Assessment, columns: Sequence[TextColumn]) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 0, 0, 1), pad_edge=False, show_edge=False)
    for column in columns:
        table.add_column("\n".join(column[:3]), justify="right", no_wrap=True)
    for row, *texts in zip(study.rows, *(column[3:] for column in columns), strict=True):
        table.add_row(*map(Text, texts), style="bold" if row.best else None)
    return table
