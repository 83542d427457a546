"""The largest stresses on the surface at the edge of contact, extrapolated to cells of no size.

There the tractions end like the square root of the distance, and the largest stress of cells of side h is too small by
about c sqrt(h). The solver's own cells at the edge are loaded or not, as their centre is in contact or not, so that the
largest of their stresses depends on how the edge cuts them. Tractions averaged over blocks of 2 x 2 and of 4 x 4 cells
hardly do, and less so the mean over the ways to cut the grid into blocks:

    S = S_2 + (S_2 - S_4)/(sqrt(2) - 1)

S are the principal stresses from the tractions alone, at several places around the contact: at each place, and for each
way to cut the grid, the stresses of the block nearby with the largest tension. They are added in their directions to
the bulk stress, and each invariant of the sum is taken where it is largest. Without shear the stress outside of the
contact is smooth, the error goes like c h, and (S_2 - S_4) is added once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from fretsolve.case.keys.quantity_names import INVARIANTS, Invariant
from fretsolve.post.stress.influence import Body, Traction
from fretsolve.post.stress.invariants import invariant, principal
from fretsolve.post.stress.layers import LayerConvolution, LayerKernels, Window
from fretsolve.problem.model.grid import Grid
from fretsolve.system.arrays import BoolArray, DoubleArray


def in_blocks(
    field: DoubleArray, sides: tuple[int, int], shift: tuple[int, int], shape: tuple[int, int]
) -> DoubleArray:
    """Return means of a field over blocks of `sides` cells, ``shape``, the first of which begins `shift` before it."""
    whole = np.zeros((shape[0] * sides[0], shape[1] * sides[1]))
    whole[shift[0] : shift[0] + field.shape[0], shift[1] : shift[1] + field.shape[1]] = field
    means: DoubleArray = whole.reshape(shape[0], sides[0], shape[1], sides[1]).mean(axis=(1, 3))
    return means


def merged(window: Window, sides: tuple[int, int]) -> Window:
    """Return the blocks of `sides` cells that cover a window."""
    first, second = (slice(one.start // side, -(-one.stop // side)) for one, side in zip(window, sides, strict=True))
    return first, second


EDGE_CELLS = 2
"""Cells from the edge of contact that count as cells at the edge."""

NEIGHBOURHOOD, NEIGHBOURHOOD_SHARE = 5.0, 0.15
"""Cells along x and y within which the block of a place lies, or if that is more, their share of the narrower side of
what is loaded: the edge near it is in one of them, and in an area contact one of them fits the edge well."""

LEAST_RISE = 0.5
"""Share of the largest change of a stress that must be in the direction of its tension at a trailing edge."""

EDGE_SHARE, PRESSED_EDGE_SHARE = 0.3, 0.5
"""Error of an extrapolated value over what the extrapolation adds, and that without shear, for exact tractions."""


@dataclass(frozen=True, eq=False)
class EdgeEstimate:
    """An invariant at the edge of contact (MPa), its estimated error, and its place (2,) in cells."""

    value: float
    error: float
    place: DoubleArray


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Blocks at the edge of contact. stress: ``(6, blocks)`` in MPa; middles: ``(2, blocks)`` in cells.

    reach: cells within which blocks are near one another.
    """

    stress: DoubleArray
    middles: DoubleArray
    reach: float

    def near(self, places: DoubleArray) -> DoubleArray:
        """Return the stress of the block near each of `places` whose tension is largest, ``(6, places)``."""
        tension = principal(self.stress)[0]
        chosen = []
        for place in places.T:
            distance = np.abs(self.middles - place[:, None]).max(axis=0)
            inside = distance <= max(self.reach, float(distance.min()))
            chosen.append(int(np.where(inside, tension, -np.inf).argmax()))
        return self.stress[:, chosen]

    def tops(self, rank: DoubleArray, most: int) -> DoubleArray:
        """Return the middles of blocks whose rank is the highest near them, ``(2, up to most)``, the highest first."""
        left = np.ones(rank.shape, bool)
        found: list[int] = []
        while left.any() and len(found) < most:
            best = int(np.where(left, rank, -np.inf).argmax())
            near = np.abs(self.middles - self.middles[:, best, None]).max(axis=0) <= self.reach
            if rank[best] >= rank[near].max():
                found.append(best)
            left &= ~near
        return self.middles[:, found]


