"""What each increment cost, and how well it is solved."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fretsolve.export.text_report import stage_ends
from fretsolve.plots.canvas import Target, canvas
from fretsolve.plots.load_history import require_increments
from fretsolve.plots.marks import marks

if TYPE_CHECKING:
    from fretsolve.result import Result

PANEL = (8.0, 2.7)
COUNTS = ("iterations_normal", "iterations_tangential", "alternations")
RESIDUALS = ("residual_gap", "residual_stick", "residual_slip", "residual_bound", "residual_load")
FLOOR = 1e-4
"""Residuals below this part of the tolerance are round-off, which would take up most of the axis."""

MOST_STAGES = 60
"""Of more stages the ends are not marked: the lines would hide the curves."""


def convergence(result: Result, ax: Target = None) -> Figure:
    """Iterations and alternations per increment, and below them the residuals with the tolerance as a line.

    Residuals below 1e-4 of the tolerance are drawn there. Raises PictureError.
    """
    require_increments(result)
    with canvas(ax, 2, 1, PANEL, sharex=True) as drawn:
        for axes, draw in zip(drawn.axes, (_draw_counts, _draw_residuals), strict=False):
            draw(axes, result)
            _mark_stages(axes, result)
            axes.set_xlim(-0.5, result.increments - 0.5)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
        drawn.axes[-1].set_xlabel("increment (vertical lines: ends of stages)")
        drawn.heading(result)
    return drawn.figure


def _draw_counts(axes: Axes, result: Result) -> None:
    for name, mark in zip(COUNTS, marks(len(COUNTS)), strict=True):
        values = result.history[name]
        options = mark.options(len(values)) | {"linewidth": 1.1}
        axes.plot(result.history["step"], values, label=name.replace("_", " "), **options)
    axes.set_ylim(bottom=0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
    axes.set_ylabel("count per increment (1)")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def _draw_residuals(axes: Axes, result: Result) -> None:
    axes.set_yscale("log")
    tolerance = float(result.effective_case.get("solver", {}).get("tolerance", np.nan))
    least = FLOOR * tolerance if np.isfinite(tolerance) else np.finfo(float).eps
    for name, mark in zip(RESIDUALS, marks(len(RESIDUALS)), strict=True):
        values = np.maximum(result.history[name], least)
        options = mark.options(len(values)) | {"linewidth": 1.1}
        axes.plot(result.history["step"], values, label=name.removeprefix("residual_"), **options)
    if np.isfinite(tolerance):
        axes.axhline(tolerance, color="black", linestyle="--", linewidth=1.2, label=f"tolerance {tolerance:g}")
    axes.set_ylabel(f"residual (1; slip: rad),\nbelow {least:.0e}: drawn there")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def _mark_stages(axes: Axes, result: Result) -> None:
    ends = stage_ends(result.history["stage"])[:-1]
    for end in ends if len(ends) <= MOST_STAGES else ():
        axes.axvline(end + 0.5, color="0.75", linewidth=0.8, zorder=0.6)
