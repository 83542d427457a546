"""Increments of a line contact: what the history holds, restarts, error bars, and what has no solution."""

from __future__ import annotations

import math
from dataclasses import asdict
from itertools import pairwise

import numpy as np
import pytest
from line_cases import DISSIMILAR, FRICTION, HERTZ, LOAD, MATERIAL, SIMILAR, A, line_case, solve_line

from fretsolve import run, run_with_error_bars
from fretsolve.contact.zones.edge_law import ZoneFields
from fretsolve.contact.zones.line_contact import line_zones, width
from fretsolve.errors import GridEdgeError, SlidingError
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.required_terms import derive_model
from fretsolve.result.state import Zone
from fretsolve.simulation.problem_setup import set_up

PARTS = {
    "bodies": DISSIMILAR,
    "grid": {"points": 100, "size": 0.3},
    "reference_depth": 5.0,
    "load_path": [
        {"P": LOAD, "increments": 2},
        {"Qx": 8.0, "My": 0.05, "increments": 2},
        {"delta_z": 1.2e-3, "increments": 2},
        {"Qy": 4.0, "P": 60.0, "bulk_2": {"xx": 30.0}, "increments": 2},
    ],
}


@pytest.fixture(scope="module")
def states():
    return list(run(line_case(**PARTS)))


@pytest.mark.parametrize("done", [1, 3, 5, 7])
def test_resuming_gives_the_same_to_the_last_bit(states, done):
    resumed = list(run(line_case(**PARTS), states[done - 1], [state.summary for state in states[:done]]))
    assert len(resumed) == len(states) - done
    for found, wanted in zip(resumed, states[done:], strict=True):
        for name in ("pressure", "shear", "slip", "slip_path", "work_density", "zone", "gap"):
            np.testing.assert_array_equal(getattr(found.fields, name), getattr(wanted.fields, name))
        ours, theirs = asdict(found.summary), asdict(wanted.summary)
        ours["wall_time"] = theirs["wall_time"]
        np.testing.assert_equal(ours, theirs)  # NaN is NaN


def test_imposed_values_are_found(states):
    ends = [states[step].summary for step in (1, 3, 5, 7)]
    assert pytest.approx(LOAD, rel=1e-6) == ends[0].P
    assert (ends[1].Qx, ends[1].My) == pytest.approx((8.0, 0.05), rel=1e-5)
    assert ends[2].delta_z == pytest.approx(1.2e-3, rel=1e-6)
    assert (ends[3].Qy, ends[3].P) == pytest.approx((4.0, 60.0), rel=1e-5)


def test_displacements_are_known_by_a_reference_depth(states):
    assert all(math.isfinite(state.summary.delta_x) and math.isnan(state.summary.delta_y) for state in states)
    assert all(state.summary.delta_z > 0.0 for state in states)
    without = [state.summary for state in solve_line()]
    assert all(math.isnan(row.delta_x) and math.isnan(row.delta_z) for row in without)


def test_sums_are_per_length():
    state = solve_line()[-1]
    side = set_up(line_case()).grid.dx
    assert state.fields.pressure.sum() * side == pytest.approx(LOAD, rel=1e-6)
    assert state.fields.work_density.sum() * side == pytest.approx(state.summary.work_total, rel=1e-9)
    assert state.summary.contact_area == 2.0 * state.summary.contact_radius


def test_without_contact_there_is_no_middle():
    last = solve_line(load_path=[{"P": LOAD}, {"P": 0.0}])[-1].summary
    assert (last.contact_half_width_x, last.contact_radius) == (0.0, 0.0)
    assert math.isnan(last.contact_center_x)


@pytest.mark.parametrize("reach", [1.15, 3.0, 40.0])
def test_size_of_the_grid_changes_little(reach):
    """The free constant, which follows from the grid's length, has no effect: the same cells give the same."""
    cells = 2 * round(20 * reach) + 1
    found = solve_line(grid={"points": cells, "size": cells * A / 20})
    assert found[-1].summary.max_pressure == pytest.approx(HERTZ.max_pressure, rel=1e-3)
    assert found[-1].summary.stick_radius == pytest.approx(0.0680778, rel=2e-3)
    assert found[-1].summary.work_total == pytest.approx(1.36e-4, rel=0.03)
    assert all(state.summary.worst_residual <= 1e-6 for state in found)


