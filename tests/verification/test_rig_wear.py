"""Wear of contacts on a rig: over each jump the actuator is held, and the contact follows its wear.

A soft rig presses like a force and shears like one, a stiff one like a displacement; so its limits are known runs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from line_cases import line_case
from solving import DISSIMILAR, HERTZ, SIMILAR, build

from fretsolve import run
from fretsolve.simulation.problem_setup import set_up
from tests.fake_states import assert_same_state

APPROACH, LOAD, ALPHA = HERTZ.delta_z, 400.0, 1e-7
COLUMNS = ("P", "Qx", "delta_z", "wear_volume", "contact_radius", "wear_depth_max")


def case_of(press, name, most, cycles, jump="auto", **keys):
    stages = [{name: -most, "increments": 2}, {name: most, "increments": 2}]
    path = [press, {name: most, "increments": 2}, {"cycle": {"represents": cycles, "jump": jump, "stages": stages}}]
    wear, grid = {"law": "energy", "alpha": ALPHA}, {"points": 24, "size": 1.1}
    return build(**{"coupling": "none", "grid": grid, "wear": wear, "load_path": path, **keys})


def last_of(*arguments, **keys):
    states = list(run(case_of(*arguments, **keys)))
    rows = [state.summary for state in states]
    for row in rows:
        assert row.wear_volume == pytest.approx(ALPHA * row.work_total, rel=1e-12, abs=1e-20)
    return rows[-1]


def close(one, other, rel):
    found, wanted = ([getattr(row, name) for name in COLUMNS] for row in (one, other))
    assert found == pytest.approx(wanted, rel=rel)


@pytest.mark.parametrize(
    ("stiffness", "press", "rel"),
    [
        # 400 N on 1 N/mm, which the worn micrometre changes by 1e-3 mN
        (1.0, {"P": LOAD}, 1e-4),
        (1e9, {"delta_z": APPROACH}, 1e-3),
    ],
)
def test_soft_and_stiff_rigs_along_the_normal(stiffness, press, rel):
    pressed = {"actuator_z": APPROACH + LOAD / stiffness}
    on_rig = last_of(pressed, "delta_x", 8e-3, 3000, rig={"stiffness_z": stiffness})
    close(on_rig, last_of(press, "delta_x", 8e-3, 3000), rel)
    assert on_rig.actuator_z == pressed["actuator_z"]


def test_in_between_the_load_falls_as_the_rig_relaxes():
    stiffness = 2e5
    row = last_of({"actuator_z": APPROACH + LOAD / stiffness}, "delta_x", 8e-3, 3000, rig={"stiffness_z": stiffness})
    assert row.delta_z + row.P / stiffness == pytest.approx(APPROACH + LOAD / stiffness, rel=1e-9)
    low, high = (last_of(press, "delta_x", 8e-3, 3000).P for press in ({"delta_z": APPROACH}, {"P": LOAD}))
    assert low * 1.01 < row.P < 0.99 * high


def test_jumps_of_any_length_go_the_same_way():
    """At first short jumps: a jump that held the contact instead of the actuator would leave its load behind."""
    stiffness = 2e5
    rows = [
        last_of(
            {"actuator_z": APPROACH + LOAD / stiffness}, "delta_x", 8e-3, 1200, jump, rig={"stiffness_z": stiffness}
        )
        for jump in (60, 1200)
    ]
    close(rows[1], rows[0], 0.01)


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR])
@pytest.mark.parametrize("most", [8e-3, 1.5e-3])
def test_a_rig_along_x_wears_as_its_motion_less_its_give(bodies, most):
    """Gross slip of D - C mu P; partial slip, in which the contact grows stiffer as it wears."""
    stiffness, cycles = 50e3, 2000 if most > 2e-3 else 20000
    keys = {"bodies": bodies} if bodies is SIMILAR else {"bodies": bodies, "coupling": "auto"}
    row = last_of({"P": LOAD}, "actuator_x", most, cycles, rig={"stiffness_x": stiffness}, **keys)
    assert row.delta_x + row.Qx / stiffness == pytest.approx(most, rel=1e-6)
    if most > 2e-3:
        close(row, last_of({"P": LOAD}, "delta_x", most - 0.1 * LOAD / stiffness, cycles, **keys), 2e-3)
    else:
        assert 0.0 < row.stick_radius < 0.2 and abs(row.Qx) < 0.1 * LOAD


def test_going_on_gives_the_same_bits():
    stiffness = {"stiffness_x": 50e3, "stiffness_z": 2e5}
    case = case_of({"actuator_z": APPROACH + LOAD / 2e5}, "actuator_x", 8e-3, 800, rig=stiffness)
    states = list(run(case))
    jumps = [place for place, state in enumerate(states) if state.summary.jump > 1.0]
    for step in (jumps[0] - 1, jumps[-1]):
        history = [state.summary for state in states[: step + 1]]
        for again, state in zip(run(case, states[step], history), states[step + 1 :], strict=True):
            assert_same_state(replace(again, summary=replace(again.summary, wall_time=state.summary.wall_time)), state)


def test_periodic_cycles_count_wear():
    """Without jumps the surfaces keep their shape, and the depth counts up over the cycles that are solved."""
    ends = [{"actuator_x": sign * 1.5e-3, "increments": 3} for sign in (-1.0, 1.0)]
    path = [{"P": LOAD}, ends[1], {"cycle": {"until": "periodic", "stages": ends}}]
    parts = {"bodies": DISSIMILAR, "coupling": "auto", "rig": {"stiffness_x": 50e3}, "load_path": path}
    rows = [state.summary for state in run(case_of({"P": LOAD}, "actuator_x", 1.5e-3, 1, **parts))]
    assert rows[-1].wear_volume == pytest.approx(ALPHA * rows[-1].work_total, rel=1e-12)
    assert 2.0 <= rows[-1].cycles < 20.0
    pressed = [row for row in rows if row.stage == 1][-1]
    assert rows[-1].delta_z == pytest.approx(pressed.delta_z, rel=0.01)


@pytest.mark.slow
def test_a_line_pressed_by_an_actuator():
    stages = [{"actuator_x": -8e-3, "increments": 2}, {"actuator_x": 8e-3, "increments": 2}]
    steel = {"young_modulus": 210e3, "poisson_ratio": 0.3}

    def last(press, rig):
        case = line_case(
            bodies=[steel, steel],
            friction=0.5,
            reference_depth=10.0,
            grid={"points": 64, "size": 0.8},
            rig={"stiffness_x": 20e3, **rig},
            wear={"law": "energy", "alpha": ALPHA},
            load_path=[press, {"actuator_x": 8e-3, "increments": 2}, {"cycle": {"represents": 1e4, "stages": stages}}],
        )
        return [state.summary for state in run(set_up(case))][-1]

    by_force = last({"P": 100.0}, {})
    by_rig = last({"actuator_z": 2.777e-3 + 100.0 / 1.0}, {"stiffness_z": 1.0})
    close(by_rig, by_force, 1e-3)
    stiff = last({"actuator_z": 2.777e-3 + 100.0 / 1e5}, {"stiffness_z": 1e5})
    assert stiff.P < 70.0
    assert stiff.delta_z + stiff.P / 1e5 == pytest.approx(stiff.actuator_z, rel=1e-6)
    assert np.isfinite(stiff.wear_error)
