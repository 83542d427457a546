"""Read the fields of one increment, and choose the part of the contact plane to show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from matplotlib.transforms import Bbox

from fretsolve.errors import PictureError
from fretsolve.post.export.selection import stored_names, stored_step
from fretsolve.result import Result
from fretsolve.result.state import Zone
from fretsolve.system.arrays import BoolArray, DoubleArray

VECTORS = ("shear", "slip")
"""Fields of two components, by their names in the case file, which leave out the component."""


class Snapshot:
    """The stored fields of increment `step`, read on first use.

    Fields have the names of the case file: pressure, shear, slip, slip_path, work_density, zone, gap.
    """

    def __init__(self, result: Result, step: int):
        self.result = result
        self.step = step
        self._read: dict[str, DoubleArray] = {}

    def field(self, name: str) -> DoubleArray:
        """Return a field, ``(nx, ny)``, or a vector field, ``(2, nx, ny)``, in the result's units.

        Raises PictureError if it is not stored.
        """
        require_field(self.result, name)
        if name not in self._read:
            self._read[name] = np.asarray(self.result.field(name, self.step), float)
        return self._read[name]

    def magnitude(self, name: str) -> DoubleArray:
        """Return a scalar field, or the length of a vector field, ``(nx, ny)``; 0 for an infinite gap (no material)."""
        values = np.hypot(*self.field(name)) if name in VECTORS else self.field(name)
        return np.where(np.isfinite(values), values, 0.0)

    @cached_property
    def contact(self) -> BoolArray:
        """Cells in contact, ``(nx, ny)``; none if no stored field shows them."""
        if "zone" in self.result.fields:
            return np.asarray(self.field("zone") != Zone.OPEN)
        if "pressure" in self.result.fields:
            return np.asarray(self.field("pressure") > 0.0)
        return np.zeros((len(self.result.x), len(self.result.y)), bool)

    @cached_property
    def stick(self) -> BoolArray | None:
        """Cells that stick, ``(nx, ny)``; None if the zones are not stored."""
        return self.field("zone") == Zone.STICK if "zone" in self.result.fields else None


def require_increments(result: Result) -> None:
    """Raise PictureError if the run has not saved an increment yet."""
    if not result.increments:
        raise PictureError(result.why_empty)


def require_field(result: Result, name: str) -> None:
    """Raise PictureError if the field is not stored."""
    stored = stored_names(result)
    if name not in stored:
        there = ", ".join(stored) or "none"
        raise PictureError(f"no field {name!r} is stored, only {there}; output.fields in the case file chooses them")


def require_area(result: Result) -> None:
    """Raise PictureError if the contact is a line, of one row of cells."""
    if len(result.y) == 1:
        raise PictureError("a line contact has one row of cells along x; profiles draws its fields")


def chosen_fields(snapshots: Sequence[Snapshot], usual: Sequence[str], asked: Sequence[str] | None = None) -> list[str]:
    """Return the fields asked for, else the usual ones that are stored and not 0 everywhere, or the first stored one.

    Raises PictureError if a field asked for, or all usual ones, are not stored.
    """
    result = snapshots[0].result
    stored = [name for name in usual if name in stored_names(result)]
    for name in asked or stored or usual[:1]:
        require_field(result, name)
    if asked:
        return list(dict.fromkeys(asked))
    return [name for name in stored if any(snapshot.field(name).any() for snapshot in snapshots)] or stored[:1]


def chosen_step(result: Result, step: int | None) -> int:
    """Return increment `step` (negative: from the end), by default the last one with fields. Raises PictureError."""
    require_increments(result)
    if not result.steps or not result.fields:
        raise PictureError("no fields are stored; output.fields in the case file chooses them")
    try:
        return result.steps[-1] if step is None else stored_step(result, step)
    except ValueError as error:
        raise PictureError(str(error)) from error


def cell_size(centres: DoubleArray) -> float:
    """Return the side of a cell (mm); 1 for a single cell."""
    return float(centres[1] - centres[0]) if len(centres) > 1 else 1.0


def outer_edges(centres: DoubleArray) -> tuple[float, float]:
    """Return where the first cell begins and the last one ends (mm)."""
    half = 0.5 * cell_size(centres)
    return float(centres[0]) - half, float(centres[-1]) + half


def middle(snapshot: Snapshot) -> tuple[float, float]:
    """Return the middle of the contact (mm), or of the grid if that is at most a cell away or nothing touches."""
    found = []
    for centres, low, high in _extent(snapshot.result, snapshot.contact):
        of_contact, of_grid = 0.5 * (low + high), 0.5 * float(centres[0] + centres[-1])
        found.append(of_grid if abs(of_contact - of_grid) <= cell_size(centres) else of_contact)
    return found[0], found[1]


def shown_place(snapshot: Snapshot) -> tuple[float, float]:
    """Return the middle of the contact (mm), or the place of the largest pressure if nothing touches in the middle."""
    result, at = snapshot.result, middle(snapshot)
    cell = tuple(int(np.abs(centres - place).argmin()) for centres, place in zip((result.x, result.y), at, strict=True))
    if snapshot.contact[cell] or not snapshot.contact.any():
        return at
    weight = snapshot.field("pressure") if "pressure" in result.fields else snapshot.contact
    i, j = np.unravel_index(int(np.argmax(weight)), weight.shape)
    return float(result.x[i]), float(result.y[j])


def view_box(result: Result, contact: BoolArray) -> Bbox:
    """Return the contact with some space around it (mm), within the grid; the whole grid if nothing touches."""
    sides = []
    for centres, low, high in _extent(result, contact):
        space = max(0.12 * (high - low), 1.5 * cell_size(centres))
        first, last = outer_edges(centres)
        sides.append((max(first, low - space), min(last, high + space)))
    return Bbox(np.transpose(sides))


def _extent(result: Result, contact: BoolArray) -> Iterator[tuple[DoubleArray, float, float]]:
    """Yield the cell centres along x and y, with the first and the last in contact (mm), or of all if none is."""
    for axis, centres in enumerate((result.x, result.y)):
        touching = centres[contact.any(axis=1 - axis)]
        ends = touching if len(touching) else centres
        yield centres, float(ends[0]), float(ends[-1])
