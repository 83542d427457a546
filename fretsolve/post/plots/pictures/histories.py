"""Draw the history: the fretting loop, the stick radius over the load, and iterations and residuals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fretsolve.errors import PictureError
from fretsolve.post.export.selection import RESIDUALS, rows_of_stick_zones
from fretsolve.post.plots.canvas import BELOW_LABEL, LETTERS, PANEL_WIDTH, Canvas, Target, canvas, panel_width, title_of
from fretsolve.post.plots.labels import (
    CLOSED_FORM,
    MOST_INCREMENTS,
    MOST_NAMED,
    axis_label,
    draw_lines,
    line_colors,
    marker_spacing,
    marks,
    physical_name,
    readable,
    set_increment_ticks,
    symbol,
    unit_of,
)
from fretsolve.post.plots.load_history import LoadCycle, MovedLoad, MovedPair, cycles, moved_bulk, moved_pairs
from fretsolve.post.plots.many_lines import BAND, END_LINES, MOST_POINTS, draw_range, drawn_lines
from fretsolve.post.plots.reference import along_path, hertz_curve, stick_form
from fretsolve.post.plots.snapshot import require_increments
from fretsolve.result import Result
from fretsolve.result.state import stage_ends
from fretsolve.system.arrays import DoubleArray

AT_ACTUATOR: dict[str, Any] = {"color": "#d95f02", "linestyle": "-", "linewidth": 1.0, "zorder": 1.8}
"""Options of the line of a loop over the motion of the actuator."""

COUNTS = {
    "iterations_normal": "normal iterations",
    "iterations_tangential": "tangential iterations",
    "alternations": "staggered iterations",
}


def loop(result: Result, ax: Target = None) -> Figure:
    """Draw force over displacement of each pair that the load path moves, one panel each.

    The area of closed cycles is shaded and labelled with the energy that all loads dissipate in the cycle, except where
    bulk stress moves: its work is no part of the area. Error bars are drawn if the history has columns
    ``<name>_error``. Where a rig gives, the loop over the motion of the actuator is drawn, too: it has the same area.
    Raises PictureError.
    """
    require_increments(result)
    moved = moved_pairs(result)
    if not moved:
        raise PictureError("no load component is more than round-off")
    moved = [pair for pair in moved if not np.isnan(result.history[pair.motion]).all()]
    if not moved:
        raise PictureError(
            "displacements of a line contact have an unknown constant without reference_depth, and along y in any case;"
            " profiles draws its slip, stick-history its stick zone"
        )
    levels = [[_levels(result.history[name]) for name in (pair.motion, pair.force)] for pair in moved]
    pairs = [pair for pair, (motions, forces) in zip(moved, levels, strict=True) if motions > 2 and forces > 1]
    if not pairs and _bulk_moves(result):
        raise PictureError("bulk stress has no displacement of its own; stick-history and profiles show what it does")
    pairs = pairs or moved[:1]
    with canvas(ax, len(pairs), (PANEL_WIDTH, 3.2)) as drawn:
        for axes, pair in zip(drawn.axes, pairs, strict=False):
            _draw_loop(drawn, axes, result, pair)
        energy, error = (float(result.history.get(name, [0.0])[-1]) for name in ("work_total", "work_total_error"))
        note = ", with the work of bulk stress" if _bulk_moves(result) else ""
        drawn.heading(title_of(result), f"total dissipated energy: {_energy(result, energy, error)}{note}")
    return drawn.figure


def stick_history(result: Result, ax: Target = None) -> Figure:
    """Draw c/a, stick radius over contact radius, over each tangential load that the path moves, or else over P.

    Bulk stress is one of them where it moves without the others. Radii are of circles of equal area; where wear changes
    the surfaces, they are the radii at the end of the cycle before. Closed forms for the computed forces are drawn
    where they apply. Raises PictureError.
    """
    require_increments(result)
    if not np.any(result.history["max_shear"]) and not np.any(result.history["stick_radius"]):
        raise PictureError("nothing sticks or slips without friction and shear traction")
    moved = moved_pairs(result)
    shearing: list[MovedLoad] = [pair for pair in moved if pair.force in ("Qx", "Qy", "Mz")]
    for bulk in sorted(moved_bulk(result), key=lambda bulk: -np.abs(result.history[bulk.force]).max()):
        if not any(bulk.driven.keys() <= other.driven.keys() for other in shearing):
            shearing.append(bulk)
    loads = shearing or [pair for pair in moved if pair.force == "P"]
    with canvas(ax, len(loads), (PANEL_WIDTH, 3.0)) as drawn:
        for axes, load in zip(drawn.axes, loads, strict=False):
            _draw_stick_ratio(drawn, axes, result, load)
        drawn.heading(title_of(result))
    return drawn.figure


def convergence(result: Result, ax: Target = None) -> Figure:
    """Draw the iterations of each increment, and below them the residuals with the tolerance as a line.

    Residuals below 1e-4 of the tolerance are drawn there. Raises PictureError.
    """
    require_increments(result)
    ends = stage_ends(result.history["stage"])[:-1]
    few = len(ends) <= 60  # the lines of more would hide the curves
    with canvas(ax, 2, (4.5, 2.1), columns=1, share="x") as drawn:
        for axes, draw in zip(drawn.axes, (_draw_counts, _draw_residuals), strict=False):
            draw(axes, result)
            for end in ends if few else ():
                axes.axvline(end + 0.5, color="0.75", linewidth=0.8, zorder=0.6)
            if panel_width(axes) > 4.5:  # inches: a wider panel has its legend beside it
                axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
            else:
                axes.legend(loc="lower right", bbox_to_anchor=(1.02, 1.0), ncols=2, columnspacing=1.0, frameon=False)
            axes.set_xlim(-0.5, result.increments - 0.5)
            set_increment_ticks(axes)
        note = " (vertical lines: ends of stages)" if few else ""
        crowd = result.increments / (254.0 * panel_width(drawn.axes[-1]))  # increments in 0.1 mm
        if crowd > 2.0:
            note = f" (each 0.1 mm of the axis holds about {crowd:.0f} of them)"
        drawn.axes[-1].set_xlabel("increment" + note)
        drawn.heading(title_of(result))
    return drawn.figure


def _draw_loop(drawn: Canvas, axes: Axes, result: Result, pair: MovedPair) -> None:
    farthest = max(pair.motion, pair.actuator or pair.motion, key=lambda name: np.abs(result.history[name]).max())
    x_unit, y_unit = unit_of(result, farthest), unit_of(result, pair.force)
    x, y = result.history[pair.motion] * x_unit.factor, result.history[pair.force] * y_unit.factor
    found = cycles(result, pair)
    drawn_cycles = [found[place] for place in drawn_lines(len(found))]
    if pair.actuator:
        draw = axes.plot if len(found) == len(drawn_cycles) else partial(draw_range, axes)
        draw(result.history[pair.actuator] * x_unit.factor, y, label="at the actuator", **AT_ACTUATOR)
    _draw_cycles(axes, found, x, y, ", at the contact" if pair.actuator else "")
    closed = [] if _bulk_moves(result) else [cycle for cycle in found if cycle.closed]
    for cycle in closed if len(closed) <= 2 else closed[-1:]:
        color = marks(len(found), [cycle.number])[0].color
        total = result.history["work_total"]
        label = f"{_energy(result, float(total[cycle.last] - total[cycle.first]))} dissipated in {cycle.name}"
        axes.fill(x[cycle.steps], y[cycle.steps], color=color, alpha=0.15, linewidth=0, zorder=0.5, label=label)
    rows = np.unique(np.concatenate([np.arange(cycle.first, cycle.last + 1) for cycle in drawn_cycles]))
    rows = rows[:: marker_spacing(len(rows), MOST_POINTS)]
    errors = [
        np.abs(result.history[f"{name}_error"][rows]) * unit.factor if f"{name}_error" in result.history else None
        for name, unit in ((pair.motion, x_unit), (pair.force, y_unit))
    ]
    if any(error is not None for error in errors):
        look: dict[str, Any] = {"fmt": "none", "ecolor": "0.35", "elinewidth": 0.8, "capsize": 1.5, "zorder": 2.5}
        some = "" if len(rows) == result.increments else f", of {len(rows)} of {result.increments} increments"
        axes.errorbar(x[rows], y[rows], xerr=errors[0], yerr=errors[1], label=f"estimated errors{some}", **look)
    curve = hertz_curve(result) if pair.force == "P" else None
    if curve is not None:
        x, y = curve[0] * x_unit.factor, curve[1] * y_unit.factor
        axes.plot(x, y, label="Hertz (closed form)", **CLOSED_FORM)
    xlabel = axis_label(pair.motion, x_unit)
    if pair.actuator:
        xlabel = f"{physical_name(pair.motion)}, {symbol(pair.actuator)} ({x_unit.text})"
    axes.set(xlabel=xlabel, ylabel=axis_label(pair.force, y_unit))
    _show_origin(axes, result)
    _tell_apart(drawn, axes, found)


def _levels(values: DoubleArray) -> int:
    size = float(np.nanmax(np.abs(values)))
    return len(np.unique(np.round(values / size, 9))) if size else 1


def _show_origin(axes: Axes, result: Result) -> None:
    """Have the origin in the limits of a single point, which has none of its own."""
    if result.increments == 1:
        axes.plot([0.0], [0.0], linestyle="")


def _bulk_moves(result: Result) -> bool:
    return bool(moved_bulk(result))


def _draw_stick_ratio(drawn: Canvas, axes: Axes, result: Result, moved: MovedLoad) -> None:
    name = moved.last_driven
    unit = unit_of(result, name)
    load, contact = result.history[name] * unit.factor, result.history["contact_radius"]
    ratio = result.history["stick_radius"] / np.where(contact > 0.0, contact, np.nan)
    ratio = ratio[rows_of_stick_zones(result.history)]
    found = cycles(result, moved)
    _draw_cycles(axes, found, load, ratio)
    # of many cycles the first ones have it, since each of its values follows from all loads before
    many = len(found) > len(drawn_lines(len(found)))
    count = min(found[END_LINES - 1].last + 1 if many else result.increments, MOST_POINTS)
    end = "" if count == result.increments else f", up to increment {count - 1}"
    # a curve of 200 points also between few increments; under displacement control the forces there are not known
    parts = max(2, -(-200 // result.increments)) if name == moved.force else 1
    form = stick_form(result, moved.force, parts, count)
    if form is not None and name == moved.force:
        path = along_path(load[:count], parts)
        axes.plot(path, form[1], label=f"{form[0]} (closed form{end})", **CLOSED_FORM)
    elif form is not None:
        # values at the increments alone; in gross slip the force does not tell them
        look = CLOSED_FORM | {"linestyle": "", "marker": "o", "markersize": 8.0}
        values = np.where(ratio[:count] > 0.0, form[1], np.nan)
        axes.plot(load[:count], values, label=f"{form[0]} (closed form{end})", **look)
    size = "half-width" if len(result.y) == 1 else "radius"
    axes.set(ylim=(-0.03, 1.05), xlabel=axis_label(name, unit), ylabel=f"stick {size} over contact {size}, c/a")
    _show_origin(axes, result)
    _tell_apart(drawn, axes, found)


def _draw_cycles(axes: Axes, found: Sequence[LoadCycle], x: DoubleArray, y: DoubleArray, where: str = "") -> None:
    """Draw a line for each of few cycles, of many for the first and last ones and some, and the range of all between.

    where: added to their names.
    """
    places = drawn_lines(len(found))
    if len(places) < len(found):
        inner = found[END_LINES : len(found) - END_LINES]
        between = slice(inner[0].first, inner[-1].last + 1)
        drawn = f"{len(places) - 2 * END_LINES} of them as lines"
        label = f"range of cycles {inner[0].number} to {inner[-1].number}{where}, {drawn}"
        draw_range(axes, x[between], y[between], label=label, **BAND)
    for cycle, mark in zip([found[place] for place in places], marks(len(found), places), strict=True):
        count = len(x[cycle.steps])
        every = marker_spacing(count, MOST_INCREMENTS)
        name = cycle.name + where
        label = name if every == 1 or not mark.marker else f"{name}, one in {every} increments marked"
        axes.plot(x[cycle.steps], y[cycle.steps], label=label, **mark.options(count, MOST_INCREMENTS))


def _tell_apart(drawn: Canvas, axes: Axes, found: Sequence[LoadCycle]) -> None:
    """Add a legend below the panel, as curves may fill it, and a colour bar for many cycles."""
    handles, _ = axes.get_legend_handles_labels()
    if len(found) > MOST_NAMED:
        mapping = ScalarMappable(Normalize(0, found[-1].number), line_colors())
        bar = drawn.colorbar(axes, mapping, "cycle (0: first loading)")
        bar.set_ticks(MaxNLocator(integer=True))
        handles = [handle for handle in handles if not str(handle.get_label()).startswith("cycle")]
    if len(handles) > 1:
        width = panel_width(axes)
        longest = sorted(len(str(handle.get_label())) for handle in handles)[-2:]
        # the sample of a line takes 8 letters, and the legend may be 0.6 inches wider than the panel
        columns = 2 if width > 2.4 and sum(longest) + 16 < LETTERS * (width + 0.6) else 1
        axes.legend(handles=handles, ncols=columns, **BELOW_LABEL)


def _energy(result: Result, energy: float, error: float = 0.0) -> str:
    """Return a dissipated energy in a readable unit, with its error if that is known."""
    unit = readable(result.units("work_total"), energy)
    if not error > 0.0:
        return f"{energy * unit.factor:.4g} {unit.text}"
    uncertain = error * unit.factor
    decimals = max(0, 1 - math.floor(math.log10(uncertain)))
    return f"{energy * unit.factor:.{decimals}f} ± {uncertain:.{decimals}f} {unit.text}"


def _draw_counts(axes: Axes, result: Result) -> None:
    _draw_columns(axes, result, COUNTS)
    axes.set(ylim=(0, None), ylabel="count per increment")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))


def _draw_residuals(axes: Axes, result: Result) -> None:
    tolerance = float(result.effective_case.get("solver", {}).get("tolerance", np.nan))
    # residuals below are round-off, which would take up most of the axis
    least = 1e-4 * tolerance if np.isfinite(tolerance) else np.finfo(float).eps
    _draw_columns(axes, result, RESIDUALS, least)
    if np.isfinite(tolerance):
        axes.axhline(tolerance, color="black", linestyle="--", linewidth=1.2, label=f"tolerance {tolerance:g}")
    axes.set(yscale="log", ylabel=f"residual (slip: rad),\nbelow {least:.0e}: drawn there")


def _draw_columns(axes: Axes, result: Result, labels: Mapping[str, str], least: float = 0.0) -> None:
    """Draw columns of the history over the increments; values below `least` there."""
    lines = [(label, np.maximum(result.history[name], least)) for name, label in labels.items()]
    draw_lines(axes, result.history["step"], lines, linewidth=1.1)
