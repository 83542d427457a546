"""Pictures of a sweep: a quantity as curves or as a map over the settings, and the running condition."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas, one_line
from fretsolve.plots.labels import MOST_INCREMENTS, MOST_NAMED, line_colors, marks, physical_name, readable, symbol
from fretsolve.sweep.quantity import LAST_STAGE
from fretsolve.sweep.table import Column, Table
from fretsolve.system.arrays import DoubleArray, IndexArray

CONDITIONS: dict[str, dict[str, Any]] = {
    "stick": {"marker": "^", "color": "0.5"},
    "partial slip": {"marker": "o", "color": "#3b528b"},
    "gross slip": {"marker": "s", "color": "#d95f02"},
    "no solution": {"marker": "x", "color": "black"},
}
"""Marker and colour of each running condition, in the order in which they follow each other under growing shear."""

SLIP_CONDITIONS = tuple(CONDITIONS)[:-1]
"""Those with a region of their own in the map."""


def curve(table: Table, quantity: str, over: str, ax: Target = None) -> Figure:
    """Draw a quantity over a varied key, with error bars if there are any; a line for each value of the other keys.

    Raises PictureError.
    """
    x, y = _numbers(table, over), _found(table, quantity)
    errors = next((column for column in table.errors if column.name == f"{quantity} error"), None)
    unit = readable(y.units, y.values)
    groups = _groups(table, over)
    with _panel(ax, table, x, f"{_in_words(quantity)} ({unit.text})") as (sheet, axes):
        for (name, rows), mark in zip(groups.items(), marks(len(groups)), strict=True):
            order = rows[np.argsort(x.values[rows], kind="stable")]
            options = mark.options(len(order), MOST_INCREMENTS) | ({"label": name} if name else {})
            bars = unit.factor * _bounded(errors.values[order]) if errors is not None else None
            axes.errorbar(x.values[order], unit.factor * y.values[order], yerr=bars, capsize=2.0, **options)
        if 1 < len(groups) <= MOST_NAMED:
            sheet.legend(axes.get_legend_handles_labels()[0], 2)
    return sheet.figure


def _bounded(bars: DoubleArray) -> DoubleArray:
    """Return error bars with NaN for those without a bound, which cannot be drawn."""
    return np.where(np.isinf(bars), np.nan, bars)


def surface(table: Table, quantity: str, over: Sequence[str], ax: Target = None) -> Figure:
    """Draw a quantity as colours over two varied keys, crosses where it has no value. Raises PictureError."""
    x, y, z = _numbers(table, over[0]), _numbers(table, over[1]), _found(table, quantity)
    known = np.isfinite(z.values)
    others = [one.name for one in table.settings if one.name not in over and not _follows(one, x, y)]
    if others and len(set(zip(x.values.tolist(), y.values.tolist(), strict=True))) < len(table.states):
        raise PictureError(f"{', '.join(others)} varies as well, so a point has several values")
    unit = readable(z.units, z.values)
    with _panel(ax, table, x, y) as (sheet, axes):
        columns, rows = np.unique(x.values), np.unique(y.values)
        if len(columns) * len(rows) == len(z.values) and min(len(columns), len(rows)) > 1:
            values = np.full((len(rows), len(columns)), np.nan)
            values[np.searchsorted(rows, y.values), np.searchsorted(columns, x.values)] = unit.factor * z.values
            colors: Any = axes.pcolormesh(columns, rows, values, shading="nearest", cmap=line_colors())
        else:
            colored = unit.factor * z.values[known]
            colors = axes.scatter(x.values[known], y.values[known], c=colored, cmap=line_colors(), s=30.0)
        axes.plot(x.values[~known], y.values[~known], linestyle="", marker="x", color="black")
        sheet.colorbar(axes, colors, f"{_in_words(quantity)} ({unit.text})")
    return sheet.figure


def running_condition_map(table: Table, over: Sequence[str], ax: Target = None) -> Figure:
    """Draw partial slip and gross slip over two columns, usually the displacement or shear and the normal load.

    Raises PictureError.
    """
    x, y = _numbers(table, over[0]), _numbers(table, over[1])
    cases = zip(table.outcomes, table.states, strict=True)
    found = np.array([one.running_condition or "no solution" if state.has_result else "" for one, state in cases])
    if not (found != "").any():
        raise PictureError("no case has a result yet")
    with _panel(ax, table, x, y) as (sheet, axes):
        _draw_regions(axes, x, y, found)
        handles: list[Line2D] = []
        for name, look in CONDITIONS.items():
            here = found == name
            if here.any():
                handles += axes.plot(
                    x.values[here], y.values[here], linestyle="", markersize=5.0, clip_on=False, label=name, **look
                )
        sheet.legend(handles, len(handles))
    return sheet.figure


def _draw_regions(axes: Axes, x: Column, y: Column, found: NDArray[np.str_]) -> None:
    """Colour the regions of the running conditions, with borders half-way between points, if these fill a grid."""
    columns, rows = np.unique(x.values), np.unique(y.values)
    if len(columns) * len(rows) != len(found) or min(len(columns), len(rows)) < 2:
        return
    numbers = {name: float(number) for number, name in enumerate(SLIP_CONDITIONS)}
    values = np.full((len(rows), len(columns)), np.nan)
    values[np.searchsorted(rows, y.values), np.searchsorted(columns, x.values)] = [
        numbers.get(name, np.nan) for name in found
    ]
    known = np.ma.masked_invalid(values)
    levels = np.arange(len(numbers) + 1) - 0.5
    axes.contourf(columns, rows, known, levels, colors=[CONDITIONS[name]["color"] for name in numbers], alpha=0.2)
    if np.ptp(known) > 0.0:
        axes.contour(columns, rows, known, levels[1:-1], colors="black", linewidths=1.0)


@contextmanager
def _panel(ax: Target, table: Table, x: Column, y: Column | str) -> Iterator[tuple[Canvas, Axes]]:
    """Make a canvas of one panel with labels, title and scales: logarithmic for values of equal ratios.

    y: a label for the axis of a quantity, which stays linear.
    """
    with canvas(ax, 1, (3.7, 2.9)) as sheet:
        axes = sheet.axes[0]
        axes.set(xlabel=_axis_label(x), ylabel=y if isinstance(y, str) else _axis_label(y))
        for column, set_scale in ((x, axes.set_xscale), (y, axes.set_yscale)):
            values = np.unique(column.values) if isinstance(column, Column) else np.empty(0)
            if len(values) > 2 and values[0] > 0.0:
                ratios = values[1:] / values[:-1]
                if np.ptp(ratios) < 1e-3 * ratios[0]:
                    set_scale("log")
        yield sheet, axes
        sheet.heading(one_line(table.manifest.title))


def _follows(column: Column, *others: Column) -> bool:
    """Return whether a column has one value wherever the others have theirs: it is tied to them, or constant."""
    places = list(zip(*(other.values.tolist() for other in others), strict=True))
    return len(set(places)) == len(set(zip(places, column.values.tolist(), strict=True)))


def _in_words(name: str) -> str:
    """Return a key or a quantity, such as ``delta_x@3`` or ``load_path.0.P``, in words."""
    name, _, stage = name.partition("@")
    stage = "" if stage == str(LAST_STAGE) else stage
    return physical_name(name.rpartition(".")[2]) + (f" at the end of stage {stage}" if stage else "")


def _short_name(key: str) -> str:
    """Return the last part of a key, as a symbol if it has one."""
    name = key.rpartition(".")[2]
    return symbol(name) if physical_name(name).endswith("$") else name.replace("_", " ")


def _axis_label(column: Column) -> str:
    """Return the meaning of a column and its unit."""
    unit = column.units.replace("um", "µm")
    return _in_words(column.name) + (f" ({unit})" if unit not in ("", "1") else "")


def _column(table: Table, name: str) -> Column:
    columns = {column.name: column for column in (*table.settings, *table.found)}
    if name not in columns:
        raise PictureError(f"{name!r} is not a column of the sweep; it has {', '.join(columns)}")
    return columns[name]


def _found(table: Table, quantity: str) -> Column:
    column = _column(table, quantity)
    if not np.isfinite(column.values).any():
        raise PictureError(f"no case has a value of {quantity}")
    return column


def _numbers(table: Table, name: str) -> Column:
    column = _column(table, name)
    if column.values.dtype == object:
        raise PictureError(f"the values of {name} are not numbers in one unit, so they cannot be an axis")
    return column


def _groups(table: Table, over: str) -> dict[str, IndexArray]:
    """Return the rows by the values of all varied keys except `over` and those tied to it."""
    x = _column(table, over)
    others = [column for column in table.settings if column.name != over and not _follows(column, x)]

    def text(column: Column, row: int) -> str:
        value = column.values[row]
        shown = str(value) if column.values.dtype == object else f"{value:.6g} {column.units}".rstrip()
        return f"{_short_name(column.name)} {shown}"

    names = [", ".join(text(column, row) for column in others) for row in range(len(table.states))]
    return {name: np.flatnonzero(np.array(names) == name) for name in dict.fromkeys(names)}
