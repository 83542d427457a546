"""The largest stresses of each increment, where they are, and how wrong they may be.

Inside and below the surface a stress converges with the square of the cells' side h; its error bar is the difference to
the stress of tractions averaged over 2 x 2 cells. At the edges of contact and of slip zones the stress on the surface
converges with the square root of h, so that its error is some 1/(sqrt(2) - 1) times this difference, and the largest
stress may lie at any place where value and error together exceed the largest value. At the edge of contact, where the
tension of a sliding contact is largest, the stress is extrapolated (`fretsolve.post.stress.edge`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import maximum_filter

from fretsolve.case.keys.quantity_names import INVARIANTS, Invariant
from fretsolve.post.stress.edge import NEIGHBOURHOOD, EdgeExtrapolation, edge_cells, in_blocks, merged
from fretsolve.post.stress.influence import Body
from fretsolve.post.stress.invariants import invariant, largest
from fretsolve.post.stress.layers import LayerConvolution, LayerKernels
from fretsolve.post.stress.request import Layer, StressRequest, cell_centres, is_outermost
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.system.arrays import BoolArray, ComplexArray, DoubleArray

ERROR_FACTOR, LINE_ERROR_FACTOR = 2.0, 5.0
"""Error on the surface over the difference to blocks of cells, and that in line contacts."""


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


class DoubledCells:
    """The stress of tractions averaged over blocks of 2 x 2 cells, or of 2 cells of a line, as if these were cells."""

    def __init__(self, tractions: TractionHistory, request: StressRequest):
        self._tractions, self._request, grid = tractions, request, tractions.grid
        self._sides = 2, 1 if tractions.plane_strain else 2
        self._target = merged(request.target, self._sides)
        self._convolution = LayerConvolution(
            (self._sides[0] * grid.dx, self._sides[1] * grid.dy),
            merged(request.source, self._sides),
            self._target,
            request.tractions,
            plane_strain=tractions.plane_strain,
        )
        self._kernels: dict[tuple[Body, float], LayerKernels] = {}

    def spectra(self, step: int) -> ComplexArray:
        """Return the spectra of the averaged tractions of an increment."""
        request, source = self._request, self._convolution.source
        fields = self._tractions.read(step, request.source, request.tractions)
        shift = request.source[0].start % self._sides[0], request.source[1].start % self._sides[1]
        shape = source[0].stop - source[0].start, source[1].stop - source[1].start
        blocks = {name: in_blocks(field, self._sides, shift, shape) for name, field in fields.items()}
        return self._convolution.forward(blocks)

    def stress(self, body: Body, step: int, depth: float, spectra: ComplexArray) -> DoubleArray:
        """Return the stress in the blocks of the target with the bulk stress, (6, blocks along x, along y)."""
        if (body, depth) not in self._kernels:
            nu = self._tractions.poisson_ratios[body]
            potentials = self._convolution.potentials(depth, {body: nu})
            self._kernels[body, depth] = self._convolution.kernels(potentials, depth, nu, body)
        stress = self._convolution.stress(self._kernels[body, depth], spectra)
        stress[[0, 1, 3]] += self._tractions.bulk_stress(body, step)[:, None, None]
        return stress

    def bounds(self, body: Body, step: int, stress: DoubleArray) -> dict[Invariant, SurfaceBounds]:
        """Return where the largest invariants on the surface may lie.

        stress: the stress on the surface in the cells, with the bulk stress, (6, nx, ny).
        """
        coarse = self.stress(body, step, 0.0, self.spectra(step))
        return {name: self._bounds(invariant(name, stress), invariant(name, coarse)) for name in INVARIANTS}

    def _bounds(self, fine: DoubleArray, coarse: DoubleArray) -> SurfaceBounds:
        first, second = self._request.target
        shift = first.start % self._sides[0], second.start % self._sides[1]
        shape = coarse.shape[0], coarse.shape[1]
        # A block at the end of the window may have fewer cells, but has one.
        covered = in_blocks(np.ones_like(fine), self._sides, shift, shape)
        value = in_blocks(fine, self._sides, shift, shape) / covered
        factor = LINE_ERROR_FACTOR if self._tractions.plane_strain else ERROR_FACTOR
        error = factor * maximum_filter(np.abs(value - coarse), 3, mode="nearest")  # of the blocks around, too
        upper = np.maximum(value, coarse) + error
        chosen = np.argwhere(upper >= value.max()).T
        middles = [
            side * (window.start + numbers + 0.5)
            for side, window, numbers in zip(self._sides, self._target, chosen, strict=True)
        ]
        best = np.unravel_index(int(value.argmax()), value.shape)
        return SurfaceBounds(upper[chosen[0], chosen[1]], np.stack(middles), float(error[best]))


EDGE_LEAD = 0.25
"""An extrapolated value at the edge is the largest if it exceeds all cells' values by this share of its error."""

