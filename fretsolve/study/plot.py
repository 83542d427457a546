"""The picture of a study: the error of each run against its cost."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fretsolve.case.quantities import percent
from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Target, canvas
from fretsolve.plots.labels import line_colors
from fretsolve.study.assessment import Assessment, Row, front
from fretsolve.study.table import key_names
from fretsolve.study.variation import short
from fretsolve.study.wording import TARGETS

PANEL = (3.7, 2.9)
COLUMNS = 3

MARKED_KEYS = 3
"""Keys whose values the markers show: the first by shade, the second by shape, the third by size."""

MARKERS = "osD^vPX<>p"
MARKER, SMALLEST, LARGEST = 5.0, 3.6, 8.0
"""Widths of the markers (points): without a key that they show, and with one."""

FRONT: dict[str, Any] = {"color": "black", "linewidth": 1.0, "drawstyle": "steps-post", "zorder": 2.0}
FINEST: dict[str, Any] = {"color": "0.5", "linewidth": 1.2, "linestyle": "--", "zorder": 1.0}
TARGET: dict[str, Any] = {"color": "0.5", "linewidth": 1.0, "linestyle": ":", "zorder": 1.0}

LABEL_SIZE, LETTER, LABEL_GAP = 6.5, 3.9, 5.0
"""Points: of a label, the width of one of its letters, and its distance from the marker."""

INSIDE = (215.0, 150.0)
"""Size of a panel inside its axes (points), for labels that keep clear of each other."""

ROOM = 0.08
"""Part of an axis that is left free at each of its ends."""

LEAST_ROOM = math.log(1.5)

FINE_TICKS, FEW_DECADES = (1.0, 2.0, 5.0), 100.0
"""Ticks of an axis that spans less than this ratio."""

BELOW_LEAST = 0.4
"""Errors of 0 are drawn at this part of the least error above 0."""

ZERO: dict[str, Any] = {"ha": "right", "va": "center", "annotation_clip": False}
CLEAR = 1.6
"""Least ratio of a labelled tick to the place of 0."""

NO_ERROR = 1e-6
"""Stands for the least error if all errors of a panel are 0."""


@dataclass(frozen=True)
class Marking:
    """The look of the runs: by their values of the first key (shade), the second (marker) and the third (size)."""

    study: Assessment

    def of(self, row: Row) -> dict[str, Any]:
        """Return the options of the marker of a run."""
        settings = row.outcome.trial.settings
        options = [self.value(index, setting.value) for index, setting in enumerate(settings[:MARKED_KEYS])]
        merged: dict[str, Any] = {"marker": "o", "color": "0.4", "markersize": MARKER}
        for option in options:
            merged |= option
        return merged

    def value(self, index: int, value: str) -> dict[str, Any]:
        """Return the options that a value of the key `index` decides."""
        values = self.study.variations[index].values
        place = values.index(value)
        part = place / max(len(values) - 1, 1)
        if index == 0:
            return {"color": line_colors()(1.0 - part)}
        if index == 1:
            return {"marker": MARKERS[place % len(MARKERS)]}
        return {"markersize": SMALLEST + (LARGEST - SMALLEST) * (1.0 - part)}


def trade(study: Assessment, title: str = "", ax: Target = None) -> Figure:
    """Draw a panel for the worst error of each run and one per quantity, over the time of the run.

    Runs that no other one beats in both are joined and labelled. Raises PictureError.
    """
    rows = [row for row in study.rows if row.compared]
    if not rows:
        raise PictureError("no run has an error to draw")
    names = study.names
    panels = [("worst of the quantities", [row.worst for row in rows])] * (len(names) > 1)
    panels += [(_heading(study, name), [study.error_of(row, name) for row in rows]) for name in names]
    columns = min(COLUMNS, len(panels))
    with canvas(ax, -(-len(panels) // columns), columns, PANEL) as drawn:
        marking = Marking(study)
        for axes, (heading, errors) in zip(drawn.axes, panels, strict=False):
            _draw(axes, study, rows, errors, marking)
            axes.set_title(heading)
        for axes in drawn.axes[len(panels) :]:
            axes.set_visible(False)
        for axes in drawn.axes[max(len(panels) - columns, 0) : len(panels)]:
            axes.set_xlabel("time of the run (s)")
        for axes in drawn.axes[: len(panels) : columns]:
            axes.set_ylabel("error (%)")
        columns_of_legend = _legend(study, marking)
        height = max(map(len, columns_of_legend))
        handles = [handle for column in columns_of_legend for handle in (*column, *(height - len(column)) * [_blank()])]
        drawn.legend(handles, len(columns_of_legend))
        if drawn.own:
            drawn.figure.suptitle("\n".join(filter(None, [title, f"truth: {study.reference_words}"])), parse_math=False)
    return drawn.figure


def _heading(study: Assessment, name: str) -> str:
    stages = study.stages_of(name)
    return f"{name}, {'stage' if stages.isdecimal() else 'worst of stages'} {stages}"


def _draw(axes: Axes, study: Assessment, rows: Sequence[Row], errors: Sequence[float], marking: Marking) -> None:
    costs = [row.outcome.seconds for row in rows]
    least = min((error for error in errors if error > 0.0), default=NO_ERROR)
    heights = [100.0 * (error if error > 0.0 else BELOW_LEAST * least) for error in errors]
    finest = study.finest_row
    ends = [*costs, *([finest.outcome.seconds] if finest is not None else [])]
    axes.set_xscale("log")
    axes.set_yscale("log")
    longest = max(len(short(row.outcome.trial.settings)) for row in rows)
    axes.set_xlim(_limits(ends, (LETTER * longest + LABEL_GAP) / INSIDE[0]))
    axes.set_ylim(_limits(heights, LABEL_SIZE / INSIDE[1]))
    best = front(costs, errors)
    chosen = [index for index in sorted(range(len(rows)), key=costs.__getitem__) if best[index]]
    axes.plot([costs[index] for index in chosen], [heights[index] for index in chosen], **FRONT)
    for index, row in enumerate(rows):
        edge = {"markeredgecolor": "black", "markeredgewidth": 1.1} if best[index] else {"markeredgecolor": "white"}
        axes.plot(costs[index], heights[index], linestyle="", zorder=3.0 + best[index], **(marking.of(row) | edge))
    if finest is not None:
        axes.axvline(finest.outcome.seconds, **FINEST)
    for target in TARGETS:
        axes.axhline(100.0 * target, **TARGET)
    _label(axes, [(costs[index], heights[index], short(rows[index].outcome.trial.settings)) for index in chosen])
    zero = 100.0 * BELOW_LEAST * least if min(errors) == 0.0 else 0.0
    if zero:
        place = axes.get_yaxis_transform()
        axes.annotate("0", (0.0, zero), xycoords=place, xytext=(-4.0, 0.0), textcoords="offset points", **ZERO)
    for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        axis.set_major_locator(LogLocator(subs=FINE_TICKS if high < FEW_DECADES * low else (1.0,)))
        axis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value > CLEAR * zero else ""))


def _limits(values: Sequence[float], before: float) -> tuple[float, float]:
    """Return the limits of a logarithmic axis with room on both sides; before: part of the axis that labels need."""
    low, high = math.log(min(values)), math.log(max(values))
    room = max(ROOM * (high - low), LEAST_ROOM)
    return math.exp(low - room - before * (high - low + 2.0 * room)), math.exp(high + room)


def _label(axes: Axes, points: Sequence[tuple[float, float, str]]) -> None:
    """Label points of a front at their lower left, where no run is, unless labels would overlap."""
    taken: list[tuple[float, float, float]] = []
    for x, y, text in points:
        right, top = _place(axes.get_xlim(), x) * INSIDE[0], _place(axes.get_ylim(), y) * INSIDE[1]
        left = right - LABEL_GAP - LETTER * len(text)
        if any(left < end and right > begin and abs(top - height) < LABEL_SIZE for begin, end, height in taken):
            continue
        taken.append((left, right, top))
        to_the_right = left < 0.0
        axes.annotate(
            text,
            (x, y),
            xytext=(LABEL_GAP if to_the_right else -LABEL_GAP, -LABEL_GAP),
            textcoords="offset points",
            ha="left" if to_the_right else "right",
            va="top",
            fontsize=LABEL_SIZE,
            zorder=5.0,
        )


def _place(limits: tuple[float, float], value: float) -> float:
    """Return where `value` lies between logarithmic `limits`, from 0 to 1."""
    low, high = map(math.log, limits)
    return (math.log(value) - low) / (high - low)


def _legend(study: Assessment, marking: Marking) -> list[list[Line2D]]:
    """Return the columns of the legend: one for each key that the markers show, then the lines."""
    plain: dict[str, Any] = {"marker": "o", "color": "0.4", "markersize": MARKER, "markeredgecolor": "white"}
    plain |= {"linestyle": ""}
    keys = [
        [Line2D([], [], label=f"{name} {value}", **(plain | marking.value(index, value))) for value in variation.values]
        for index, (name, variation) in enumerate(zip(key_names(study.variations), study.variations, strict=True))
    ]
    lines = [
        Line2D([], [], label="none is cheaper and as accurate", marker="o", markerfacecolor="white", **FRONT),
        Line2D([], [], label="time of the finest run", **FINEST),
        Line2D([], [], label=" and ".join(percent(target) for target in TARGETS), **TARGET),
    ]
    return [*keys[:MARKED_KEYS], lines]


def _blank() -> Line2D:
    return Line2D([], [], linestyle="", label=" ")
