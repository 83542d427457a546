"""Draw wear: the scar over the cycles along a line and as a map, worn volume and depth over the cycles."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas, scaled_height, title_of
from fretsolve.plots.labels import CLOSED_FORM, MOST_INCREMENTS, marks, unit_of
from fretsolve.plots.pictures.line_profiles import ProfileLine
from fretsolve.plots.pictures.maps import draw_panel, outline_key, scale_of
from fretsolve.plots.reference import worn_limit
from fretsolve.plots.snapshot import Snapshot, chosen_step, middle, require_field, view_box
from fretsolve.result import Result
from fretsolve.system.arrays import BoolArray, DoubleArray, IndexArray

MOST_PROFILES = 6
"""Profiles in a picture."""

ALIKE = 0.95
"""Volume over the last one from which a profile counts as the last one."""

MOST_TICKS = 5
"""Intervals between the ticks of the cycles, so that numbers of six digits stay apart."""

VISIBLE = 0.01
"""Error over the largest volume above which its band is wider than the line of the volume; the heading has any."""

WIDTH, HEIGHT = 3.7, 2.6
"""Inches of a panel."""


def wear(result: Result, ax: Target = None) -> Figure:
    """Draw the worn depth along x through the middle over the cycles, its map at the end, volume and depth over cycles.

    The depth is that of both bodies together. Volume has its estimated error as a band where it is wide enough to be
    seen, and the worn limit of partial slip if a closed form gives it. A line contact has no map. Raises PictureError.
    """
    last = chosen_step(result, None)
    if "wear_volume" not in result.history:
        raise PictureError("nothing is worn, since the case has no wear")
    require_field(result, "wear_depth")
    is_line = len(result.y) == 1
    snapshot = Snapshot(result, last)
    worn = np.asarray(snapshot.field("wear_depth") > 0.0)
    box = view_box(result, snapshot.contact | worn)
    panels = 3 if is_line else 4
    heights = [HEIGHT] * panels
    if not is_line:
        heights[:2] = [max(HEIGHT, scaled_height(box.height / box.width, WIDTH))] * 2
    with canvas(ax, panels, (WIDTH, HEIGHT), heights=heights) as drawn:
        axes = list(drawn.axes)
        _draw_profiles(axes[0], result, worn)
        if not is_line and len(axes) > 1:
            depth = float(snapshot.field("wear_depth").max())
            draw_panel(drawn, axes[1], snapshot, scale_of(result, "wear_depth", depth), box)
        for panel, draw in zip(axes[1 if is_line else 2 :], (_draw_volume, _draw_depth), strict=False):
            draw(panel, result)
        key = outline_key(snapshot) if not is_line and len(axes) > 1 else []
        drawn.legend([*axes[0].get_legend_handles_labels()[0], *key], columns=3)
        _heading(drawn, result)
    return drawn.figure


def _heading(drawn: Canvas, result: Result) -> None:
    history = result.history
    cycles, volume, error = (float(history[name][-1]) for name in ("cycles", "wear_volume", "wear_error"))
    unit = result.units("wear_volume").replace("^3", "³")
    spread = f" ± {error:.1e}" if error else ""
    drawn.heading(title_of(result), f"after {cycles:g} cycles: worn volume {volume:.4g}{spread} {unit}")


def profile_steps(result: Result) -> list[int]:
    """Return increments with fields at which the worn volume is about equally spaced, the last one included."""
    steps = np.array(result.steps)
    volume = result.history["wear_volume"][steps]
    if not volume[-1]:
        return [int(steps[-1])]
    wanted = volume[-1] * np.arange(1, MOST_PROFILES + 1) / MOST_PROFILES
    places = np.searchsorted(volume, wanted * (1.0 - 1e-9))
    chosen = sorted({int(steps[min(place, len(steps) - 1)]) for place in places} - {int(steps[-1])})
    # of those that hardly differ from the last one, that alone
    worn = result.history["wear_volume"]
    return [*(step for step in chosen if worn[step] < ALIKE * volume[-1]), int(steps[-1])]


def _draw_profiles(axes: Axes, result: Result, worn: BoolArray) -> None:
    """Draw the depth along x, downwards, through the middle of the contact at the end."""
    steps = profile_steps(result)
    line = ProfileLine(0, middle(Snapshot(result, steps[-1]))[1], result.x, result.y)
    unit = unit_of(result, "wear_depth", float(result.history["wear_depth_max"].max()))
    touched = result.x[worn.any(axis=1)]
    low, high = (float(touched[0]), float(touched[-1])) if len(touched) else (float(result.x[0]), float(result.x[-1]))
    space = 0.1 * (high - low)
    for step, mark in zip(steps, marks(len(steps)), strict=True):
        depth = line.cut(Snapshot(result, step).field("wear_depth")) * unit.factor
        label = f"after {result.history['cycles'][step]:g} cycles"
        axes.plot(result.x, depth, label=label, **mark.options(len(depth)))
    axes.set(xlim=(low - space, high + space), xlabel="x (mm)", ylabel=f"worn depth ({unit.text})")
    axes.invert_yaxis()
    axes.set_title(line.text)


def _draw_volume(axes: Axes, result: Result) -> None:
    rows = _changes(result)
    cycles, volume, error = (result.history[name][rows] for name in ("cycles", "wear_volume", "wear_error"))
    limit = worn_limit(result)
    if limit is not None and limit.volume < 5.0 * volume.max():
        axes.axhline(limit.volume, label="worn limit (closed form)", **CLOSED_FORM)
    if error.max() > VISIBLE * volume.max():
        band = volume - error, volume + error
        axes.fill_between(cycles, *band, color="0.6", alpha=0.5, linewidth=0, label="estimated error")
    _draw_line(axes, cycles, volume)
    axes.set(xlabel="cycles", ylabel=f"worn volume ({result.units('wear_volume').replace('^3', '³')})")
    axes.ticklabel_format(axis="y", scilimits=(-2, 3), useMathText=True)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc="lower right", frameon=False)


def _draw_depth(axes: Axes, result: Result) -> None:
    rows = _changes(result)
    depth = result.history["wear_depth_max"][rows]
    unit = unit_of(result, "wear_depth_max")
    _draw_line(axes, result.history["cycles"][rows], depth * unit.factor)
    axes.set(xlabel="cycles", ylabel=f"largest worn depth ({unit.text})")


def _draw_line(axes: Axes, cycles: DoubleArray, values: DoubleArray) -> None:
    """Draw values over the cycles, with markers at the solved cycles if they are few."""
    marker = "o" if len(cycles) <= MOST_INCREMENTS else ""
    axes.plot(cycles, values, color="0.1", marker=marker, markerfacecolor="white")
    axes.set_xlim(0.0, float(cycles.max()) or None)
    axes.set_ylim(bottom=0.0)
    axes.locator_params(axis="x", nbins=MOST_TICKS)
    axes.ticklabel_format(axis="x", scilimits=(0, 5), useMathText=True)


def _changes(result: Result) -> IndexArray:
    """Return the increments after which more cycles are counted, and the one before the first of them."""
    grown = np.flatnonzero(np.diff(result.history["cycles"]) > 0.0) + 1
    return np.concatenate([grown[:1] - 1, grown]) if len(grown) else np.array([0])
