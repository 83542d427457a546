"""Print the cycles of a result as a table."""

from __future__ import annotations

import numpy as np

from fretsolve.case.dimensions import smaller_unit
from fretsolve.result.cycles.table import CycleTable
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX

MOST_ROWS, FIRST_ROWS = 12, 2
"""Cycles up to which all are printed, and how many of the first of more, before the last ones."""

LEAST_DRIFT = 1e-3
"""Least drift over the range of its kind that is printed."""

HEADINGS = {
    "dissipated_energy": ("dissipated", "energy"),
    "energy_ratio": ("energy", "ratio"),
    "sliding_ratio": ("sliding", "ratio"),
    "sliding_amplitude": ("sliding", "amplitude"),
    "slip_amplitude": ("local slip", "amplitude"),
    "reversal_stiffness": ("reversal", "stiffness"),
    "force_drift": ("force", "drift"),
    "displacement_drift": ("displacement", "drift"),
}


def cycle_columns(table: CycleTable, *, corrected: bool = False) -> list[tuple[str, ...]]:
    """Return the columns of the printed table, line by line: three lines of heading, then the cells.

    corrected: of the values corrected for the number of increments, if there are any.
    """
    count = len(table)
    rows = np.arange(count)
    if count > MOST_ROWS:
        rows = np.concatenate([rows[:FIRST_ROWS], rows[count - MOST_ROWS + FIRST_ROWS :]])
    above, suffix = ("corrected", CORRECTED_SUFFIX) if corrected else ("", "")
    numbers = {"cycle": above, "stage": ""}
    found = [(first, name, "", *map(str, table.columns[name][rows].tolist())) for name, first in numbers.items()]
    for name, heading in ((name + suffix, heading) for name, heading in HEADINGS.items()):
        if name in table.columns and _tells(table, name):
            units, factor = _unit(table, name)
            cells = (_cell(table, name, int(row), factor) for row in rows)
            found.append((*heading, "" if units == "1" else units, *cells))
    return found


def _tells(table: CycleTable, name: str) -> bool:
    """Return whether a column has a value, and of a drift one that counts."""
    values = table.columns[name]
    if not np.isfinite(values).any():
        return False
    if not name.endswith("_drift"):
        return True
    scale = np.abs(table.columns[name.replace("_drift", "_range")])
    return bool((np.abs(values) > LEAST_DRIFT * scale).any())


def _unit(table: CycleTable, name: str) -> tuple[str, float]:
    """Return the unit of a column and the factor to it; lengths are displacements, which are in um where small."""
    if table.units[name] != "mm":
        return table.units[name], 1.0
    return smaller_unit("mm", float(np.nan_to_num(np.abs(table.columns[name])).max(initial=0.0)))


def _cell(table: CycleTable, name: str, row: int, factor: float) -> str:
    value = factor * table.columns[name][row]
    text = "-" if np.isnan(value) else f"{value:.4g}"
    bar = factor * table.columns[name + ERROR_SUFFIX][row] if name + ERROR_SUFFIX in table.columns else np.nan
    if np.isinf(bar):
        return f"{text} ± unbounded"
    return f"{text} ± {bar:.1e}" if np.isfinite(bar) and bar > 1e-14 * abs(value) else text
