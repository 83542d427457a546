"""The tables of a report below the history, as columns of text: last values with errors, cycles, spots of contact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.dimensions import smaller_unit
from fretsolve.case.history import FEWEST_SPOT_CELLS
from fretsolve.post.export.remarks import Spot
from fretsolve.post.export.selection import first_and_last, relevant_columns, unit_for_people
from fretsolve.result import Result
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX
from fretsolve.result.verdict import hides_energy, pressing_scales

if TYPE_CHECKING:
    from fretsolve.result.cycles.table import CycleTable  # few results have cycles

NEXT_TO_NOTHING = 1e-3
"""Value over the one that goes with it, below which error bars have not been compared with true errors."""

SCALE_WORDS = {
    "Q": "P",
    "M": "P times the contact radius",
    "d": "delta_z",
    "p": "delta_z over the radius",
    "actuator_p": "delta_z over the radius",
    "actuator_": "delta_z or the actuator's largest displacement",
}
"""The scales of such values in words, by the beginnings of their names."""

MARK = "*"
"""Stands before the name of such a value."""

TextColumn = tuple[str, ...]
"""A column as printed, line by line: three lines of heading, of which the last is the unit, and the cells."""


def error_columns(result: Result) -> list[TextColumn]:
    """Return the columns of the table, line by line: three lines of heading, then the cells.

    They are the values as run and, where these differ, the values corrected for the number of increments.
    """
    names = _names(result)
    values, errors = zip(*(_last_with_error(result, name) for name in names), strict=True)
    tiny = _tiny_values(result)
    marked = (f"{MARK} {name}" if name in tiny else name for name in names)
    columns: list[TextColumn] = [("at the", "end", "", *marked), ("", "as run", "", *values)]
    columns.append(("estimated", "error", "", *errors))
    corrected, its_errors = zip(*(_last_with_error(result, name + CORRECTED_SUFFIX) for name in names), strict=True)
    if any(text not in ("", "unknown", value) for text, value in zip(corrected, values, strict=True)):
        columns += [("corrected for", "increments", "", *corrected), ("estimated", "error", "", *its_errors)]
    return [*columns, ("", "units", "", *(unit_for_people(result, name)[0] for name in names))]


def about_tiny_values(result: Result) -> list[str]:
    """Return a line on the values next to nothing, if there are any."""
    if not (tiny := _tiny_values(result)):
        return []
    scales = " or ".join(dict.fromkeys(tiny.values()))
    return [
        f"{MARK} below a thousandth of {scales}: next to nothing, and unless imposed perhaps off by several times"
        " its estimated error"
    ]


def _names(result: Result) -> list[str]:
    found = [name for name in relevant_columns(result) if name + ERROR_SUFFIX in result.history]
    may_hide = "work_total" not in found and "work_total" + ERROR_SUFFIX in result.history
    return [*found, "work_total"] if may_hide and hides_energy(result.history) else found


def _tiny_values(result: Result) -> dict[str, str]:
    """Return the last values that are next to nothing, each with what it is small against, in words."""
    history = result.history
    scales = pressing_scales(history)
    return {
        name: next(words for beginning, words in SCALE_WORDS.items() if name.startswith(beginning))
        for name in _names(result)
        if name in scales
        and abs(history[name][-1]) < NEXT_TO_NOTHING * scales[name]
        and history[name + ERROR_SUFFIX][-1] > 0.0
    }


def _last_with_error(result: Result, name: str) -> tuple[str, str]:
    """Return the last value of a column of the history and its estimated error, empty if there is no such column."""
    if name not in result.history:
        return "", ""
    _, factor = unit_for_people(result, name.removesuffix(CORRECTED_SUFFIX))
    value, error = (factor * float(result.history[column][-1]) for column in (name, name + ERROR_SUFFIX))
    return "unknown" if math.isnan(value) else f"{value:.6g}", _error_text(value, error)


def _error_text(value: float, error: float) -> str:
    """Return an estimated error in two digits; 0 if it is only rounding, as of imposed loads."""
    if not math.isfinite(error):
        return "unknown" if math.isnan(error) else "unbounded"
    return f"± {error:.1e}" if abs(error) > 1e-14 * abs(value) else "± 0"


MOST_CYCLES, FIRST_CYCLES = 12, 2
"""Cycles up to which a table has all, and how many of the first of more, before the last ones."""

MOST_SPOTS = 10
"""Spots of contact that a table has."""

HEADINGS = {
    "dissipated_energy": ("dissipated", "energy"),
    "energy_ratio": ("energy", "ratio"),
    "sliding_ratio": ("sliding", "ratio"),
    "sliding_amplitude": ("sliding", "amplitude"),
    "slip_amplitude": ("local slip", "amplitude"),
    "reversal_stiffness": ("reversal", "stiffness"),
    "force_drift": ("force", "drift"),
    "displacement_drift": ("displacement", "drift"),
    "actuator_energy_ratio": ("energy ratio", "at actuator"),
    "actuator_sliding_ratio": ("sliding ratio", "at actuator"),
    "actuator_sliding_amplitude": ("sliding amplitude", "at actuator"),
    "actuator_reversal_stiffness": ("reversal stiffness", "at actuator"),
    "actuator_displacement_drift": ("displacement drift", "at actuator"),
}


def cycle_columns(table: CycleTable, *, corrected: bool = False) -> list[TextColumn]:
    """Return the columns of the printed table, line by line: three lines of heading, then the cells.

    corrected: of the values corrected for the number of increments, if there are any.
    """
    rows = first_and_last(np.arange(len(table)), MOST_CYCLES, FIRST_CYCLES)
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
    # a drift below a thousandth of the range of its kind is not printed
    return bool((np.abs(values) > 1e-3 * scale).any())


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


def spot_columns(spots: Sequence[Spot]) -> list[TextColumn]:
    """Return the columns of the table of the spots with the largest loads."""
    reach = max(math.sqrt(spot.area) for spot in spots)

    def numbers(name: str, factor: float = 1.0) -> tuple[str, ...]:
        values = [getattr(spot, name) for spot in spots[:MOST_SPOTS]]
        least = 1e-6 * max(abs(value or 0.0) for value in (*values, reach if name in "xy" else 0.0))
        least = max(least, 1e-6 * abs(spots[0].P)) if name in ("Qx", "Qy") else least
        return tuple(_number(value, factor, least) for value in values)

    places = tuple(map(str, range(1, len(spots[:MOST_SPOTS]) + 1)))
    columns: list[TextColumn] = [
        ("", "spot", "", *places),
        ("", "cells", "", *numbers("cells")),
        ("", "area", "mm^2", *numbers("area")),
    ]
    columns += [("", name, "N", *numbers(name)) for name in ("P", "Qx", "Qy")]
    columns.append(("stick", "cells", "%", *numbers("stick", 100.0)))
    columns += [("centre", name, "mm", *numbers(name)) for name in ("x", "y")]
    return columns


def _number(value: float | None, factor: float, least: float) -> str:
    """Return a value times a factor, 0 up to `least`, a dash if it is not known."""
    return "-" if value is None else f"{factor * value:.4g}" if abs(value) > least else "0"


def about_spots(spots: Sequence[Spot]) -> list[str]:
    """Return a line on the number of spots and of spots with few cells, if there are several spots."""
    if len(spots) < 2:
        return []
    small = sum(spot.cells < FEWEST_SPOT_CELLS for spot in spots)
    shown = f", of which the table has the {MOST_SPOTS} with the largest P" if len(spots) > MOST_SPOTS else ""
    few = (
        f"; {small} of them have fewer than {FEWEST_SPOT_CELLS} cells, so that their sizes and loads are rough"
        if small
        else ""
    )
    return [f"{len(spots)} spots of contact at the last increment{shown}{few}"]
