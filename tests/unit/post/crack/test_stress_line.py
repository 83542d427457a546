"""The stress along a line is that of the cells one by one, and that of larger cells where tractions are averaged."""

import numpy as np
import pytest

from fretsolve.post.crack.stress_line import stress_line
from fretsolve.post.stress.influence import COMPONENTS, point_influence
from fretsolve.problem.model.grid import Grid

DEPTHS = np.array([0.03, 0.2, 3.0])


class GivenTractions:
    """Tractions on 9 x 8 cells or 9 strips in two increments; has what `stress_line` reads of a history."""

    def __init__(self, *, plane_strain):
        self.plane_strain = plane_strain
        self.grid = Grid(9, 1, 0.1, 0.1, 0.02) if plane_strain else Grid(9, 8, 0.1, 0.13, 0.02, -0.07)
        self.poisson_ratios = {1: 0.2, 2: 0.3}
        random = np.random.default_rng(1)
        self.fields = [{name: random.random(self.grid.shape) for name in ("p", "qx", "qy")} for _ in range(2)]

    def extent(self, steps):
        return (slice(0, self.grid.nx), slice(0, self.grid.ny)), ("p", "qx", "qy")

    def read(self, step, window, names):
        return self.fields[step]

    def bulk_stress(self, body, step):
        return step * np.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize("plane_strain", [True, False])
@pytest.mark.parametrize("body", [1, 2])
def test_it_is_the_stress_of_the_cells(plane_strain, body):
    given = GivenTractions(plane_strain=plane_strain)
    place = 0.111, 0.0 if plane_strain else 0.2
    found = stress_line(given, (0, 1), body).stress(place, DEPTHS)
    assert found.shape == (6, 3, 2, 3)
    for step in (0, 1):
        for index, depth in enumerate(DEPTHS):
            nu = given.poisson_ratios[body]
            cells = point_influence(given.grid, (*place, depth), nu, body, plane_strain=plane_strain)
            stress = cells.stress(given.fields[step])
            stress[[0, 1, 3]] += given.bulk_stress(body, step)
            np.testing.assert_allclose(found[:, 0, step, index], stress, rtol=0, atol=1e-13)


@pytest.mark.parametrize("plane_strain", [True, False])
def test_averages_are_larger_cells(plane_strain):
    """Blocks that begin with the first cell: the last one of an odd number has an empty cell beside it."""
    given = GivenTractions(plane_strain=plane_strain)
    grid, width = given.grid, 1 if plane_strain else 2
    place = 0.111, 0.0 if plane_strain else 0.2
    double = Grid(5, grid.ny // width, 0.2, width * grid.dy, 0.07, grid.y0)
    fields = {}
    for name, field in given.fields[0].items():
        blocks = np.pad(field, ((0, 1), (0, 0))).reshape(5, 2, -1, width)
        fields[name] = blocks.mean(axis=(1, 3))
    found = stress_line(given, (0,), 2).stress(place, DEPTHS)[:, :, 0]
    for index, depth in enumerate(DEPTHS):
        cells = point_influence(double, (*place, depth), 0.3, 2, plane_strain=plane_strain)
        # with the other shift, the first block holds the empty cell before the first one
        np.testing.assert_allclose(found[:, 2, index], cells.stress(fields), rtol=0, atol=1e-13)
        assert np.abs(found[:, 1, index] - found[:, 2, index]).max() > 1e-4


def test_one_component_and_sums_over_depths():
    line = stress_line(GivenTractions(plane_strain=False), (0, 1), 2)
    whole = line.stress((0.111, 0.2), DEPTHS)
    weights = np.array([[1.0, 2.0, 3.0]])
    found = line.stress((0.111, 0.2), DEPTHS, ("xz",), weights)
    np.testing.assert_allclose(found[0, ..., 0], whole[COMPONENTS.index("xz")] @ weights[0], atol=1e-13)
    np.testing.assert_allclose(line.of(1).stress((0.111, 0.2), DEPTHS), whole[:, :, 1:], atol=1e-14)
