"""The table of cycles, from histories whose loops are known: Mindlin's, with and without gross slip."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from line_cases import line_case

from fretsolve.case.models import Case
from fretsolve.post.export.report_tables import cycle_columns
from fretsolve.result.cycles import rows
from fretsolve.result.cycles.loops import (
    CHANGE_COLUMNS,
    CycleSteps,
    cycles_in,
    distance_to_limit,
    reversal_stiffness,
    stages_of,
)
from fretsolve.result.cycles.table import cycle_table

BODIES = ["rigid", {"young_modulus": 200e3, "poisson_ratio": 0.3}]
MOTIONS = ("delta_z", "phi_x", "phi_y", "delta_x", "delta_y", "phi_z")
RIG = tuple(f"actuator_{name.removeprefix('delta_')}" for name in MOTIONS)
UNMOVED = ("Qx", "delta_x")
LIMIT, ONSET = 40.0, 1.1e-3
"""Friction limit (N), and displacement (mm) at which all slips: the displacement under Q is d (1 - (1 - Q/mu P)^(2/3)),
its slope at Q = 0 is 2 d/(3 mu P)."""


def case_of(cycle: dict, **more: object) -> dict:
    path = [{"P": 400.0}, {"cycle": cycle}]
    case = {"bodies": BODIES, "surface": {"sphere": {"radius": 10.0}}, "grid": {"points": 16}, "load_path": path}
    return Case.model_validate(case | {"friction": 0.1} | more).effective()


def loading(force: np.ndarray) -> np.ndarray:
    """Displacement on first loading; later branches are twice as large (Masing)."""
    return ONSET * (1.0 - (1.0 - force / LIMIT) ** (2.0 / 3.0))


def loop(amplitude: float, points: int, turns: int = 1, beyond: float = 0.0) -> dict[str, np.ndarray]:
    """History of cycles between plus and minus a force, which slides on by `beyond` (mm) at both ends."""
    rise = np.linspace(0.0, amplitude, points + 1)
    forces, motions, stages = [0.0, *rise[1:]], [0.0, *loading(rise[1:])], [1, *[2] * points]
    for half in range(2 * turns):
        sign = -1.0 if half % 2 == 0 else 1.0
        forces += list(forces[-1] + sign * 2.0 * rise[1:])
        motions += list(motions[-1] + sign * 2.0 * loading(rise[1:]))
        stages += [3 + half] * points
        if beyond:
            forces.append(forces[-1])
            motions.append(motions[-1] + sign * 2.0 * beyond)
            stages.append(3 + half)
    forces, motions = np.array(forces), np.array(motions)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (forces[1:] + forces[:-1]) * np.diff(motions))])
    history = {name: np.zeros(len(forces)) for name in CHANGE_COLUMNS}
    history |= {"stage": np.array(stages), "Qx": forces, "delta_x": motions, "work_total": work}
    return history | {"P": np.full(len(forces), 400.0), "contact_radius": np.full(len(forces), 0.3)}


def table_of(history: dict[str, np.ndarray], cycle: dict):
    return cycle_table(history, case_of(cycle), lambda step: None, ended=True)


def test_ratios_at_the_border_of_gross_slip() -> None:
    """A Mindlin loop with the force mu P encloses 1/5 of its box, and is 0.26 of it wide at Q = 0."""
    table = table_of(loop(LIMIT, 200), {"amplitude": {"Qx": LIMIT}, "times": 1, "increments": 400})
    row = {name: float(column[0]) for name, column in table.columns.items()}
    assert row["energy_ratio"] == pytest.approx(0.2, rel=2e-3)
    assert row["sliding_ratio"] == pytest.approx(2.0 * 0.5 ** (2.0 / 3.0) - 1.0, rel=1e-4)
    assert row["sliding_amplitude"] == pytest.approx(row["sliding_ratio"] * ONSET)
    assert row["reversal_stiffness"] == pytest.approx(1.5 * LIMIT / ONSET, rel=1e-4)
    assert (row["force_range"], row["displacement_range"]) == pytest.approx((2.0 * LIMIT, 2.0 * ONSET))
    assert math.isnan(row["slip_amplitude"])  # no slip is stored
    assert (row["cycle"], row["stage"], row["first_step"], row["last_step"]) == (1, 4, 200, 600)


@pytest.mark.parametrize("beyond", [0.0, 1e-3])
@pytest.mark.parametrize("points", [2, 3, 5, 8, 13, 40])
def test_bars_of_the_loop_hold_what_lies_between_increments(points: int, beyond: float) -> None:
    """Width and slope at the reversal of a Mindlin loop up to gross slip and beyond, in few increments and in many."""
    history = loop(LIMIT, points, turns=2, beyond=beyond)
    history |= {f"{name}_error": np.zeros(len(history["stage"])) for name in (*CHANGE_COLUMNS[1:], "P")}
    columns = table_of(history, {"amplitude": {"delta_x": 1e-3}, "times": 2}).columns
    row = {name: float(column[1]) for name, column in columns.items()}
    width = ONSET * (2.0 * 0.5 ** (2.0 / 3.0) - 1.0) + beyond
    rounding = 1e-12 * width
    assert abs(row["sliding_amplitude"] - width) <= row["sliding_amplitude_error"] + rounding < width
    span = 2.0 * (ONSET + beyond)
    assert abs(row["sliding_ratio"] - 2.0 * width / span) <= row["sliding_ratio_error"] + 1e-12
    assert abs(row["reversal_stiffness"] - 1.5 * LIMIT / ONSET) <= row["reversal_stiffness_error"]


def test_a_single_long_increment_after_a_reversal_tells_no_slope() -> None:
    history = loop(LIMIT, 1, turns=2, beyond=50e-3)
    table = table_of(history, {"amplitude": {"delta_x": 50e-3}, "times": 2})
    assert np.isnan(table.columns["reversal_stiffness"]).all()
    assert table.notes[0].startswith("reversal_stiffness is not known: it takes two increments after each reversal")
    assert not table_of(loop(36.0, 10), {"amplitude": {"Qx": 36.0}, "times": 1}).notes


def test_a_cycle_that_begins_within_a_branch_has_no_reversal_there() -> None:
    """The slope where a branch goes on is the slope of slip, not of a reversal."""
    history = loop(36.0, 20, turns=2)
    branch = slice(1 + 20 + 10, None)  # from the middle of the first branch on
    cut = {name: column[branch] for name, column in history.items()}
    found = reversal_stiffness(cut["Qx"][:41], cut["delta_x"][:41])
    assert found.value == pytest.approx(1.5 * LIMIT / ONSET, rel=1e-3)


def test_torsion_has_its_own_units() -> None:
    history = loop(36.0, 10)
    history |= {"Mz": history["Qx"], "phi_z": history["delta_x"]}
    history |= {name: np.zeros(len(history["Qx"])) for name in ("Qx", "delta_x")}
    table = table_of(history, {"amplitude": {"Mz": 36.0}, "times": 1})
    assert [table.units[name] for name in ("force_range", "displacement_range", "reversal_stiffness")] == [
        "N mm",
        "rad",
        "N mm/rad",
    ]
    assert table.columns["force_range"][0] == pytest.approx(72.0)


@pytest.mark.parametrize(("load", "motion"), [("Mx", "phi_x"), ("My", "phi_y"), ("P", "delta_z")])
def test_a_load_that_moves_alone_has_its_own_loop(load: str, motion: str) -> None:
    """Not the one of a tangential force, which is zero but for round-off."""
    history = loop(36.0, 10)
    history |= {load: history["Qx"] + (400.0 if load == "P" else 0.0), motion: history["delta_x"]}
    history |= {"Qx": 1e-16 * history["Qx"], "delta_x": 1e-3 * history["delta_x"]}
    mean = {"mean": {"P": 400.0}} if load == "P" else {}
    table = table_of(history, {"amplitude": {load: 36.0}, "times": 1, **mean})
    row = {name: float(column[0]) for name, column in table.columns.items()}
    assert row["force_range"] == pytest.approx(72.0)
    assert row["displacement_range"] == pytest.approx(np.ptp(history[motion]))
    assert row["energy_ratio"] == pytest.approx(row["dissipated_energy"] / 72.0 / row["displacement_range"])
    assert table.units["reversal_stiffness"] == ("N/mm" if load == "P" else "N mm/rad")


def test_normal_force_beside_a_constant_tangential_one_keeps_the_drift_of_its_displacement() -> None:
    history = loop(36.0, 10)
    drift = np.linspace(0.0, 1e-4, len(history["Qx"]))
    history |= {"P": 400.0 + history["Qx"], "Qx": np.full(len(drift), 10.0), "delta_x": drift}
    table = table_of(history, {"amplitude": {"P": 36.0}, "mean": {"P": 400.0}, "times": 1})
    assert table.columns["displacement_drift"][0] == pytest.approx(drift[-1] - drift[10])
    assert math.isnan(table.columns["energy_ratio"][0])  # the force does not move


def test_round_off_of_a_force_is_no_loop() -> None:
    history = loop(36.0, 10)
    history["Qx"] = 1e-16 * history["Qx"]
    path = [{"P": 400.0}, {"cycle": {"amplitude": {"bulk_2": {"xx": 50.0}}, "times": 1}}]
    case = case_of({"amplitude": {"Qx": 36.0}, "times": 1}, load_path=path)
    table = cycle_table(history, case, lambda step: None, ended=True)
    for name in ("energy_ratio", "sliding_ratio", "reversal_stiffness"):
        assert math.isnan(table.columns[name][0])
    assert table.columns["force_range"][0] == 0.0


def test_line_contact_has_its_energy_and_no_displacement() -> None:
    history = loop(18.0, 10)
    history["delta_x"] = history["delta_y"] = np.full(len(history["Qx"]), np.nan)
    case = line_case(load_path=[{"P": 400.0}, {"cycle": {"amplitude": {"Qx": 18.0}, "times": 1}}]).effective()
    table = cycle_table(history, case, lambda step: None, ended=True)
    assert table.units["dissipated_energy"] == "mJ/mm"
    assert table.columns["force_range"][0] == pytest.approx(36.0)
    assert all(np.isnan(table.columns[name][0]) for name in ("energy_ratio", "sliding_amplitude", "reversal_stiffness"))


def test_slip_amplitude_is_half_of_the_slip_between_the_ends() -> None:
    history = loop(36.0, 5)
    case = case_of({"amplitude": {"Qx": 36.0}, "times": 1})
    slip = {5: np.full((2, 3, 3), 1e-3), 10: np.full((2, 3, 3), -2e-3)}
    table = cycle_table(history, case, slip.get, ended=True)
    assert table.columns["slip_amplitude"][0] == pytest.approx(0.5 * 3e-3 * math.sqrt(2.0))


def test_only_whole_cycles_count() -> None:
    history, case = loop(36.0, 5, turns=2), case_of({"amplitude": {"Qx": 36.0}, "times": 2})
    assert [one.turn for one in cycles_in(stages_of(case), history["stage"])] == [1, 2]
    assert [one.turn for one in cycles_in(stages_of(case), history["stage"], ended=False)] == [1]
    assert cycles_in(stages_of(case), history["stage"][:9]) == []
    assert stages_of({"load_path": [{"P": 400.0}]}) == ()


def test_bars_follow_those_of_the_history() -> None:
    history = loop(36.0, 10, turns=2)
    for name in ("Qx", "Qy", "delta_x", "delta_y", "work_total"):
        history[f"{name}_error"] = 0.01 * np.abs(history[name])
    history["Qx_error"][:] = 0.0  # it is imposed
    columns = table_of(history, {"amplitude": {"Qx": 36.0}, "times": 2}).columns
    np.testing.assert_allclose(columns["dissipated_energy_error"], 0.01 * columns["dissipated_energy"])
    np.testing.assert_allclose(columns["force_range_error"], 0.0)
    np.testing.assert_allclose(
        columns["displacement_range_error"], 0.01 * columns["displacement_range"] / math.sqrt(2.0)
    )
    np.testing.assert_allclose(columns["energy_ratio_error"], columns["energy_ratio"] * 0.01 * math.sqrt(1.5))
    assert "slip_amplitude_error" not in columns


def with_corrected_values(history: dict[str, np.ndarray], motion: float, bar: float) -> dict[str, np.ndarray]:
    """Corrected values of which displacement and energy are `motion` times those as run, with relative bars."""
    factors = {"Qx": 1.0, "Qy": 1.0, "delta_x": motion, "delta_y": motion, "work_total": motion}
    found = dict(history)
    for name, factor in factors.items():
        corrected = factor * history[name]
        bars = bar * (name != "Qx")  # which is imposed
        found |= {f"{name}_error": 5.0 * bars * np.abs(history[name]), f"{name}_corrected": corrected}
        found[f"{name}_corrected_error"] = bars * np.abs(corrected)
    return found


def test_corrected_values_are_those_of_the_corrected_loop() -> None:
    history = with_corrected_values(loop(36.0, 10, turns=2), 1.1, 0.01)
    table = table_of(history, {"amplitude": {"Qx": 36.0}, "times": 2})
    columns = table.columns
    for name in ("dissipated_energy", "displacement_range", "sliding_amplitude"):
        np.testing.assert_allclose(columns[f"{name}_corrected"], 1.1 * columns[name])
    for name in ("energy_ratio", "sliding_ratio", "force_range"):
        np.testing.assert_allclose(columns[f"{name}_corrected"], columns[name])
    # Their bars are those of the corrected values.
    energy = columns["dissipated_energy_corrected"]
    np.testing.assert_allclose(columns["dissipated_energy_corrected_error"], 0.01 * energy)
    np.testing.assert_allclose(columns["dissipated_energy_error"], 0.05 * columns["dissipated_energy"])
    assert table.units["sliding_amplitude_corrected"] == "mm"
    told = "energy dissipated in the cycle, corrected for the number of increments"
    assert table.meanings["dissipated_energy_corrected"] == told
    assert table.meanings["dissipated_energy_corrected_error"] == f"estimated error of {told}"
    never = ("slip_amplitude_c", "reversal_stiffness_c", "force_drift_c")
    assert not [name for name in columns if name.startswith(never)]


def test_the_printed_table_has_them_only_where_they_differ() -> None:
    cycle = {"amplitude": {"Qx": 36.0}, "times": 2}
    same = table_of(with_corrected_values(loop(36.0, 10, turns=2), 1.0, 0.0), cycle)
    other = table_of(with_corrected_values(loop(36.0, 10, turns=2), 1.1, 0.0), cycle)
    as_run, corrected = (cycle_columns(same, corrected=one) for one in (False, True))
    assert [column[3:] for column in corrected if column not in as_run] == [("1", "2")]
    assert corrected[0][:2] == ("corrected", "cycle")
    energies = [cycle_columns(other, corrected=one)[2] for one in (False, True)]
    assert [energy[:3] for energy in energies] == [("dissipated", "energy", "mJ")] * 2
    assert float(energies[1][3]) == pytest.approx(1.1 * float(energies[0][3]), rel=1e-3)


def on_a_rig(history: dict[str, np.ndarray], stiffness: float) -> dict[str, np.ndarray]:
    """A history with the motions of an actuator behind a spring along x."""
    same = {f"actuator_{name.removeprefix('delta_')}": history[name] for name in MOTIONS}
    return history | same | {"actuator_x": history["delta_x"] + history["Qx"] / stiffness}


@pytest.mark.parametrize("moved", ["Qx", "actuator_x"])
def test_columns_at_the_actuator_are_those_of_its_loop(moved: str) -> None:
    """At the border of gross slip a fifth of the contact's box is dissipated; a spring makes the box wider."""
    stiffness, contact, found = 50e3, 2.0 * ONSET, table_of(loop(LIMIT, 200), {"amplitude": {"Qx": LIMIT}, "times": 1})
    width = contact + 2.0 * LIMIT / stiffness
    cycle = {"amplitude": {moved: LIMIT if moved == "Qx" else 0.5 * width}, "times": 1, "increments": 400}
    case = case_of(cycle, rig={"stiffness_x": stiffness})
    table = cycle_table(on_a_rig(loop(LIMIT, 200), stiffness), case, lambda step: None, ended=True)
    row = {name: float(column[0]) for name, column in table.columns.items()}
    assert row["actuator_displacement_range"] == pytest.approx(width)
    assert row["actuator_energy_ratio"] == pytest.approx(0.2 * contact / width, rel=2e-3)
    assert row["actuator_sliding_amplitude"] == pytest.approx(row["sliding_amplitude"], rel=1e-12)
    assert row["actuator_sliding_ratio"] == pytest.approx((2.0 * 0.5 ** (2.0 / 3.0) - 1.0) * contact / width, rel=1e-4)
    at_contact = 1.5 * LIMIT / ONSET
    assert row["actuator_reversal_stiffness"] == pytest.approx(1.0 / (1.0 / at_contact + 1.0 / stiffness), rel=1e-3)
    assert row["actuator_displacement_drift"] == pytest.approx(0.0, abs=1e-12)
    assert table.meanings["actuator_energy_ratio"].endswith("range, at the actuator")
    for name in found.columns:
        np.testing.assert_array_equal(found.columns[name], table.columns[name])


