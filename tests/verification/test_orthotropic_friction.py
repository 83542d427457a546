"""Friction with two coefficients along two axes. Certified values: two independent solvers, which agree to 1e-6."""

from __future__ import annotations

import math

import numpy as np
import pytest
from solving import DISSIMILAR, build, solve

from fretsolve import run
from fretsolve.errors import SlidingError
from fretsolve.problem.model.materials import mismatch_displacement
from fretsolve.simulation.problem_setup import set_up

PAIR = {"coefficient": [0.2, 0.1]}


def driven(friction, points=64, **stage):
    path = [{"P": 400.0}, {"increments": 1, **stage}]
    return solve(friction=friction, grid={"points": points}, load_path=path)[-1]


def test_certified():
    found = driven(PAIR, 96, Qx=30.0, Qy=30.0).summary
    assert found.delta_x == pytest.approx(0.63611e-3, rel=1e-4)
    assert found.delta_y == pytest.approx(0.71357e-3, rel=1e-4)
    assert found.work_total == pytest.approx(3.377e-3, rel=1e-3)
    assert found.stick_area == pytest.approx(0.0808, rel=0.01)
    assert (found.Qx, found.Qy) == pytest.approx((30.0, 30.0))


def test_turned_axes_turn_the_solution():
    straight = driven(PAIR, Qx=30.0, Qy=30.0)
    quarter = driven({"coefficient": [0.1, 0.2], "angle": "90 deg"}, Qx=30.0, Qy=30.0)
    # Both are solved to 1e-6 of some 170 MPa; how far rounding takes them apart depends on the machine.
    assert quarter.fields.shear == pytest.approx(straight.fields.shear, abs=1e-5)
    half = driven({**PAIR, "angle": "45 deg"}, Qx=0.0, Qy=30.0 * math.sqrt(2.0)).summary
    cosine = math.sqrt(0.5)
    turned = cosine * (half.delta_x + half.delta_y), cosine * (half.delta_y - half.delta_x)
    assert turned == pytest.approx((straight.summary.delta_x, straight.summary.delta_y), rel=1e-3)
    assert half.work_total == pytest.approx(straight.summary.work_total, rel=1e-3)


@pytest.mark.parametrize(("angle", "force"), [(45.0, (0.178885, 0.044721)), (30.0, (0.192154, 0.027735))])
def test_sliding_along_a_direction(angle, force):
    e = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    found = driven(PAIR, 32, delta_x=1.0 * e[0], delta_y=1.0 * e[1]).summary
    assert (found.Qx / 400.0, found.Qy / 400.0) == pytest.approx(force, rel=2e-3)
    assert found.stick_area == 0.0
    # the dissipated energy is that of the force, but for the elastic energy
    assert found.work_total == pytest.approx(found.Qx * e[0] + found.Qy * e[1], rel=3e-3)


def test_tractions_stay_within_the_ellipse():
    state = driven(PAIR, Qx=40.0, Qy=20.0)
    (qx, qy), p = state.fields.shear, state.fields.pressure
    used = np.hypot(qx / 0.2, qy / 0.1)
    assert (used <= p * (1.0 + 1e-6)).all()
    slipping = state.fields.zone == 2
    assert used[slipping] == pytest.approx(p[slipping], rel=1e-6)


@pytest.mark.parametrize("bodies", [DISSIMILAR], ids=["dissimilar"])
def test_equal_coefficients_are_isotropic_friction(bodies):
    path = [{"P": 400.0, "increments": 2}, {"Qx": 20.0, "Qy": 10.0, "increments": 2}]
    parts = {"bodies": bodies, "grid": {"points": 32}, "load_path": path}
    two = solve(friction={"coefficient": [0.1, 0.1], "angle": "20 deg"}, **parts)
    one = solve(friction=0.1, **parts)
    for found, expected in zip(two, one, strict=True):
        assert found.fields.shear == pytest.approx(expected.fields.shear, abs=1e-3)
        assert found.summary.work_total == pytest.approx(expected.summary.work_total, rel=1e-4, abs=1e-12)


