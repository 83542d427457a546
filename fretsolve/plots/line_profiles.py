"""Draw pressure, shear traction and slip along two lines through the contact, with closed forms beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fretsolve.errors import PictureError
from fretsolve.plots.canvas import Target, canvas
from fretsolve.plots.labels import CLOSED_FORM, marks, readable, short_number
from fretsolve.plots.load_history import chosen_stage_ends, load_text
from fretsolve.plots.maps import NAMES
from fretsolve.plots.reference import Curve, hertz_pressure, shear_form
from fretsolve.plots.snapshot import (
    VECTORS,
    Snapshot,
    chosen_step,
    common_contact,
    component,
    middle,
    present_fields,
    view_box,
)
from fretsolve.result import Result
from fretsolve.system.arrays import DoubleArray

FIELDS = ("pressure", "shear", "slip")
PANEL = (4.6, 2.5)
LEAST_COMPONENT = 0.02
"""A component is drawn if it reaches this part of the field's largest length."""

CURVE_POINTS = 400

COMPONENTS: tuple[dict[str, Any], ...] = ({"linewidth": 1.4}, {"linewidth": 0.8, "markersize": 3.0})
"""Options that tell the components x and y of one increment apart, in one panel."""

_COMPONENT_KEY = ("x component: open markers", "y component: thin, filled markers")


