"""``fretsolve check`` on quantities that the history does not hold, and cases that could not know what they expect."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from command_line import invoke, result_of
from line_cases import LINE
from small_cases import TWO_CYCLES, case_error, write_case

from fretsolve import open_result
from fretsolve.case.keys.quantity_names import EXPECTED_DIMENSIONS, LINE_EXPECTED_DIMENSIONS
from fretsolve.case.keys.settings_spec import Expectation
from fretsolve.case.loading import load_case, stored_case
from fretsolve.post.names import stress_path
from fretsolve.post.stress.stress_file import read_peaks
from fretsolve.result.cycles.table import CORRECTED_CYCLE_NAMES, CYCLE_NAMES

CURVE = "{strength: 900 MPa, strength_exponent: -0.09, ductility: 0.6, ductility_exponent: -0.6}"
STRESS = "stress: {depths: [0 mm, 90 um]}"
FATIGUE = f"fatigue: {{material: {{strain_life: {CURVE}}}, criteria: [swt], depths: [0 mm, 90 um]}}"
CASE = TWO_CYCLES.replace("points: 16", "points: 12")


def expecting(*entries: str, output: str = "", case: str = CASE) -> str:
    lines = "".join(f"  - {{{entry}}}\n" for entry in entries)
    return f"{case}{f'output: {{{output}}}' if output else ''}\nexpect:\n{lines}"


def test_values_are_those_of_a_run(tmp_path: Path) -> None:
    """The values that `run`, `stress` and `show` find of the same case are as expected; nothing else is left."""
    out = result_of(write_case(tmp_path, f"{CASE}output: {{{STRESS}}}\n"), "-q")
    with open_result(out) as result:
        energy, ratio = (result.cycles.columns[name].tolist() for name in ("dissipated_energy", "energy_ratio"))
        slip, radius = result.cycles.columns["slip_amplitude"][1], result.history["stick_radius"][-1]
    mises, _ = read_peaks(stress_path(out))["max_mises"][result.increments - 1]
    text = expecting(
        f"quantity: dissipated_energy, value: {energy[1]} mJ, rel: 1e-9",
        f"quantity: energy-ratio, value: {ratio[0]}, rel: 1e-9, cycle: 1",
        f"quantity: slip_amplitude, value: {1e3 * slip} um, rel: 1e-9",
        f"quantity: max_mises, value: {mises} MPa, rel: 1e-9",
        f"quantity: stick_radius, value: {radius} mm, rel: 1e-9",
        "quantity: swt_max, value: 1 MPa, rel: 500 %",
        "quantity: force_range, value: 100 N, rel: 1 %",
        output=f"{STRESS}, {FATIGUE}",
    )
    folder = tmp_path / "checked"
    folder.mkdir()
    junit = tmp_path / "junit.xml"
    result = invoke("check", write_case(folder, text), "--junit", junit)
    rows = [line.split() for line in result.stdout.splitlines()[2:9]]
    assert [row[-1] for row in rows] == ["yes"] * 6 + ["NO"], result.stdout
    assert [" ".join(row[:3]) for row in rows[:2]] == [
        "last cycle dissipated_energy",
        "cycle 1 energy-ratio".replace("-", "_"),
    ]
    assert [row[0] for row in rows[3:6]] == ["6", "6", "run"]
    assert "200 N" in result.stdout  # the whole range, twice the amplitude
    assert result.exit_code == 1
    assert [path.name for path in folder.iterdir()] == ["case.yaml"]
    assert 'name="energy_ratio of cycle 1"' in junit.read_text()


def test_a_cycle_that_the_run_does_not_reach_and_a_failure(tmp_path: Path) -> None:
    text = expecting("quantity: energy_ratio, value: 1, rel: 1 %", case=CASE.replace("100 N", "200 N"))
    result = invoke("check", write_case(tmp_path, text))
    assert result.exit_code == 3
    assert "not reached" in result.stdout and "gross slip" in result.stdout


def test_loops_of_torque_have_other_units(tmp_path: Path) -> None:
    path = CASE.replace("Qx: 100 N", "Mz: 10 N mm").replace("Qx: -100 N", "Mz: -10 N mm")
    text = expecting("quantity: force_range, value: 20, rel: 1 %", case=path)
    result = invoke("check", write_case(tmp_path, text))
    assert result.exit_code == 2
    assert "expect.0.quantity: force_range of a loop of moment and rotation is in N mm, which cannot be compared; " in (
        result.stdout
    )
    text = expecting("quantity: energy_ratio, value: 0.5, abs: 1", case=path)
    assert invoke("check", write_case(tmp_path, text)).exit_code == 0


REFUSED = [
    ("max_mises", "", "expect.0.quantity: max_mises needs output.stress; add output: {stress:"),
    ("swt_max", STRESS, "expect.0.quantity: swt_max needs output.fatigue; add output: {fa"),
    ("findley_max", FATIGUE, "needs the criterion findley; add it to output.fatigue.criteria"),
    ("crack_life", "", "expect.0.quantity: crack_life needs output.crack; add output: {crack:"),
    (
        "swt_life",
        "fatigue: {material: {}, criteria: [swt]}",
        "expect.0.quantity: swt_life needs strain_life in output.fatigue.material",
    ),
    (
        "crack_arrest_length",
        "crack: {material: {threshold_range: 2 MPa m^0.5}}",
        "expect.0.quantity: crack_arrest_length needs fatigue_range in output.crack.material",
    ),
    (
        "crack_life",
        "crack: {}",
        "crack_life needs an end of life, toughness in output.crack.material or output.crack.final_length, and paris"
        " and strain_life or shear_strain_life in output.crack.material",
    ),
    (
        "crack_life",
        f"crack: {{material: {{strain_life: {CURVE}}}, criterion: fatemi-socie, thickness: 9 mm}}",
        "crack_life needs paris and shear_strain_life in output.crack.material",
    ),
    ("energy_ratio, cycle: 3", "", "expect.0.cycle: 3 is beyond the load path; a cycle from 1 to 2"),
    ("energy_ratio, stage: 2", "", "expect.0.stage: energy_ratio is a quantity of a cycle; cycle:"),
    ("delta_z, cycle: 2", "", "expect.0.cycle: delta_z is no quantity of a cycle; stage chooses"),
    ("max_mises, cycle: 2", STRESS, "expect.0.cycle: max_mises is no quantity of a cycle; stage"),
    ("swt_max, stage: 2", FATIGUE, "expect.0.stage: swt_max has one value of the whole run;"),
    ("actuator_energy_ratio", "", "actuator_energy_ratio is known with a rig alone; the case has"),
    ("slip_amplitude", "fields: [pressure]", "slip_amplitude follows from the slip; output.fields"),
    ("enrgy_ratio", "", "'enrgy_ratio' is not a quantity that can be compared; did you mean 'ene"),
    ("swt_lif", "", "'swt_lif' is not a quantity that can be compared; did you mean 'swt_life'?"),
    ("energy_ratio_corrected", "", "values as run are: energy_ratio is needed"),
    ("dissipated_energy, value: 1 N", "", "'1 N' is a force; an energy such as '0.014 mJ' is needed"),
    ("swt_life, value: 1 mm", FATIGUE, "expect.0.value: '1 mm' is a length; a number such as '1000' is needed"),
]


@pytest.mark.parametrize(("entry", "output", "message"), REFUSED)
def test_what_the_result_will_not_tell_is_refused(tmp_path: Path, entry: str, output: str, message: str) -> None:
    value = "" if "value" in entry else ", value: 1"
    error = case_error(write_case(tmp_path, expecting(f"quantity: {entry}{value}, rel: 1", output=output)))
    assert message in str(error)
    assert ".yaml:14: " in str(error) or ".yaml:15: " in str(error)


def test_without_a_cycle_there_are_no_quantities_of_cycles(tmp_path: Path) -> None:
    case = CASE.partition("  - cycle")[0]
    error = case_error(write_case(tmp_path, expecting("quantity: energy_ratio, value: 1, rel: 1", case=case)))
    assert "energy_ratio is a quantity of a cycle, and the load path has none; another one is needed" in str(error)


def test_all_quantities_of_cycles_as_run_can_be_expected() -> None:
    assert set(CYCLE_NAMES) - set(CORRECTED_CYCLE_NAMES) < set(EXPECTED_DIMENSIONS)


def test_forces_of_a_line_contact_are_per_length() -> None:
    units = {name: LINE_EXPECTED_DIMENSIONS[name].unit for name in EXPECTED_DIMENSIONS}
    assert (units["force_range"], units["dissipated_energy"], units["sliding_amplitude"]) == ("N/mm", "mJ/mm", "mm")
    assert (units["reversal_stiffness"], units["max_mises"], units["swt_life"]) == ("N/mm^2", "MPa", "")


@pytest.mark.parametrize(
    ("quantity", "value", "internal"),
    [
        ("dissipated_energy", "1.5 uJ", 1.5e-3),
        ("reversal_stiffness", "20 kN/mm", 2e4),
        ("max_tension", "0.2 GPa", 200.0),
        ("ruiz-2_max", "3 MPa^2 mm", 3.0),
        ("fatemi-socie_max", "1 %", 0.01),
        ("crack_arrest_length", "20 um", 0.02),
        ("crack_life", 2e5, 2e5),
    ],
)
def test_expected_values_have_units(quantity: str, value: object, internal: float) -> None:
    found = Expectation.model_validate({"quantity": quantity, "value": value, "rel": 0.1})
    assert found.value == pytest.approx(internal, rel=1e-12)
    assert found.quantity == quantity.replace("-", "_")


def test_a_name_that_is_near_nothing_lists_what_can_be_expected() -> None:
    with pytest.raises(ValueError, match=r"or one of dissipated_energy, .*, max_mises, .*, swt_life, .* is needed"):
        Expectation.model_validate({"quantity": "zzz", "value": 1, "rel": 0.1})


def test_what_never_breaks_can_be_expected(tmp_path: Path) -> None:
    """A crack under a threshold of nothing goes through; that is stored as JSON that any program reads."""
    crack = "crack: {material: {threshold_range: 1e-9 MPa m^0.5, fatigue_range: 1 MPa}}"
    entry = "quantity: crack_arrest_length, value: .inf, abs: 1 mm"
    life, output = "quantity: swt_life, value: .inf, abs: 0", f"{crack}, {FATIGUE}"
    path = "load_path: [{P: 100 N/mm, increments: 2}, {bulk_2: {xx: 500 MPa}, increments: 1}]\n"
    ramp = LINE.partition("load_path")[0] + path
    file = write_case(tmp_path, expecting(entry, life, output=output, case=ramp))
    arrest, swt = (line.split() for line in invoke("check", file).stdout.splitlines()[2:4])
    assert arrest == ["run", "crack_arrest_length", "inf", "mm", "inf", "mm", "+0", "mm", "1", "mm", "yes"]
    assert (swt[2], float(swt[3]) > 0.0, swt[-1]) == ("inf", True, "NO")
    case = load_case(file)
    stored = json.loads(json.dumps(case.effective(), allow_nan=False))
    assert stored["expect"][0]["value"] == ".inf"
    again = stored_case(stored)
    assert again is not None
    assert again.expect[0].value == math.inf


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("quantity: swt_life, value: .inf, rel: 1 %", "expect.0: rel says nothing about a value of inf; abs is needed"),
        ("quantity: swt_life, value: 9, abs: .inf", "expect.0.abs: inf is not finite; "),
        ("quantity: max_mises, value: .inf, abs: 1 MPa", "expect.0.value: inf is not finite; "),
    ],
)
def test_endless_values_that_say_nothing_are_refused(tmp_path: Path, entry: str, message: str) -> None:
    assert message in str(case_error(write_case(tmp_path, expecting(entry, output=f"{STRESS}, {FATIGUE}"))))
