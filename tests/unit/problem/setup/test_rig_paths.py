"""Random load paths on random rigs: whatever moves what, a case is set up, graded and described."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from line_cases import line_case
from solving import DISSIMILAR, NO_POISSON, SIMILAR, build

from fretsolve import run
from fretsolve.case.history import COMPONENTS
from fretsolve.cli.commands.validate import report
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.simulation.accuracy.rounds import first_round
from fretsolve.simulation.problem_setup import set_up

LARGEST = {
    "P": 500.0,
    "delta_z": 0.01,
    "actuator_z": 0.02,
    "Qx": 60.0,
    "Qy": 60.0,
    "Mz": 9.0,
    "Mx": 2.0,
    "My": 2.0,
    "delta_x": 3e-3,
    "delta_y": 3e-3,
    "actuator_x": 6e-3,
    "actuator_y": 6e-3,
    "phi_z": 4e-3,
    "actuator_phi_z": 6e-3,
    **dict.fromkeys(("phi_x", "phi_y", "actuator_phi_x", "actuator_phi_y"), 1e-4),
}
STIFFNESSES = {
    "stiffness_x": 5e4,
    "stiffness_y": 8e3,
    "stiffness_z": 2e5,
    **dict.fromkeys(("stiffness_phi_x", "stiffness_phi_y", "stiffness_phi_z"), 5e6),
}
SURFACES = (
    {"sphere": {"radius": 10.0}},
    {"sphere": {"radius": 10.0, "center": [0.05, 0.02]}},
    {"ellipsoid": {"radius_x": 10.0, "radius_y": 20.0}},
    {"punch": {"radius": 0.3}},
    {"cone": {"angle": 0.02}},
    [{"sphere": {"radius": 10.0}}, {"cone": {"angle": 0.01}}],
)
FRICTIONS = (0.1, 0.0, {"initial": 0.1, "final": 0.3, "slip": 0.01}, {"initial": 0.3, "final": 0.1, "slip": 1.0})


def random_stage(random, presses=False):
    """A stage of one to three modes; some values are 0, some like those before."""
    modes = random.choice(6, random.integers(1, 4), replace=False).tolist()
    modes = [0, *(mode for mode in modes if mode)] if presses else modes
    stage = {}
    for mode in modes:
        name = str(random.choice(COMPONENTS[mode]))
        value = LARGEST[name] * random.choice([0.0, 0.3, 0.6, 1.0])
        stage[name] = value if mode == 0 else value * random.choice([-1.0, 1.0])
    if presses and not any(stage.get(name) for name in COMPONENTS[0]):
        stage = {"P": 400.0}
    more = [{}, {"increments": 3}, {"spacing": "graded"}, {"increments": 2, "spacing": "graded"}]
    return stage | more[random.integers(4)]


def sheared_path(random):
    """A path that presses once, and moves one tangential mode by any of its three names."""
    names = COMPONENTS[random.integers(3, 6)]
    stages = [str(random.choice(names)) for _ in range(random.integers(2, 7))]
    least = {"Qx": 0.6, "Qy": 0.6, "Mz": 0.7}  # of what friction does not carry
    values = [LARGEST[name] * least.get(name, 1.0) * random.uniform(-1.0, 1.0) for name in stages]
    return [{"P": 400.0}, *({name: value} for name, value in zip(stages, values, strict=True))]


def random_path(random):
    path = [random_stage(random, presses=True)]
    for _ in range(random.integers(1, 5)):
        if random.random() < 0.3:
            name = str(random.choice(COMPONENTS[random.integers(3, 6)]))
            path.append({"cycle": {"amplitude": {name: LARGEST[name]}, "times": int(random.integers(1, 4))}})
        else:
            path.append(random_stage(random))
    return path


@pytest.mark.parametrize("seed", range(60))
def test_any_load_path_on_a_rig_is_described(seed):
    random = np.random.default_rng(seed)
    keys = random.choice(list(STIFFNESSES), random.integers(1, 7), replace=False).tolist()
    case = build(
        bodies=(SIMILAR, NO_POISSON, DISSIMILAR)[random.integers(3)],
        surface=SURFACES[0 if seed % 2 else random.integers(len(SURFACES))],
        friction=FRICTIONS[0 if seed % 3 else random.integers(len(FRICTIONS))],
        coupling=str(random.choice(["auto", "none", "full"])),
        grid={"points": 16, "size": 1.0},
        rig={key: STIFFNESSES[key] for key in keys},
        load_path=sheared_path(random) if seed % 2 else random_path(random),
        solver={"accuracy": "5 %"} if seed % 4 == 0 else {},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        first = first_round(case)
        setup = first.setup
        lines, texts = list(report(first)), case_warnings(setup)
    assert all(lines) and all(texts)
    path = setup.load_path
    assert path.increments == sum(path.counts) >= len(path.stages)
    for before, after, shares in path.imposed_in_stages():
        assert shares[-1] == 1.0
        assert (np.diff([0.0, *shares]) > 0.0).all()
        for names in COMPONENTS:
            assert sum(name in after for name in names) == sum(name in before for name in names) == 1
    # what is known of the loads at the contact leaves no more than one of each mode
    for load in setup.closed_forms.loads:
        assert all(sum(name in load for name in names) == 1 for names in COMPONENTS)
    for load, contact in zip(path.imposed, setup.closed_forms.loads, strict=True):
        assert contact.get("P", 0.0) >= 0.0
        assert {name for name in contact if name in ("Qx", "Qy", "Mz")} >= {
            name for name in load if name in ("Qx", "Qy", "Mz")
        }


@pytest.mark.parametrize("seed", range(12))
def test_any_load_path_of_a_line_on_a_rig_is_described(seed):
    random = np.random.default_rng(seed)
    largest = {"P": 150.0, "Qx": 20.0, "Qy": 20.0, "My": 2.0, "delta_z": 5e-3, "actuator_z": 9e-3}
    largest |= {"delta_x": 2e-3, "actuator_x": 5e-3, "phi_y": 1e-4, "actuator_phi_y": 1e-4}
    path = [{str(random.choice(["P", "actuator_z"])): 100.0 if seed % 2 else 0.008}]
    for _ in range(4):
        name = str(random.choice(list(largest)))
        path.append({name: largest[name] * random.uniform(0.3, 1.0), "spacing": "graded"})
    case = line_case(
        surface={"cylinder": {"radius": 10.0, "center": 0.01 * (seed % 3)}},
        grid={"points": 32, "size": 1.0},
        reference_depth=10.0,
        rig={"stiffness_x": 5e3, "stiffness_z": 9e3, "stiffness_phi_y": 1e6},
        load_path=path,
    )
    first = first_round(case)
    setup = first.setup
    assert list(report(first))
    case_warnings(setup)
    assert all(shares[-1] == 1.0 for *_, shares in setup.load_path.imposed_in_stages())


@pytest.mark.parametrize("seed", range(6))
def test_what_closed_forms_say_of_a_path_is_what_a_solve_finds(seed):
    """Through reversals and gross slip, by force, motion and actuator; Lubkin takes the influence across."""
    random = np.random.default_rng(seed)
    path = sheared_path(random)
    torsion = any(name in COMPONENTS[5] for name in path[1])
    case = build(
        bodies=NO_POISSON if torsion else SIMILAR,
        coupling="auto" if torsion else "none",
        grid={"points": 48},
        rig={key: STIFFNESSES[key] / (5e4 if key == "stiffness_phi_z" else 1.0) for key in STIFFNESSES},
        load_path=[path[0], *({**stage, "increments": 3} for stage in path[1:])],
    )
    setup = set_up(case)
    (force, motion, actuator), states = setup.on_rig.driven
    solved = list(run(setup))
    assert sorted(states) == list(range(len(path)))
    for stage, state in states.items():
        summary = solved[setup.load_path.last_steps[stage]].summary
        scale = 7.0947 if torsion else 40.0
        assert getattr(summary, force) == pytest.approx(state.force, abs=2e-3 * scale)
        for name, value in ((motion, state.motion), (actuator, state.actuator)):
            assert getattr(summary, name) == pytest.approx(value, abs=2e-3 * (LARGEST[motion] + abs(value)))
        assert state.slides == (summary.stick_area == 0.0 and stage > 0)
