"""The part of an increment in which a cell touches, and the mean of its pressure."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, HERTZ, LOAD, MATERIAL, RADIUS, A, solve

from fretsolve.model.grid import Grid
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.result.state import Zone
from fretsolve.simulation import slip_and_work
from fretsolve.simulation.slip_and_work import mean_pressure, share_in_contact, slipped_apart

GRID = Grid.from_size((301, 301), (0.75, 0.75), (0.0, 0.0))
R = np.hypot(GRID.x[:, None], GRID.y[None, :])


def gap_outside(contact_radius):
    """Between a sphere and the flat that it presses (Johnson, section 3.5)."""
    ratio = np.maximum(R / contact_radius, 1.0)
    a = contact_radius**2 / RADIUS
    flat = a - R**2 / (2.0 * RADIUS)
    pressed = (a / np.pi) * ((2.0 - ratio**2) * np.arcsin(1.0 / ratio) + np.sqrt(ratio**2 - 1.0))
    return np.where(contact_radius < R, pressed - flat, 0.0)


@pytest.mark.parametrize("smaller", [0.98, 0.95, 0.9])
def test_share_is_that_of_the_way_of_hertz_edge(smaller):
    """Cells in the ring that a growing contact covers: those near its old edge touch first."""
    before = gap_outside(smaller * A)
    pressure = HERTZ.pressure(R)
    ring = np.nonzero((smaller * A < R) & (R < A))
    found = share_in_contact(pressure, before, ring, GRID, MATERIAL.contact_modulus)
    way = (A - R[ring]) / (A - smaller * A)
    assert np.sqrt(np.mean((found - way) ** 2)) < 0.05
    assert found.min() > 0.0
    assert found.max() <= 1.0


def test_a_cell_alone_has_a_share_too():
    pressure, gap = np.zeros((5, 5)), np.full((5, 5), 1e-4)
    pressure[2, 2] = 500.0
    cell = (np.array([2]), np.array([2]))
    grid = Grid.from_size((5, 5), (0.05, 0.05), (0.0, 0.0))
    assert 0.0 < share_in_contact(pressure, gap, cell, grid, 1e5)[0] < 1.0
    assert share_in_contact(pressure, 0.0 * gap, cell, grid, 1e5)[0] == 1.0


def test_mean_pressure_is_that_of_hertz_contact_as_its_area_grows():
    loads = LOAD * np.linspace(0.25, 1.0, 2001) ** 1.5
    path = [hertz_sphere(load, RADIUS, MATERIAL.contact_modulus).pressure(np.array([0.05, 0.15])) for load in loads]
    mean = np.mean([0.5 * (one + other) for one, other in zip(path[1:], path[:-1], strict=True)], axis=0)
    assert mean_pressure(path[0], path[-1]) == pytest.approx(mean, rel=1e-6)


def test_mean_pressure_of_a_pressure_that_stays_or_is_nothing():
    pressure = np.array([[0.0, 3.0, 1e-30, 2e3]])
    assert mean_pressure(pressure, pressure) == pytest.approx(pressure, rel=1e-15)
    assert mean_pressure(pressure, 0.0 * pressure) == pytest.approx(2.0 / 3.0 * pressure, rel=1e-15)


def test_pressing_and_parting_take_the_slip_of_the_time_in_contact_only():
    """A finer path hardly changes what a cell near the edge has slipped; the whole motion was twice as much."""
    stages = [{"P": LOAD}, {"P": 0.5 * LOAD}]
    paths = []
    for count in (10, 60):
        path = [{**stage, "increments": count, "spacing": "graded"} for stage in stages]
        states = solve(bodies=DISSIMILAR, grid={"points": 32}, load_path=path, solver={"tolerance": 1e-5})
        paths.append((states[count - 1].fields.slip_path.sum(), states[-1].fields.slip_path.sum()))
    coarse, fine = np.array(paths)
    assert coarse == pytest.approx(fine, rel=0.25)


def test_a_cell_that_parts_slips_where_the_edge_that_leaves_it_does():
    zone = np.full((9, 5), Zone.OPEN, np.uint8)
    zone[2:7] = Zone.STICK
    zone[2] = Zone.SLIP
    parted = np.zeros(zone.shape, bool)
    parted[[0, 1, 7, 8]] = True
    slipped = slipped_apart(parted, zone, np.zeros(zone.shape, bool))
    assert slipped[:2].all()
    assert not slipped[2:].any()


@pytest.mark.parametrize("most", [0, 10**9], ids=["tree", "comparisons"])
def test_no_cell_is_nearer_than_the_nearest(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where squares of distances pass 2**31, as on long lines."""
    monkeypatch.setattr(slip_and_work, "FEW_PAIRS", most)
    choice = np.random.default_rng(1)
    for side in (60, 90_000):
        places, cells = choice.integers(0, side, (300, 2)), choice.integers(0, side, (2000, 2))
        distances = np.square(places[:, None] - cells).sum(axis=2)
        found = slip_and_work.nearest(places, cells)
        np.testing.assert_array_equal(distances[np.arange(300), found], distances.min(axis=1))


def test_where_no_contact_is_left_cells_slip_that_slipped_before():
    zone = np.full((4, 4), Zone.OPEN, np.uint8)
    parted, slipping = np.zeros(zone.shape, bool), np.zeros(zone.shape, bool)
    parted[1:3], slipping[2:] = True, True
    assert (slipped_apart(parted, zone, slipping) == (parted & slipping)).all()


def test_unloading_at_full_stick_takes_no_work():
    path = [{"P": LOAD, "increments": 10}, {"P": 0.02 * LOAD, "increments": 10}]
    states = solve(bodies=DISSIMILAR, friction=10.0, grid={"points": 32}, load_path=path)
    assert states[-1].summary.work_total < 1e-6 * LOAD * states[9].summary.delta_z
