"""Draw along lines: pressure, shear traction and slip with closed forms, and wear, whose scar grows over the cycles."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretsolve.errors import PictureError
from fretsolve.post.plots.canvas import PANEL_WIDTH, Canvas, Target, canvas, scaled_height, title_of
from fretsolve.post.plots.labels import (
    CLOSED_FORM,
    FIELD_NAMES,
    MOST_INCREMENTS,
    draw_lines,
    marks,
    short_number,
    unit_of,
)
from fretsolve.post.plots.load_history import chosen_stage_ends, load_texts, stored_stage_ends
from fretsolve.post.plots.pictures.maps import draw_panel, outline_key, scale_of
from fretsolve.post.plots.reference import closed_forms, hertz_pressure, shear_form, slip_form, worn_limit
from fretsolve.post.plots.snapshot import (
    VECTORS,
    Snapshot,
    chosen_fields,
    chosen_step,
    middle,
    require_field,
    shown_place,
    view_box,
)
from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.result import Result
from fretsolve.system.arrays import BoolArray, DoubleArray, IndexArray

PROFILE_FIELDS = ("pressure", "shear", "slip")
CLOSED_FORMS = {"pressure": hertz_pressure, "shear": shear_form, "slip": slip_form}

COMPONENTS: dict[str, dict[str, Any]] = {
    "x component: open markers": {"linewidth": 1.4},
    "y component: thin, filled markers": {"linewidth": 0.8, "markersize": 3.0},
}
"""Options that tell the components x and y of one increment apart, in one panel."""


@dataclass(frozen=True)
class ProfileLine:
    """A line through the contact along `axis` (0: x, 1: y), at `at` (mm) on the other axis.

    along: the cell centres on it, across: the cell centres on the other axis (mm).
    """

    axis: int
    at: float
    along: DoubleArray
    across: DoubleArray

    @property
    def text(self) -> str:
        """The title of a panel."""
        name, other = "xy" if self.axis == 0 else "yx"
        if len(self.across) == 1:
            return f"along {name}"
        return f"along {name} at {other} = {short_number(self.at, float(np.ptp(self.across)))} mm"

    def cut(self, values: DoubleArray) -> DoubleArray:
        """Return `values` (..., nx, ny) on the line, (..., n), linear between the two nearest rows of cells."""
        row = float(np.interp(self.at, self.across, np.arange(len(self.across))))
        low = int(row)
        high = min(low + 1, len(self.across) - 1)
        axis, part = -1 - self.axis, row - low
        return np.asarray((1.0 - part) * values.take(low, axis) + part * values.take(high, axis))


def profiles(
    result: Result, ax: Target = None, *, steps: Sequence[int] | None = None, at: tuple[float, float] | None = None
) -> Figure:
    """Draw pressure, shear traction and slip along x and y: a row of two panels for each stored field.

    Of a line contact it is one panel, along x.

    steps: increments; by default the ends of stages, of many the first two and the last four. at: the point (mm) that
    both lines go through; by default the middle of the contact at the last of the increments, or the largest
    pressure if nothing touches there. Components of vectors are drawn if they reach 2 % of the largest length. Raises
    PictureError.
    """
    chosen_step(result, None)
    chosen = [chosen_step(result, step) for step in steps] if steps else chosen_stage_ends(result)
    snapshots = [Snapshot(result, step) for step in chosen]
    names = chosen_fields(snapshots, PROFILE_FIELDS)
    lines = _lines(result, at or shown_place(snapshots[-1]))
    loads, forms = load_texts(result, chosen), closed_forms(result)
    with canvas(ax, len(lines) * len(names), (PANEL_WIDTH, 2.1), columns=len(lines), share="row") as drawn:
        panels = list(zip(drawn.axes, itertools.product(names, lines), strict=False))
        components = [_draw_panel(axes, line, name, snapshots, loads, forms) for axes, (name, line) in panels]
        for axes, (name, _) in panels:
            if name == "pressure":
                axes.set_ylim(bottom=0.0)  # once both panels of the row have their curves
        ends = 0 if steps else len(stored_stage_ends(result))
        drawn.heading(title_of(result), f"the ends of {len(chosen)} of {ends} stages" * (len(chosen) < ends))
        # each label once, closed forms last
        labelled = [pair for axes in drawn.axes for pair in zip(*axes.get_legend_handles_labels(), strict=True)]
        handles = {label: handle for handle, label in reversed(labelled)}
        labels = sorted(dict.fromkeys(label for _, label in labelled), key=lambda label: "closed form" in label)
        key = [
            Line2D([], [], color="0.3", marker="o", markerfacecolor=face, label=label, **options)
            for (label, options), face in zip(COMPONENTS.items(), ("white", "0.3"), strict=True)
        ]
        drawn.legend([*map(handles.get, labels), *(key if max(components) > 1 else [])], columns=len(lines))
    return drawn.figure


def _lines(result: Result, at: tuple[float, float]) -> tuple[ProfileLine, ...]:
    for name, position, centres in (("x", at[0], result.x), ("y", at[1], result.y)):
        if not centres[0] <= position <= centres[-1]:
            reach = f"from {centres[0]:.4g} to {centres[-1]:.4g} mm"
            raise PictureError(f"{name} = {position:g} mm is off the grid, whose cells lie {reach}")
    lines = ProfileLine(0, at[1], result.x, result.y), ProfileLine(1, at[0], result.y, result.x)
    return lines[:1] if len(result.y) == 1 else lines  # a line contact has a row of cells alone


def _draw_panel(
    axes: Axes,
    line: ProfileLine,
    name: str,
    snapshots: Sequence[Snapshot],
    loads: Sequence[str],
    forms: ClosedForms | None,
) -> int:
    """Draw one field along one line at several increments; return the number of its components.

    loads: of the increments, in words; forms: `closed_forms` of the result.
    """
    result = snapshots[0].result
    box = view_box(result, np.logical_or.reduce([snapshot.contact for snapshot in snapshots]))
    low, high = box.intervalx if line.axis == 0 else box.intervaly
    inside = (line.along >= low) & (line.along <= high)
    largest = max(float(snapshot.magnitude(name).max()) for snapshot in snapshots)
    unit = unit_of(result, name, largest)
    curves: list[Line2D] = []
    components: set[int] = set()
    points, across = np.linspace(low, high, 400), np.full(400, line.at)
    for snapshot, load, mark in zip(snapshots, loads, marks(len(snapshots)), strict=True):
        # values, the components of a vector one by one
        rows = np.atleast_2d(line.cut(snapshot.field(name)))
        outside = line.cut(snapshot.contact.astype(float)) == 0.0  # nothing touches there, which is not a value of 0
        shown = [k for k, row in enumerate(rows) if row.any() and np.abs(row).max() >= 0.02 * largest]
        components |= set(shown)
        label = f"increment {snapshot.step}: {load}"
        for k in shown:
            options = mark.options(int(inside.sum())) | list(COMPONENTS.values())[k]
            if k:
                options["markerfacecolor"] = mark.color
            values = np.where(outside, np.nan, rows[k])
            axes.plot(line.along[inside], values[inside] * unit.factor, label=label, **options)
        # a closed form that several increments share is drawn once
        curve = CLOSED_FORMS[name](result, snapshot.step, forms) if name in CLOSED_FORMS and shown else None
        if curve is not None:
            exact = np.atleast_2d(curve.at(*((points, across) if line.axis == 0 else (across, points)))) * unit.factor
            exact[:, (exact == 0.0).all(axis=0)] = np.nan  # beyond its edge
            for k in shown:
                if not any(np.allclose(exact[k], form.get_ydata(), rtol=1e-4, equal_nan=True) for form in curves):
                    curves += axes.plot(points, exact[k], label=f"{curve.name} (closed form)", **CLOSED_FORM)
    of_vector = [" and ".join("xy"[k] for k in sorted(components))] if name in VECTORS and components else []
    ylabel = " ".join([FIELD_NAMES[name], *of_vector, f"({unit.text})"])
    axes.set(xlim=(low, high), xlabel=f"{'xy'[line.axis]} (mm)", ylabel=ylabel, title=line.text)
    return len(components)


VISIBLE = 0.01
"""Error over the largest volume above which its band is wider than the line of the volume; the heading has any."""

HEIGHT = 2.6
"""Inches of a panel of wear."""


def wear(result: Result, ax: Target = None) -> Figure:
    """Draw the worn depth along x through the middle over the cycles, its map at the end, volume and depth over cycles.

    The depth is the sum over both bodies. Volume has its estimated error as a band where it is wide enough to be
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
        heights[:2] = [max(HEIGHT, scaled_height(box.height / box.width, PANEL_WIDTH))] * 2
    with canvas(ax, panels, (PANEL_WIDTH, HEIGHT), heights=heights) as drawn:
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
    wanted = volume[-1] * np.arange(1, 7) / 6.0  # up to six profiles
    places = np.searchsorted(volume, wanted * (1.0 - 1e-9))
    chosen = sorted({int(steps[min(place, len(steps) - 1)]) for place in places} - {int(steps[-1])})
    # of those that hardly differ from the last one, that alone
    worn = result.history["wear_volume"]
    return [*(step for step in chosen if worn[step] < 0.95 * volume[-1]), int(steps[-1])]