class TestErrorBars:
    def test_bars_of_unknown_displacements_are_unknown(self):
        state = list(run_with_error_bars(line_case(grid={"points": 32}, solver={"error_bars": True})))[-1]
        assert math.isnan(state.errors.delta_x_error) and math.isnan(state.errors.delta_z_error)
        assert math.isfinite(state.errors.work_total_error) and math.isfinite(state.errors.phi_y_error)


def test_accuracy_picks_a_row_of_cells():
    setup = set_up(line_case(grid={}, solver={"accuracy": 0.01}, load_path=[{"P": LOAD}, {"Qx": 18.0}]))
    assert setup.grid.nx == 30 and setup.grid.ny == 1


def test_increments_of_pressing_grow_the_contact_by_equal_parts():
    """a grows like sqrt(P)."""
    case = line_case(bodies=DISSIMILAR, load_path=[{"P": LOAD, "increments": 8, "spacing": "graded"}])
    path = LoadPath(case.stages(), derive_model(case))
    radii = [math.sqrt(path.increment(step, []).normal.values[0]) for step in range(4)]
    steps = [after - before for before, after in pairwise(radii)]
    assert max(steps) < 1.35 * min(steps)


class TestSize:
    def test_cylinder_by_hertz(self):
        assert set_up(line_case()).grid.size[0] == pytest.approx(2.4 * A)

    @pytest.mark.parametrize(
        "surface",
        [
            {"cylinder": {"radius": 10.0, "center": 0.05}},
            [{"cylinder": {"radius": 20.0}}, {"cylinder": {"radius": 20.0}}],
            {"punch": {"half_width": 0.2}},
        ],
    )
    def test_others_by_a_search(self, surface):
        setup = set_up(line_case(surface=surface))
        assert isinstance(setup.grid, LineGrid)
        state = next(run(setup))
        assert 0.5 < 2.0 * state.summary.contact_radius / setup.grid.size[0] < 1.0

    def test_of_two_cylinders_is_that_of_their_sum(self):
        """Two of 20 mm add up to one of 10 mm."""
        surfaces = [{"cylinder": {"radius": 20.0}}, {"cylinder": {"radius": 20.0}}]
        found = solve_line(surface=surfaces, grid={"points": 200})[0].summary
        assert found.contact_radius == pytest.approx(A, rel=1e-3)


class TestNoSolution:
    @pytest.mark.parametrize(
        ("force", "rest"),
        [
            ("Qx", "lower the load, raise P or the friction, or impose delta_x instead, with a reference_depth"),
            ("Qy", "lower the load, or raise P or the friction"),
        ],
    )
    def test_gross_slip(self, force, rest):
        with pytest.raises(SlidingError, match=rf"under {force} = 30 N/mm: .* \(mu P = 30 N/mm\); {rest} \(increment"):
            solve_line(load_path=[{"P": LOAD}, {force: 30.0, "increments": 1}])

    def test_contact_at_the_edge(self):
        with pytest.raises(GridEdgeError, match=r"\(-x, \+x\) of the potential contact area of 0.2 mm, .*; size: "):
            solve_line(grid={"points": 40, "size": 0.2})


