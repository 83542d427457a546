"""The table of the last values with their estimated errors, and which of them are next to nothing."""

from __future__ import annotations

import math

from fretsolve.export.selection import relevant_columns, unit_for_people
from fretsolve.result import Result
from fretsolve.result.state import CORRECTED_SUFFIX, ERROR_SUFFIX
from fretsolve.result.verdict import hides_energy, pressing_scales

TINY = 1e-3
"""Value over the one that goes with it, below which error bars have not been compared with true errors."""

SCALE_WORDS = {"Q": "P", "M": "P times the contact radius", "d": "delta_z", "p": "delta_z over the radius"}
"""The scales of such values in words, by the first letters of their names."""

TINY_MARK = "*"
"""Stands before the name of such a value."""

Column = tuple[str, ...]


def error_columns(result: Result) -> list[Column]:
    """Return the columns of the table, line by line: three lines of heading, then the cells.

    They are those as run and, where they differ, those corrected for the number of increments.
    """
    names = _names(result)
    values, errors = zip(*(_last_with_error(result, name) for name in names), strict=True)
    tiny = _tiny_values(result)
    marked = (f"{TINY_MARK} {name}" if name in tiny else name for name in names)
    columns: list[Column] = [("at the", "end", "", *marked), ("", "as run", "", *values)]
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
        f"{TINY_MARK} below a thousandth of {scales}: next to nothing, and unless imposed perhaps off by several times"
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
        name: SCALE_WORDS[name[0]]
        for name in _names(result)
        if name in scales and abs(history[name][-1]) < TINY * scales[name] and history[name + ERROR_SUFFIX][-1] > 0.0
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
