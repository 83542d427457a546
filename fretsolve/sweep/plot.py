"""Pictures of a sweep: a quantity as curves or as a map over the settings, and the running condition."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FixedLocator, NullLocator
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from fretsolve.case.keys.quantity_names import OF_WHOLE_RUN
from fretsolve.errors import PictureError
from fretsolve.post.names import ENDLESS
from fretsolve.post.plots.canvas import Canvas, Target, canvas, one_line
from fretsolve.post.plots.labels import (
    MOST_INCREMENTS,
    MOST_NAMED,
    UPWARDS,
    Mark,
    line_colors,
    marks,
    physical_name,
    quantity_label,
    readable,
    symbol,
)
from fretsolve.post.plots.many_lines import BAND, END_LINES, drawn_lines
from fretsolve.result.cycles.table import CYCLE_NAMES
from fretsolve.sweep.quantity import LAST_STAGE
from fretsolve.sweep.table import Column, Table
from fretsolve.system.arrays import DoubleArray, IndexArray

CONDITIONS: dict[str, dict[str, Any]] = {
    "stick": {"marker": "^", "color": "0.5"},
    "partial slip": {"marker": "o", "color": "#3b528b"},
    "mixed": {"marker": "D", "color": "#7b9f35"},
    "gross slip": {"marker": "s", "color": "#d95f02"},
    "no solution": {"marker": "x", "color": "black"},
}
"""Marker and colour of each running condition, in the order in which they follow each other under growing shear."""

AMPLITUDES = {
    "delta": "displacement amplitude",
    "phi": "rotation amplitude",
    "actuator": "displacement amplitude of the actuator",
    "actuator_phi": "rotation amplitude of the actuator",
    "": "load amplitude",
}
"""Amplitudes of a cycle in words, by the beginning of the component's name."""


def curve(table: Table, quantity: str, over: str, ax: Target = None) -> Figure:
    """Draw a quantity over a varied key, with error bars if there are any; a line for each value of the other keys.

    Over another quantity the lines go along the first varied key. Lives have a logarithmic axis, and arrows at its top
    stand for run-outs, or for a crack that goes through. Raises PictureError.
    """
    x, y = _column(table, over, axis=True), _column(table, quantity)
    errors = next((column for column in table.errors if column.name == f"{quantity} error"), None)
    unit = readable(y.units, y.values)
    along = x if any(x is one for one in table.settings) else table.settings[0]
    if along is not x:
        text, factor = readable(x.units, x.values)
        x = replace(x, values=factor * x.values, units=text)
    groups = _groups(table, along)
    with _panel(ax, table, x, _label(quantity, unit.text)) as (sheet, axes):
        lines, places = list(groups.items()), drawn_lines(len(groups))
        for (name, rows), mark in zip([lines[place] for place in places], marks(len(lines), places), strict=True):
            order = rows[np.argsort(along.values[rows], kind="stable")] if along.values.dtype != object else rows
            options = mark.options(len(order), MOST_INCREMENTS) | ({"label": name} if name else {})
            bars = None
            if errors is not None:  # a bar without a bound cannot be drawn
                bars = unit.factor * np.where(np.isinf(errors.values[order]), np.nan, errors.values[order])
            axes.errorbar(x.values[order], unit.factor * y.values[order], yerr=bars, capsize=2.0, **options)
            _draw_endless(axes, x.values[order], y.values[order], mark, len(groups))
        _set_scale(axes, y)
        named = axes.get_legend_handles_labels()[0] if 1 < len(groups) <= MOST_NAMED else []
        if len(places) < len(lines):
            some = f"{len(places)} of {len(lines)} lines: the first and the last {END_LINES}, and some between"
            named = [Line2D([], [], color=BAND["color"], label=some)]
        sheet.legend([*named, *_endless_key(y)], 2)
        if len(groups) > MOST_NAMED:
            _add_scale(sheet, axes, table, along)
    return sheet.figure