def test_a_turned_actuator_has_units_of_moments() -> None:
    """A torque of 40 N mm at 1.1e-3 rad, on a spring that turns by 4e-4 rad."""
    history = loop(LIMIT, 20)
    history |= {"Mz": history["Qx"], "phi_z": history["delta_x"]} | dict.fromkeys(UNMOVED, 0.0 * LIMIT * history["P"])
    history = on_a_rig(history, 1.0) | {"actuator_phi_z": history["phi_z"] + history["Mz"] / 1e5}
    cycle = {"amplitude": {"actuator_phi_z": 1.5e-3}, "times": 1, "increments": 40}
    case = case_of(cycle, rig={"stiffness_phi_z": 1e5})
    table = cycle_table(history, case, lambda step: None, ended=True)
    assert table.columns["actuator_displacement_range"][0] == pytest.approx(2.0 * (ONSET + LIMIT / 1e5))
    names = ("actuator_sliding_amplitude", "actuator_reversal_stiffness", "actuator_energy_ratio")
    assert [table.units[name] for name in names] == ["rad", "N mm/rad", "1"]


def test_bars_at_the_actuator_follow_those_of_its_motion() -> None:
    """The width at the mean force is the contact's, and so is its error; the ratio to the range has the actuator's."""
    history = on_a_rig(loop(LIMIT, 200), 50e3)
    history |= {f"{name}_error": np.zeros(len(history["P"])) for name in (*CHANGE_COLUMNS[1:], *RIG)}
    history |= {"actuator_x_error": np.full(len(history["P"]), 1e-5)}
    case = case_of({"amplitude": {"actuator_x": 1.9e-3}, "times": 1, "increments": 400}, rig={"stiffness_x": 50e3})
    table = cycle_table(history, case, lambda step: None, ended=True)
    row = {name: float(column[0]) for name, column in table.columns.items()}
    assert row["displacement_range_error"] < 1e-12 < row["actuator_displacement_range_error"]
    assert row["actuator_displacement_range_error"] == pytest.approx(math.sqrt(2.0) * 1e-5, rel=1e-6)
    relative = math.sqrt(2.0) * 1e-5 / row["actuator_displacement_range"]
    assert row["actuator_energy_ratio_error"] == pytest.approx(relative * row["actuator_energy_ratio"], rel=1e-6)


