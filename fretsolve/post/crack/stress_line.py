"""The stress along a line into a body, exactly that of the tractions on the cells, at any depths.

A uniformly loaded cell acts through its corners, a strip through its edges (`fretsolve.post.stress.influence`). The
functions of the corners' places are computed once for all increments, and only around cells that are ever loaded.

What a cell contributes, averaged over blocks of 2 x 2 cells or 2 strips of a line, is what the cell contributes if the
tractions are averaged so. The difference tells the error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from scipy.ndimage import binary_dilation

from fretsolve.errors import CaseError
from fretsolve.post.crack.stress_intensity import nodes
from fretsolve.post.stress.influence import (
    COMPONENTS,
    Body,
    Component,
    Potential,
    Strip,
    Traction,
    corner,
    stress_terms,
    strip_edge,
)
from fretsolve.post.stress.request import machine_memory
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray, IndexArray

SHIFTS = (0, 1)
"""Cells at which the first block of two begins. The edge of contact lies at another place in the blocks of each."""

ARRAYS = 60
"""Arrays over the cells at once, while all components of the stress at a depth are computed."""

LARGEST_BLOCK = 2**19
"""Numbers in an array of functions over depths and corners, which stay in cache."""


@dataclass(frozen=True, eq=False)
class StressLine:
    """The stress below a point of the surface, in all increments of some `steps`.

    shape: of the grid of cells around those that are loaded, with a cell beyond on each side; x, y: of corners of
    cells, (corners,) in mm, and `corners`, their places in the grid of corners; loaded: places of cells in that of
    cells, (cells,); loads: tractions on these cells, (steps, cells) in MPa; bulk: (steps, 6) in MPa.
    """

    steps: tuple[int, ...]
    body: Body
    poisson_ratio: float
    plane_strain: bool
    shape: tuple[int, int]
    x: DoubleArray
    y: DoubleArray
    corners: IndexArray
    loaded: IndexArray
    loads: Mapping[Traction, DoubleArray]
    bulk: DoubleArray

    def of(self, step: int) -> StressLine:
        """Return the stress line in one of the increments."""
        one = slice(self.steps.index(step), self.steps.index(step) + 1)
        loads = {name: values[one] for name, values in self.loads.items()}
        return replace(self, steps=(step,), loads=loads, bulk=self.bulk[one])

    def stress(
        self,
        place: tuple[float, float],
        depths: DoubleArray,
        components: Sequence[Component] = COMPONENTS,
        weights: DoubleArray | None = None,
    ) -> DoubleArray:
        """Return components (MPa) at depths (mm) below a place, ``(components, 1 + averages, steps, depths)``.

        weights: (sums, depths) of stresses that are added; then of each sum instead of each depth.
        """
        if weights is None:  # one by one: all depths at once would take much memory
            alone = np.ones((1, 1))
            return np.concatenate(
                [self.stress(place, depths[[index]], components, alone) for index in range(len(depths))], axis=-1
            )
        names = [(one, traction) for one in components for traction in self.loads]
        sums = {name: np.zeros((len(weights), len(self.x))) for name in names}
        step = max(1, LARGEST_BLOCK // max(1, len(self.x)))
        for begin in range(0, len(depths), step):
            self._add(sums, place, depths[begin : begin + step], weights[:, begin : begin + step])
        rows = [COMPONENTS.index(one) for one in components]
        bulk = self.bulk[:, rows].T[:, None, :, None] * weights.sum(axis=1)
        shape = 1 + len(SHIFTS), len(weights), len(self.steps)
        total = np.zeros((len(components), *shape))
        for (one, traction), values in sums.items():
            found = self._of_cells(values) @ self.loads[traction].T
            total[components.index(one)] += found.reshape(shape)
        return np.asarray(total.swapaxes(2, 3) + bulk)

    def stress_intensity(self, place: tuple[float, float], length: float) -> DoubleArray:
        """Return K_I and K_II (MPa m^0.5) of a crack at a place, ``(2, 1 + averages, steps)``."""
        share, weights = nodes()
        stress = self.stress(place, length * share, ("xx", "xz"), weights[None])
        return np.asarray(math.sqrt(length) * stress[..., 0])

    def _of_cells(self, values: DoubleArray) -> DoubleArray:
        """Return what loaded cells contribute, and with tractions averaged over blocks, (3 x sums, cells).

        values: what corners contribute, (sums, corners).
        """
        across = self.shape[0] + 1, self.shape[1] + (not self.plane_strain)
        found = np.zeros((len(values), across[0] * across[1]))
        found[:, self.corners] = values
        of_cells: DoubleArray = -np.diff(found.reshape(-1, *across), axis=1)
        if not self.plane_strain:
            of_cells = -np.diff(of_cells, axis=2)
        variants = [of_cells, *(_averaged(of_cells, shift, self.plane_strain) for shift in SHIFTS)]
        return np.concatenate([one.reshape(len(values), -1)[:, self.loaded] for one in variants])

    def _add(
        self,
        sums: Mapping[tuple[Component, Traction], DoubleArray],
        place: tuple[float, float],
        depths: DoubleArray,
        weights: DoubleArray,
    ) -> None:
        """Add what corners contribute per difference of a traction at some depths; sums: (sums, corners)."""
        X, Y, z = place[0] - self.x, place[1] - self.y, depths[:, None]
        r = np.empty(0) if self.plane_strain else np.sqrt(X * X + Y * Y + z * z)
        terms = {key: self._factors(*key) for key in sums}
        for name in dict.fromkeys(name for factors in terms.values() for name in factors):
            # the sign of the corner before the cell, whose offset is larger
            if self.plane_strain:
                values = strip_edge(cast(Strip, name), X, z)
            else:
                values = corner(cast(Potential, name), X, Y, r, z)
            for key, factors in terms.items():
                if name in factors:
                    constant, slope = factors[name]
                    sums[key][:] += (weights * (constant + slope * depths)) @ values

    def _factors(self, component: Component, traction: Traction) -> dict[Potential | Strip, tuple[float, float]]:
        """Return the factor of each function at depth 0, and its change by the depth, with which it is linear."""
        at_0, at_1 = (
            stress_terms(component, traction, depth, self.poisson_ratio, self.body, plane_strain=self.plane_strain)
            for depth in (0.0, 1.0)
        )
        return {name: (at_0.get(name, 0.0), at_1.get(name, 0.0) - at_0.get(name, 0.0)) for name in {**at_0, **at_1}}


def stress_line(tractions: TractionHistory, steps: Sequence[int], body: Body) -> StressLine:
    """Return the stress line of a body in increments of a result. Raises CaseError if it needs too much memory."""
    window, kept = tractions.extent(steps)
    grid, line = tractions.grid, tractions.plane_strain
    around = [(1, 1), (0, 0) if line else (1, 1)]
    shape = window[0].stop - window[0].start + 2, 1 if line else window[1].stop - window[1].start + 2
    needed = 8.0 * shape[0] * shape[1] * ((len(kept) + 1) * len(steps) + ARRAYS)
    require_memory(needed, f"the tractions of {len(steps)} increments")
    loads = {name: np.zeros((len(steps), shape[0] * shape[1])) for name in kept}
    for index, step in enumerate(steps):
        for name, field in tractions.read(step, window, kept).items():
            loads[name][index] = np.pad(field, around).ravel()
    loaded = np.any([values.any(axis=0) for values in loads.values()], axis=0).reshape(shape)
    # a block reaches a cell beyond the loaded ones, and a cell has a corner on each side
    blocks = binary_dilation(loaded, np.ones((3, 1 if line else 3)))
    corners = np.pad(blocks, [(0, 1), (0, 0) if line else (0, 1)])
    corners[1:] |= corners[:-1]
    if not line:
        corners[:, 1:] |= corners[:, :-1]
    x = grid.x[0] + grid.dx * (window[0].start - 1.5 + np.arange(corners.shape[0]))
    y = np.zeros(1) if line else grid.y[0] + grid.dy * (window[1].start - 1.5 + np.arange(corners.shape[1]))
    places = np.argwhere(corners).T
    bulk = np.zeros((len(steps), len(COMPONENTS)))
    bulk[:, [0, 1, 3]] = [tractions.bulk_stress(body, step) for step in steps]
    return StressLine(
        steps=tuple(steps),
        body=body,
        poisson_ratio=tractions.poisson_ratios[body],
        plane_strain=line,
        shape=shape,
        x=x[places[0]],
        y=y[places[1]],
        corners=np.flatnonzero(corners),
        loaded=np.flatnonzero(loaded),
        loads={name: loads.pop(name)[:, loaded.ravel()] for name in kept},  # one whole field at a time
        bulk=bulk,
    )


def require_memory(needed: float, what: str) -> None:
    """Raise CaseError if this machine has less memory than `needed` (bytes); what: takes it, in words."""
    if needed > (there := machine_memory()):
        raise CaseError(
            f"{what} take {needed / 1e9:.3g} GB of memory, this machine has {there / 1e9:.3g} GB; fewer cycles,"
            " or a larger output.every in the case, is needed"
        )


def _averaged(field: DoubleArray, shift: int, line: bool) -> DoubleArray:
    """Return fields (sums, nx, ny) with the means of blocks of two cells along x, and of 2 x 2 cells unless on a line.

    shift: the first cell of a block. The outermost cells bear no load, so that they need no second one.
    """
    for axis in (1,) if line else (1, 2):
        numbers = np.arange(field.shape[axis])
        other = np.clip(((numbers + shift) ^ 1) - shift, 0, len(numbers) - 1)
        field = 0.5 * (field + np.take(field, other, axis=axis))
    return field
