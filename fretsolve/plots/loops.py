"""The fretting loop: force over displacement, cycle by cycle, with the dissipated work."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas
from fretsolve.plots.load_history import Cycle, MovedPair, cycles, moved_pairs, require_increments
from fretsolve.plots.marks import CLOSED_FORM, MOST_INCREMENTS, MOST_NAMED, line_colors, marks, spacing
from fretsolve.plots.quantities import axis_label, readable, unit_of
from fretsolve.plots.reference import hertz_curve

if TYPE_CHECKING:
    from fretsolve.result import Result

PANEL = (4.6, 3.9)
MOST_COLUMNS = 3
MOST_SHADED = 2
"""Of more closed cycles only the last one is shaded."""


def loop(result: Result, ax: Target = None) -> Figure:
    """Force over displacement of each pair that the load path moves, a panel each.

    The area of closed cycles is shaded and labelled with the work dissipated in the cycle, by all loads together. Error
    bars are drawn where the history has columns ``<name>_error``. Raises PictureError.
    """
    pairs = loop_pairs(result)
    columns = min(len(pairs), MOST_COLUMNS)
    rows = -(-len(pairs) // columns)
    with canvas(ax, rows, columns, PANEL) as drawn:
        for axes, pair in zip(drawn.axes, pairs, strict=False):
            _draw(drawn, axes, result, pair)
        for axes in drawn.axes[len(pairs) :] if drawn.own else ():
            axes.set_axis_off()
        drawn.heading(result, f"dissipated work in total: {_total_work(result)}")
    return drawn.figure


def loop_pairs(result: Result) -> list[MovedPair]:
    """The pairs with a curve to draw: moved in more than one increment, or whatever is moved. Raises PictureError."""
    require_increments(result)
    pairs = moved_pairs(result)
    if not pairs:
        raise PictureError("no load component is more than round-off")
    curves = [pair for pair in pairs if len(np.unique(result.history[pair.motion])) > 2]
    return curves or pairs[:1]


def _draw(drawn: Canvas, axes: Axes, result: Result, pair: MovedPair) -> None:
    x_unit, y_unit = unit_of(result, pair.motion), unit_of(result, pair.force)
    x = result.history[pair.motion] * x_unit.factor
    y = result.history[pair.force] * y_unit.factor
    found = cycles(result, pair)
    styles = marks(len(found))
    handles: list[Any] = []
    for cycle, style in zip(found, styles, strict=True):
        steps = cycle.steps
        count = len(x[steps])
        every = spacing(count, MOST_INCREMENTS)
        label = cycle.name if every == 1 or not style.marker else f"{cycle.name}, one in {every} increments marked"
        handles += axes.plot(x[steps], y[steps], label=label, **style.options(count, MOST_INCREMENTS))
    closed = [cycle for cycle in found if cycle.closed]
    for cycle in closed if len(closed) <= MOST_SHADED else closed[-1:]:
        color = styles[cycle.number].color
        axes.fill(x[cycle.steps], y[cycle.steps], color=color, alpha=0.15, linewidth=0, zorder=0.5)
        label = f"{_work(result, cycle)} dissipated in {cycle.name}"
        handles.append(Patch(color=color, alpha=0.25, linewidth=0, label=label))
    handles += _draw_errors(axes, result, pair, x_unit.factor, y_unit.factor)
    handles += _draw_hertz(axes, result, pair, x_unit.factor, y_unit.factor)
    axes.set_xlabel(axis_label(pair.motion, x_unit))
    axes.set_ylabel(axis_label(pair.force, y_unit))
    if len(found) > MOST_NAMED:
        add_cycle_colorbar(drawn, axes, found)
        handles = [handle for handle in handles if not str(handle.get_label()).startswith("cycle")]
    place_legend(axes, handles)


def _work(result: Result, cycle: Cycle) -> str:
    """Work dissipated in a cycle, with its unit."""
    total = result.history["work_total"]
    work = float(total[cycle.last] - total[cycle.first])
    unit = readable("mJ", work)
    return f"{work * unit.factor:.4g} {unit.text}"


def _total_work(result: Result) -> str:
    """All dissipated work with its error, where that is known, and its unit."""
    work, error = float(result.history["work_total"][-1]), result.history.get("work_total_error")
    unit = readable("mJ", work)
    if error is None or not error[-1] > 0.0:
        return f"{work * unit.factor:.4g} {unit.text}"
    uncertain = float(error[-1]) * unit.factor
    decimals = max(0, 1 - math.floor(math.log10(uncertain)))
    return f"{work * unit.factor:.{decimals}f} ± {uncertain:.{decimals}f} {unit.text}"


def _draw_errors(axes: Axes, result: Result, pair: MovedPair, x_factor: float, y_factor: float) -> list[Any]:
    """Error bars of whichever of both columns has errors, for the legend."""
    x_error, y_error = (result.history.get(f"{name}_error") for name in (pair.motion, pair.force))
    if x_error is None and y_error is None:
        return []
    bars = axes.errorbar(
        result.history[pair.motion] * x_factor,
        result.history[pair.force] * y_factor,
        xerr=None if x_error is None else np.abs(x_error) * x_factor,
        yerr=None if y_error is None else np.abs(y_error) * y_factor,
        fmt="none",
        ecolor="0.35",
        elinewidth=0.8,
        capsize=1.5,
        zorder=2.5,
        label="estimated errors",
    )
    return [bars]


def _draw_hertz(
    axes: Axes, result: Result, pair: MovedPair, x_factor: float, y_factor: float
) -> list[Line2D]:
    """Hertz's curve beside P over delta_z, where it applies."""
    curve = hertz_curve(result) if pair.force == "P" else None
    if curve is None:
        return []
    return axes.plot(curve[0] * x_factor, curve[1] * y_factor, label="Hertz (closed form)", **CLOSED_FORM)


def add_cycle_colorbar(drawn: Canvas, axes: Axes, found: Sequence[Cycle]) -> None:
    """Tells many cycles apart."""
    mapping = ScalarMappable(Normalize(0, found[-1].number), line_colors())
    bar = drawn.colorbar(axes, mapping, "cycle (0: first loading)")
    bar.locator = MaxNLocator(integer=True)
    bar.update_ticks()


def place_legend(axes: Axes, handles: Sequence[Any]) -> None:
    """A legend beside the curves, which may fill the panel; none where there is nothing to tell apart."""
    if len(handles) > 1:
        axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False)
