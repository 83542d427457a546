"""The picture of a study: the error of each run against its cost."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from fretsolve.case.dimensions import percent
from fretsolve.errors import PictureError
from fretsolve.post.plots.canvas import MOST_COLUMNS, canvas, one_line
from fretsolve.post.plots.labels import line_colors, physical_name
from fretsolve.sweep.quantity import place_of
from fretsolve.sweep.study.assessment import AssessedRun, Assessment, front
from fretsolve.sweep.study.plan import short
from fretsolve.sweep.study.report import TARGETS, key_names

LOOKS: dict[str, dict[str, Any]] = {
    "run": {"marker": "o", "color": "0.4", "markersize": 5.0, "linestyle": ""},
    "front": {"color": "black", "linewidth": 1.0, "drawstyle": "steps-post", "zorder": 2.0},
    "finest": {"color": "0.5", "linewidth": 1.2, "linestyle": "--", "zorder": 1.0},
    "target": {"color": "0.5", "linewidth": 1.0, "linestyle": ":", "zorder": 1.0},
}
"""Options of markers and lines."""

LABEL_SIZE, LETTER, LABEL_GAP = 6.5, 3.9, 5.0
"""Points: of a label, the width of one of its letters, and its distance from the marker."""

INSIDE = (215.0, 150.0)
"""Size of a panel inside its axes (points), for labels that keep clear of each other."""


def trade(study: Assessment, title: str) -> Figure:
    """Draw a panel for the worst error of each run and one per quantity, over the time of the run.

    Runs that no other one beats in both are joined and labelled. Raises PictureError.
    """
    rows = [row for row in study.rows if row.compared]
    if not rows:
        raise PictureError("no run has an error to draw")
    panels = [("worst of the quantities", [row.worst for row in rows])] * (len(study.names) > 1)
    for name in study.names:
        stages = study.stages_of(name)
        heading = f"{physical_name(name)}, {'worst of ' * (len(stages) > 1)}{place_of(name, stages)}"
        panels.append((heading, [study.error_of(row, name) for row in rows]))
    with canvas(None, len(panels), (3.7, 2.9)) as drawn:
        for axes, (heading, errors) in zip(drawn.axes, panels, strict=False):
            _draw(axes, study, rows, errors)
            axes.set_title(heading)
        for axes in drawn.axes[-MOST_COLUMNS:]:
            axes.set_xlabel("time of the run (s)")
        for axes in drawn.axes[::MOST_COLUMNS]:
            axes.set_ylabel("error (%)")
        legend = _legend(study)
        height = max(map(len, legend))
        blank = [Line2D([], [], linestyle="", label=" ")]
        drawn.legend([handle for column in legend for handle in column + blank * (height - len(column))], len(legend))
        drawn.heading(one_line(title), f"reference: {study.plan.reference_words}")
    return drawn.figure


def _draw(axes: Axes, study: Assessment, rows: Sequence[AssessedRun], errors: Sequence[float]) -> None:
    costs, finest = [row.outcome.seconds for row in rows], study.finest.outcome.seconds
    zero = 40.0 * min((error for error in errors if error > 0.0), default=1e-6)  # where errors of 0 are drawn
    heights = [100.0 * error if error > 0.0 else zero for error in errors]
    longest = max(len(short(row.case.settings)) for row in rows)
    before = (LETTER * longest + LABEL_GAP) / INSIDE[0], LABEL_SIZE / INSIDE[1]
    limits = _limits([*costs, finest], before[0]), _limits(heights, before[1])
    axes.set(xscale="log", yscale="log", xlim=limits[0], ylim=limits[1])
    # runs and front
    best, looks = front(costs, errors), _looks(study)
    chosen = [index for index in sorted(range(len(rows)), key=costs.__getitem__) if best[index]]
    points = [(costs[index], heights[index], short(rows[index].case.settings)) for index in chosen]
    axes.plot([point[0] for point in points], [point[1] for point in points], **LOOKS["front"])
    for index, row in enumerate(rows):
        edge = {"markeredgecolor": "black", "markeredgewidth": 1.1} if best[index] else {"markeredgecolor": "white"}
        options = LOOKS["run"] | edge
        for look, value in zip(looks, row.case.settings.values(), strict=False):
            options |= look[value]
        axes.plot(costs[index], heights[index], zorder=3.0 + best[index], **options)
    _label(axes, points)
    # lines
    axes.axvline(finest, **LOOKS["finest"])
    for target in TARGETS:
        axes.axhline(100.0 * target, **LOOKS["target"])
    # ticks, also at the place of 0
    for axis, (low, high) in zip((axes.xaxis, axes.yaxis), limits, strict=True):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 100.0 * low else (1.0,)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
    if min(errors) == 0.0:
        place: dict[str, Any] = {"xytext": (-4.0, 0.0), "textcoords": "offset points", "ha": "right", "va": "center"}
        axes.annotate("0", (0.0, zero), xycoords=axes.get_yaxis_transform(), annotation_clip=False, **place)
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value > 1.6 * zero else ""))


def _limits(values: Sequence[float], before: float) -> tuple[float, float]:
    """Return the limits of a logarithmic axis with room on both sides; before: part of the axis that labels need."""
    low, high = math.log(min(values)), math.log(max(values))
    room = max(0.08 * (high - low), math.log(1.5))
    return math.exp(low - room - before * (high - low + 2.0 * room)), math.exp(high + room)


def _label(axes: Axes, points: Sequence[tuple[float, float, str]]) -> None:
    """Label points of a front at their lower left, where no run is, unless labels would overlap."""
    taken: list[Bbox] = []
    to_panel = axes.transScale + axes.transLimits
    for x, y, text in points:
        right, top = to_panel.transform((x, y)) * INSIDE
        left = right - LABEL_GAP - LETTER * len(text)
        box = Bbox.from_extents(left, top - LABEL_SIZE, right, top)
        if box.count_overlaps(taken):
            continue
        taken.append(box)
        side, sign = ("left", 1.0) if left < 0.0 else ("right", -1.0)
        place: dict[str, Any] = {"xytext": (sign * LABEL_GAP, -LABEL_GAP), "textcoords": "offset points", "ha": side}
        axes.annotate(text, (x, y), va="top", fontsize=LABEL_SIZE, zorder=5.0, **place)


def _looks(study: Assessment) -> list[dict[str, dict[str, Any]]]:
    """Return the options of the markers by the values of the first three keys: their shades, shapes and sizes."""
    options: tuple[Callable[[int, float], dict[str, Any]], ...] = (
        lambda place, rest: {"color": line_colors()(rest)},
        lambda place, rest: {"marker": "osD^vPX<>p"[place % 10]},
        lambda place, rest: {"markersize": 3.6 + 4.4 * rest},
    )
    return [
        {value: option(place, 1.0 - place / max(len(values) - 1, 1)) for place, value in enumerate(values)}
        for option, values in zip(options, study.plan.variations.values(), strict=False)
    ]


def _legend(study: Assessment) -> list[list[Line2D]]:
    """Return the columns of the legend: one for each key that the markers show, then the lines."""
    keys = [
        [
            Line2D([], [], label=f"{name} {value}", markeredgecolor="white", **(LOOKS["run"] | options))
            for value, options in look.items()
        ]
        for name, look in zip(key_names(study.plan.variations), _looks(study), strict=False)
    ]
    lines = [
        Line2D([], [], label="Pareto front", marker="o", markerfacecolor="white", **LOOKS["front"]),
        Line2D([], [], label="time of the finest run", **LOOKS["finest"]),
        Line2D([], [], label=" and ".join(percent(target) for target in TARGETS), **LOOKS["target"]),
    ]
    return [*keys, lines]
