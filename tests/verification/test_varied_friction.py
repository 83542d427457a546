"""Friction that varies against closed forms by Abel's transform and against certified values of independent solvers.

The base case: P = 400 N, friction 0.1, nu = 0.3, one increment from rest.
"""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, HERTZ, NO_POISSON, SIMILAR, build, solve

from fretsolve import run
from fretsolve.errors import SlidingError
from fretsolve.simulation.problem_setup import set_up

CAP = {"coefficient": 0.1, "shear_limit": 100.0}
POINTS, SMALL = {"points": 128}, {"points": 64}


def pulled(friction, force, **parts):
    path = [{"P": 400.0}, {"Qx": force, "increments": 1}]
    return solve(friction=friction, load_path=path, **{"grid": POINTS, **parts})[-1].summary


class TestCertified:
    def test_shear_limit(self):
        found = pulled(CAP, 0.8 * 26.3424)
        assert found.delta_x == pytest.approx(0.43881e-3, rel=1e-3)
        assert found.stick_area == pytest.approx(0.13866, rel=3e-3)
        assert found.work_total == pytest.approx(0.4844e-3, rel=1e-3)

    def test_spot(self):
        found = pulled({"expression": "0.1 - 0.08*(r < 0.1 mm)"}, 0.8 * 34.885)
        assert found.delta_x == pytest.approx(0.60848e-3, rel=1e-3)
        assert found.work_total == pytest.approx(1.159e-3, rel=1e-3)
        # an annulus; 256 and 400 points give 0.0930 and 0.0929, as counts of cells tend to
        assert found.stick_area == pytest.approx(0.0929, rel=3e-3)

    def test_strip(self):
        """The certified one is 28 cells wide."""
        friction = {"expression": "0.1 + 0.2*(abs(y) < 0.0984375 mm)"}
        found = pulled(friction, 0.8 * 77.834, grid={"points": 128, "size": 0.9})
        assert found.delta_x == pytest.approx(1.67769e-3, rel=3e-3)
        assert found.stick_area == pytest.approx(0.0590, rel=0.02)
        assert found.work_total == pytest.approx(14.394e-3, rel=3e-3)


@pytest.mark.parametrize("share", [pytest.param(0.5, marks=pytest.mark.slow), 0.9])
@pytest.mark.parametrize(
    "friction",
    [
        {"coefficient": 0.1, "shear_limit": 0.05 * HERTZ.max_pressure},
        {"coefficient": 0.1, "shear_limit": 0.025 * HERTZ.max_pressure},
        {"coefficient": 0.1, "exponent": 2 / 3, "reference_pressure": HERTZ.max_pressure},
        {"expression": f"0.1 + 0.2*(r < {0.4 * HERTZ.contact_radius} mm)"},
    ],
    ids=["half", "quarter", "power", "spot"],
)
def test_closed_forms(friction, share):
    """delta_x, c and W of slip from the rim, exact for nu = 0."""
    parts = {"bodies": NO_POISSON, "coupling": "none", "grid": POINTS}
    setup = set_up(build(friction=friction, load_path=[{"P": 400.0}], **parts))
    force = share * setup.closed_forms.gross_slip(400.0, setup.closed_forms.hertz[0])[0]
    case = build(friction=friction, load_path=[{"P": 400.0}, {"Qx": force, "increments": 1}], **parts)
    found = list(run(case))[-1].summary
    exact = {form.quantity: form.value for form in set_up(case).closed_forms.values() if form.stage == 1}
    assert exact.keys() >= {"delta_x", "stick_radius", "work_total"}
    assert found.delta_x == pytest.approx(exact["delta_x"], rel=3e-3)
    assert found.stick_radius == pytest.approx(exact["stick_radius"], rel=3e-3)
    assert found.work_total == pytest.approx(exact["work_total"], rel=0.02)


def test_cyclic_closed_form_of_a_shear_limit():
    path = [{"P": 400.0}, {"Qx": 18.0, "increments": 1}, {"Qx": -18.0, "increments": 1}, {"Qx": 9.0, "increments": 1}]
    case = build(friction=CAP, bodies=NO_POISSON, coupling="none", grid={"points": 64}, load_path=path)
    states, forms = list(run(case)), list(set_up(case).closed_forms.values())
    for form in forms:
        if form.quantity in ("delta_x", "work_total"):
            assert getattr(states[form.stage].summary, form.quantity) == pytest.approx(form.value, rel=0.02)
    assert {form.stage for form in forms if form.quantity == "delta_x"} == {1, 2, 3}


def test_a_field_of_one_value_is_that_coefficient():
    """On dissimilar bodies, in partial slip, through staggered iterations."""
    parts = {"bodies": DISSIMILAR, "grid": {"points": 32}}
    path = [{"P": 400.0, "increments": 2}, {"Qx": 30.0, "increments": 2}]
    varied = solve(friction={"expression": "0.1"}, load_path=path, **parts)
    constant = solve(friction=0.1, load_path=path, **parts)
    for one, other in zip(varied, constant, strict=True):
        assert one.fields.shear == pytest.approx(other.fields.shear, abs=1e-3)
        assert one.summary.work_total == pytest.approx(other.summary.work_total, rel=1e-5, abs=1e-12)


