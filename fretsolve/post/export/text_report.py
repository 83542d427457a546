"""Print a result as tables: the output of ``fretsolve show``."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import IO, TYPE_CHECKING

import numpy as np

from fretsolve.case.dimensions import cell_counts, counted, in_small_unit
from fretsolve.case.history import moment_sign
from fretsolve.errors import printable
from fretsolve.post.export.remarks import (
    about_rows,
    has_wear,
    may_have_spots,
    rows_of_wear,
    spot_warnings,
    spots_of,
    wear_totals,
    yield_warnings,
)
from fretsolve.post.export.report_tables import (
    FIRST_CYCLES,
    MOST_CYCLES,
    TextColumn,
    about_spots,
    about_tiny_values,
    cycle_columns,
    error_columns,
    spot_columns,
)
from fretsolve.post.export.selection import (
    RESIDUALS,
    first_and_last,
    relevant_columns,
    round_off,
    rows_of_stick_zones,
    total_cost,
    unit_for_people,
)
from fretsolve.result import Result
from fretsolve.result.state import ERROR_SUFFIX, stage_ends
from fretsolve.result.verdict import Verdict, verdict_of, why_no_bars
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.progress import unescaped_output

if TYPE_CHECKING:  # rich takes 50 ms to load
    from rich.console import Console

WIDTH = 120
"""Columns of the report where the output is not a terminal, or one that is too narrow."""

MOST_STAGES, FIRST_STAGES = 60, 6
"""Stages up to which a table has all, and how many of the first of more, before the last ones."""


def report_console() -> Console:
    """Return rich's console for tables: as wide as the terminal, or `WIDTH` if there is none or it is very narrow."""
    from rich.console import Console

    return Console(file=unescaped_output(), highlight=False, width=_width_of(unescaped_output()))


def _width_of(file: IO[str]) -> int:
    width = shutil.get_terminal_size().columns if file.isatty() else WIDTH
    return width if width >= 60 else WIDTH


def print_report(
    result: Result,
    *,
    heading: bool = True,
    every_increment: bool = False,
    columns: Sequence[str] | None = None,
    file: IO[str] | None = None,
    reached: Verdict | None = None,
) -> None:
    """Print heading, tables and totals to `file` (standard output by default), with colour on a terminal.

    columns: of the history, by default the columns above round-off. Without them the last values with their error bars
    have a table, too. reached: the verdict of the rounds on the accuracy, by default of the error bars of the result.
    """
    file = file or unescaped_output()
    width = _width_of(file)
    lines = _summary(result) if heading else []
    tables = history_tables(result, every_increment=every_increment, width=width, columns=columns)
    tables += _cycle_tables(result, width)
    spots = spots_of(result) if may_have_spots(result) else []
    if len(spots) > 1:
        tables.append(_table(spot_columns(spots)))
    if columns is None and "P" + ERROR_SUFFIX in result.history and result.increments:
        tables.append(_table(error_columns(result)))
    for table in tables:
        lines += ["", *table.lines_for(file)]
    warnings = [*spot_warnings(result.history), *yield_warnings(result)] if heading else []
    lines += map(
        printable, (*_totals(result, reached, every_increment=every_increment), *about_spots(spots), *warnings)
    )
    file.write("".join(f"{line}\n" for line in lines))


def _summary(result: Result) -> list[str]:
    title = result.effective_case.get("title") or result.path.name
    status = f"{result.status}, {counted(result.increments, 'increment')}"
    if "failure" in result.attributes:
        status += f": {result.attributes['failure']}"
    grid = f"grid {cell_counts((len(result.x), len(result.y)))} cells{_grid_size(result)}"
    version = result.attributes["fretsolve_version"]
    lines = [str(title), status, f"coupling {result.coupling}, {grid}, fretsolve {version}"]
    return [printable(line) for line in lines]


