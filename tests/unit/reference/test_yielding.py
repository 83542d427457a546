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
    onset = yield_onset(nu, 0.0 if line else 1.0)
    assert onset.pressure == pytest.approx(pressure, abs=6e-5)
    assert onset.depth == pytest.approx(depth, abs=6e-4)


@pytest.mark.parametrize(
    ("ratio", "of_pressure", "of_depth"), [(0.0, 3e-3, 0.02), (0.25, 3e-3, 0.03), (0.6, 5e-3, 0.06), (1.0, 3e-3, 0.02)]
)
def test_the_stress_of_cells_is_largest_there(ratio: float, of_pressure: float, of_depth: float) -> None:
    """The shorter semi-axis is 1; the middle lies in a cell."""
    length = 1.0 / ratio if ratio else 1.0
    nx, ny = (161, 1) if ratio == 0.0 else (61, 41)
    grid = Grid(nx, ny, 2.1 * length / nx, 2.1 / ny if ratio else 2.1 / nx)
    across = (grid.y if ratio else np.zeros(1))[None, :]
    pressure = np.sqrt(np.maximum(1.0 - (grid.x[:, None] / length) ** 2 - across**2, 0.0))
    onset = yield_onset(0.3, ratio)

    def mises(depth: float) -> float:
        influence = point_influence(grid, (0.0, 0.0, depth), 0.3, 2, ("p",), plane_strain=ratio == 0.0)
        return float(von_mises(influence.stress({"p": pressure})))

    depths = np.linspace(0.4, 0.8, 41)
    values = [mises(depth) for depth in depths]
    assert max(values) == pytest.approx(1.0 / onset.pressure, rel=of_pressure)
    assert depths[int(np.argmax(values))] == pytest.approx(onset.depth, abs=of_depth)
