"""A result as a table for people: what ``fretsolve show`` prints."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import IO

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fretsolve.result import Result
from fretsolve.result.state import ERROR_SUFFIX
from fretsolve.setup.accuracy import verdict
from fretsolve.system.arrays import DoubleArray, IndexArray

WIDTH = 120
"""Columns of the report where the output is no terminal, or one that is too narrow for it."""

NARROWEST = 60

NOTHING = 1e-8
"""Below this share of its group's scale a value is round-off: it is printed as 0, a column of it left out."""

ROUNDING = 1e-14
"""Share of a value to which double precision rounds it in a sum or two."""

UNLIKE_THE_OTHER = 1e3
"""A tangential displacement below 1e-6 of the other one is within the usual tolerance: it counts as round-off."""

GAP = 2
"""Blanks between two columns."""

_RESIDUALS = ("residual_gap", "residual_stick", "residual_slip", "residual_bound", "residual_load")
_COLUMNS = (
    *("P", "Mx", "My", "Qx", "Qy", "Mz"),
    *("delta_z", "delta_x", "delta_y", "phi_x", "phi_y", "phi_z"),
    *("contact_radius", "stick_radius", "max_pressure", "max_shear", "work_total"),
)


@dataclass(frozen=True)
class Column:
    """A column as printed: a heading of two lines, the units, the cells."""

    heading: tuple[str, str]
    units: str
    cells: tuple[str, ...]

    @property
    def width(self) -> int:
        return max(len(text) for text in (*self.heading, self.units, *self.cells))


def print_report(
    result: Result, *, heading: bool = True, every_increment: bool = False, file: IO[str] | None = None
) -> None:
    """Print heading, table and totals to `file` (standard output by default), with colour on a terminal."""
    console = Console(file=file, highlight=False)
    if not console.is_terminal or console.width < NARROWEST:
        console = Console(file=file, highlight=False, width=WIDTH)
    for line in summary(result) if heading else []:
        console.print(escape(line), soft_wrap=True)
    for table in history_tables(result, every_increment=every_increment, width=console.width):
        console.print()
        console.print(table)
    errors = error_table(result)
    if errors is not None:
        console.print()
        console.print(errors)
    for line in totals(result):
        console.print(escape(line), soft_wrap=True)


def summary(result: Result) -> list[str]:
    """Lines on what the result is: title, status, case."""
    title = result.effective_case.get("title") or result.path.name
    status = f"{result.status}, {result.increments} increments"
    if "failure" in result.attributes:
        status += f": {result.attributes['failure']}"
    nx, ny = len(result.x), len(result.y)
    return [
        str(title),
        status,
        f"coupling {result.coupling}, grid {nx} x {ny} cells{_area(result)},"
        f" fretsolve {result.attributes['fretsolve_version']}",
    ]


def _area(result: Result) -> str:
    """The sides of the grid in words; nothing where a side of one cell was sized by the loads."""
    asked = result.effective_case.get("grid", {}).get("size")
    given = asked if isinstance(asked, list) else [math.nan, math.nan]
    sides = [
        len(axis) * float(axis[1] - axis[0]) if len(axis) > 1 else float(side)
        for axis, side in zip((result.x, result.y), given, strict=True)
    ]
    return "" if any(map(math.isnan, sides)) else f" on {sides[0]:.4g} x {sides[1]:.4g} mm"


def history_tables(result: Result, *, every_increment: bool = False, width: int = WIDTH) -> list[Table]:
    """The history as one table, or several of at most `width` characters, each with `step` and `stage`.

    One row per end of a stage, or per increment. Columns without anything but round-off are left out.
    """
    rows = np.arange(result.increments) if every_increment else stage_ends(result.history["stage"])
    if not len(rows):
        return []
    fixed = [
        Column(("", name), "", tuple(str(value) for value in result.history[name][rows]))
        for name in ("step", "stage")
    ]
    columns = [
        Column(_heading(name), result.units(name), _cells(result, name, rows))
        for name in relevant_columns(result)
    ]
    residuals = tuple(f"{value:.1e}" for value in worst_residuals(result)[rows])
    columns.append(Column(("worst", "residual"), "1", residuals))
    return [_table(part) for part in _split(fixed, columns, width)]


def totals(result: Result) -> list[str]:
    """Lines on the whole run: certificate, work and cost. Empty where there is no increment."""
    if not result.increments:
        return []
    history = result.history
    worst = worst_residuals(result)
    step = int(worst.argmax())
    name = max(_RESIDUALS, key=lambda residual: history[residual][step])
    applications, seconds = float(history["operator_applications"].sum()), float(history["wall_time"].sum())
    lines = []
    if "coarse_runs_wall_time" in history:
        coarse = float(history["coarse_runs_wall_time"].sum())
        applications += float(history["coarse_runs_applications"].sum())
        seconds += coarse
        lines.append(f"error bars: coarse runs took {100.0 * coarse / seconds:.0f} % of the run")
    reached = verdict(result.effective_case.get("solver", {}), history)
    lines += [] if reached is None else [str(reached)]
    return [
        f"worst residual {worst[step]:.1e} ({name} of increment {step}),"
        f" dissipated work {history['work_total'][-1]:.6g} {result.units('work_total')}",
        f"{applications:.0f} operator applications, {seconds:.3g} {result.units('wall_time')} of wall time",
        *lines,
    ]


