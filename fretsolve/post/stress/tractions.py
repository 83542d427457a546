"""Tractions, bulk stresses and elastic bodies of a result, as the stress below its surface needs them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fretsolve.case.history import BULK
from fretsolve.errors import CaseError
from fretsolve.post.stress.influence import TRACTIONS, Body, Traction
from fretsolve.post.stress.layers import Window
from fretsolve.problem.model.grid import Grid
from fretsolve.result import Result
from fretsolve.system.arrays import BoolArray, DoubleArray

BODIES: tuple[Body, Body] = (1, 2)


@dataclass(frozen=True, eq=False)
class TractionHistory:
    """Reads the tractions of a result one increment at a time.

    Raises CaseError if the result lacks what the stress follows from.
    """

    result: Result

    def __post_init__(self) -> None:
        result = self.result
        if not result.increments:
            raise CaseError(result.why_empty, (), result.path)
        if len(result.x) < 2 or (len(result.y) < 2 and not self.plane_strain):
            raise CaseError("the grid has only one cell across, which is too few for stresses", (), result.path)
        missing = "pressure" not in result.fields or (self.has_shear and "shear_x" not in result.fields)
        if missing:
            message = "the result does not hold pressure and shear, from which stresses follow"
            raise CaseError(f"{message}; output.fields in the case chooses them", (), result.path)

    @cached_property
    def grid(self) -> Grid:
        """The grid of the result."""
        x, y = self.result.x, self.result.y
        if self.plane_strain:
            dx = float(x[-1] - x[0]) / (len(x) - 1)
            return Grid(len(x), 1, dx, dx, float(x[0] + x[-1]) / 2)
        dx, dy = (float(axis[-1] - axis[0]) / (len(axis) - 1) for axis in (x, y))
        return Grid(len(x), len(y), dx, dy, float(x[0] + x[-1]) / 2, float(y[0] + y[-1]) / 2)

    @cached_property
    def plane_strain(self) -> bool:
        """True for a line contact, whose cells are strips in one row."""
        return bool(self.result.effective_case.get("plane") == "strain")

    @cached_property
    def has_sharp_edges(self) -> bool:
        """True if a surface is a punch without edge radius or a cone, at whose edge or tip stress has no bound."""
        surfaces = self.result.effective_case.get("surface", ())
        found = [(kind, keys) for one in surfaces for kind, keys in one.items()]
        return any(kind == "cone" or (kind == "punch" and not keys.get("edge_radius")) for kind, keys in found)

    @cached_property
    def has_shear(self) -> bool:
        """True if any increment has shear."""
        return bool(np.any(self.result.history["max_shear"]))

    @cached_property
    def poisson_ratios(self) -> dict[Body, float]:
        """Poisson's ratio of each elastic body."""
        bodies = self.result.effective_case.get("bodies", ())
        elastic = zip(BODIES, bodies, strict=False)
        return {number: float(body["poisson_ratio"]) for number, body in elastic if isinstance(body, dict)}

    def pressure(self, step: int) -> DoubleArray:
        """Return the pressure of an increment, ``(nx, ny)``."""
        return np.asarray(self.result.field("pressure", step), np.float64)

    def read(self, step: int, window: Window, tractions: Sequence[Traction] = TRACTIONS) -> dict[Traction, DoubleArray]:
        """Return tractions of an increment in the cells of `window`."""
        names: dict[Traction, str] = {"p": "pressure", "qx": "shear_x", "qy": "shear_y"}
        zeros = np.zeros(self.grid.shape)[window]
        return {
            one: np.asarray(self.result.field(names[one], step), np.float64)[window]
            if one == "p" or self.has_shear
            else zeros
            for one in tractions
        }

    def bulk_stress(self, body: Body, step: int) -> DoubleArray:
        """Return the bulk stress xx, yy, xy (MPa) of a body at an increment, (3,); in plane strain yy = nu xx."""
        history = self.result.history
        bulk = np.array([float(history[name][step]) if name in history else 0.0 for name in BULK[body]])
        if self.plane_strain:
            bulk[1] = self.poisson_ratios[body] * bulk[0]
        return bulk

    def extent(self, steps: Sequence[int]) -> tuple[Window, tuple[Traction, ...]]:
        """Return the cells that any of the increments loads, and the tractions that are not 0 in all of them."""
        loaded: BoolArray = np.zeros(self.grid.shape, bool)
        kept = {"p"}
        for step in steps:
            fields = self.read(step, (slice(None), slice(None)))
            for name, field in fields.items():
                if np.any(field):
                    loaded |= field != 0.0
                    kept.add(name)
        return bounding_window(loaded), tuple(name for name in TRACTIONS if name in kept)


def bounding_window(cells: BoolArray) -> Window:
    """Return the smallest window with all `cells`; the middle cell if there is none."""
    slices = []
    for axis in (0, 1):
        found = np.flatnonzero(cells.any(axis=1 - axis))
        middle = cells.shape[axis] // 2
        slices.append(slice(int(found[0]), int(found[-1]) + 1) if len(found) else slice(middle, middle + 1))
    return slices[0], slices[1]