def _draw_endless(axes: Axes, x: DoubleArray, y: DoubleArray, mark: Mark, groups: int) -> None:
    """Draw an arrow at the top of the axis for each value without a bound, those of several groups side by side."""
    endless = x[np.isposinf(y)]
    if not len(endless):
        return
    beside = min(6.0, 24.0 / groups) * (mark.index - 0.5 * (groups - 1)) / 72.0  # inches
    aside = ScaledTranslation(beside, 0.0, axes.get_figure(root=True).dpi_scale_trans)  # type: ignore[union-attr]
    top = np.full(len(endless), 0.94)
    axes.update_datalim(np.column_stack([endless, top]), updatey=False)
    axes.autoscale_view()
    axes.plot(endless, top, transform=axes.get_xaxis_transform() + aside, color=mark.color, **UPWARDS)


def _set_scale(axes: Axes, y: Column) -> None:
    """Make the axis of a life logarithmic, and keep its top free for arrows."""
    if y.units == "cycles":
        axes.set_yscale("log")
    if np.isposinf(y.values).any():
        axes.margins(y=0.2)
    if not np.isfinite(y.values).any():
        axes.yaxis.set_major_locator(NullLocator())
        axes.yaxis.set_minor_locator(NullLocator())


def _endless_key(y: Column) -> list[Line2D]:
    """Return the key of values without a bound; empty without such values."""
    meaning = ENDLESS.get(y.name.partition("@")[0], "without a bound")
    return [Line2D([], [], color="0.3", label=meaning, **UPWARDS)] if np.isposinf(y.values).any() else []


def surface(table: Table, quantity: str, over: Sequence[str], ax: Target = None) -> Figure:
    """Draw a quantity as colours over two varied keys, crosses where it has no value. Raises PictureError.

    Lives have logarithmic colours, and arrows stand for run-outs, or for a crack that goes through.
    """
    x, y, z = _column(table, over[0], axis=True), _column(table, over[1], axis=True), _column(table, quantity)
    finite, endless = np.isfinite(z.values), np.isposinf(z.values)
    _require_places(table, x, y)
    unit = readable(z.units, z.values)
    with _panel(ax, table, x, y) as (sheet, axes):
        grid = _on_grid(x, y, unit.factor * z.values)
        look: dict[str, Any] = {"cmap": line_colors(), "norm": LogNorm() if z.units == "cycles" else None}
        if grid is not None:
            colors: Any = axes.pcolormesh(*grid, shading="nearest", **look)
        else:
            colors = axes.scatter(x.values[finite], y.values[finite], c=unit.factor * z.values[finite], s=30.0, **look)
        unknown = ~(finite | endless)
        axes.plot(x.values[unknown], y.values[unknown], linestyle="", marker="x", color="black")
        if endless.any():
            axes.plot(x.values[endless], y.values[endless], color="black", **UPWARDS)
        if finite.any():
            sheet.colorbar(axes, colors, _label(quantity, unit.text))
        sheet.legend(_endless_key(z), 1)
    return sheet.figure


def _require_places(table: Table, x: Column, y: Column) -> None:
    """Raise PictureError if two cases lie at one place."""
    others = [one.name for one in table.settings if one is not x and one is not y and not _follows(one, x, y)]
    if others and len(set(zip(x.values.tolist(), y.values.tolist(), strict=True))) < len(table.states):
        raise PictureError(f"{', '.join(others)} varies as well, so a point has several values")


def independent_keys(table: Table) -> list[str]:
    """Return the varied keys, without keys that are tied to a key before them."""
    found: list[Column] = []
    for column in table.settings:
        if not any(_follows(column, other) for other in found):
            found.append(column)
    return [column.name for column in found]


