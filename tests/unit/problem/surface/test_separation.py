from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from fretsolve.case.keys.body_specs import (
    ConeSurface,
    CylinderSurface,
    EllipsoidSurface,
    HeightsSurface,
    PunchSurface,
    SphereSurface,
)
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.surface.separation import separation

GRID = Grid.from_size((9, 6), (1.8, 1.2))


def single(surface, x, y):
    return float(separation([surface], np.array([x]), np.array([y]))[0, 0])


def test_sphere_is_its_osculating_paraboloid():
    h = separation([SphereSurface(radius=10.0)], GRID.x, GRID.y)
    assert h.shape == GRID.shape and h.dtype == np.float64 and h.flags.c_contiguous
    np.testing.assert_allclose(h, (GRID.x[:, None] ** 2 + GRID.y**2) / 20.0, rtol=1e-14)


def test_surfaces_add_up_each_about_its_centre():
    ball = SphereSurface(radius=10.0, center=(0.5, -0.25))
    socket = SphereSurface(radius=-12.0)
    expected = separation([ball], GRID.x, GRID.y) + separation([socket], GRID.x, GRID.y)
    np.testing.assert_allclose(separation([ball, socket], GRID.x, GRID.y), expected, rtol=1e-14)
    assert single(ball, 0.5, -0.25) == 0.0


BUTT = CylinderSurface(radius=10.0, axis="x", length=2.0)
ROLLER = CylinderSurface(radius=10.0, axis="y", length=4.0, end_radius=0.5)
SHARP, ROUNDED = PunchSurface(radius=0.5), PunchSurface(radius=1.0, edge_radius=0.5)
SQUARE = PunchSurface(half_width=1.0, edge_radius=0.5)


@pytest.mark.parametrize(
    ("surface", "x", "y", "height"),
    [
        (SphereSurface(radius=-10.0), 0.3, 0.4, -0.0125),
        (ConeSurface(angle="2 deg", center=(0.1, 0.0)), 0.4, 0.4, 0.5 * math.tan(math.radians(2.0))),
        (CylinderSurface(radius=10.0, axis="x", crown_radius=500.0), 2.0, 1.0, 4.0 / 1000.0 + 1.0 / 20.0),
        (BUTT, 1.0, 0.2, 0.002),
        (BUTT, 1.0001, 0.0, math.inf),
        (ROLLER, 0.2, -1.8, 0.002 + 0.5 - 0.4),
        (ROLLER, 0.0, 2.0, 0.5),
        (ROLLER, 0.0, 2.0001, math.inf),
        (SHARP, 0.3, 0.4001, math.inf),
        (ROUNDED, 0.0, -0.9, 0.5 - 0.3),
        (ROUNDED, 1.0001, 0.0, math.inf),
        (PunchSurface(radius=1.0, edge_radius=1.0), 1e-7, 0.0, 5e-15),
        (SQUARE, 0.8, 0.9, 0.5),  # 0.3 and 0.4 past the flat's corner
        (SQUARE, 0.9, 0.0, 0.2),
        (SQUARE, 0.95, 0.95, math.inf),
    ],
)
def test_height_at_a_point(surface, x, y, height):
    assert single(surface, x, y) == pytest.approx(height, rel=1e-12, abs=0.0)


class TestPunch:
    def test_cells_of_a_sharp_round_punch_are_those_with_the_centre_in_it(self):
        grid = Grid.from_size((40, 41), (1.2, 1.3))
        h = separation([PunchSurface(radius=0.5)], grid.x, grid.y)
        np.testing.assert_array_equal(np.isfinite(h), np.hypot(grid.x[:, None], grid.y) <= 0.5)
        assert np.all(h[np.isfinite(h)] == 0.0)

    @pytest.mark.parametrize("center", [(0.0, 0.0), (0.1, 1.7), (-3.3, 1e3)])
    def test_rounding_of_coordinates_does_not_decide_about_cells_on_the_edge(self, center):
        grid = Grid.from_size((11, 11), (1.1, 1.1), center)
        h = separation([PunchSurface(half_width=0.3, center=center)], grid.x, grid.y)
        assert np.isfinite(h).sum() == 49


@pytest.mark.parametrize("points", [(8, 8), (9, 12)])
@pytest.mark.parametrize(
    "surface",
    [
        SphereSurface(radius=10.0),
        EllipsoidSurface(radius_x=5.0, radius_y=40.0),
        CylinderSurface(radius=10.0, axis="y", length=1.0, end_radius=0.2, crown_radius=50.0),
        ConeSurface(angle=0.03),
        PunchSurface(radius=0.6, edge_radius=0.1),
        PunchSurface(half_width=0.5, edge_radius=0.1),
    ],
    ids=lambda surface: surface.kind,
)
def test_mirror_symmetry_holds_to_the_last_bit(surface, points):
    grid = Grid.from_size(points, (1.3, 1.7))
    h = separation([surface], grid.x, grid.y)
    np.testing.assert_array_equal(h, h[::-1, :])
    np.testing.assert_array_equal(h, h[:, ::-1])


def test_height_map_adds_to_the_other_surfaces(tmp_path: Path):
    np.save(tmp_path / "rough.npy", np.arange(12.0).reshape(4, 3))
    rough = HeightsSurface(file=str(tmp_path / "rough.npy"), spacing=(1.0, 1.0), unit="um", center=(1.0, 2.0))
    x, y = np.array([0.5, 1.5]), np.array([1.0, 2.0, 3.0])
    total = separation([SphereSurface(radius=10.0), rough], x, y)
    heights = 1e-3 * np.array([[3.0, 4.0, 5.0], [6.0, 7.0, 8.0]])
    np.testing.assert_allclose(total, (x[:, None] ** 2 + y**2) / 20.0 + heights, rtol=1e-12)
