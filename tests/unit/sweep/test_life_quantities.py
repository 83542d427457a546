"""Lives, fatigue parameters and cracks as quantities of sweeps: names, values from files beside results, tables."""

import csv
import math

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from line_cases import LINE
from small_cases import LOOP, write_case
from sweeping import manifest_of, write_sweep
from test_sweep_plots import LOAD, table_of

from fretsolve.errors import CaseError
from fretsolve.post.crack import crack_file
from fretsolve.post.fatigue import fatigue_file
from fretsolve.sweep.outcome import read_outcome
from fretsolve.sweep.quantity import needed_key, plain, read_quantity
from fretsolve.sweep.seeds import seed_columns
from fretsolve.sweep.table import Column, collect, write_table_csv, write_table_hdf5

INF = math.inf


def test_hyphens_and_underscores_mean_the_same():
    for text in ("fatemi-socie_max", "fatemi_socie_max", "fatemi_socie-max"):
        assert read_quantity(text).name == "fatemi_socie_max"
    assert (read_quantity("ruiz-1_max").name, read_quantity("delta-z@2").stage) == ("ruiz_1_max", 2)
    assert plain("fatemi-socie_life@3") == "fatemi_socie_life@3"


def test_units_and_the_key_that_gives_a_quantity():
    units = {
        "swt_max": "MPa",
        "fatemi_socie_max": "1",
        "ruiz_2_max": "MPa^2 mm",
        "swt_life": "cycles",
        "crack_life": "cycles",
        "crack_arrest_length": "mm",
    }
    assert {name: read_quantity(name).units for name in units} == units
    keys = {"max_mises": "output.stress", "swt_life": "output.fatigue", "crack_life": "output.crack", "delta_z": ""}
    assert {name: needed_key(name) for name in keys} == keys


def test_a_refused_quantity_lists_all_that_there_are():
    for text, hint in {
        "swt": "did you mean 'swt_max' or 'swt_life'?",
        "crack": "did you mean 'crack_arrest_length' or 'crack_life'?",
        "fatemi-socie-live": "'fatemi-socie-live' is not a quantity that can be compared; did you mean",
        "max-misses": "did you mean 'max_mises'?",
        "crack_life@2": "crack_life has one value of the whole run, not one of each stage; leave @2 out",
    }.items():
        with pytest.raises(CaseError) as refused:
            read_quantity(text)
        assert hint in str(refused.value)
    with pytest.raises(CaseError) as refused:
        read_quantity("banana")
    parts = str(refused.value).split("one of these is needed: ")[1].split("; ")
    assert [part.partition(":")[0] for part in parts[1:]] == ["of stresses", "of fatigue", "of a crack", "of cycles"]
    assert parts[1].endswith("max_mises, max_tension, max_tresca")
    assert parts[2].endswith("ruiz_1_max, ruiz_2_max, swt_life, fatemi_socie_life")
    assert parts[3] == "of a crack: crack_arrest_length, crack_life"


@pytest.fixture
def known(monkeypatch):
    """Lives and cracks as files beside results would have them."""
    worst = {"swt_life": (INF, 0.0), "fatemi_socie_life": (2e5, 3e4), "swt_max": (0.3, 0.02)}
    of_crack = {"crack_arrest_length": (INF, 0.0), "crack_life": (4e5, INF)}
    monkeypatch.setattr(fatigue_file, "read_worst", lambda path, result: worst)
    monkeypatch.setattr(crack_file, "read_crack", lambda path, result: of_crack)
    return worst | of_crack


def test_values_and_errors_come_from_the_files_beside_a_result(known, tmp_path):
    out = result_of(write_case(tmp_path, LOOP))
    quantities = [read_quantity(name, stages) for name in known for stages in (4, 10**9)]
    found = read_outcome(out, quantities)
    expected = [pair for pair in known.values() for _ in range(2)]
    np.testing.assert_array_equal(np.transpose([found.values, found.errors]), expected)
    assert found.units["swt_life"] == "cycles"


def test_endless_lives_survive_tables(tmp_path):
    columns = [Column("swt_life", "cycles", np.array([INF, 3e5, np.nan]))]
    write_table_csv(tmp_path / "t.csv", columns)
    assert (tmp_path / "t.csv").read_text().splitlines() == ["swt_life (cycles)", "inf", "300000", '""']
    write_table_hdf5(tmp_path / "t.h5", {"values": columns}, {})
    with h5py.File(tmp_path / "t.h5") as file:
        np.testing.assert_array_equal(file["values/swt_life"][()], [INF, 3e5, np.nan])
        assert file["values/swt_life"].attrs["units"] == "cycles"


def test_the_mean_over_seeds_with_a_run_out_is_endless_and_has_no_scatter():
    points = [{LOAD: "1 N", "surface.0.roughness.seed": str(seed)} for seed in (1, 2)]
    counts, _, mean, scatter = seed_columns(table_of(points, [INF, 1e6]))
    assert (counts.values.tolist(), mean.values.tolist()) == ([2], [INF])
    assert np.isnan(scatter.values).all()


def test_a_table_names_quantities_as_they_stand_in_files(tmp_path):
    manifest = manifest_of(tmp_path)
    assert [one.name for one in collect(manifest, ["delta-z", "fatemi-socie_life"]).found] == [
        "delta_z",
        "fatemi_socie_life",
    ]


CRACK = """\
output: {crack: {material: {threshold_range: 2.1 MPa m^0.5, fatigue_range: 248 MPa}}}
"""


def test_a_crack_needs_its_key_in_the_case(tmp_path):
    text = "case: case.yaml\naxes: [friction: [0.3, 0.4]]\nquantities: [crack-life]\n"
    file = write_sweep(tmp_path, text, LINE)
    message = "crack_life is known from runs with output.crack alone; output.crack in the case is needed"
    assert message in refused(2, "sweep", "run", file)


@pytest.mark.slow
def test_a_sweep_collects_where_cracks_stop_and_what_is_not_known(tmp_path):
    """A small force leaves no crack, a large bulk stress breaks the specimen; no material gives a life."""
    path = LINE.partition("load_path")[0] + CRACK
    path += "load_path: [{P: 100 N/mm}, {cycle: {amplitude: {Qx: 18 N/mm, bulk_2: {xx: 0 MPa}}, times: 2}}]\n"
    key = "load_path.1.cycle.amplitude.bulk_2.xx"
    text = f"case: case.yaml\naxes: [{key}: [0 MPa, 400 MPa]]\nquantities: [crack-arrest-length]\n"
    file = write_sweep(tmp_path, text, path)
    assert invoke("sweep", "run", file, "-q", "-j", 1).exit_code == 0
    folder = tmp_path / "sweep.sweep"
    assert invoke("sweep", "collect", folder).exit_code == 0
    with (folder / "table.csv").open() as table:
        rows = list(csv.DictReader(table))
    lengths = [row["crack_arrest_length (mm)"] for row in rows]
    assert lengths == ["0", "inf"]
    times = [path.stat().st_mtime_ns for path in sorted((folder / "results").glob("*.crack.h5"))]
    assert len(times) == 2
    next((folder / "results").glob("*.crack.h5")).unlink()
    assert invoke("sweep", "run", file, "-q", "-j", 1).exit_code == 0
    assert len(list((folder / "results").glob("*.crack.h5"))) == 2
    assert invoke("sweep", "plot", folder, "--quantity", "crack-arrest-length").exit_code == 0
    file.write_text(text.replace("length]", "length, crack_life]"))
    told = refused(2, "sweep", "run", file, "-o", tmp_path / "other")
    assert "quantities.1: crack_life needs an end of life" in told