def error_table(result: Result) -> Table | None:
    """The last values with their estimated errors, None where the result has none."""
    names = [name for name in relevant_columns(result) if name + ERROR_SUFFIX in result.history]
    if not result.increments or not names:
        return None
    values = [float(result.history[name][-1]) for name in names]
    errors = [float(result.history[name + ERROR_SUFFIX][-1]) for name in names]
    columns = [
        Column(("at the", "end"), "", tuple(names)),
        Column(("", "value"), "", tuple(f"{value:.6g}" for value in values)),
        Column(("estimated", "error"), "", tuple(map(_error, values, errors))),
        Column(("", "units"), "", tuple(result.units(name) for name in names)),
    ]
    return _table(columns)


def _error(value: float, error: float) -> str:
    """An estimated error in the two digits that it deserves; none where it is that of rounding, as of imposed loads."""
    if math.isnan(error):
        return "unknown"
    return f"± {error:.1e}" if abs(error) > ROUNDING * abs(value) else "± 0"


def stage_ends(stage: NDArray[np.int64]) -> IndexArray:
    """Increments after which the stage changes, the last included."""
    return np.flatnonzero(np.append(np.diff(stage) != 0, True))[: len(stage)]


def relevant_columns(result: Result) -> list[str]:
    """Names of the columns that are more than round-off; `P` and `delta_z` always."""
    return [
        name
        for name in _COLUMNS
        if name in ("P", "delta_z")
        or np.abs(result.history[name]).max(initial=0.0) > _round_off(result, name)
    ]


def _round_off(result: Result, name: str) -> float:
    """What counts as 0 in the column `name`: a share of the load or the displacement that goes with it."""
    if not result.increments:
        return 0.0
    force, approach, radius = (
        float(np.abs(result.history[column]).max()) for column in ("P", "delta_z", "contact_radius")
    )
    scales = dict.fromkeys(("Qx", "Qy"), force)
    scales |= dict.fromkeys(("Mx", "My", "Mz"), force * radius)
    sideways = max(float(np.abs(result.history[column]).max()) for column in ("delta_x", "delta_y"))
    scales |= dict.fromkeys(("delta_x", "delta_y"), max(approach, UNLIKE_THE_OTHER * sideways))
    scales |= dict.fromkeys(("phi_x", "phi_y", "phi_z"), approach / radius if radius else 0.0)
    return NOTHING * scales.get(name, 0.0)


def _cells(result: Result, name: str, rows: IndexArray) -> tuple[str, ...]:
    """The values of a column, round-off as 0."""
    nothing = _round_off(result, name)
    return tuple(f"{value:.4g}" if abs(value) > nothing else "0" for value in result.history[name][rows])


def worst_residuals(result: Result) -> DoubleArray:
    """The worst residual of the certificate of each increment, ``(increments,)``."""
    worst: DoubleArray = np.max([result.history[name] for name in _RESIDUALS], axis=0)
    return worst


def _heading(name: str) -> tuple[str, str]:
    """Long names in two lines; those of rigid displacements, which are short, in one."""
    first, _, second = name.rpartition("_")
    return (first, second) if len(second) > 1 and first else ("", name)


def _split(fixed: Sequence[Column], columns: Sequence[Column], width: int) -> list[list[Column]]:
    """As few tables as `width` allows, and of those the ones that are least unequal in width."""
    narrowest = max(column.width + GAP for column in columns)
    room = max(width - sum(column.width + GAP for column in fixed), narrowest)
    fewest = len(_filled(columns, room))
    least = next(less for less in range(narrowest, room + 1) if len(_filled(columns, less)) == fewest)
    return [[*fixed, *part] for part in _filled(columns, least)]


def _filled(columns: Sequence[Column], room: int) -> list[list[Column]]:
    """The columns in order, each part as wide as `room` allows."""
    parts: list[list[Column]] = [[]]
    used = 0
    for column in columns:
        used += column.width + GAP
        if parts[-1] and used > room:
            parts.append([])
            used = column.width + GAP
        parts[-1].append(column)
    return parts


def _table(columns: Sequence[Column]) -> Table:
    table = Table(box=SIMPLE_HEAD, padding=(0, 0, 0, GAP - 1), pad_edge=False, show_edge=False)
    with_units = any(column.units for column in columns)
    for column in columns:
        heading = (*column.heading, column.units) if with_units else column.heading
        table.add_column("\n".join(heading), justify="right", no_wrap=True)
    for row in zip(*(column.cells for column in columns), strict=True):
        table.add_row(*row)
    return table
