"""Friction that changes with slip."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from solving import HERTZ, NO_POISSON, build, solve

from fretsolve import run
from fretsolve.case.keys.friction_spec import FrictionSpec
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.errors import WeakeningError
from fretsolve.problem.friction.limit import FrictionOnGrid, cycles_of_little_change, fall_per_slip, largest_growth
from fretsolve.problem.model.required_terms import derive_model
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.result.state import Fields, broadcast_zeros
from fretsolve.simulation.problem_setup import set_up

PATH = [{"P": 400.0}, {"delta_x": 1e-3, "increments": 4}]
FALLING = {"initial": 0.3, "final": 0.1, "slip": "0.1 um"}


@pytest.mark.parametrize(("uniform", "factor"), [(False, 1.3000), (True, 1.7275)])
def test_threshold_of_full_slip(uniform, factor):
    """Rings: 1.3000 p0 w a/G* under Hertz's pressure, 1.7275 under a uniform one; nu = 0."""
    setup = set_up(build(bodies=NO_POISSON, grid={"points": 64}))
    material, a = setup.model.compliances, HERTZ.contact_radius
    operator = ElasticOperator(
        setup.grid.shape,
        (setup.grid.dx, setup.grid.dy),
        material,
        derive_model(build(bodies=NO_POISSON, grid={"points": 64}, load_path=PATH)).terms,
    )
    r = np.hypot(setup.grid.x[:, None], setup.grid.y[None, :])
    fall = np.where(r < a, 1.0 if uniform else np.sqrt(np.maximum(1.0 - (r / a) ** 2, 0.0)), 0.0)
    assert largest_growth(fall, operator.tangential) / (0.25 * material.tangential * a) == pytest.approx(
        factor, rel=0.01
    )


@pytest.mark.parametrize(
    "more",
    [{}, {"shear_limit": 400.0}, {"exponent": 0.5, "reference_pressure": 300.0, "shear_limit": 600.0}],
    ids=["coefficient", "shear limit", "power of the pressure"],
)
@pytest.mark.parametrize("scale", ["slip", "energy"])
def test_fall_is_the_derivative_of_the_limit_by_slip(scale, more):
    spec = FrictionSpec.model_validate({"initial": 0.3, "final": 0.1, scale: 2.0, **more})
    law, (state,) = FrictionOnGrid(spec), solve(grid={"points": 16})
    before = replace(state.fields, slip_path=np.full((16, 16), 0.5), work_density=np.full((16, 16), 0.8))
    bound = law.limit(before)
    limit, slip = bound.limit(before.pressure), 1e-6
    after = replace(before, slip_path=before.slip_path + slip, work_density=before.work_density + slip * limit)
    fall = (limit - law.limit(after).limit(before.pressure)) / slip
    found = fall_per_slip(spec, before.pressure, bound)
    assert found == pytest.approx(fall, rel=1e-3, abs=1e-6 * fall.max())
    assert (found == 0.0).any() and (found > 0.0).any()


def test_a_shear_limit_below_the_friction_leaves_nothing_to_fall():
    """So that friction is constant where the coefficient alone would end the run."""
    friction = {**FALLING, "final": 0.2, "shear_limit": 1.0}
    path = [PATH[0], {"delta_x": 1e-5, "increments": 2}]
    with pytest.raises(WeakeningError):
        solve(friction={**friction, "shear_limit": 1e4}, grid={"points": 24}, load_path=path)
    setup = set_up(build(friction=friction, grid={"points": 24}, load_path=path))
    assert len(list(run(setup))) == 3
    assert not [text for text in case_warnings(setup) if text.startswith("friction")]


def test_too_fast_a_fall_is_refused_unless_allowed():
    case = build(friction=FALLING, grid={"points": 24}, load_path=PATH)
    with pytest.raises(WeakeningError, match=r"a larger friction.slip is needed, or weakening: allow") as caught:
        list(run(case))
    assert (caught.value.exit_code, caught.value.key) == (3, ("stage", 2))
    allowed = solve(friction={**FALLING, "weakening": "allow"}, grid={"points": 24}, load_path=PATH)
    assert len(allowed) == 5
    slow = solve(friction={**FALLING, "slip": "10 um"}, grid={"points": 24}, load_path=PATH)
    assert math.isfinite(slow[-1].summary.work_total)


