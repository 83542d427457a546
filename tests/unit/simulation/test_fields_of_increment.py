"""Fields of a state: what is kept of the solution, slip of cells that the edge passes, and dissipated energy."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, HERTZ, LOAD, MATERIAL, RADIUS, A, build, solve

from fretsolve.elastic import thread_team
from fretsolve.problem.model.grid import Grid
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.result.state import Zone
from fretsolve.simulation.fields_of_increment import mean_pressure, share_in_contact, unloaded
from fretsolve.simulation.problem_setup import set_up


def test_unloaded_surfaces_touch_at_their_nearest_points():
    separation = np.array([[3.0, 1.0], [np.inf, 2.5]])
    fields, displacement = unloaded(separation)
    assert fields.gap.tolist() == [[2.0, 0.0], [np.inf, 1.5]]
    assert not any(np.any(field) for field in (fields.pressure, fields.shear, fields.slip, fields.zone, displacement))
    assert fields.shear.shape == displacement.shape == (2, 2, 2)


def test_fields_in_parts_are_those_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction differs from part to part, and cells of each part slip, stick and open."""
    path = [{"P": 400.0, "increments": 2}, {"Qx": 10.0, "increments": 2}, {"P": 150.0, "increments": 2}]
    parts = {"bodies": DISSIMILAR, "grid": {"points": 17}, "friction": {"expression": "0.1 + 0.1*x"}, "load_path": path}
    whole = solve(**parts)
    assert (whole[-1].fields.zone[[4, 12]] == Zone.OPEN).any(axis=1).all()
    monkeypatch.setattr(thread_team, "parts_of", lambda shape: [(0, 5), (5, 9), (9, shape[0])])
    for found, wanted in zip(solve(**parts), whole, strict=True):
        assert found.summary.work == pytest.approx(wanted.summary.work, rel=1e-7)
        for name in ("slip", "slip_path", "work_density"):
            one, other = getattr(found.fields, name), getattr(wanted.fields, name)
            np.testing.assert_allclose(one, other, atol=1e-7 * np.abs(other).max(), err_msg=name)


def test_friction_and_its_limit_are_kept_where_the_case_asks_for_them():
    fields = ["pressure", "shear", "friction", "shear_bound"]
    friction = {"expression": "0.1 + 0.2*x"}
    (state,) = solve(grid={"points": 12}, friction=friction, output={"fields": fields})
    assert state.fields.friction is not None and state.fields.shear_bound is not None
    np.testing.assert_allclose(state.fields.shear_bound, state.fields.friction * state.fields.pressure, rtol=1e-12)
    x = set_up(build(grid={"points": 12}, friction=friction)).grid.x
    np.testing.assert_allclose(state.fields.friction, np.repeat(0.1 + 0.2 * x[:, None], 12, axis=1), rtol=1e-9)


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


def test_mean_pressure_is_that_of_hertz_contact_as_its_area_grows():
    loads = LOAD * np.linspace(0.25, 1.0, 2001) ** 1.5
    path = [hertz_sphere(load, RADIUS, MATERIAL.contact_modulus).pressure(np.array([0.05, 0.15])) for load in loads]
    mean = np.mean([0.5 * (one + other) for one, other in zip(path[1:], path[:-1], strict=True)], axis=0)
    assert mean_pressure(path[0], path[-1]) == pytest.approx(mean, rel=1e-6)


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


def test_unloading_at_full_stick_takes_no_work():
    path = [{"P": LOAD, "increments": 10}, {"P": 0.02 * LOAD, "increments": 10}]
    states = solve(bodies=DISSIMILAR, friction=10.0, grid={"points": 32}, load_path=path)
    assert states[-1].summary.work_total < 1e-6 * LOAD * states[9].summary.delta_z