class TestUnderBulkStress:
    def test_turned_axes_turn_the_solution(self):
        """On dissimilar bodies, with a shear stress, and back."""
        parts = {"bodies": DISSIMILAR, "grid": {"points": 32}}
        pressed = {"P": 400.0, "increments": 2}

        def along(axis):
            loads = ((20.0, 80.0, 30.0), (-20.0, -80.0, 0.0))
            return [{f"Q{axis}": q, "bulk_2": {2 * axis: own, "xy": shear}, "increments": 2} for q, own, shear in loads]

        straight = solve(friction=PAIR, load_path=[pressed, *along("x")], **parts)
        turned = solve(friction={**PAIR, "angle": "90 deg"}, load_path=[pressed, *along("y")], **parts)
        for one, other in zip(straight, turned, strict=True):
            assert one.fields.shear[0] == pytest.approx(other.fields.shear[1].T, abs=1e-3)
            assert one.summary.delta_x == pytest.approx(other.summary.delta_y, rel=1e-6, abs=1e-10)
            assert one.summary.work_total == pytest.approx(other.summary.work_total, rel=1e-6)

    @pytest.mark.parametrize("angle", [0.0, 0.5])
    def test_sticking_cells_follow_both_surfaces(self, angle):
        """Where a cell sticks, rigid motion, elastic displacement and mismatch cancel."""
        stage = {"Qx": 10.0, "Qy": 15.0, "bulk_2": {"xx": 60.0, "xy": 40.0}}
        case = build(
            friction={**PAIR, "angle": angle}, grid={"points": 40}, load_path=[{"P": 400.0}, {**stage, "increments": 1}]
        )
        setup, state = set_up(case), list(run(case))[-1]
        assert setup.model.bulk is not None
        stretch = setup.model.bulk.mismatch({"bulk_2_xx": 60.0, "bulk_2_xy": 40.0})
        w = mismatch_displacement(stretch, setup.grid, np.zeros(3))
        motion = np.array([state.summary.delta_x, state.summary.delta_y])[:, None, None]
        slip = motion - state.displacement - w
        stick = state.fields.zone == 1
        assert 100 < np.count_nonzero(stick) < np.count_nonzero(state.fields.pressure)
        largest = np.hypot(*slip)[state.fields.zone == 2].max()
        assert np.hypot(*slip)[stick].max() < 1e-5 * largest
        # and the others slip along (q_1/mu_1^2, q_2/mu_2^2)
        cosine, sine = math.cos(angle), math.sin(angle)
        turn = np.array([[cosine, sine], [-sine, cosine]])
        moved = (state.fields.zone == 2) & (np.hypot(*slip) > 0.1 * largest)
        q, s = turn @ state.fields.shear[:, moved], turn @ slip[:, moved]
        along = q / np.array([[0.2**2], [0.1**2]])
        assert np.abs(along[0] * s[1] - along[1] * s[0]).max() < 1e-5 * (np.hypot(*along) * np.hypot(*s)).max()


def test_more_than_friction_carries():
    case = build(friction=PAIR, grid={"points": 24}, load_path=[{"P": 400.0}, {"Qx": 70.0, "Qy": 30.0}])
    message = r"gross slip under Qx = \S+ N, Qy = \S+ N: friction carries at most 0.\d+ of it; lower the load, "
    with pytest.raises(SlidingError, match=message):
        list(run(case))


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        ({"Mz": 1.0}, "two coefficients of friction are not solved with torsion"),
        ({"phi_z": 1e-3}, "two coefficients of friction are not solved with torsion"),
        ({"delta_x": 1e-3}, "with friction.angle forces or displacements are needed along x and y both"),
    ],
)
def test_what_is_not_solved_is_refused(stage, message):
    with pytest.raises(ValueError, match=message):
        build(friction={**PAIR, "angle": 0.5}, grid={"points": 24}, load_path=[{"P": 400.0}, stage])
