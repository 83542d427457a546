"""Contacts on a rig, with a layer, and with both, against runs under the loads that they find: modes I, II and III."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretsolve import case_from_dict, run
from fretsolve.result.state import State

CONTACT: dict[str, Any] = {
    "bodies": [{"young_modulus": 200e3, "poisson_ratio": 0.3}, {"young_modulus": 70e3, "poisson_ratio": 0.2}],
    "surface": {"sphere": {"radius": 10.0}},
    "grid": {"points": 32, "size": 1.1},
    "friction": 0.2,
    "solver": {"tolerance": 1e-7},
    "output": {"fields": ["pressure", "shear"]},
}
RIG = {"rig": {"stiffness_x": 50e3, "stiffness_y": 30e3, "stiffness_z": 200e3, "stiffness_phi_z": 5e5}}
LAYER = {"interface": {"shear_compliance": 2e-6, "normal_compliance": 1e-6}}
MODES: dict[str, list[dict[str, Any]]] = {
    "I": [{"P": 300.0}, {"actuator_x": 3e-3, "increments": 4}, {"actuator_x": -3e-3, "increments": 6}],
    "II": [
        {"P": 300.0},
        {"Qx": 15.0, "increments": 3},
        {"actuator_z": 14e-3, "increments": 3},
        {"actuator_z": 8e-3, "increments": 3},
    ],
    "III": [{"P": 300.0}, {"actuator_phi_z": 2e-3, "increments": 4}, {"actuator_phi_z": -1e-3, "increments": 4}],
}
LOADS = ("P", "Mx", "My", "Qx", "Qy", "Mz")


def states_of(case: dict[str, Any]) -> list[State]:
    return list(run(case_from_dict(case)))


def under_loads(case: dict[str, Any], states: list[State], names: tuple[str, ...]) -> list[State]:
    """Return the states of the contact without its rig, under the loads of each increment."""
    path = [{"increments": 1} | {name: getattr(one.summary, name) for name in names} for one in states]
    alone = {key: value for key, value in case.items() if key != "rig"}
    return states_of({**alone, "load_path": path})


def assert_alike(one: State, other: State) -> None:
    for field in ("pressure", "shear"):
        mine, theirs = getattr(one.fields, field), getattr(other.fields, field)
        assert np.abs(mine - theirs).max() <= 1e-6 * np.abs(theirs).max()
    for name in ("delta_z", "work_total"):
        assert getattr(one.summary, name) == pytest.approx(getattr(other.summary, name), rel=3e-6)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("extra", [RIG, {**RIG, **LAYER}], ids=["rig", "rig and layer"])
def test_a_contact_on_a_rig_is_the_contact_under_its_loads(extra: dict[str, Any], mode: str) -> None:
    case = {**CONTACT, **extra, "load_path": MODES[mode]}
    states = states_of(case)
    reference = under_loads(case, states, ("P", "Qx", "Qy", "Mz"))
    assert_alike(states[-1], reference[-1])
    assert_alike(states[len(states) // 2], reference[len(states) // 2])
    spent, forced = (sum(one.summary.operator_applications for one in each) for each in (states, reference))
    assert spent <= 1.1 * forced


@pytest.mark.parametrize("mode", MODES)
def test_a_layer_under_displacements_is_the_layer_under_its_loads(mode: str) -> None:
    names = {"actuator_x": "delta_x", "actuator_z": "delta_z", "actuator_phi_z": "phi_z"}
    path = [{names.get(name, name): value for name, value in stage.items()} for stage in MODES[mode]]
    case = {**CONTACT, **LAYER, "load_path": path}
    states = states_of(case)
    assert_alike(states[-1], under_loads(case, states, ("P", "Qx", "Qy", "Mz"))[-1])


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5], ids=["frictionless", "gross slip", "partial slip"])
def test_a_rig_that_couples_its_motions_obeys_its_compliance(tmp_path: Path, friction: float) -> None:
    """An arm below the contact bends: Qx moves it along z and tilts it, P moves it along x."""
    compliance = np.zeros((6, 6))  # Qx, Qy, P, Mx, My, Mz
    compliance[0, 0], compliance[2, 2], compliance[4, 4], compliance[1, 1] = 4e-5, 1e-5, 1e-6, 1e-6
    compliance[0, 2] = compliance[2, 0] = 1.2e-5
    compliance[0, 4] = compliance[4, 0] = 3e-6
    np.savetxt(tmp_path / "rig.csv", compliance, delimiter=",", header="Qx,Qy,P,Mx,My,Mz")
    path = [
        {"actuator_z": 13e-3, "increments": 3},
        {"actuator_x": 8e-3, "increments": 4},
        {"actuator_x": -6e-3, "increments": 4},
    ]
    case = {**CONTACT, "friction": friction, "rig": {"compliance": str(tmp_path / "rig.csv")}, "load_path": path}
    states = states_of(case)
    order = [3, 4, 0, 1, 2, 5]  # of LOADS
    for state in states:
        loads = np.array([getattr(state.summary, name) for name in LOADS])
        given_way = np.empty(6)
        given_way[order] = compliance @ loads[order]
        s = state.summary
        assert s.actuator_z == pytest.approx(s.delta_z + given_way[0], abs=2e-6 * abs(s.actuator_z))
        assert s.actuator_x == pytest.approx(s.delta_x + given_way[3], abs=2e-8)
        assert s.phi_y == pytest.approx(-given_way[2], abs=1e-9)
        assert s.spring_energy == pytest.approx(0.5 * loads @ given_way, rel=1e-9)
    if friction == 0.0:
        return
    assert abs(states[-1].summary.phi_y) > 1e-6
    assert pytest.approx(states[2].summary.P, rel=0.01) != states[-1].summary.P
    if friction > 0.1:  # no loads keep a contact that slides as a whole
        assert_alike(states[-1], under_loads(case, states, LOADS)[-1])


@pytest.mark.parametrize("stiffness", [1e9, 5e4, 1e3, 1e1])
def test_soft_and_stiff_rigs_go_through_gross_slip_and_back(stiffness: float) -> None:
    """In gross slip Qx is mu P, and the contact moves by the actuator's motion less mu P/k."""
    limit = 60.0
    beyond = 6e-3 + limit / stiffness
    path = [
        {"P": 300.0},
        {"actuator_x": beyond, "increments": 5},
        {"actuator_x": 0.0, "increments": 3},
        {"actuator_x": -beyond, "increments": 4},
    ]
    alike = {"bodies": CONTACT["bodies"][:1] * 2, "coupling": "none"}  # else some shear lies across the force
    states = states_of({**CONTACT, **alike, "rig": {"stiffness_x": stiffness}, "load_path": path})
    ends = [one.summary for one, after in zip(states, [*states[1:], None], strict=True)
            if after is None or after.summary.stage != one.summary.stage]  # fmt: skip
    assert [one.Qx for one in ends[1::2]] == pytest.approx([limit, -limit], rel=1e-6)
    assert [one.delta_x for one in ends[1::2]] == pytest.approx([6e-3, -6e-3], rel=1e-6, abs=1e-9 * limit / stiffness)
    assert all(one.stick_cells == 0 for one in ends[1::2])
    assert ends[2].actuator_x == 0.0
    assert ends[2].delta_x == pytest.approx(-ends[2].Qx / stiffness, rel=1e-6, abs=1e-12)