class TestEdges:
    GRID = LineGrid.of_length(9, 9.0, 0.0)

    def zones(self, pressure, zone, gap=None, shear=None, slip=None):
        field = np.array(pressure, float)[:, None]
        gap = np.where(field > 0.0, 0.0, 1e-9) if gap is None else np.array(gap, float)[:, None]
        shear = np.zeros((2, 9, 1)) if shear is None else shear
        slip = np.zeros((2, 9, 1)) if slip is None else slip
        states = np.array(zone, np.uint8)[:, None]
        return line_zones(
            ZoneFields(field, gap, shear, 0.3 * field, slip, states, np.zeros_like(slip)), self.GRID, MATERIAL
        )

    def test_without_contact_there_are_none(self):
        zones = self.zones([0] * 9, [Zone.OPEN] * 9)
        assert (zones.contact, zones.stick, width(zones.contact)) == ((), (), 0.0)

    def test_a_sharp_edge_is_that_of_the_cells(self):
        """Nothing lies past it, so that the gap is infinite."""
        pressure, zone = [0, 0, 1, 1, 1, 1, 1, 0, 0], [0, 0, 1, 1, 1, 1, 1, 0, 0]
        gap = [np.inf, np.inf, 0, 0, 0, 0, 0, np.inf, np.inf]
        zones = self.zones(pressure, zone, gap)
        assert zones.contact == ((-2.5, 2.5),)
        assert zones.stick == zones.contact

    def test_two_contacts_are_two_intervals(self):
        zones = self.zones([0, 1, 2, 1, 0, 1, 2, 1, 0], [0, 1, 1, 1, 0, 2, 2, 2, 0], [np.inf] + [0] * 3 + [np.inf] * 5)
        assert zones.contact == ((-3.5, -0.5), (0.5, 3.5))
        assert zones.stick == ((-3.5, -0.5),)

    def test_a_contact_that_fills_the_grid_ends_with_it(self):
        assert self.zones([1] * 9, [Zone.STICK] * 9).contact == ((-4.5, 4.5),)


def test_a_stick_zone_of_one_strip_has_no_negative_width() -> None:
    """The laws of its two edges see them on either side of its middle."""
    case = line_case(
        surface={"cylinder": {"radius": 1.811}},
        bodies=["rigid", {"young_modulus": 7500.0, "poisson_ratio": 0.15}],
        friction=0.103,
        grid={"points": 24, "size": 0.04729},
        load_path=[{"P": 0.2316, "increments": 2}],
    )
    *_, last = run(case)
    assert last.summary.stick_cells == 1
    assert last.summary.stick_radius == last.summary.stick_half_width_x == 0.0
    assert abs(last.summary.stick_center_x) < last.summary.contact_radius


LIFTED = [
    {"P": LOAD},
    {"Qx": 20.0, "increments": 4},
    {"Qx": 0.0, "increments": 2},
    {"P": 0.0, "increments": 2},
    {"P": LOAD, "increments": 2},
    {"Qx": 20.0, "increments": 4},
]
"""A first shear, a loss of contact, and the same shear again."""


@pytest.mark.parametrize("points", [48, 64])
def test_after_a_loss_of_contact_the_stick_zone_is_that_of_a_first_shear(points: int) -> None:
    """The slip before it placed the edge 2 % of its radius off."""
    case = line_case(grid={"points": points, "size": 0.28}, load_path=LIFTED)
    states = list(run(case))
    first, again = states[4].summary, states[-1].summary
    assert states[8].summary.contact_cells == 0
    assert first.Qx == pytest.approx(again.Qx) == pytest.approx(20.0)
    assert again.stick_radius == pytest.approx(first.stick_radius, rel=1e-6)
    assert again.stick_radius == pytest.approx(HERTZ.half_width * math.sqrt(1.0 - 20.0 / (FRICTION * LOAD)), rel=1e-3)
    resumed = next(run(case, states[11], [state.summary for state in states[:12]]))
    assert resumed.summary.stick_radius == states[12].summary.stick_radius


def test_a_force_that_stays_as_an_imposed_approach_lifts_off_is_gross_slip() -> None:
    path = [{"delta_z": 5e-3, "increments": 2}, {"Qx": 8.0, "increments": 2}, {"delta_z": 0.0, "increments": 2}]
    soft = {"young_modulus": 70e3, "poisson_ratio": 0.0}
    grid = {"points": 32, "size": 1.2}
    with pytest.raises(SlidingError, match="gross slip under Qx = 8 N/mm: friction carries none of it"):
        list(run(line_case(bodies=[SIMILAR[0], soft], grid=grid, reference_depth=5.0, load_path=path)))
