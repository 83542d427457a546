"""Fatigue parameters that a case asks for, at the end of its run and in sweeps."""

import csv
import json

import h5py
import pytest
from command_line import invoke, refused
from small_cases import TWO_CYCLES

from fretsolve import open_result

STEEL = "tension_limit: 300 MPa\ntorsion_limit: 190 MPa\n"
FATIGUE = "output: {fatigue: {material: steel.yaml, criteria: [findley, crossland], depths: [0 mm, 40 um]}}\n"


@pytest.fixture
def case(tmp_path):
    """A case with a file of a material, which asks for fatigue parameters."""
    (tmp_path / "steel.yaml").write_text(STEEL)
    (tmp_path / "c.yaml").write_text(TWO_CYCLES + FATIGUE)
    return tmp_path / "c.yaml"


@pytest.mark.slow
def test_a_case_asks_for_fatigue_parameters(case, tmp_path):
    """They are those of the command, and are made again if they are missing, or of another case."""
    done = invoke("run", case)
    assert done.exit_code == 0, done.stderr
    assert "body 2, 2 depths, 5 states:" in done.stdout
    assert done.stdout.endswith(f"{tmp_path / 'c.fatigue.h5'}\n")
    with open_result(tmp_path / "c.h5") as result:
        stored = json.loads(result.attributes["effective_case"])["output"]["fatigue"]
    assert (stored["material"]["torsion_limit"], stored["criteria"]) == (190.0, ["findley", "crossland"])
    words = ("--cycle", "last", "--depth", "0", "--depth", "40um", "-q", "-o", tmp_path / "s.h5")
    assert invoke("stress", tmp_path / "c.h5", *words).exit_code == 0
    words = ("--material", tmp_path / "steel.yaml", "--criterion", "findley,crossland", "-q")
    assert invoke("fatigue", tmp_path / "s.h5", *words, "-o", tmp_path / "f.h5").exit_code == 0
    with h5py.File(tmp_path / "c.fatigue.h5") as own, h5py.File(tmp_path / "f.h5") as of_command:
        for name in ("findley", "crossland", "findley_normal"):
            assert (own[f"fatigue/body_2/{name}"][()] == of_command[f"fatigue/body_2/{name}"][()]).all()
        worst = own["fatigue/body_2/findley"].attrs["worst"]
    before = (tmp_path / "c.fatigue.h5").stat().st_mtime_ns
    assert invoke("run", case, "--resume", "-q").exit_code == 0
    assert (tmp_path / "c.fatigue.h5").stat().st_mtime_ns == before
    with h5py.File(tmp_path / "c.fatigue.h5", "r+") as file:
        file.attrs["effective_case"] = "{}"
    assert invoke("run", case, "--resume", "-q").exit_code == 0
    with h5py.File(tmp_path / "c.fatigue.h5") as file:
        assert file["fatigue/body_2/findley"].attrs["worst"] == worst
    assert sorted(path.name for path in tmp_path.iterdir() if "tmp" in path.name) == []


@pytest.mark.slow
def test_constants_in_the_case_and_averages(case, tmp_path):
    """An average has a depth of its own; one constant of a file may be overridden."""
    words = ("--set", "output.fatigue.depths=[]", "--set", "output.fatigue.average={point: 80 um}")
    done = invoke("run", case, *words, "--set", "output.fatigue.material.torsion_limit=200 MPa")
    assert done.exit_code == 0, done.stderr
    assert "point average over 0.08 mm" in done.stdout
    assert "% of 200 MPa" in done.stdout
    material = "output.fatigue.material={tension_limit: 300 MPa, torsion_limit: 200 MPa}"
    again = invoke("run", case, *words, "--set", material, "--overwrite")
    assert again.stdout.splitlines()[-3:] == done.stdout.splitlines()[-3:]


def test_mistakes_in_the_keys(case):
    for command in ("validate", "run"):
        message = "output.fatigue.material=none.yaml: output.fatigue.material: "
        assert message in refused(2, command, case, "--set", "output.fatigue.material=none.yaml")
    assert invoke("validate", case, "--set", "output.fatigue.criteria=[swt]").exit_code == 0