@pytest.mark.parametrize("turns", [2, 20])
def test_what_is_of_the_whole_history_is_taken_once(monkeypatch: pytest.MonkeyPatch, turns: int) -> None:
    taken = []
    monkeypatch.setattr(rows, "round_off", lambda history: taken.append(history) or 1e-6)
    table = table_of(loop(36.0, 5, turns=turns), {"amplitude": {"Qx": 36.0}, "times": turns})
    assert (len(table), len(taken)) == (turns, 1)
    np.testing.assert_allclose(table.columns["force_range"], 72.0)


def energies_of(series: list[float]) -> tuple[dict[str, np.ndarray], list[CycleSteps]]:
    """History of cycles that dissipate these energies, and the cycles."""
    turns = len(series)
    history, stages = loop(36.0, 5, turns=turns), stages_of(case_of({"amplitude": {"Qx": 36.0}, "times": turns}))
    found = cycles_in(stages, history["stage"])
    for one, energy in zip(found, series, strict=True):
        rows = slice(one.first + 1, one.last + 1)
        history["work_total"][rows] = history["work_total"][one.first] + np.linspace(0.1, 1.0, 10) * energy
    return history, found


@pytest.mark.parametrize(
    "dies_out",
    [lambda k: 0.5**k, lambda k: -(0.9**k), lambda k: k**-0.7, lambda k: k**-1.5, lambda k: (-0.6) ** k],
    ids=["fast", "slow", "slow power", "power", "alternating"],
)
def test_the_distance_to_the_limit_holds_the_true_one(dies_out: Callable[[int], float]) -> None:
    history, found = energies_of([1.0 + 0.3 * dies_out(k) for k in range(1, 41)])
    for count in (4, 8, 20):
        true = abs(0.3 * dies_out(count)) / (1.0 + 0.3 * dies_out(count))
        estimate = distance_to_limit(history, found[count - 3 : count])
        assert true <= 1.01 * estimate.energy
        assert estimate.value < 1e-12
    assert estimate.energy < 15.0 * true


def test_the_distance_to_the_limit_does_not_trust_one_small_change() -> None:
    """The energy turns there, as where cells stop to slip one after another."""
    history, found = energies_of([1.3, 1.2, 1.1, 1.1 - 1e-9])
    assert distance_to_limit(history, found[-3:]).energy > 0.05
