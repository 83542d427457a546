"""When a solved cycle may stand for others, and what it has too much or too little."""

import math
from dataclasses import replace
from typing import Any

import pytest
from line_cases import line_case

from fretsolve import run
from fretsolve.case.models import Case
from fretsolve.errors import ContactLostError, NotConvergedError
from fretsolve.result.state import Summary
from fretsolve.wear.jumps import SolvedCycle, require_periodic

STEEL, ALUMINIUM = ({"young_modulus": 200e3, "poisson_ratio": 0.3}, {"young_modulus": 70e3, "poisson_ratio": 0.2})

ALTERNATING = [{"Qx": -20.0, "increments": 2}, {"Qx": 20.0, "increments": 2}]


def _represents(cycles: int, stages: list[dict[str, Any]]) -> dict[str, Any]:
    return {"cycle": {"represents": cycles, "tolerance": 0.01, "stages": stages}}


def cycles_of(*energies: float, jumps: dict[int, float]) -> list[SolvedCycle]:
    """Return cycles of these energies; jumps: of those that stand for others, by their places."""
    return [SolvedCycle(energy, jump=jumps.get(place, 1.0)) for place, energy in enumerate(energies)]


def test_a_cycle_that_keeps_changing_cannot_stand_for_others():
    cycles = cycles_of(*(1.1**turn for turn in range(21)), jumps={})
    with pytest.raises(NotConvergedError, match=r"not periodic after 21 repetitions.*set jump: 1"):
        require_periodic(cycles, 0.01)
    require_periodic([*cycles[:-1], replace(cycles[-1], energy=cycles[-2].energy)], 0.01)
    require_periodic(cycles[1:], 0.01)


def test_a_contact_wears_away_in_few_jumps_under_a_held_approach():
    stages = [{"delta_x": -0.015, "increments": 1}, {"delta_x": 0.015, "increments": 1}]
    case = Case.model_validate(
        {
            "bodies": [STEEL, STEEL],
            "surface": {"sphere": {"radius": 10.0}},
            "grid": {"points": 24, "size": 1.6},
            "friction": 0.1,
            "wear": {"law": "energy", "alpha": 1e-7},
            "load_path": [
                {"delta_z": 9e-3},
                {"delta_x": 0.015, "increments": 1},
                {"cycle": {"represents": 1e6, "stages": stages}},
            ],
        }
    )
    rows: list[Summary] = []
    with pytest.raises(ContactLostError, match="the contact is worn away"):
        for state in run(case):
            rows.append(state.summary)
    assert len(rows) < 250  # once the volume is known, jumps may be as long as they like
    cap = math.pi * 10.0 * 9e-3**2  # all that the sphere and the flat share at this approach
    assert rows[-1].wear_volume == pytest.approx(cap, rel=2e-3)
    assert rows[-1].wear_error < 0.01 * cap


def solved(
    lower: dict[str, float], load_path: list[dict[str, Any]], friction: float = 0.3, points: int = 16
) -> list[Summary]:
    """Return the history of a sphere of steel that wears."""
    case = Case.model_validate(
        {
            "bodies": [STEEL, lower],
            "surface": {"sphere": {"radius": 10.0}},
            "grid": {"points": points, "size": 0.9},
            "friction": friction,
            "wear": {"law": "energy", "alpha": 1e-7},
            "load_path": load_path,
        }
    )
    return [state.summary for state in run(case)]


def rows_of(
    lower: dict[str, float], jump: float | str, friction: float = 0.1, force: float = 30.0, tolerance: float = 0.01
) -> list[Summary]:
    """Return the same under a force to and fro over 20000 cycles; tolerance: of automatic jumps."""
    stages: list[Any] = [{"Qx": -force, "increments": 2}, {"Qx": force, "increments": 2}]
    limits = {"tolerance": tolerance} if jump == "auto" else {}
    cycle = {"cycle": {"represents": 20000, "jump": jump, "stages": stages, **limits}}
    return solved(lower, [{"P": 400.0}, {"Qx": force, "increments": 2}, cycle], friction)