class EdgeExtrapolation:
    """Extrapolates the largest stresses at the edge of contact of one increment after another.

    loaded: cells of the tractions; wanted: cells among which the largest stress is looked for. ratios: Poisson's ratio
    of each body. tractions: only tractions that are not 0. plane_strain: the contact is a line.
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
        # sides of the blocks in cells, and the ways to begin them; in a line contact blocks have one row of cells
        of_lines = {2: ((0, 0), (1, 0)), 4: ((0, 0), (1, 0), (2, 0), (3, 0))}
        of_areas = {2: ((0, 0), (0, 1), (1, 0), (1, 1)), 4: ((0, 0), (0, 2), (2, 0), (2, 2))}
        self._shifts = of_lines if plane_strain else of_areas
        self._margins = EDGE_CELLS, 0 if plane_strain else EDGE_CELLS
        self._plane_strain = plane_strain
        widths = [one.stop - one.start for one in loaded]
        self.reach = NEIGHBOURHOOD if plane_strain else max(NEIGHBOURHOOD, NEIGHBOURHOOD_SHARE * min(widths))
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
    ) -> dict[tuple[Body, Invariant], EdgeEstimate]:
        """Return the largest value of each invariant at the edge of contact, none without an edge.

        fields: tractions, some of which are not 0; bulk: bulk stress xx, yy, xy of each body.
        """
        sheared = any(np.any(field) for name, field in fields.items() if name != "p")
        factor, share = (1.0 / (math.sqrt(2.0) - 1.0), EDGE_SHARE) if sheared else (1.0, PRESSED_EDGE_SHARE)
        blocks = {side: [self._at_edge(side, shift, fields) for shift in self._shifts[side]] for side in self._shifts}
        estimates: dict[tuple[Body, Invariant], EdgeEstimate] = {}
        for body, of_bulk in bulk.items():
            added = np.zeros((6, 1))
            added[[0, 1, 3], 0] = of_bulk
            finest = blocks[2][0][body]
            if not finest.stress.size:
                continue
            # the places where the largest stress may be: with the bulk stress, which is uniform, and without it, since
            # that is what the extrapolation changes
            ranks = principal(finest.stress + added)[0], principal(finest.stress)[0]
            places = np.concatenate([finest.tops(rank, 8) for rank in ranks], axis=1)
            chosen = {side: [one[body].near(places) for one in blocks[side]] for side in blocks}
            fine, coarse = (np.mean([principal(one) for one in chosen[side]], axis=0) for side in blocks)
            # Without shear there is a tension all around the contact, and no leading edge.
            rise = rises(fine, fine - coarse) if sheared else np.maximum((fine - coarse)[0], 0.0)
            rising = rise > 0.0
            if not rising.any():
                continue
            places, values = places[:, rising], (fine + factor * (fine - coarse))[:, rising]
            stress = _turned(values, chosen[2][0][:, rising]) + added
            errors = share * factor * rise[rising]
            for name in INVARIANTS:
                values = invariant(name, stress)
                best = int(values.argmax())
                estimates[body, name] = EdgeEstimate(float(values[best]), float(errors[best]), places[:, best])
        return estimates

    def _at_edge(
        self, side: int, shift: tuple[int, int], fields: Mapping[Traction, DoubleArray]
    ) -> dict[Body, _Blocks]:
        """Return the blocks at the edge of contact, for one way to cut the grid, without bulk stress."""
        convolution = self._convolutions[side]
        nx, ny = (window.stop - window.start for window in convolution.source)
        blocks = {name: in_blocks(field, self._block(side), shift, (nx, ny)) for name, field in fields.items()}
        edge = edge_cells(
            np.pad(blocks["p"] > 0.0, [(margin, margin) for margin in self._margins])
        ) & self._wanted_blocks(side, shift)
        spectra = convolution.forward(blocks)
        numbers = np.nonzero(edge)
        middles = [
            of.start - by + width * (number - margin + 0.5)
            for number, of, by, width, margin in zip(
                numbers, self._loaded, shift, self._block(side), self._margins, strict=True
            )
        ]
        return {
            body: _Blocks(
                convolution.stress(self._kernels[side, body], spectra)[:, edge], np.stack(middles), self.reach
            )
            for body in self._ratios
        }

    def _block(self, side: int) -> tuple[int, int]:
        return side, 1 if self._plane_strain else side

    def _wanted_blocks(self, side: int, shift: tuple[int, int]) -> BoolArray:
        inside = []
        for axis, (of, to, width) in enumerate(zip(self._loaded, self._wanted, self._block(side), strict=True)):
            target = self._convolutions[side].target[axis]
            begin = of.start - shift[axis] + width * (np.arange(target.stop) - self._margins[axis])
            inside.append((begin + width > to.start) & (begin < to.stop))
        blocks: BoolArray = inside[0][:, None] & inside[1]
        return blocks


def rises(values: DoubleArray, change: DoubleArray) -> DoubleArray:
    """Return by how much smaller cells raise a tension, as they do at a trailing edge, 0 elsewhere.

    values, change: principal stresses, the largest first, ``(3, places)``. At a leading edge there is no tension, and
    the stress is largest inside of the contact.
    """
    trailing = (change[0] <= values[0]) & (change[0] >= LEAST_RISE * np.abs(change).max(axis=0))
    return np.where(trailing, change[0], 0.0)


def _turned(values: DoubleArray, stress: DoubleArray) -> DoubleArray:
    """Return stresses ``(6, places)`` of principal `values` ``(3, places)`` in the principal directions of `stress`."""
    matrices = stress[[0, 3, 4, 3, 1, 5, 4, 5, 2]].T.reshape(-1, 3, 3)
    directions = np.linalg.eigh(matrices)[1][:, :, ::-1]
    turned = np.einsum("pik,kp,pjk->ijp", directions, values, directions)
    return np.asarray(turned[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])


def edge_cells(contact: BoolArray) -> BoolArray:
    """Return the cells near which, within `EDGE_CELLS`, there are cells in contact and others."""
    size = 2 * EDGE_CELLS + 1
    near, inside = (one(contact, size, mode="nearest") for one in (maximum_filter, minimum_filter))
    cells: BoolArray = near & ~inside
    return cells
