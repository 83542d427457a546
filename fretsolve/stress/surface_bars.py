"""Estimate the errors of the largest stresses on the surface from tractions averaged over blocks of cells.

At the edges of contact and of slip zones the stress on the surface converges with the square root of the cells' side h,
so that its error is some 1/(sqrt(2) - 1) times its difference to the stress S_2h of blocks of 2 x 2 cells. The largest
stress may lie at any place where value and error together exceed the largest value.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fretsolve.stress.blocks import in_blocks, merged
from fretsolve.stress.halfspace.influence import Body, Traction
from fretsolve.stress.halfspace.layers import LayerConvolution
from fretsolve.stress.invariants import invariant
from fretsolve.stress.names import INVARIANTS, Invariant
from fretsolve.stress.request import StressRequest
from fretsolve.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray

ERROR_FACTOR, LINE_ERROR_FACTOR = 2.0, 5.0
"""Error on the surface over the difference to blocks of cells, and that in line contacts."""

NEAR = 3
"""Blocks across within which the largest difference counts."""


@dataclass(frozen=True, eq=False)
class SurfaceBounds:
    """Upper bounds of an invariant in an increment, on the blocks where it may be largest.

    upper: the most that it may be, ``(blocks,)``; middles: ``(2, blocks)`` in cells; error: of the largest value.
    """

    upper: DoubleArray
    middles: DoubleArray
    error: float

    def most(self, away: DoubleArray | None = None, distance: float = 0.0) -> float:
        """Return the largest value that there may be, farther than `distance` cells from the place `away` (2,)."""
        upper = self.upper
        if away is not None:
            upper = upper[np.abs(self.middles - away[:, None]).max(axis=0) > distance]
        return float(upper.max(initial=-np.inf))


class SurfaceBars:
    """Compares the stress on the surface with that of tractions averaged over blocks of cells."""

    def __init__(self, tractions: TractionHistory, request: StressRequest):
        self._tractions, self._request, grid = tractions, request, tractions.grid
        self._factor = LINE_ERROR_FACTOR if tractions.plane_strain else ERROR_FACTOR
        self._sides = 2, 1 if tractions.plane_strain else 2
        self._source, self._target = merged(request.source, self._sides), merged(request.target, self._sides)
        spacing = self._sides[0] * grid.dx, self._sides[1] * grid.dy
        self._convolution = LayerConvolution(
            spacing, self._source, self._target, request.tractions, plane_strain=tractions.plane_strain
        )
        ratios = {body: tractions.poisson_ratios[body] for body in request.bodies}
        potentials = self._convolution.potentials(0.0, ratios)
        self._kernels = {body: self._convolution.kernels(potentials, 0.0, nu, body) for body, nu in ratios.items()}

    def bounds(self, body: Body, step: int, stress: DoubleArray) -> dict[Invariant, SurfaceBounds]:
        """Return where the largest invariants may lie; stress: that of the cells, with bulk stress, (6, nx, ny)."""
        coarse = self._convolution.stress(self._kernels[body], self._convolution.forward(self._blocks(step)))
        coarse[[0, 1, 3]] += self._tractions.bulk_stress(body, step)[:, None, None]
        return {name: self._bounds(invariant(name, stress), invariant(name, coarse)) for name in INVARIANTS}

    def _bounds(self, fine: DoubleArray, coarse: DoubleArray) -> SurfaceBounds:
        from scipy.ndimage import maximum_filter

        first, second = self._request.target
        shift = first.start % self._sides[0], second.start % self._sides[1]
        shape = coarse.shape[0], coarse.shape[1]
        # A block at the end of the window may have fewer cells, but has one.
        covered = in_blocks(np.ones_like(fine), self._sides, shift, shape)
        value = in_blocks(fine, self._sides, shift, shape) / covered
        error = self._factor * maximum_filter(np.abs(value - coarse), NEAR, mode="nearest")
        upper = np.maximum(value, coarse) + error
        chosen = np.argwhere(upper >= value.max()).T
        middles = [
            side * (window.start + numbers + 0.5)
            for side, window, numbers in zip(self._sides, self._target, chosen, strict=True)
        ]
        best = np.unravel_index(int(value.argmax()), value.shape)
        return SurfaceBounds(upper[chosen[0], chosen[1]], np.stack(middles), float(error[best]))

    def _blocks(self, step: int) -> Mapping[Traction, DoubleArray]:
        return averaged(self._tractions, self._request, step, self._sides)


def averaged(
    tractions: TractionHistory, request: StressRequest, step: int, sides: tuple[int, int]
) -> dict[Traction, DoubleArray]:
    """Return the tractions of an increment, averaged over blocks of `sides` cells, in the window of such blocks."""
    fields = tractions.read(step, request.source, request.tractions)
    shift = request.source[0].start % sides[0], request.source[1].start % sides[1]
    source = merged(request.source, sides)
    shape = source[0].stop - source[0].start, source[1].stop - source[1].start
    return {name: in_blocks(field, sides, shift, shape) for name, field in fields.items()}