SOFT = {"coupling": "none", "grid": {"points": 24}, "rig": {"stiffness_x": 1e3}}
"""A rig of 1 kN/mm, on which the contact slides as a whole from 120 N and 0.12 mm at the actuator on."""


def sliding(slip, motion=0.14, **more):
    friction = {"initial": 0.3, "final": 0.1, "slip": slip, **more.pop("friction", {})}
    return solve(friction=friction, load_path=[{"P": 400.0}, {"actuator_x": motion, "increments": 8}], **SOFT | more)


class TestOnARig:
    """0.2 of P over the slip, less what has worn off before, against 1/k + S/8a = 1/982 mm/N: 0.0806 to 0.0815 mm."""

    def test_friction_that_falls_faster_than_the_rig_unloads_is_refused(self):
        with pytest.raises(WeakeningError) as caught:
            sliding(0.0795)
        assert (caught.value.exit_code, caught.value.key) == (3, ("stage", 2))
        assert (
            "times as fast with slip as contact and rig unload, so that the contact, which slides as a whole, jumps; a"
            " stiffer rig, delta_x imposed on the contact itself, a larger friction.slip, or weakening: allow is needed"
        ) in str(caught.value)
        match = re.search(r"friction falls (\S+) times", str(caught.value))
        assert match is not None
        assert float(match[1]) == pytest.approx(0.2 * 400.0 / 0.0795 / 982.0, rel=0.015)

    def test_a_slower_fall_is_followed(self):
        assert sliding(0.083)[-1].summary.stick_area == 0.0

    @pytest.mark.parametrize(
        "parts",
        [
            {"motion": 0.1},  # a stick zone holds the contact
            {"rig": {"stiffness_x": 3e3}},
            {"rig": {"stiffness_y": 1e3}, "motion": 5e-3},  # as if delta_x were imposed
            {"friction": {"weakening": "allow"}},
            {"friction": {"final": 0.4}},
        ],
        ids=["partial slip", "stiffer", "along y", "allowed", "growing"],
    )
    def test_what_is_stable(self, parts):
        assert len(sliding(0.06, **parts)) == 9

    @pytest.mark.parametrize(("stiffness", "motion", "stable"), [(400.0, 0.08, False), (900.0, 0.06, True)])
    def test_torsion(self, stiffness, motion, stable):
        """The torque falls by 2/5 a^2 P times the fall of the coefficient per slip: 580 N mm/rad."""
        parts = {
            **SOFT,
            "friction": {"initial": 0.3, "final": 0.1, "slip": 0.005},
            "bodies": NO_POISSON,
            "coupling": "auto",
            "rig": {"stiffness_phi_z": stiffness},
            "load_path": [{"P": 400.0}, {"actuator_phi_z": motion, "increments": 4}],
        }
        if stable:
            assert solve(**parts)[-1].summary.stick_area == 0.0
            return
        with pytest.raises(WeakeningError, match="phi_z imposed on the contact itself"):
            solve(**parts)


@pytest.mark.parametrize("scale", ["slip", "energy"])
def test_validate_warns_of_it_where_the_run_ends(scale):
    """The scale that the warning asks for holds, a twentieth less does not."""
    parts = {"bodies": NO_POISSON, "grid": {"points": 64}, "load_path": [*PATH[:1], {"delta_x": 1e-6, "increments": 1}]}
    friction = {"initial": 0.3, "final": 0.1, scale: 1e-9}
    (warning,) = (text for text in case_warnings(set_up(build(friction=friction, **parts))) if "friction" in text)
    match = re.fullmatch(rf"friction\.{scale}: friction falls .* ends the run; (\S+) (mm|mJ/mm\^2) or more .*", warning)
    assert match is not None
    enough = 1.01 * float(match[1])
    assert len(solve(friction={**friction, scale: enough}, **parts)) == 2
    with pytest.raises(WeakeningError):
        solve(friction={**friction, scale: 0.95 * enough}, **parts)
    for spec in ({**friction, "weakening": "allow"}, {**friction, "final": 0.4}, {**friction, scale: enough}):
        assert not [text for text in case_warnings(set_up(build(friction=spec, **parts))) if "friction" in text]


