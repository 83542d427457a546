"""The stress along a line into a body, exactly that of the tractions on the cells, at any depths.

A uniformly loaded cell acts through its corners, a strip through its edges (`fretsolve.post.stress.influence`). So the
stress at a point is the sum over all corners of a function of the corner's place, times the difference of the tractions
around it. The functions are computed once for all increments, and corners amid equal tractions need none.

The same corners serve the tractions averaged over blocks of 2 x 2 cells, or 2 strips of a line, which tell the error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

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
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray

SHIFTS = (0, 1)
"""Cells at which the first block of two begins. The edge of contact lies at another place in the blocks of each."""

LARGEST_BLOCK = 2**19
"""Numbers in an array of functions over depths and corners, which stay in cache."""


@dataclass(frozen=True, eq=False)
class StressLine:
    """The stress below a point of the surface, in all increments of some `steps`.

    x, y: of the corners of cells, (corners,) in mm; differences: of the tractions around each corner, (1 + averages,
    steps, corners): first of the tractions, then of those averaged over blocks; bulk: (steps, 6) in MPa.
    """

    steps: tuple[int, ...]
    body: Body
    poisson_ratio: float
    plane_strain: bool
    x: DoubleArray
    y: DoubleArray
    differences: Mapping[Traction, DoubleArray]
    bulk: DoubleArray

    def of(self, step: int) -> StressLine:
        """Return the stress line in one of the increments."""
        one = slice(self.steps.index(step), self.steps.index(step) + 1)
        differences = {name: values[:, one] for name, values in self.differences.items()}
        return replace(self, steps=(step,), differences=differences, bulk=self.bulk[one])

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
        weights = np.eye(len(depths)) if weights is None else weights
        names = [(one, traction) for one in components for traction in self.differences]
        sums = {name: np.zeros((len(weights), len(self.x))) for name in names}
        step = max(1, LARGEST_BLOCK // max(1, len(self.x)))
        for begin in range(0, len(depths), step):
            self._add(sums, place, depths[begin : begin + step], weights[:, begin : begin + step])
        rows = [COMPONENTS.index(one) for one in components]
        bulk = self.bulk[:, rows].T[:, None, :, None] * weights.sum(axis=1)
        shape = 1 + len(SHIFTS), len(self.steps), len(weights)
        total = np.zeros((len(components), *shape))
        for (one, traction), values in sums.items():
            found = self.differences[traction].reshape(shape[0] * shape[1], len(self.x)) @ values.T
            total[components.index(one)] += found.reshape(shape)
        return np.asarray(total + bulk)

    def stress_intensity(self, place: tuple[float, float], lengths: DoubleArray) -> DoubleArray:
        """Return K_I and K_II (MPa m^0.5) of cracks at a place, ``(2, 1 + averages, steps, lengths)``."""
        share, weights = nodes()
        found = [
            math.sqrt(length) * self.stress(place, length * share, ("xx", "xz"), weights[None]) for length in lengths
        ]
        return np.concatenate(found, axis=-1)

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
    """Return the stress line of a body in increments of a result."""
    window, kept = tractions.extent(steps)
    grid, line = tractions.grid, tractions.plane_strain
    around = [(1, 1), (0, 0) if line else (1, 1)]
    found: dict[Traction, list[list[DoubleArray]]] = {name: [] for name in kept}
    for step in steps:
        for name, field in tractions.read(step, window, kept).items():
            padded = np.pad(field, around)
            variants = [padded, *(_averaged(padded, shift, line) for shift in SHIFTS)]
            found[name].append([_differences(one, line).ravel() for one in variants])
    differences = {name: np.array(values).swapaxes(0, 1) for name, values in found.items()}
    first, second = window
    x = grid.x[0] + grid.dx * (np.arange(first.start, first.stop + 3) - 1.5)
    y = np.zeros(1) if line else grid.y[0] + grid.dy * (np.arange(second.start, second.stop + 3) - 1.5)
    corners = [axis.ravel() for axis in np.meshgrid(x, y, indexing="ij")]
    used = np.any([values.any(axis=(0, 1)) for values in differences.values()], axis=0)
    bulk = np.zeros((len(steps), len(COMPONENTS)))
    bulk[:, [0, 1, 3]] = [tractions.bulk_stress(body, step) for step in steps]
    return StressLine(
        tuple(steps),
        body,
        tractions.poisson_ratios[body],
        line,
        corners[0][used],
        corners[1][used],
        {name: np.ascontiguousarray(values[:, :, used]) for name, values in differences.items()},
        bulk,
    )


def _averaged(field: DoubleArray, shift: int, line: bool) -> DoubleArray:
    """Return a field with the mean of each block of two cells along x, and of 2 x 2 cells unless on a line.

    shift: the first cell of a block. The outermost cells of the field are 0, so that they need no second one.
    """
    for axis in (0,) if line else (0, 1):
        numbers = np.arange(field.shape[axis])
        other = np.clip(((numbers + shift) ^ 1) - shift, 0, len(numbers) - 1)
        field = 0.5 * (field + np.take(field, other, axis=axis))
    return field


def _differences(field: DoubleArray, line: bool) -> DoubleArray:
    """Return the differences across each corner of cells in a field that is 0 around, or across each edge of strips."""
    along_x = np.diff(field, axis=0, prepend=0.0, append=0.0)
    return along_x if line else np.diff(along_x, axis=1, prepend=0.0, append=0.0)
