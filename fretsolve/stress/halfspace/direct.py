"""Stress at a point by a direct sum over all cells: for few points, many increments, and to check the convolution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.model.grid import Grid
from fretsolve.stress.halfspace.influence import COMPONENTS, TRACTIONS, Body, Traction, stress_terms
from fretsolve.stress.halfspace.potentials import Potential, Strip, cell_values
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True, eq=False)
class PointInfluence:
    """Coefficients of the six components at a point from each cell, ``(6, tractions, nx, ny)``."""

    values: DoubleArray
    tractions: Sequence[Traction]

    def stress(self, tractions: Mapping[Traction, DoubleArray]) -> DoubleArray:
        """Return the six components (MPa) from tractions (nx, ny), ``(6,)``."""
        fields = np.stack([tractions[name] for name in self.tractions])
        total: DoubleArray = np.einsum("ctxy,txy->c", self.values, fields)
        return total


def point_influence(
    grid: Grid,
    point: tuple[float, float, float],
    nu: float,
    body: Body,
    tractions: Sequence[Traction] = TRACTIONS,
    *,
    plane_strain: bool = False,
) -> PointInfluence:
    """Return the coefficients at a point: x, y and depth (mm); at depth 0 it may not lie on the edge of a cell.

    plane_strain: cells are strips without end along y, in one row.
    """
    x, y, depth = point
    known: dict[Potential | Strip, DoubleArray] = {}

    def values(name: Potential | Strip) -> DoubleArray:
        if name not in known:
            # The offsets from the cells descend with their index.
            ascending = cell_values(name, (x - grid.x)[::-1], (y - grid.y)[::-1], depth, grid.dx, grid.dy)
            known[name] = ascending[::-1, ::-1]
        return known[name]

    found = np.zeros((len(COMPONENTS), len(tractions), *grid.shape))
    for row, component in enumerate(COMPONENTS):
        for column, traction in enumerate(tractions):
            for name, factor in stress_terms(component, traction, depth, nu, body, plane_strain=plane_strain).items():
                found[row, column] += factor * values(name)
    return PointInfluence(found, tuple(tractions))