@pytest.mark.parametrize(
    ("friction", "warned"),
    [
        ({"initial": 0.2, "final": 0.7, "slip": 5.0}, True),
        ({"cycles": [[1, 0.2], [1000, 0.7]]}, True),
        ({"cycles": [[1, 0.2]]}, False),
        ({"coefficient": 0.2, "shear_limit": 300.0}, False),
    ],
)
def test_cycles_that_count_as_periodic_before_friction_has_run_in_are_warned_of(friction, warned):
    stages = [{"Qx": 30.0}, {"Qx": -30.0}]
    told = {}
    for repeated in ({"until": "periodic", "tolerance": 0.02}, {"times": 3}):
        path = [{"P": 400.0}, {"cycle": {**repeated, "stages": stages}}]
        texts = case_warnings(set_up(build(friction=friction, grid={"points": 40}, load_path=path)))
        told["until" in repeated] = [text for text in texts if "friction" in text]
    assert told[False] == []
    assert bool(told[True]) == warned
    if warned:
        assert told[True][0].startswith("load_path.1.cycle.until: friction changes from cycle to cycle, and one that")
        assert "less than 2 % counts as periodic" in told[True][0]


def fields(slip_path: float = 0.0, work_density: float = 0.0) -> Fields:
    none, vector = broadcast_zeros((2, 2)), broadcast_zeros((2, 2, 2))
    zone = np.zeros((2, 2), np.uint8)
    return Fields(none, vector, vector, np.full((2, 2), slip_path), np.full((2, 2), work_density), zone, none)


ENERGY, SO_FAR = np.array([[0.0, 0.1], [0.2, 0.1]]), np.array([[0.0, 1e-3], [2e-3, 1e-3]])
RUNNING_IN = {"initial": 0.2, "final": 0.7}


@pytest.mark.parametrize(
    ("friction", "cycles", "state", "expected"),
    [
        (0.1, 5.0, {}, math.inf),
        ({**RUNNING_IN, "slip": 5.0}, 1.0, {}, 0.05 * 0.7 / (0.5 * 2e-3 / 5.0)),
        ({**RUNNING_IN, "slip": 5.0}, 1.0, {"slip_path": 5.0}, 0.035 * math.e / (0.5 * 2e-3 / 5.0)),
        ({**RUNNING_IN, "energy": 10.0}, 1.0, {}, 0.05 * 0.7 / (0.5 * 0.2 / 10.0)),
        ({**RUNNING_IN, "energy": 0.1}, 1.0, {}, 1.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 40.0, {}, 60.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 100.0, {}, 100.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 1050.0, {}, 50.0),
        ({"cycles": [[100, 0.1], [1100, 0.1], [1200, 0.2]]}, 300.0, {}, 800.0),
        ({"cycles": [[100, 0.1], [1100, 0.2]]}, 1100.0, {}, math.inf),
    ],
)
def test_a_solved_cycle_stands_for_as_many_as_change_the_coefficient_by_5_percent(friction, cycles, state, expected):
    spec = FrictionSpec.model_validate(friction)
    assert cycles_of_little_change(spec, cycles, fields(**state), ENERGY, SO_FAR) == pytest.approx(expected)


def test_a_cell_that_has_just_come_into_contact_counts_by_what_it_dissipates():
    spec = FrictionSpec.model_validate({**RUNNING_IN, "slip": 1.0})
    state = fields(slip_path=100.0)
    state.slip_path[0, 0] = 0.0
    path, energy = np.full((2, 2), 0.1), np.array([[0.01, 1.0], [1.0, 1.0]])
    assert cycles_of_little_change(spec, 1.0, state, energy, path) == pytest.approx(0.05 * 0.7 / (0.01 * 0.5 * 0.1))
