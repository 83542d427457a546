"""The runs of a study as a table on the console."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from fretsolve.study.assessment import AssessedRun, Assessment
from fretsolve.study.variation import Variation
from fretsolve.study.wording import two_digits

GAP = 2
"""Blanks between two columns."""

BEST = "*"


@dataclass(frozen=True)
class _Column:
    """A heading of three lines, of which the last is the unit, and the cells below it."""

    heading: tuple[str, str, str]
    cells: tuple[str, ...]

    @property
    def width(self) -> int:
        return max(map(len, (*self.heading, *self.cells)))


def tables(study: Assessment, width: int) -> Iterator[Table]:
    """Yield tables of at most `width` characters, as many as the quantities need; a row per run, by cost."""
    fixed = list(_fixed(study))
    part, used = list(fixed), sum(column.width + GAP for column in fixed)
    for column in _errors(study):
        if len(part) > len(fixed) and used + column.width + GAP > width:
            yield _table(study, part)
            part, used = list(fixed), sum(column.width + GAP for column in fixed)
        part.append(column)
        used += column.width + GAP
    yield _table(study, part)


def key_names(variations: Sequence[Variation]) -> list[str]:
    """Return the last parts of the varied keys, or the whole key if another one ends alike."""
    last = [variation.key.rpartition(".")[2] for variation in variations]
    return [name if last.count(name) == 1 else variation.key for name, variation in zip(last, variations, strict=True)]


def _fixed(study: Assessment) -> Iterator[_Column]:
    rows = study.rows
    settings = [row.outcome.trial.settings for row in rows]
    for index, name in enumerate(key_names(study.variations)):
        values = [chosen[index].value for chosen in settings]
        if not index:
            width = max(map(len, values))
            values = [f"{BEST if row.best else ''} {value:>{width}}" for row, value in zip(rows, values, strict=True)]
        yield _Column(("", name, ""), tuple(values))
    yield _Column(("", "time", "s"), tuple(two_digits(row.outcome.seconds) for row in rows))


def _errors(study: Assessment) -> Iterator[_Column]:
    largest = "largest" if study.problem_keys else "worst"
    yield _Column((largest, study.difference, "%"), tuple(_cell(study, row, row.worst) for row in study.rows))
    for name in study.names:
        first, _, second = name.rpartition("_")
        heading = (first, second) if len(second) > 1 and first else (name, f"@{study.stages_of(name)}")
        yield _Column((*heading, "%"), tuple(_cell(study, row, study.error_of(row, name)) for row in study.rows))


def _cell(study: Assessment, row: AssessedRun, error: float) -> str:
    if row.outcome.failure:
        return "failed"
    return study.standard if row.is_reference else two_digits(100.0 * error)


def _table(study: Assessment, columns: Sequence[_Column]) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 0, 0, GAP - 1), pad_edge=False, show_edge=False)
    for column in columns:
        table.add_column("\n".join(column.heading), justify="right", no_wrap=True)
    cells = zip(*(column.cells for column in columns), strict=True)
    for row, texts in zip(study.rows, cells, strict=True):
        table.add_row(*map(Text, texts), style="bold" if row.best else None)
    return table
