"""Print the cycles of a result as a table."""

from __future__ import annotations

import numpy as np

from fretsolve.result.cycles import CycleTable
from fretsolve.result.state import ERROR_SUFFIX

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


def cycle_columns(table: CycleTable) -> list[tuple[str, ...]]:
    """Return the columns of the printed table, line by line: three lines of heading, then the cells."""
    count = len(table)
    rows = np.arange(count)
    if count > MOST_ROWS:
        rows = np.concatenate([rows[:FIRST_ROWS], rows[count - MOST_ROWS + FIRST_ROWS :]])
    found = [("", name, "", *map(str, table.columns[name][rows].tolist())) for name in ("cycle", "stage")]
    for name, heading in HEADINGS.items():
        if _tells(table, name):
            units = table.units[name]
            found.append((*heading, "" if units == "1" else units, *(_cell(table, name, int(row)) for row in rows)))
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


def _cell(table: CycleTable, name: str, row: int) -> str:
    value = table.columns[name][row]
    text = "-" if np.isnan(value) else f"{value:.4g}"
    bar = table.columns[name + ERROR_SUFFIX][row] if name + ERROR_SUFFIX in table.columns else np.nan
    return f"{text} ± {bar:.1e}" if np.isfinite(bar) and bar > 1e-14 * abs(value) else text
