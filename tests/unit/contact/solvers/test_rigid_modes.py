from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.solvers.rigid_modes import NormalModes, TangentialModes, larger, solve_modes
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl

GRID = Grid.from_size((7, 5), (1.4, 0.9), (0.3, -0.2))
ALL = [0, 1, 2]


@pytest.fixture
def fields():
    return np.random.default_rng(0).normal(size=(2, 7, 5))


class TestBalance:
    BALANCE = LoadControl((True, False, True), (10.0, 0.2, -3.0))

    def test_parts(self):
        assert self.BALANCE.forced_index == [0, 2]
        assert self.BALANCE.imposed_displacement.tolist() == [0.0, 0.2, 0.0]
        assert self.BALANCE.imposed_resultant.tolist() == [10.0, 0.0, -3.0]

    def test_displacements_as_increments(self):
        moved = self.BALANCE.relative_to(np.array([5.0, 0.15, 7.0]))
        assert moved.forced == self.BALANCE.forced
        assert moved.values == pytest.approx((10.0, 0.05, -3.0))


class TestNormalModes:
    MODES = NormalModes(GRID)

    def test_resultants_of_an_even_pressure(self):
        """The force acts at the grid's centre: My/P = x0, Mx/P = y0."""
        p, mx, my = self.MODES.resultants(np.full(GRID.shape, 2.0))
        assert p == pytest.approx(2.0 * 1.4 * 0.9)
        assert (my / p, mx / p) == pytest.approx(GRID.center)

    def test_displacement(self):
        out = np.empty(GRID.shape)
        self.MODES.displacement(np.array([1.0, 2.0, 3.0]), out)
        np.testing.assert_allclose(out, 1.0 + 2.0 * GRID.y[None, :] + 3.0 * GRID.x[:, None])


class TestTangentialModes:
    MODES = TangentialModes(GRID)

    def test_resultants(self):
        shear = np.zeros((2, *GRID.shape))
        shear[0, 2, 4], shear[1, 5, 1] = 3.0, 4.0
        qx, qy, mz = self.MODES.resultants(shear)
        area = GRID.cell_area
        assert (qx, qy) == pytest.approx((3.0 * area, 4.0 * area))
        assert mz == pytest.approx((4.0 * GRID.x[5] - 3.0 * GRID.y[4]) * area)

    def test_rotation_is_about_the_origin(self):
        out = np.empty((2, *GRID.shape))
        self.MODES.displacement(np.array([0.0, 0.0, 0.5]), out)
        np.testing.assert_allclose(out[0], np.broadcast_to(-0.5 * GRID.y[None, :], GRID.shape))
        np.testing.assert_allclose(out[1], np.broadcast_to(0.5 * GRID.x[:, None], GRID.shape))


def test_missing_resultants_are_those_imposed_less_those_of_a_traction():
    modes = NormalModes(GRID)
    control = LoadControl((True, False, True), (2.0 * GRID.cell_area, 0.5, 3.0 * GRID.cell_area))
    assert modes.missing(control, (1.5, 4.0, 0.5)) == pytest.approx((0.5, -4.0, 2.5))


@pytest.mark.parametrize(("value", "other"), [(np.nan, 1.0), (1.0, np.nan), (np.nan, np.nan)])
def test_the_larger_number_is_nan_if_one_is(value, other):
    assert np.isnan(larger(value, other))


class TestSolveModes:
    GRAM = np.array([[4.0, 1.0, 0.0], [1.0, 3.0, 0.5], [0.0, 0.5, 2.0]])

    def test_all_modes(self):
        right = np.array([1.0, 2.0, 3.0])
        np.testing.assert_allclose(self.GRAM @ solve_modes(self.GRAM, right, ALL), right)

    def test_some_modes(self):
        found = solve_modes(self.GRAM, np.array([1.0, 2.0, 3.0]), [0, 2])
        assert found[1] == 0.0
        assert found[[0, 2]] == pytest.approx([0.25, 1.5])

    def test_scales_do_not_count(self):
        """A contact of nanometres has a polar moment that seems to vanish beside its area."""
        scale = np.diag([1.0, 1e-7, 1e7])
        found = solve_modes(scale @ self.GRAM @ scale, scale @ np.array([1.0, 2.0, 3.0]), ALL)
        np.testing.assert_allclose(scale @ found, np.linalg.solve(self.GRAM, [1.0, 2.0, 3.0]))

    @pytest.mark.parametrize("cell", [(0.0, 0.0), (0.2, -0.3)])
    def test_a_single_cell_gets_no_amplitude_that_it_cannot_tell(self, cell):
        x, y = cell
        mode = np.array([1.0, y, x])
        found = solve_modes(np.outer(mode, mode), 2.0 * mode, ALL)
        assert np.isfinite(found).all()
        assert mode @ found == pytest.approx(2.0)
