"""Energies of a rig in series with the contact, by the work of the loads along both motions.

The polygon of the loop over the motion of the actuator less the polygon over the motion of the contact is what goes
into the springs, whatever the increments are, since the springs are linear.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from solving import DISSIMILAR, FRICTION, LOAD, LOADS, MOTIONS, SIMILAR, solve

from fretsolve.result.state import State

ACTUATORS = ("actuator_z", "actuator_phi_x", "actuator_phi_y", "actuator_x", "actuator_y", "actuator_phi_z")
EXACT = {"tolerance": 1e-8}


def columns(states: list[State], names: tuple[str, ...]) -> np.ndarray:
    return np.array([[getattr(state.summary, name) for name in names] for state in states])


def works(states: list[State], motions: tuple[str, ...]) -> np.ndarray:
    """Trapezoidal work of all loads in each increment, from the second on."""
    loads, moved = columns(states, LOADS), columns(states, motions)
    return np.sum(0.5 * (loads[1:] + loads[:-1]) * np.diff(moved, axis=0), axis=1)


MODE_I = {"rig": {"stiffness_x": 50e3, "stiffness_z": 200e3}, "bodies": SIMILAR}
MODE_II = {"rig": {"stiffness_x": 20e3, "stiffness_z": 100e3}, "bodies": DISSIMILAR}
MODE_III = {"rig": {"stiffness_phi_z": 2e6}, "bodies": SIMILAR}


def path_of(mode: str, increments: int) -> tuple[dict[str, Any], list[dict[str, float]]]:
    """A case of a mode that ends with a cycle of two stages; in mode I the first cycles do not close to 1e-6."""
    if mode == "II":
        forces = [{"P": force, "increments": increments} for force in (LOAD, 0.4 * LOAD)]
        return MODE_II, 3 * forces
    case, name, end = (MODE_I, "actuator_x", 1.6e-3) if mode == "I" else (MODE_III, "actuator_phi_z", 6e-6)
    ends = [{name: sign * end, "increments": increments} for sign in (1.0, -1.0)]
    return case, [{"P": LOAD}, *3 * ends, ends[0]]


@pytest.fixture(scope="module", params=["I", "II", "III"])
def cycle(request: pytest.FixtureRequest) -> list[State]:
    """The states of the last two stages, from the last but two on: a closed cycle."""
    case, path = path_of(request.param, 6)
    return solve(grid={"points": 32}, friction=FRICTION, load_path=path, solver=EXACT, **case)[-13:]


def test_loops_at_contact_and_actuator_have_the_same_area(cycle: list[State]) -> None:
    at_contact, at_actuator = (works(cycle, names).sum() for names in (MOTIONS, ACTUATORS))
    ends = [cycle[place].summary.spring_energy for place in (0, -1)]
    assert at_actuator - at_contact == pytest.approx(ends[1] - ends[0], abs=1e-6 * abs(at_contact))
    assert abs(ends[1] - ends[0]) < 1e-6 * abs(at_contact)


def test_in_between_they_differ_by_the_energy_of_the_springs(cycle: list[State]) -> None:
    difference = works(cycle, ACTUATORS) - works(cycle, MOTIONS)
    stored = columns(cycle, ("spring_energy",))[:, 0]
    assert np.ptp(stored) > 1e-3 * stored.max()
    loop = abs(works(cycle, MOTIONS).sum())
    np.testing.assert_allclose(np.cumsum(difference), stored[1:] - stored[0], atol=1e-6 * loop)


def test_energy_of_the_springs_is_that_of_their_loads(cycle: list[State]) -> None:
    """k u^2 / 2 of each spring, with the way u from contact to actuator."""
    ways = columns(cycle, ACTUATORS) - columns(cycle, MOTIONS)
    loads = columns(cycle, LOADS)
    np.testing.assert_allclose(columns(cycle, ("spring_energy",))[:, 0], 0.5 * np.sum(loads * ways, axis=1), rtol=1e-6)


@pytest.mark.parametrize("mode", ["I", "III"])
def test_area_of_the_loop_at_the_actuator_approaches_the_dissipation(mode: str) -> None:
    """By an error of second order in the increments, as the loop at the contact does without a rig."""
    counts, misses = (4, 8, 16), []
    for count in counts:
        case, path = path_of(mode, count)
        states = solve(grid={"points": 32}, coupling="none", load_path=path, solver=EXACT, **case)[-2 * count - 1 :]
        dissipated = states[-1].summary.work_total - states[0].summary.work_total
        misses.append((dissipated - works(states, ACTUATORS).sum()) / dissipated)
    assert min(misses) > 0.0
    assert -np.polyfit(np.log(counts), np.log(misses), 1)[0] > 1.7
    assert misses[-1] < 0.01