def _draw_profiles(axes: Axes, result: Result, worn: BoolArray) -> None:
    """Draw the depth along x, downwards, through the middle of the contact at the end."""
    steps = profile_steps(result)
    line = ProfileLine(0, middle(Snapshot(result, steps[-1]))[1], result.x, result.y)
    unit = unit_of(result, "wear_depth", float(result.history["wear_depth_max"].max()))
    touched = result.x[worn.any(axis=1)]
    low, high = (float(touched[0]), float(touched[-1])) if len(touched) else (float(result.x[0]), float(result.x[-1]))
    space = 0.1 * (high - low)
    depths = [line.cut(Snapshot(result, step).field("wear_depth")) * unit.factor for step in steps]
    labels = [f"after {result.history['cycles'][step]:g} cycles" for step in steps]
    draw_lines(axes, result.x, list(zip(labels, depths, strict=True)))
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
    axes.locator_params(axis="x", nbins=5)  # numbers of six digits stay apart
    axes.ticklabel_format(axis="x", scilimits=(0, 5), useMathText=True)


def _changes(result: Result) -> IndexArray:
    """Return the increments after which more cycles are counted, and the increment before the first such increment."""
    grown = np.flatnonzero(np.diff(result.history["cycles"]) > 0.0) + 1
    return np.concatenate([grown[:1] - 1, grown]) if len(grown) else np.array([0])