SOLVED_FACTOR, SOLVED_LINE_FACTOR = 2.0, 4.0
"""Error at the edge with the solver's tractions over the error with exact ones, and the same ratio in line contacts. A
cell at the edge is loaded or not, and a slip zone may be a few cells wide; in an area contact that varies along the
edge (docs/verification.md)."""

Key = tuple[Body, Invariant]


@dataclass(frozen=True)
class Peak:
    """The largest value of an invariant in an increment (MPa).

    value: the best estimate, which is the value of the cells unless `at_edge`; error: its estimated error; on_cells:
    the largest value at the centres of cells, of cells at the edge if `at_edge`; x, y, depth: where the value is (mm).
    deepest: it is at the largest depth of several, so that it may grow below; outermost: it is in the last cells of the
    window, so that it may grow beyond; unbounded: it is at a sharp edge or tip, and no value is the largest.
    """

    value: float
    error: float
    on_cells: float
    x: float
    y: float
    depth: float
    at_edge: bool = False
    deepest: bool = False
    outermost: bool = False
    unbounded: bool = False


class PeakSearch:
    """Collects the largest values of all layers."""

    def __init__(self, tractions: TractionHistory, request: StressRequest):
        self._tractions, self._request = tractions, request
        self._centres = cell_centres(tractions.grid, request.target)
        shape = len(request.steps), len(request.depths)
        keys = [(body, name) for body in request.bodies for name in INVARIANTS]
        self._values = {key: np.full(shape, -np.inf) for key in keys}
        self._cells = {key: np.zeros((*shape, 2), np.intp) for key in keys}
        self._solved_factor = SOLVED_LINE_FACTOR if tractions.plane_strain else SOLVED_FACTOR
        self._doubled = DoubledCells(tractions, request)
        self._bounds: dict[tuple[Body, Invariant, int], SurfaceBounds] = {}
        self._at_edge: dict[tuple[Body, Invariant, int], float] = {}

    def add(self, layer: Layer) -> None:
        """Note the largest values of a layer, and on the surface also the largest values at the edge of contact."""
        place = layer.step_index, layer.depth_index
        for name, (value, cell) in largest(layer.stress).items():
            self._values[layer.body, name][place] = value
            self._cells[layer.body, name][place] = cell
        if self._request.depths[layer.depth_index] == 0.0:
            step = self._request.steps[layer.step_index]
            for name, bounds in self._doubled.bounds(layer.body, step, layer.stress).items():
                self._bounds[layer.body, name, layer.step_index] = bounds
            cells = np.argwhere(self._edge(layer.step_index))
            if len(cells):
                for name, (value, _) in largest(layer.stress[:, *cells.T][:, :, None]).items():
                    self._at_edge[layer.body, name, layer.step_index] = value

    def peaks(self) -> dict[Key, list[Peak]]:
        """Return the peaks of each increment, once all layers are added."""
        best = {key: values.argmax(axis=1) for key, values in self._values.items()}
        halved = self._on_doubled_cells({(key[0], int(depth)) for key, depths in best.items() for depth in depths})
        found = {
            key: [self._on_cells(key, index, int(depth), halved) for index, depth in enumerate(depths)]
            for key, depths in best.items()
        }
        for (body, name, index), peak in self._extrapolated().items():
            # A value elsewhere that is as large is better known.
            if peak.value - EDGE_LEAD / self._solved_factor * peak.error > found[body, name][index].value:
                found[body, name][index] = peak
        for (body, name, index), bounds in self._bounds.items():
            found[body, name][index] = self._bounded(found[body, name][index], bounds)
        return found

    def _bounded(self, peak: Peak, bounds: SurfaceBounds) -> Peak:
        if self._tractions.has_sharp_edges and peak.depth == 0.0:
            return replace(peak, value=peak.on_cells, error=math.inf, unbounded=True)
        grid = self._tractions.grid
        place = np.array([(peak.x - grid.x[0]) / grid.dx, (peak.y - grid.y[0]) / grid.dy]) + 0.5
        if peak.at_edge:
            error = max(peak.error, bounds.most(place, NEIGHBOURHOOD) - peak.value)
        else:
            error = max(peak.error, bounds.most() - peak.value, bounds.error if peak.depth == 0.0 else 0.0)
        return replace(peak, error=error)

    def _edge(self, index: int) -> BoolArray:
        pressure = self._tractions.pressure(self._request.steps[index])
        edge = edge_cells(pressure > 0.0)
        target = self._request.target
        found = np.zeros(self._request.shape, bool)
        inside = [slice(max(0, of.start), min(of.stop, count)) for of, count in zip(target, edge.shape, strict=True)]
        wanted = [slice(of.start - to.start, of.stop - to.start) for of, to in zip(inside, target, strict=True)]
        found[wanted[0], wanted[1]] = edge[inside[0], inside[1]]
        return found

    def _on_cells(
        self, key: Key, index: int, depth: int, halved: Mapping[tuple[Body, int], list[dict[Invariant, float]]]
    ) -> Peak:
        depths, along = self._request.depths, self._values[key][index]
        change = abs(float(along[depth]) - halved[key[0], depth][index][key[1]])
        return Peak(
            float(along[depth]),
            change + between_depths(depths, along, depth),
            float(along[depth]),
            *self._place(self._cells[key][index, depth]),
            depths[depth],
            deepest=depth > 0 and depth == len(depths) - 1,
            outermost=is_outermost(self._cells[key][index, depth], self._request.shape),
        )

    def _extrapolated(self) -> dict[tuple[Body, Invariant, int], Peak]:
        if not self._at_edge:
            return {}
        request, tractions = self._request, self._tractions
        ratios = {body: tractions.poisson_ratios[body] for body in request.bodies}
        extrapolation = EdgeExtrapolation(
            tractions.grid,
            request.source,
            request.target,
            ratios,
            request.tractions,
            plane_strain=tractions.plane_strain,
        )
        found = {}
        for index in sorted({index for _, _, index in self._at_edge}):
            step = request.steps[index]
            fields = tractions.read(step, request.source, request.tractions)
            bulk = {body: tractions.bulk_stress(body, step) for body in request.bodies}
            for (body, name), one in extrapolation.estimates(fields, bulk).items():
                grid, on_cells = tractions.grid, self._at_edge[body, name, index]
                x, y = (
                    float(axis[0] + side * (cells - 0.5))
                    for axis, side, cells in zip((grid.x, grid.y), (grid.dx, grid.dy), one.place, strict=True)
                )
                error = self._solved_factor * one.error
                found[body, name, index] = Peak(one.value, error, on_cells, x, y, 0.0, at_edge=True)
        return found

    def _place(self, cell: Sequence[int]) -> tuple[float, float]:
        """Return the centre of a cell of the target (mm)."""
        x, y = self._centres
        return float(x[cell[0]]), float(y[cell[1]])

    def _on_doubled_cells(self, places: set[tuple[Body, int]]) -> dict[tuple[Body, int], list[dict[Invariant, float]]]:
        """Return the largest values of each increment at some depths, from tractions averaged over 2 x 2 cells."""
        found: dict[tuple[Body, int], list[dict[Invariant, float]]] = {place: [] for place in places}
        for step in self._request.steps:
            spectra = self._doubled.spectra(step)
            for body, index in places:
                stress = self._doubled.stress(body, step, self._request.depths[index], spectra)
                found[body, index].append({name: value for name, (value, _) in largest(stress).items()})
        return found


def between_depths(depths: Sequence[float], values: DoubleArray, best: int) -> float:
    """Return by how much a parabola through the largest value and its neighbours over the depth rises above it."""
    if not 0 < best < len(depths) - 1:
        return 0.0
    (before, at, after), (low, top, high) = depths[best - 1 : best + 2], values[best - 1 : best + 2]
    left, right = (top - low) / (at - before), (high - top) / (after - at)
    curvature = 2.0 * (right - left) / (after - before)
    slope = (left * (after - at) + right * (at - before)) / (after - before)
    return float(-0.5 * slope * slope / curvature) if curvature < 0.0 else 0.0