def _grid_size(result: Result) -> str:
    """Return the sides of the grid in words; nothing if a side has one cell, whose size the loads have set."""
    asked = result.effective_case.get("grid", {}).get("size")
    given = asked if isinstance(asked, list) else [math.nan, math.nan]
    sides = [
        len(axis) * float(axis[1] - axis[0]) if len(axis) > 1 else float(side)
        for axis, side in zip((result.x, result.y), given, strict=True)
    ]
    return "" if any(map(math.isnan, sides)) else f" on {sides[0]:.4g} x {sides[1]:.4g} mm"


def history_tables(
    result: Result, *, every_increment: bool = False, width: int = WIDTH, columns: Sequence[str] | None = None
) -> list[TextTable]:
    """Return the history as one table, or several of at most `width` characters, each with `step` and `stage`.

    One row per end of a stage, of very many the first and the last ones, or per increment; with wear the stages of a
    cycle are left out, of which the row of the change after it tells, with the stick zone at the cycle's end. columns:
    by default all columns above round-off.
    """
    rows = np.arange(result.increments) if every_increment else stage_ends(result.history["stage"])
    if not len(rows):
        return []
    if has_wear(result) and not every_increment:
        rows = rows_of_wear(result, rows)
    if not every_increment:
        rows = first_and_last(rows, MOST_STAGES, FIRST_STAGES)
    fixed = [("", name, "", *map(str, result.history[name][rows].tolist())) for name in ("step", "stage")]
    of_stick = rows_of_stick_zones(result.history)[rows]
    shown: list[TextColumn] = []
    for name in relevant_columns(result) if columns is None else columns:
        least, (unit, factor) = round_off(result, name), unit_for_people(result, name)
        values = result.history[name][of_stick if name.startswith("stick_") else rows]
        cells = ("0" if abs(value) <= least else f"{factor * value:.4g}" for value in values)
        shown.append((*_heading(name), unit, *cells))
    if columns is None:
        shown.append(("worst", "residual", "1", *(f"{value:.1e}" for value in _worst_residuals(result)[rows])))
    return _tables(fixed, shown, width)


def _cycle_tables(result: Result, width: int) -> list[TextTable]:
    """Return tables of cycles of at most `width` characters, as run and with corrected values, if there are any."""
    if (cycles := result.cycles) is None:
        return []
    as_run, corrected = (cycle_columns(cycles, corrected=one) for one in (False, True))
    differ = any(column[3:] not in [one[3:] for one in as_run] for column in corrected)
    return [
        table for one in ((as_run, corrected) if differ else (as_run,)) for table in _tables(one[:1], one[1:], width)
    ]


def _heading(name: str) -> tuple[str, str]:
    stem, _, axis = name.rpartition("_")
    if len(axis) > 1:
        return stem, axis
    first, _, second = stem.rpartition("_")
    return (first, f"{second}_{axis}") if first else ("", name)  # delta_x stays in one line


def _totals(result: Result, reached: Verdict | None, *, every_increment: bool) -> list[str]:
    """Return lines on the whole run: residual, dissipated energy and cost; none if there is no increment."""
    if not result.increments:
        return []
    history, lines = result.history, []
    worst = _worst_residuals(result)
    step = int(worst.argmax())
    name = max(RESIDUALS, key=lambda residual: history[residual][step])
    seconds, applications = total_cost(result)
    before = len(result.rounds_before)
    in_rounds = f" in {before + 1} rounds" if before else ""
    if "coarse_runs_wall_time" in history:
        own, for_errors = (float(history[name].sum()) for name in ("wall_time", "coarse_runs_wall_time"))
        lines.append(f"error bars: coarse runs took {100.0 * for_errors / (own + for_errors):.0f} % of the run")
        lines += about_tiny_values(result)
    lines += [unknown] if (unknown := why_no_bars(history)) else []
    if reached is None and result.status == "complete":
        reached = verdict_of(result.effective_case, history, result.cycle_columns)
        if reached is not None and result.in_rounds:
            reached = replace(reached, advice="", far="")  # `run` says why no round follows
    lines += [] if reached is None else [str(reached)]
    lines += _point_of_load(result)
    lines += wear_totals(result)
    if (cycles := result.cycles) is not None:
        lines += [*cycles.notes, *(outcome for outcome, _ in cycles.outcomes)]
    ends = stage_ends(history["stage"])
    left_out = []
    if not every_increment and len(rows_of_wear(result, ends) if has_wear(result) else ends) > MOST_STAGES:
        left_out.append(f"the table has the first {FIRST_STAGES} and the last stages; --csv prints all")
    if cycles is not None and len(cycles) > MOST_CYCLES:
        left_out.append(f"the table of cycles has the first {FIRST_CYCLES} and the last ones; --json prints all")
    return [
        *left_out,
        *about_rows(result),
        f"worst residual {worst[step]:.1e} ({name} of increment {step}),"
        f" dissipated energy {history['work_total'][-1]:.6g} {result.units('work_total')}",
        f"{applications} operator applications, {seconds:.3g} {result.units('wall_time')} of wall time{in_rounds}",
        *lines,
    ]


