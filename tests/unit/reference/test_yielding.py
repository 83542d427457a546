"""The onset of yield under Hertz's pressure, by von Mises: certified values, and the stress of cells."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.post.stress.influence import point_influence
from fretsolve.post.stress.invariants import von_mises
from fretsolve.problem.model.grid import Grid
from fretsolve.reference.yielding import yield_onset


@pytest.mark.parametrize(
    ("nu", "line", "pressure", "depth"),
    [
        (0.3, False, 1.6128, 0.481),  # Johnson (1985), section 4.2, to more digits
        (0.42, False, 1 / 0.56653, 0.521),
        (0.3, True, 1.7937, 0.704),
        (
            0.5,
            True,
            1 / (3**0.5 * 0.300283),
            0.786,
        ),  # without a change of volume by the largest shear: sqrt(3) times it
        (0.1, True, 1 / 0.8, 0.0),  # at the surface, where the stresses are p0, p0 and 2 nu p0
    ],
)
def test_onset(nu: float, line: bool, pressure: float, depth: float) -> None:
    onset = yield_onset(nu, line=line)
    assert onset.pressure == pytest.approx(pressure, abs=6e-5)
    assert onset.depth == pytest.approx(depth, abs=6e-4)


@pytest.mark.parametrize("line", [False, True])
def test_the_stress_of_cells_is_largest_there(line: bool) -> None:
    """Half a contact radius has 40 cells; the middle lies in a cell."""
    cells = 41 if not line else 161
    h = 2.1 / cells
    grid = Grid(cells, 1 if line else cells, h, h)
    r = np.hypot(grid.x[:, None], 0.0 * grid.x[:1] if line else grid.y[None, :])
    pressure = np.sqrt(np.maximum(1.0 - r**2, 0.0))
    onset = yield_onset(0.3, line=line)

    def mises(depth: float) -> float:
        influence = point_influence(grid, (0.0, 0.0, depth), 0.3, 2, ("p",), plane_strain=line)
        return float(von_mises(influence.stress({"p": pressure})))

    assert mises(onset.depth) == pytest.approx(1.0 / onset.pressure, rel=3e-3)
    assert mises(onset.depth) > max(mises(0.9 * onset.depth), mises(1.1 * onset.depth))