@pytest.mark.parametrize(
    ("friction", "force", "volume"),
    [(0.1, 30.0, 1.757e-5), (0.3, 60.0, 3.735e-5)],  # of small jumps, to a jump of none
)
def test_the_error_of_dissimilar_bodies_is_within_its_estimate_and_the_tolerance(friction, force, volume):
    last = rows_of(ALUMINIUM, "auto", friction, force)[-1]
    assert abs(last.wear_volume - volume) < last.wear_error < 0.01 * last.wear_volume
    given = rows_of(ALUMINIUM, 2000.0, friction, force)[-1]
    assert abs(given.wear_volume - volume) < given.wear_error


@pytest.mark.parametrize(
    ("lower", "volume"), [(STEEL, 5.2081e-6), (ALUMINIUM, 9.8589e-6)], ids=["similar", "dissimilar"]
)
def test_the_error_is_within_its_estimate_where_the_load_is_out_of_phase_with_the_force(lower, volume):
    stages = [{"P": 400.0, "Qx": -40.0, "increments": 3}, {"P": 300.0, "Qx": 40.0, "increments": 3}]
    path = [{"P": 300.0}, {"Qx": 40.0, "increments": 2}, _represents(20000, stages)]
    last = solved(lower, path)[-1]
    # 100 jumps of 200 cycles
    assert abs(last.wear_volume - volume) < last.wear_error < 0.01 * last.wear_volume


def test_the_error_of_dissimilar_bodies_in_a_line_contact_is_within_its_estimate():
    case = line_case(
        bodies=[STEEL, ALUMINIUM],
        grid={"points": 64, "size": 0.4},
        friction=0.3,
        wear={"law": "energy", "alpha": 1e-7},
        load_path=[{"P": 100.0}, {"Qx": 20.0, "increments": 2}, _represents(20000, ALTERNATING)],
    )
    last = [state.summary for state in run(case)][-1]
    # 100 jumps of 200 cycles
    assert abs(last.wear_volume - 3.1642e-6) < last.wear_error < 0.01 * last.wear_volume


STEEL_WIRE = {"young_modulus": 200e3, "poisson_ratio": 0.29}


@pytest.mark.parametrize(
    ("k", "volume"), [(1e-7, 3.4218e-6), (5e-8, 1.6954e-6)], ids=["deep cycles", "less deep cycles"]
)
def test_wires_whose_cycles_wear_deep_take_few_jumps(k, volume):
    """One cycle wears more than a first jump may: crossed wires of 0.225 mm, 3000 cycles of +-3 um under 1 N."""
    stages = [{"delta_x": -3e-3, "increments": 2}, {"delta_x": 3e-3, "increments": 2}]
    case = Case.model_validate(
        {
            "bodies": [STEEL, STEEL] if k == 1e-7 else [STEEL_WIRE, STEEL_WIRE],
            "surface": {"sphere": {"radius": 0.225}},
            "grid": {"points": 32, "size": 0.08},
            "friction": 0.6,
            "wear": {"law": "archard", "k": k},
            "load_path": [{"P": 1.0}, {"delta_x": 3e-3, "increments": 2}, _represents(3000, stages)],
        }
    )
    rows = [state.summary for state in run(case)]
    assert sum(row.jump > 0.0 for row in rows) < 50
    # cycle by cycle, by jump: 1
    assert abs(rows[-1].wear_volume / volume - 1.0) < 2e-3
    assert abs(rows[-1].wear_volume - volume) < rows[-1].wear_error < 0.01 * volume


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_a_small_tolerance_is_met_in_few_jumps(tolerance):
    rows = rows_of(STEEL, "auto", tolerance=tolerance)
    jumps = sum(row.jump > 1.0 for row in rows)
    assert jumps < 0.5 / math.sqrt(tolerance)  # the error of a jump falls with the second power
    exact = 1.117507e-5  # 200 jumps of 100 cycles
    assert abs(rows[-1].wear_volume - exact) < rows[-1].wear_error < tolerance * exact
