"""Error bars of the largest parameters, from tractions averaged over blocks of 2 x 2 cells, or of 2 strips.

A parameter converges as the stresses do that it follows from, see `fretsolve.post.stress.peaks`: below the surface the
bar is the difference of the largest values, with what a parabola over the depth adds; on the surface the bar is some
times the largest difference near the worst place.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import maximum_filter

from fretsolve.case.keys.material_spec import Material
from fretsolve.case.keys.quantity_names import SLIP_CRITERIA
from fretsolve.post.fatigue.criteria import FatigueField, fatigue_field
from fretsolve.post.fatigue.request import Average, ComputedTractions, depth_weights
from fretsolve.post.fatigue.ruiz import ruiz_field, sliding_in
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.edge import in_blocks, merged
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.peaks import ERROR_FACTOR, LINE_ERROR_FACTOR, DoubledCells
from fretsolve.system.arrays import DoubleArray


class BlockFields:
    """The parameters of a body in blocks of cells; the states of cycles are increments."""

    def __init__(self, tractions: ComputedTractions, average: Average | None, body: Body, material: Material):
        self._tractions, self._average, self._body, self._material = tractions, average, body, material
        self._sides = 2, 1 if tractions.history.plane_strain else 2
        self._target = merged(tractions.stresses.target, self._sides)
        self._cells = DoubledCells(tractions.history, tractions.stresses)
        self._known: tuple[LoadCycle, int, DoubleArray] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Blocks along x and along y."""
        first, second = self._target
        return first.stop - first.start, second.stop - second.start

    def bar(self, name: str, cycle: LoadCycle, depth: int, values: DoubleArray) -> float:
        """Return the error of the largest of `values` (nx, ny) at the place `depth` of the layers (MPa)."""
        coarse = self._field(name, cycle, depth).value.reshape(self.shape)
        change = abs(float(coarse.max()) - float(values.max()))
        if self._average is not None or self._tractions.stresses.depths[depth] > 0.0:
            return change
        if self._tractions.history.has_sharp_edges:
            return math.inf
        shift = tuple(one.start % side for one, side in zip(self._tractions.stresses.target, self._sides, strict=True))
        # A block at the end of the window may have fewer cells, but has one.
        covered, sums = (
            in_blocks(one, self._sides, (shift[0], shift[1]), self.shape) for one in (np.ones_like(values), values)
        )
        near = maximum_filter(np.abs(sums / covered - coarse), 3, mode="nearest")
        cell = np.unravel_index(int(values.argmax()), values.shape)
        block = tuple((int(at) + begin) // side for at, begin, side in zip(cell, shift, self._sides, strict=True))
        factor = LINE_ERROR_FACTOR if self._tractions.history.plane_strain else ERROR_FACTOR
        return factor * max(change, float(near[block]))

    def _field(self, name: str, cycle: LoadCycle, depth: int) -> FatigueField:
        stress = self._stress(cycle, depth)
        if name in SLIP_CRITERIA:
            return ruiz_field(name, stress, sliding_in(self._tractions.history, cycle, self._target, self._sides))
        return fatigue_field(name, self._material, stress)

    def _stress(self, cycle: LoadCycle, depth: int) -> DoubleArray:
        """Return the stresses (steps, 6, blocks); those of the last call are kept, since criteria share places."""
        if self._known is None or self._known[:2] != (cycle, depth):
            layer = np.stack([self._of_increment(step, depth) for step in cycle.states])
            self._known = cycle, depth, cycle.with_rest(layer.reshape(len(layer), 6, -1))
        return self._known[2]

    def _of_increment(self, step: int, depth: int) -> DoubleArray:
        depths, spectra = self._tractions.stresses.depths, self._cells.spectra(step)
        if self._average is None:
            return self._cells.stress(self._body, step, depths[depth], spectra)
        whole = np.stack([self._cells.stress(self._body, step, one, spectra) for one in depths], axis=1)
        grid = self._tractions.history.grid
        block = self._sides[0] * grid.dx, self._sides[1] * grid.dy
        return self._average.of(whole, depth_weights(np.array(depths), *self._average.depth_range), block)