class TestChangeUnderLoad:
    def test_raised_nothing_moves(self):
        path = [{"P": 400.0}, {"Qx": 36.0, "increments": 1}, {"friction": 0.3}, {"Qx": 60.0, "increments": 1}]
        before, raised, after = solve(friction=0.2, grid=SMALL, load_path=path)[1:]
        assert (raised.fields.shear == before.fields.shear).all()
        assert raised.summary.work == 0.0
        assert raised.summary.delta_x == before.summary.delta_x
        # certified 1.221797 um, against 1.221805 um with 0.3 throughout
        assert after.summary.delta_x == pytest.approx(1.221797e-3, rel=3e-4)

    @pytest.mark.parametrize("precision", ["double", "single"])
    @pytest.mark.parametrize("load", ["Q", "delta_"])
    def test_raised_on_dissimilar_bodies_nothing_moves_either(self, precision, load):
        along = {"Qx": 20.0, "Mz": 1.0} if load == "Q" else {"delta_x": 3e-4, "delta_y": 1e-4}
        path = [{"P": 400.0, "increments": 2}, {**along, "increments": 2}, {"friction": 0.3}]
        parts = {"bodies": DISSIMILAR, "grid": {"points": 32}, "solver": {"precision": precision}}
        before, raised = solve(friction=0.2, load_path=path, **parts)[-2:]
        assert (raised.fields.shear == before.fields.shear).all()
        assert (raised.fields.pressure == before.fields.pressure).all()
        assert (raised.summary.work, raised.summary.delta_x) == (0.0, before.summary.delta_x)

    def test_lowered_it_slips_as_if_it_had_been_so(self):
        path = [{"P": 400.0}, {"Qx": 36.0, "increments": 1}, {"friction": 0.1}]
        before, lowered = solve(friction=0.2, grid=SMALL, load_path=path)[1:]
        direct = solve(friction=0.1, grid=SMALL, load_path=path[:2])[-1]
        assert lowered.summary.delta_x == pytest.approx(0.863045e-3, rel=3e-4)
        assert lowered.summary.delta_x == pytest.approx(direct.summary.delta_x, rel=1e-5)
        assert np.abs(lowered.fields.shear - direct.fields.shear).max() < 0.7
        assert lowered.summary.work > 0.0
        assert lowered.summary.work_total == before.summary.work_total + lowered.summary.work

    def test_lowered_below_what_the_loads_need_it_ends_before_solving(self):
        path = [{"P": 400.0}, {"Qx": 36.0, "increments": 1}, {"friction": 0.08}]
        states = []
        with pytest.raises(SlidingError, match=r"carries at most 0.888889 of it \(sum of the friction limit = 32 N\)"):
            for state in run(build(friction=0.2, grid=SMALL, load_path=path)):
                states.append(state)
        assert len(states) == 2


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR], ids=["similar", "dissimilar"])
def test_places_without_friction_slip_freely(bodies):
    path = [{"P": 400.0, "increments": 2}, {"delta_x": 0.3e-3, "delta_y": -0.1e-3, "increments": 2}]
    state = solve(friction={"expression": "0.3*(r < 0.1)"}, bodies=bodies, grid={"points": 40}, load_path=path)[-1]
    free = (state.fields.pressure > 0.0) & (np.hypot(*state.fields.shear) == 0.0)
    assert np.count_nonzero(free) > 0.8 * np.count_nonzero(state.fields.pressure) * (1.0 - (0.1 / 0.3) ** 2)
    assert 0.5 < state.summary.stick_area / (np.pi * 0.1**2) < 1.1


def test_running_in_hardens_with_slip():
    """Slip in cycles raises friction in the slip annulus, so that the dissipated energy per cycle falls."""
    cycle = {"cycle": {"times": 4, "stages": [{"Qx": -30.0, "increments": 6}, {"Qx": 30.0, "increments": 6}]}}
    friction = {"initial": 0.1, "final": 0.3, "slip": "1 um"}
    path = [{"P": 400.0}, {"Qx": 30.0, "increments": 6}, cycle]
    parts = {"grid": {"points": 32}, "output": {"fields": ["friction"]}}
    states = solve(friction=friction, load_path=path, **parts)
    energies = [sum(state.summary.work for state in states[7 + 12 * n : 19 + 12 * n]) for n in range(4)]
    assert energies == sorted(energies, reverse=True)
    assert states[-1].summary.stick_area > states[6].summary.stick_area
    mu = states[-1].fields.friction
    assert mu is not None
    assert (mu.min(), mu.max()) == pytest.approx((0.1, 0.2), abs=0.1)
    assert mu[16, 16] == pytest.approx(0.1)