def test_what_a_run_refuses_before_it_begins(case, tmp_path):
    assert "the whole load path has 1 stored state;" in refused(2, "run", case, "--set", "load_path=[{P: 1 N}]")
    ruiz = ("--set", "output.fatigue.criteria=[ruiz_1]")
    surface = "output.fatigue.criteria: ruiz-1 is a parameter of the surface"
    assert f"{surface}; 0 mm is needed among" in refused(2, "run", case, *ruiz, "--set", "output.fatigue.depths=[5 um]")
    average = ("--set", "output.fatigue.depths=[]", "--set", "output.fatigue.average={line: 1 mm}")
    assert f"{surface}, no average over depths" in refused(2, "run", case, *ruiz, *average)
    fields = ("--set", "output.fields=[pressure, shear]")
    assert "ruiz-1 needs slip, which output.fields leaves out" in refused(2, "run", case, *ruiz, *fields)
    assert "output.fields needs shear" in refused(2, "run", case, "--set", "output.fields=[pressure]")
    rigid = "bodies=[{young_modulus: 70 GPa, poisson_ratio: 0.5}, rigid]"
    words = ("--set", rigid, "--set", "output.fatigue.bodies=[2]")
    assert "body 2 is rigid, so that it has no stress" in refused(2, "run", case, *words)
    short = ("--set", "output.fatigue.depths=[]", "--set", "output.fatigue.average={line: 1 um}")
    assert "output.fatigue.average: the averaging length 0.001 mm is below a cell" in refused(2, "run", case, *short)
    assert "output.every: the cycle has 2 stored states" in refused(2, "run", case, "--set", "output.every=4")
    (tmp_path / "steel.yaml").write_text("tension_limit: 300 N\n")
    assert "steel.yaml:1: tension_limit: '300 N' is a force" in refused(2, "run", case)
    assert not (tmp_path / "c.h5").exists()


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep of three cases that ask for stresses and fatigue parameters, of which the first has no solution."""
    folder = tmp_path_factory.mktemp("swept")
    (folder / "steel.yaml").write_text(STEEL)
    (folder / "c.yaml").write_text(TWO_CYCLES + FATIGUE.replace("output: {", "output: {stress: {depths: [0 mm]}, "))
    quantities = "[findley_max, crossland_max, max_tension]"
    (folder / "s.yaml").write_text(f"case: c.yaml\naxes:\n  - friction: [0.1, 0.3, 0.5]\nquantities: {quantities}\n")
    assert invoke("sweep", "run", folder / "s.yaml", "-q", "-j", 1).exit_code == 0
    return folder / "s.sweep"


def table_of(swept):
    assert invoke("sweep", "collect", swept).exit_code == 0
    return list(csv.DictReader((swept / "table.csv").read_text().splitlines()))


@pytest.mark.slow
def test_a_sweep_collects_the_largest_parameters(swept, tmp_path):
    """A case without a solution has no side outputs."""
    assert "2 complete, 1 no solution" in invoke("sweep", "status", swept).stdout
    _, *rows = table_of(swept)
    for row in rows:
        with h5py.File(swept / "results" / f"{row['id']}.fatigue.h5") as file:
            worst = file["fatigue/body_2/findley"].attrs["worst"]
        assert float(row["findley_max (MPa)"]) == pytest.approx(worst, rel=1e-9)
        assert float(row["max_tension (MPa)"]) > float(row["max_tension error (MPa)"]) > 0.0
    assert float(rows[0]["crossland_max (MPa)"]) > 0.0
    for name, text in (("c.yaml", TWO_CYCLES), ("s.yaml", (swept.with_suffix(".yaml")).read_text())):
        (tmp_path / name).write_text(text)
    assert "output.fatigue in the case is needed" in refused(2, "sweep", "run", tmp_path / "s.yaml")
    (tmp_path / "s.yaml").write_text(text.replace("findley_max, crossland_max, ", ""))
    assert "output.stress in the case is needed" in refused(2, "sweep", "run", tmp_path / "s.yaml")
    (tmp_path / "s.yaml").write_text(text.replace("findley_max", "findley_max@2"))
    assert "findley_max has one value of the whole run, not one of each stage; leave @2 out" in refused(
        2, "sweep", "run", tmp_path / "s.yaml"
    )


@pytest.mark.slow
def test_a_sweep_goes_on_after_a_kill_between_result_and_side_outputs(swept):
    rows = table_of(swept)
    killed = [
        sorted((swept / "results").glob(f"*.{name}.h5"))[place] for place, name in enumerate(("stress", "fatigue"))
    ]
    for path in killed:
        path.unlink()
    assert "1 no solution, 2 waiting" in invoke("sweep", "status", swept).stdout
    assert invoke("sweep", "run", swept.with_suffix(".yaml"), "-q", "-j", 1).exit_code == 0
    assert all(path.exists() for path in killed)
    assert table_of(swept) == rows
