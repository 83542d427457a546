"""The largest stresses on the surface at the edge of contact, extrapolated to cells of no size.

There the tractions end like the square root of the distance, and the largest stress of cells of side h is too small by
about c sqrt(h). The solver's own cells at the edge are loaded or not, as their centre is in contact or not, so that the
largest of their stresses depends on how the edge cuts them. Tractions averaged over blocks of 2 x 2 and of 4 x 4 cells
hardly do, and less so the mean over the ways to cut the grid into blocks:

    M = M_2 + (M_2 - M_4)/(sqrt(2) - 1)

M are the principal stresses where the tension is largest, from which von Mises and Tresca follow. Without shear the
stress outside of the contact is smooth, the error is that of c h, and (M_2 - M_4) is added once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from fretsolve.model.grid import Grid
from fretsolve.stress.halfspace.influence import Body, Traction
from fretsolve.stress.halfspace.layers import LayerConvolution, LayerKernels, Window
from fretsolve.stress.invariants import invariant, principal
from fretsolve.stress.names import INVARIANTS, Invariant
from fretsolve.system.arrays import BoolArray, DoubleArray

EDGE_CELLS = 2
"""Cells from the edge of contact that count as those at the edge."""

SHIFTS = {2: ((0, 0), (0, 1), (1, 0), (1, 1)), 4: ((0, 0), (0, 2), (2, 0), (2, 2))}
LINE_SHIFTS = {2: ((0, 0), (1, 0)), 4: ((0, 0), (1, 0), (2, 0), (3, 0))}
"""Sides of the blocks in cells, and the ways to begin them; in a line contact blocks have one row of cells."""

EXTRAPOLATION = 1.0 / (math.sqrt(2.0) - 1.0)

EDGE_SHARE, PRESSED_EDGE_SHARE = 0.25, 0.5
"""Error of an extrapolated value over what the extrapolation adds to the largest principal stress, and that without
shear."""


class EdgeExtrapolation:
    """Extrapolates the largest stresses at the edge of contact of one increment after another.

    loaded: cells of the tractions; wanted: those among which the largest stress is looked for. ratios: Poisson's ratio
    of each body. tractions: those that are not 0. plane_strain: the contact is a line.
    """

    def __init__(
        self,
        grid: Grid,
        loaded: Window,
        wanted: Window,
        ratios: Mapping[Body, float],
        tractions: tuple[Traction, ...],
        *,
        plane_strain: bool = False,
    ):
        self._shifts = LINE_SHIFTS if plane_strain else SHIFTS
        self._margins = EDGE_CELLS, 0 if plane_strain else EDGE_CELLS
        self._plane_strain = plane_strain
        self._loaded, self._wanted = loaded, wanted
        self._convolutions: dict[int, LayerConvolution] = {}
        self._kernels: dict[tuple[int, Body], LayerKernels] = {}
        self._ratios = ratios
        for side in self._shifts:
            # Some blocks of margin on each side, where the stress at the edge is looked for as well.
            source, target = [], []
            for of, width, margin in zip(loaded, self._block(side), self._margins, strict=True):
                count = -(-(of.stop - of.start) // width) + (width > 1)
                source.append(slice(margin, margin + count))
                target.append(slice(0, count + 2 * margin))
            spacing = side * grid.dx, grid.dy if plane_strain else side * grid.dy
            convolution = LayerConvolution(
                spacing, (source[0], source[1]), (target[0], target[1]), tractions, plane_strain=plane_strain
            )
            potentials = convolution.potentials(0.0, ratios)
            self._convolutions[side] = convolution
            for body, nu in ratios.items():
                self._kernels[side, body] = convolution.kernels(potentials, 0.0, nu, body)

    def estimates(
        self, fields: Mapping[Traction, DoubleArray], bulk: Mapping[Body, DoubleArray]
    ) -> dict[tuple[Body, Invariant], tuple[float, float]]:
        """Return the invariants where the tension at the edge is largest, each with its estimated error (MPa).

        fields: tractions, some of which are not 0; bulk: bulk stress xx, yy, xy of each body.
        """
        sheared = any(np.any(field) for name, field in fields.items() if name != "p")
        factor, share = (EXTRAPOLATION, EDGE_SHARE) if sheared else (1.0, PRESSED_EDGE_SHARE)
        means = {side: self._mean(side, fields, bulk) for side in self._shifts}
        estimates: dict[tuple[Body, Invariant], tuple[float, float]] = {}
        for body in self._ratios:
            fine, coarse = means[2][body], means[4][body]
            added = factor * max(float(fine[0] - coarse[0]), 0.0)
            values = fine + factor * (fine - coarse) if added else fine
            whole = np.concatenate([values, np.zeros(3)])
            for name in INVARIANTS:
                estimates[body, name] = float(invariant(name, whole[:, None])[0]), share * added
        return estimates

    def _mean(
        self, side: int, fields: Mapping[Traction, DoubleArray], bulk: Mapping[Body, DoubleArray]
    ) -> dict[Body, DoubleArray]:
        """Return the principal stresses of each body where the tension is largest, as the mean over all shifts."""
        found = [self._at_edge(side, shift, fields, bulk) for shift in self._shifts[side]]
        return {body: np.mean([one[body] for one in found], axis=0) for body in bulk}

    def _at_edge(
        self,
        side: int,
        shift: tuple[int, int],
        fields: Mapping[Traction, DoubleArray],
        bulk: Mapping[Body, DoubleArray],
    ) -> dict[Body, DoubleArray]:
        """Return the principal stresses where the tension at the edge is largest, of one way to cut the grid."""
        convolution = self._convolutions[side]
        nx, ny = (window.stop - window.start for window in convolution.source)
        blocks = {name: in_blocks(field, self._block(side), shift, (nx, ny)) for name, field in fields.items()}
        edge = edge_cells(
            np.pad(blocks["p"] > 0.0, [(margin, margin) for margin in self._margins])
        ) & self._wanted_blocks(side, shift)
        spectra = convolution.forward(blocks)
        found = {}
        for body, of_bulk in bulk.items():
            stress = convolution.stress(self._kernels[side, body], spectra)[:, edge]
            stress[[0, 1, 3]] += of_bulk[:, None]
            values = principal(stress)
            found[body] = values[:, values[0].argmax()] if edge.any() else np.zeros(3)
        return found

    def _block(self, side: int) -> tuple[int, int]:
        """Return the cells of a block along x and along y."""
        return side, 1 if self._plane_strain else side

    def _wanted_blocks(self, side: int, shift: tuple[int, int]) -> BoolArray:
        """Return which blocks have wanted cells."""
        inside = []
        for axis, (of, to, width) in enumerate(zip(self._loaded, self._wanted, self._block(side), strict=True)):
            target = self._convolutions[side].target[axis]
            begin = of.start - shift[axis] + width * (np.arange(target.stop) - self._margins[axis])
            inside.append((begin + width > to.start) & (begin < to.stop))
        blocks: BoolArray = inside[0][:, None] & inside[1]
        return blocks


def in_blocks(
    field: DoubleArray, sides: tuple[int, int], shift: tuple[int, int], shape: tuple[int, int]
) -> DoubleArray:
    """Return means of a field over blocks of `sides` cells, ``shape``, the first of which begins `shift` before it."""
    whole = np.zeros((shape[0] * sides[0], shape[1] * sides[1]))
    whole[shift[0] : shift[0] + field.shape[0], shift[1] : shift[1] + field.shape[1]] = field
    means: DoubleArray = whole.reshape(shape[0], sides[0], shape[1], sides[1]).mean(axis=(1, 3))
    return means


def edge_cells(contact: BoolArray) -> BoolArray:
    """Return the cells near which, within `EDGE_CELLS`, there are cells in contact and others."""
    from scipy.ndimage import maximum_filter, minimum_filter

    size = 2 * EDGE_CELLS + 1
    near, inside = (one(contact, size, mode="nearest") for one in (maximum_filter, minimum_filter))
    cells: BoolArray = near & ~inside
    return cells
