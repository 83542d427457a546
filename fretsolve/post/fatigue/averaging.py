"""Average stresses over a length before a parameter is taken (theory of critical distances, Taylor 1999).

- point: the stress at depth L/2;
- line: the mean over depths from 0 to 2 L;
- volume: the mean over a cube of side L below the surface, centred on the point.

Between stored depths stress is linear. A cell's value holds over the cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import correlate1d

from fretsolve.case.keys.output_spec import AverageKind
from fretsolve.errors import CaseError
from fretsolve.system.arrays import DoubleArray

GAP = 0.3
"""Largest distance of stored depths over the averaging length; depths from a result are closer."""


@dataclass(frozen=True)
class Average:
    """An average over a length L (mm)."""

    kind: AverageKind
    length: float

    @property
    def depth_range(self) -> tuple[float, float]:
        """First and last depth over which stress is averaged (mm)."""
        if self.kind == "point":
            return 0.5 * self.length, 0.5 * self.length
        return 0.0, self.length * (2.0 if self.kind == "line" else 1.0)

    def require_length(self, cell: tuple[float, float]) -> None:
        """Raise CaseError if L is below a cell."""
        largest = max(cell)
        if not self.length >= largest:
            raise CaseError(
                f"the averaging length {self.length:g} mm is below a cell; {largest:.4g} mm or more is needed"
            )

    def require_resolved(self, depths: DoubleArray, cell: tuple[float, float]) -> None:
        """Raise CaseError if L is below a cell, or the stored depths do not hold the range."""
        self.require_length(cell)
        first, last = self.depth_range
        rounding = 1e-9 * last
        if first < depths[0] - rounding or last > depths[-1] + rounding:
            raise CaseError(
                f"the average needs depths from {first:g} to {last:g} mm, the stresses reach from {depths[0]:g} to"
                f" {depths[-1]:g} mm; `fretsolve stress --depth` computes others"
            )

    def gap_problem(self, depths: DoubleArray, cell: tuple[float, float]) -> str | None:
        """Return a warning if stored depths are far apart where stress is averaged, None if they are not."""
        first, last = self.depth_range
        inside = depths[(depths >= first - 1e-9 * last) & (depths <= last * (1.0 + 1e-9))]
        if first == last:
            gap = 0.0 if len(inside) else float(np.diff(depths[np.searchsorted(depths, first) - 1 :][:2])[0])
        else:
            gap = float(np.diff(np.unique(np.concatenate([[first], inside, [last]]))).max())
        if gap <= max(GAP * self.length, *cell):
            return None
        return (
            f"stresses are stored at depths {gap:.3g} mm apart and taken as linear between, which is far against the"
            f" averaging length {self.length:g} mm; more --depth in `fretsolve stress`, or the result itself, is better"
        )

    def of(self, stress: DoubleArray, weights: DoubleArray, cell: tuple[float, float]) -> DoubleArray:
        """Return the averages (..., nx, ny) of stresses (..., depths, nx, ny); weights: `depth_weights` of its range.

        In a volume, the window beyond the edge of the cells goes on as their last one.
        """
        below: DoubleArray = np.einsum("...dxy,d->...xy", stress, weights)
        if self.kind != "volume":
            return below
        for axis, side in ((-2, cell[0]), (-1, cell[1])):
            if below.shape[axis] > 1:
                below = correlate1d(below, box_weights(self.length / side), axis=axis, mode="nearest")
        return below


def depth_weights(depths: DoubleArray, first: float, last: float) -> DoubleArray:
    """Return weights (depths,) of the mean between two depths of what is linear between `depths`; a value if equal."""
    if last <= first:
        # The hat function of each depth is 1 there and 0 at the others.
        return np.asarray([float(np.interp(first, depths, hat)) for hat in np.eye(len(depths))])
    inside = depths[(depths > first) & (depths < last)]
    nodes = np.concatenate([[first], inside, [last]])
    hats = np.array([np.interp(nodes, depths, hat) for hat in np.eye(len(depths))])
    return np.asarray(0.5 * (hats[:, 1:] + hats[:, :-1]) @ np.diff(nodes) / (last - first))


def box_weights(cells: float) -> DoubleArray:
    """Return the weights of cells in a window `cells` cells wide around the middle one; they add up to 1."""
    beside = max(0, int(np.ceil(0.5 * (cells - 1.0))))
    weights = np.ones(2 * beside + 1)
    if beside:
        weights[0] = weights[-1] = 0.5 * (cells - (2 * beside - 1))
    return np.asarray(weights / weights.sum())