def running_condition_map(table: Table, over: Sequence[str], ax: Target = None) -> Figure:
    """Draw stick, partial slip, mixed and gross slip over two columns, usually displacement amplitude and normal force.

    Where the table has the energy ratios of cycles, their contours are drawn. Raises PictureError.
    """
    x, y = _column(table, over[0], axis=True), _column(table, over[1], axis=True)
    cases = zip(table.outcomes, table.states, strict=True)
    found = np.array([one.running_condition or "no solution" if state.has_result else "" for one, state in cases])
    if not (found != "").any():
        raise PictureError("no case has a result yet")
    _require_places(table, x, y)
    with _panel(ax, table, x, y) as (sheet, axes):
        _draw_regions(axes, x, y, found)
        handles: list[Line2D] = []
        for name, look in CONDITIONS.items():
            here = found == name
            if here.any():
                handles += axes.plot(
                    x.values[here], y.values[here], linestyle="", markersize=3.5, clip_on=False, label=name, **look
                )
        handles += _draw_energy_ratios(axes, x, y, table)
        sheet.legend(handles, len(handles))
    return sheet.figure


def _draw_regions(axes: Axes, x: Column, y: Column, found: NDArray[np.str_]) -> None:
    """Colour the regions of the running conditions, with borders half-way between points, if these fill a grid."""
    there = [name for name in CONDITIONS if name in found and name != "no solution"]  # neighbours have one border
    numbers = {name: float(number) for number, name in enumerate(there)}
    grid = _on_grid(x, y, np.array([numbers.get(name, np.nan) for name in found]))
    if grid is None:
        return
    columns, rows, known = grid
    levels = np.arange(len(numbers) + 1) - 0.5
    axes.contourf(columns, rows, known, levels, colors=[CONDITIONS[name]["color"] for name in numbers], alpha=0.2)
    if np.ptp(known) > 0.0:
        axes.contour(columns, rows, known, levels[1:-1], colors="black", linewidths=1.0)


def _draw_energy_ratios(axes: Axes, x: Column, y: Column, table: Table) -> list[Line2D]:
    """Draw contours of the energy ratio of the last cycle, and return their key; nothing without cycles."""
    ratios = next((column.values for column in table.found if column.name.partition("@")[0] == "energy_ratio"), None)
    grid = None if ratios is None else _on_grid(x, y, ratios)
    if grid is None or not np.ptp(grid[2]) > 0.0:
        return []
    levels = [level for level in np.arange(0.1, 0.95, 0.1) if grid[2].min() < level < grid[2].max()]
    if not levels:
        return []
    look: dict[str, Any] = {"colors": "0.25", "linewidths": 0.8, "linestyles": "dashed"}
    lines = axes.contour(*grid, levels, **look)
    for text in axes.clabel(lines, fmt="%.1f", fontsize=6.5):
        text.set_path_effects([withStroke(linewidth=2.0, foreground="white")])
    return [Line2D([], [], color="0.25", linewidth=0.8, linestyle="--", label="energy ratio")]


def _on_grid(x: Column, y: Column, values: DoubleArray) -> tuple[DoubleArray, DoubleArray, Any] | None:
    """Return columns, rows and a masked array of values that fill a grid of two or more each way; else None."""
    columns, rows = np.unique(x.values), np.unique(y.values)
    if len(columns) * len(rows) != len(values) or min(len(columns), len(rows)) < 2:
        return None
    found = np.full((len(rows), len(columns)), np.nan)
    found[np.searchsorted(rows, y.values), np.searchsorted(columns, x.values)] = values
    return columns, rows, np.ma.masked_invalid(found)


@contextmanager
def _panel(ax: Target, table: Table, x: Column, y: Column | str) -> Iterator[tuple[Canvas, Axes]]:
    """Make a canvas of one panel with labels, title and scales: logarithmic for values of equal ratios.

    y: a label for the axis of a quantity, which stays linear.
    """
    with canvas(ax, 1, (3.7, 2.9)) as sheet:
        axes = sheet.axes[0]
        ylabel = y if isinstance(y, str) else _label(y.name, y.units)
        axes.set(xlabel=_label(x.name, x.units), ylabel="\n".join(textwrap.wrap(ylabel, 42)))
        for column, set_scale, axis in ((x, axes.set_xscale, axes.xaxis), (y, axes.set_yscale, axes.yaxis)):
            values = np.unique(column.values) if isinstance(column, Column) else np.empty(0)
            if len(values) > 2 and values[0] > 0.0:
                ratios = values[1:] / values[:-1]
                if np.ptp(ratios) < 1e-3 * ratios[0]:
                    set_scale("log")
                    axis.set_major_locator(FixedLocator(_some(values)))
                    axis.set_major_formatter("{x:.4g}")
                    axis.set_minor_locator(NullLocator())
        yield sheet, axes
        sheet.heading(one_line(table.manifest.title))