def _point_of_load(result: Result) -> list[str]:
    """Return a line on where P acts at the end, if the pressure has a moment about the origin."""
    force, relevant = float(result.history["P"][-1]), relevant_columns(result)
    moments = {name: axis for name, axis in (("My", "x"), ("Mx", "y")) if name in relevant}
    if not force or not moments:
        return []
    places = [
        f"{axis} = {name}/P = {in_small_unit(float(result.history[name][-1]) / force, 4)}"
        for name, axis in moments.items()
    ]
    return [f"at the end P acts at {', '.join(places)}; {moment_sign(list(moments))}"]


def _worst_residuals(result: Result) -> DoubleArray:
    return np.asarray(np.max([result.history[name] for name in RESIDUALS], axis=0))


def _width(column: TextColumn) -> int:
    return 2 + max(map(len, column))


def _tables(fixed: Sequence[TextColumn], columns: Sequence[TextColumn], width: int) -> list[TextTable]:
    """Return `columns` in as few tables as `width` allows, each of which begins with the `fixed` ones.

    Of the ways to split them the most even one is chosen.
    """
    widths = list(map(_width, columns))
    narrowest, most = max(widths), width - sum(map(_width, fixed))
    parts = min((_filled(widths, less) for less in range(narrowest, max(most, narrowest) + 1)), key=len)
    return [_table([*fixed, *(columns[place] for place in part)]) for part in parts]


def _filled(widths: Sequence[int], width: int) -> list[list[int]]:
    """Return the places of columns of some widths in order, each part as wide as `width` allows."""
    parts: list[list[int]] = [[]]
    for place, own in enumerate(widths):
        if parts[-1] and sum(widths[one] for one in parts[-1]) + own > width:
            parts.append([])
        parts[-1].append(place)
    return parts


@dataclass(frozen=True)
class TextTable:
    """A table as lines: those of its heading, which are bold on a terminal, and those below the rule."""

    heading: Sequence[str]
    rows: Sequence[str]

    def lines_for(self, file: IO[str]) -> list[str]:
        """Return all lines as `file` can show them."""
        bold = "\x1b[1m{}\x1b[0m" if file.isatty() and os.environ.get("TERM", "dumb") != "dumb" else "{}"
        encoding = getattr(file, "encoding", None) or "utf-8"
        rule = "\N{BOX DRAWINGS LIGHT HORIZONTAL}" if encoding.lower().startswith("utf") else "-"
        return [*map(bold.format, self.heading), rule * len(self.heading[0]), *self.rows]


def _table(columns: Sequence[TextColumn]) -> TextTable:
    heading_lines = 3 if any(units for _, _, units, *_ in columns) else 2
    cells = []
    for column in columns:
        shown = (*column[:heading_lines], *column[3:])
        width = max(map(len, shown))
        cells.append([cell.rjust(width) for cell in shown])
    lines = list(map("  ".join, zip(*cells, strict=True)))
    return TextTable(lines[:heading_lines], lines[heading_lines:])