@dataclass(frozen=True)
class ProfileLine:
    """A line through the contact along `axis` (0: x, 1: y), at `at` (mm) on the other axis.

    along: the cell centres on it, across: those on the other axis (mm).
    """

    axis: int
    at: float
    along: DoubleArray
    across: DoubleArray

    @property
    def text(self) -> str:
        """The title of a panel."""
        name, other = "xy" if self.axis == 0 else "yx"
        return f"along {name} at {other} = {short_number(self.at, float(np.ptp(self.across)))} mm"

    def cut(self, values: DoubleArray) -> DoubleArray:
        """Return `values` (..., nx, ny) on the line, (..., n), linear between the two nearest rows of cells."""
        row = float(np.interp(self.at, self.across, np.arange(len(self.across))))
        low = int(row)
        high = min(low + 1, len(self.across) - 1)
        axis, part = -1 - self.axis, row - low
        return np.asarray((1.0 - part) * values.take(low, axis) + part * values.take(high, axis))

    def points(self, along: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
        """Return x and y of positions on the line."""
        other = np.full_like(along, self.at)
        return (along, other) if self.axis == 0 else (other, along)


def profiles(
    result: Result,
    ax: Target = None,
    *,
    steps: Sequence[int] | None = None,
    at: tuple[float, float] | None = None,
) -> Figure:
    """Draw pressure, shear traction and slip along x and y: a row of two panels for each of them that is stored.

    steps: increments; by default the ends of stages, of many the first two and the last four. at: the point (mm) that
    both lines go through; by default the middle of the contact at the last of the increments. Components of vectors
    are drawn if they reach 2 % of the largest length. Raises PictureError.
    """
    chosen_step(result, None)
    chosen = [chosen_step(result, step) for step in steps] if steps else chosen_stage_ends(result)
    snapshots = [Snapshot(result, step) for step in chosen]
    names = present_fields(snapshots, FIELDS)
    lines = _lines(result, at or middle(snapshots[-1]))
    with canvas(ax, len(names), 2, PANEL) as drawn:
        pairs = [(name, line) for name in names for line in lines]
        panels = [_Panel(axes, line, name, snapshots) for axes, (name, line) in zip(drawn.axes, pairs, strict=False)]
        handles: dict[str, Line2D] = {}
        for panel in panels:
            for handle in panel.draw():
                handles.setdefault(str(handle.get_label()), handle)
        drawn.heading(result)
        drawn.legend([*handles.values(), *_component_key(panels)], columns=2)
    return drawn.figure


def _lines(result: Result, at: tuple[float, float]) -> tuple[ProfileLine, ProfileLine]:
    for name, position, centres in (("x", at[0], result.x), ("y", at[1], result.y)):
        if not centres[0] <= position <= centres[-1]:
            reach = f"from {centres[0]:.4g} to {centres[-1]:.4g} mm"
            raise PictureError(f"{name} = {position:g} mm is off the grid, whose cells lie {reach}")
    return ProfileLine(0, at[1], result.x, result.y), ProfileLine(1, at[0], result.y, result.x)


class _Panel:
    """One field along one line, at several increments."""

    def __init__(self, axes: Axes, line: ProfileLine, name: str, snapshots: Sequence[Snapshot]):
        self.axes, self.line, self.name, self.snapshots = axes, line, name, snapshots
        result = snapshots[0].result
        self.largest = max(float(snapshot.magnitude(name).max()) for snapshot in snapshots)
        self.unit = readable(result.units(component(name)), self.largest)
        box = view_box(result, common_contact(snapshots))
        self.limits = box.x if line.axis == 0 else box.y
        self.components: set[int] = set()

    def draw(self) -> list[Line2D]:
        """Draw the panel, and return its lines for the legend."""
        found: list[Line2D] = []
        forms: list[tuple[Curve, list[int]]] = []
        inside = (self.line.along >= self.limits[0]) & (self.line.along <= self.limits[1])
        for snapshot, mark in zip(self.snapshots, marks(len(self.snapshots)), strict=True):
            rows = np.atleast_2d(self.line.cut(snapshot.field(self.name)))
            least = LEAST_COMPONENT * self.largest
            shown = [k for k, row in enumerate(rows) if row.any() and np.abs(row).max() >= least]
            for k in shown:
                options = mark.options(int(inside.sum())) | COMPONENTS[k]
                if k:
                    options["markerfacecolor"] = mark.color
                values = rows[k][inside] * self.unit.factor
                label = f"increment {snapshot.step}: {load_text(snapshot.result, snapshot.step)}"
                found += self.axes.plot(self.line.along[inside], values, label=label, **options)
            self.components |= set(shown)
            form = _closed_form(snapshot, self.name)
            if form is not None and shown:
                forms.append((form, shown))
        found += self._draw_forms(forms)
        self.axes.set_xlim(self.limits)
        self.axes.set_xlabel(f"{'xy'[self.line.axis]} (mm)")
        self.axes.set_ylabel(f"{self._axis_name()} ({self.unit.text})")
        self.axes.set_title(self.line.text)
        return found

    def _draw_forms(self, forms: Sequence[tuple[Curve, Sequence[int]]]) -> list[Line2D]:
        """Draw the closed forms, once if those of several increments are the same."""
        along = np.linspace(*self.limits, CURVE_POINTS)
        found: list[Line2D] = []
        before: list[DoubleArray] = []
        for form, components in forms:
            rows = np.atleast_2d(form.at(*self.line.points(along))) * self.unit.factor
            for k in components:
                if not any(np.allclose(rows[k], other, rtol=1e-4) for other in before):
                    found += self.axes.plot(along, rows[k], label=f"{form.name} (closed form)", **CLOSED_FORM)
                    before.append(rows[k])
        return found

    def _axis_name(self) -> str:
        """Return the field with the components that are drawn, such as ``slip x``."""
        components = " and ".join("xy"[k] for k in sorted(self.components)) if self.name in VECTORS else ""
        return f"{NAMES[self.name]} {components}".rstrip()


def _closed_form(snapshot: Snapshot, name: str) -> Curve | None:
    if name == "pressure":
        return hertz_pressure(snapshot.result, snapshot.step)
    return shear_form(snapshot.result, snapshot.step) if name == "shear" else None


def _component_key(panels: Sequence[_Panel]) -> list[Line2D]:
    """Return lines that show how the components differ, if a panel has both."""
    if not any(len(panel.components) > 1 for panel in panels):
        return []
    shades = ({"markerfacecolor": "white"}, {"markerfacecolor": "0.3"})
    return [
        Line2D([], [], color="0.3", marker="o", label=label, **(options | shade))
        for label, options, shade in zip(_COMPONENT_KEY, COMPONENTS, shades, strict=True)
    ]
