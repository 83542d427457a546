"""The fields of one increment, with what the pictures derive from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.errors import PictureError
from fretsolve.plots.load_history import require_increments
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, DoubleArray

if TYPE_CHECKING:
    from fretsolve.result import Result


VECTORS = ("shear", "slip")
"""Fields of two components; they are named as in the case file, without the component."""

MARGIN = 0.12
"""Space around the contact in a map, in parts of its size."""


@dataclass(frozen=True)
class Window:
    """A part of the contact plane (mm)."""

    x: tuple[float, float]
    y: tuple[float, float]

    @property
    def aspect(self) -> float:
        """Height over width."""
        return (self.y[1] - self.y[0]) / (self.x[1] - self.x[0])


class Snapshot:
    """The stored fields of increment `step`, read when they are asked for.

    Fields go by the names of the case file: pressure, shear, slip, slip_path, work_density, zone, gap.
    """

    def __init__(self, result: Result, step: int):
        self.result = result
        self.step = step
        self._read: dict[str, DoubleArray] = {}

    def field(self, name: str) -> DoubleArray:
        """A field, ``(nx, ny)``, vectors ``(2, nx, ny)``, in the result's units. Raises PictureError if not stored."""
        require_field(self.result, name)
        if name not in self._read:
            names = (f"{name}_x", f"{name}_y") if name in VECTORS else (name,)
            members = [np.asarray(self.result.field(member, self.step), float) for member in names]
            self._read[name] = np.stack(members) if name in VECTORS else members[0]
        return self._read[name]

    def magnitude(self, name: str) -> DoubleArray:
        """A scalar field, or the length of a vector field, ``(nx, ny)``."""
        values = self.field(name)
        return np.hypot(values[0], values[1]) if name in VECTORS else values

    @cached_property
    def contact(self) -> BoolArray:
        """Cells in contact, ``(nx, ny)``."""
        if has_field(self.result, "zone"):
            return np.asarray(self.field("zone") != Zone.OPEN)
        return np.asarray(self.field("pressure") > 0.0)

    @cached_property
    def stick(self) -> BoolArray | None:
        """Cells that stick, ``(nx, ny)``; None where the zones are not stored."""
        return self.field("zone") == Zone.STICK if has_field(self.result, "zone") else None


def has_field(result: Result, name: str) -> bool:
    """Whether a field, by its name in the case file, is stored."""
    return (f"{name}_x" if name in VECTORS else name) in result.fields


def stored_names(result: Result) -> list[str]:
    """The fields that are stored, by their names in the case file."""
    return list(dict.fromkeys(name.removesuffix("_x").removesuffix("_y") for name in result.fields))


def require_field(result: Result, name: str) -> None:
    """Raise PictureError where the field is not stored."""
    if not has_field(result, name):
        there = ", ".join(stored_names(result)) or "none"
        raise PictureError(
            f"the field {name!r} is not stored, only {there}; output.fields in the case file chooses them"
        )


def chosen_step(result: Result, step: int | None) -> int:
    """The increment asked for (negative: from the end), by default the last one with fields. Raises PictureError."""
    require_increments(result)
    if not result.steps or not result.fields:
        raise PictureError("no fields are stored; output.fields in the case file chooses them")
    if step is None:
        return result.steps[-1]
    wanted = step + result.increments if step < 0 else step
    if not 0 <= wanted < result.increments:
        raise PictureError(f"there is no increment {step}; there are 0 to {result.increments - 1}")
    if wanted not in result.steps:
        nearest = min(result.steps, key=lambda stored: abs(stored - wanted))
        raise PictureError(
            f"the fields of increment {wanted} are not stored (output.every); the nearest ones are those of {nearest}"
        )
    return wanted


def middle(snapshot: Snapshot) -> tuple[float, float]:
    """The middle of the contact (mm); that of the grid where it is no more than a cell away, or nothing touches."""
    result = snapshot.result
    places = []
    for (low, high), centres in zip(_extent(result, _union([snapshot])), (result.x, result.y), strict=True):
        found, of_grid = 0.5 * (low + high), 0.5 * float(centres[0] + centres[-1])
        cell = float(centres[1] - centres[0]) if len(centres) > 1 else 1.0
        places.append(of_grid if abs(found - of_grid) <= cell else found)
    return places[0], places[1]


def common_window(snapshots: Sequence[Snapshot]) -> Window:
    """The window of the contacts of all `snapshots` together."""
    return window(snapshots[0].result, _union(snapshots))


def window(result: Result, contact: BoolArray) -> Window:
    """The contact with some space around it, within the grid; the whole grid where nothing touches."""
    sides = []
    for (low, high), centres in zip(_extent(result, contact), (result.x, result.y), strict=True):
        cell = float(centres[1] - centres[0]) if len(centres) > 1 else 1.0
        space = max(MARGIN * (high - low), 1.5 * cell)
        edges = float(centres[0]) - 0.5 * cell, float(centres[-1]) + 0.5 * cell
        sides.append((max(edges[0], low - space), min(edges[1], high + space)))
    return Window(*sides)


def _union(snapshots: Sequence[Snapshot]) -> BoolArray:
    """Cells in contact in any of `snapshots`; none where it is not stored what touches."""
    result = snapshots[0].result
    if has_field(result, "zone") or has_field(result, "pressure"):
        return np.asarray(np.logical_or.reduce([snapshot.contact for snapshot in snapshots]))
    return np.zeros((len(result.x), len(result.y)), bool)


def _extent(result: Result, contact: BoolArray) -> list[tuple[float, float]]:
    """First and last cell centre in contact along x and along y (mm), those of the grid where none is."""
    sides = []
    for axis, centres in enumerate((result.x, result.y)):
        inside = np.flatnonzero(contact.any(axis=1 - axis))
        first, last = (inside[0], inside[-1]) if len(inside) else (0, -1)
        sides.append((float(centres[first]), float(centres[last])))
    return sides
