"""How much of the contact sticks, over the load."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Canvas, Target, canvas
from fretsolve.plots.load_history import MovedPair, cycles, last_driven, moved_pairs, require_increments
from fretsolve.plots.loops import add_cycle_colorbar, place_legend
from fretsolve.plots.marks import CLOSED_FORM, MOST_INCREMENTS, MOST_NAMED, marks
from fretsolve.plots.quantities import axis_label, unit_of
from fretsolve.plots.reference import stick_form
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result import Result

PANEL = (4.9, 3.6)


def stick_history(result: Result, ax: Target = None) -> Figure:
    """c/a, the stick over the contact radius, over each tangential load that the path moves, or over P.

    Radii are those of circles of equal area. Closed forms for the forces found are drawn where they apply. Raises
    PictureError.
    """
    pairs = _pairs(result)
    with canvas(ax, 1, len(pairs), PANEL) as drawn:
        for axes, pair in zip(drawn.axes, pairs, strict=False):
            _draw(drawn, axes, result, pair)
        drawn.heading(result)
    return drawn.figure


def stick_ratio(result: Result) -> DoubleArray:
    """c/a of each increment, NaN without a contact."""
    contact = result.history["contact_radius"]
    touching = np.where(contact > 0.0, contact, np.nan)
    return np.asarray(result.history["stick_radius"] / touching)


def _pairs(result: Result) -> list[MovedPair]:
    require_increments(result)
    if not np.any(result.history["max_shear"]) and not np.any(result.history["stick_radius"]):
        raise PictureError("nothing sticks or slips without friction and shear")
    pairs = moved_pairs(result)
    tangential = [pair for pair in pairs if pair.force in ("Qx", "Qy", "Mz")]
    return tangential or [pair for pair in pairs if pair.force == "P"]


def _draw(drawn: Canvas, axes: Axes, result: Result, pair: MovedPair) -> None:
    name = last_driven(pair)
    unit = unit_of(result, name)
    load, ratio = result.history[name] * unit.factor, stick_ratio(result)
    found = cycles(result, pair)
    handles: list[Any] = []
    for cycle, mark in zip(found, marks(len(found)), strict=True):
        steps = cycle.steps
        options = mark.options(len(load[steps]), MOST_INCREMENTS)
        handles += axes.plot(load[steps], ratio[steps], label=cycle.name, **options)
    form = stick_form(result, pair.force)
    if form is not None:
        handles += axes.plot(load, form.values, label=f"{form.name} (closed form)", **CLOSED_FORM)
    axes.set_ylim(-0.03, 1.05)
    axes.set_xlabel(axis_label(name, unit))
    axes.set_ylabel("stick radius over contact radius, c/a (1)")
    if len(found) > MOST_NAMED:
        add_cycle_colorbar(drawn, axes, found)
        handles = [handle for handle in handles if not str(handle.get_label()).startswith("cycle")]
    place_legend(axes, handles)