def _add_scale(sheet: Canvas, axes: Axes, table: Table, over: Column) -> None:
    """Add a colour bar for many lines, by the one other key that varies; with several of them there is none."""
    others = [column for column in table.settings if column is not over and not _follows(column, over)]
    if len(others) == 1 and others[0].values.dtype != object:
        (other,) = others
        bar = sheet.colorbar(axes, ScalarMappable(Normalize(0.0, 1.0), line_colors()), _label(other.name, other.units))
        # the lines have colours at equal distances, in the order of the table
        values = list(dict.fromkeys(other.values.tolist()))
        shown = _some(range(len(values)))
        bar.set_ticks([k / (len(values) - 1) for k in shown], labels=[f"{values[k]:.4g}" for k in shown])


def _some(values: Sequence[Any] | DoubleArray) -> list[Any]:
    places = np.linspace(0, len(values) - 1, min(len(values), 5)).round().astype(int)
    return [values[place] for place in places]


def _follows(column: Column, *others: Column) -> bool:
    """Return whether a column has one value wherever the others have theirs: it is tied to them, or constant."""
    places = list(zip(*(other.values.tolist() for other in others), strict=True))
    return len(set(places)) == len(set(zip(places, column.values.tolist(), strict=True)))


def _in_words(name: str) -> str:
    """Return a key or a quantity, such as ``delta_x@3`` or ``load_path.0.P``, in words."""
    name, _, stage = name.partition("@")
    stage = "" if stage == str(LAST_STAGE) else stage
    path, _, last = name.rpartition(".")
    if path.endswith("amplitude") and last.rpartition("_")[0] in AMPLITUDES:
        return f"{AMPLITUDES[last.rpartition('_')[0]]} {symbol(last)}"
    if last in OF_WHOLE_RUN:
        return physical_name(last)
    end = "" if not stage else f" of cycle {stage}" if last in CYCLE_NAMES else f" at the end of stage {stage}"
    return physical_name(last) + end


def _label(name: str, units: str) -> str:
    return quantity_label(_in_words(name), units)


def _column(table: Table, name: str, *, axis: bool = False) -> Column:
    """Return a column of numbers; axis: whether it is to be one. Raises PictureError, also if no value is known."""
    columns = {column.name: column for column in (*table.settings, *table.found)}
    if name not in columns:
        raise PictureError(f"{name!r} is not a column of the sweep; it has {', '.join(columns)}")
    column = columns[name]
    if axis and column.values.dtype == object:
        raise PictureError(f"the values of {name} are not numbers in one unit, so they cannot be an axis")
    if not (np.isfinite(column.values) if axis else ~np.isnan(column.values)).any():
        raise PictureError(f"no case has a value of {name}")
    return column


def _groups(table: Table, along: Column) -> dict[str, IndexArray]:
    """Return the rows by the values of all varied keys, except one key and the keys tied to it."""
    others = [column for column in table.settings if column is not along and not _follows(column, along)]

    def text(column: Column, row: int) -> str:
        value = column.values[row]
        shown = (
            str(value) if column.values.dtype == object else f"{value:.6g} {column.units.replace('um', 'µm')}".rstrip()
        )
        short = column.name.rpartition(".")[2]
        short = symbol(short) if physical_name(short).endswith("$") else short.replace("_", " ")
        return f"{short} {shown}"

    found: dict[str, list[int]] = {}
    for row in range(len(table.states)):
        found.setdefault(", ".join(text(column, row) for column in others), []).append(row)
    return {name: np.array(rows) for name, rows in found.items()}
