"""The commands on a line contact: units, closed forms, pictures, exports, sweeps and studies."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from line_cases import LINE, A
from small_cases import write_case

from fretsolve import open_result

CYCLE = LINE + "  - {Qx: -18 N/mm, increments: 6}\n"


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return result_of(write_case(tmp_path_factory.mktemp("line"), CYCLE))


VALIDATED = {
    LINE: (
        "64 cells of 0.004375 mm on 0.28 mm",
        "stage 2: Qx -> 18 N/mm in 4 increments",
        "# Hertz at the largest load",
        "P = 100 N/mm: half-width a = 0.107641 mm, p0 = 591.431 MPa",
        "gross slip begins at Q = mu P = 30 N/mm",
        "smallest stick half-width c = 0.0680778 mm, 31.1 cells across, at the end of stage 2 (Cattaneo-Mindlin)",
    ),
    LINE + "  - {bulk_2: {xx: 20 MPa}}\n  - {Qx: -18 N/mm, bulk_2: {xx: 162 MPa}}\n": (
        "once the last two stages repeat: half-width c = 0.0680778 mm, middle at x = -0.0107",
    ),
    LINE + "  - {bulk_2: {xx: 20 MPa}}\n": (
        "no closed form gives the stick zone: it needs a cylinder on a body of its own material",
    ),
    LINE.replace("cylinder: {radius: 10 mm}", "punch: {half_width: 0.5 mm, edge_radius: 100 mm}")
    .replace(", size: 0.28 mm", "")
    .replace("100 N/mm", "200 N/mm")
    .replace("18 N/mm", "36 N/mm"): (
        "P = 200 N/mm: half-width a = 0.866669 mm, largest pressure = 163.515 MPa",
        "smallest stick half-width c = 0.709708 mm",
        "(Ciavarella-Jaeger)",
    ),
    LINE.replace("18 N/mm", "31 N/mm"): (
        "31 N/mm is not below the 30 N/mm (mu P) that friction carries: gross slip ends the run; impose delta_x"
        " to follow it, with a reference_depth",
    ),
}


@pytest.mark.parametrize("text", VALIDATED)
def test_validate_prints_units_closed_forms_and_warnings(tmp_path: Path, text: str) -> None:
    done = invoke("validate", write_case(tmp_path, text))
    assert done.exit_code == 0
    assert [line for line in VALIDATED[text] if line not in done.output] == []
    assert done.stderr == "" or text != LINE


def test_validate_prints_the_stick_zone_of_a_sphere_under_bulk_stress_or_why_there_is_none() -> None:
    case = Path(__file__).parents[4] / "cases" / "sphere_bulk.yaml"
    done = invoke("validate", case)
    assert "smallest stick radius c = 0.221858 mm, 78.6 cells across, its middle at x = 0.0602212 mm" in done.stdout
    narrow = "load_path=[{P: 400 N}, {Qx: 39.7 N, bulk_2: {xx: 71.141 MPa, yy: 14.89 MPa}}]"
    few = invoke("validate", case, "--set", "grid.points=16", "--set", narrow, "--set", "expect=[]")
    assert "the stick zone shrinks to" in few.stderr
    for change, why in (
        ("stage.2.bulk_2.yy=0 MPa", "force and bulk stress are not in proportion"),
        ("load_path=[{P: 400 N}, {Qx: 24 N, bulk_2: {xx: 100 MPa}}]", "it needs a mismatch along y of -0.09677 times"),
    ):
        done = invoke("validate", case, "--set", change, "--set", "expect=[]")
        assert f"no closed form gives the stick zone under this bulk stress: {why}" in done.stdout


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("expect=[{quantity: stick_center_y, value: 0 mm, abs: 1 um}]", "stick_center_y is always NaN"),
        ("expect=[{quantity: delta_z, value: 1 um, rel: 1 %}]", "delta_z is NaN in a line contact without"),
        ("expect=[{quantity: work_total, value: 1e-3 mJ, rel: 1 %}]", "'1e-3 mJ' is an energy; an energy per length"),
        ("reference_depth=0.1 mm", "0.1 mm is less than the grid's length; 0.28 mm or more is needed"),
        ("stage.2.bulk_2.xx=3 N", "'3 N' is a force; a stress such as '70 MPa' is needed"),
    ],
)
def test_mistakes(tmp_path: Path, change: str, told: str) -> None:
    assert told in refused(2, "validate", write_case(tmp_path, LINE), "--set", change)


@pytest.mark.parametrize(
    "words",
    [
        ["stage.2.bulk_2.xx=1e4 MPa", "stage.2.Qx=9 N/mm"],
        [
            "bodies=[{young_modulus: 70 GPa, poisson_ratio: 0.33}, {young_modulus: 70 GPa, poisson_ratio: 0.33}]",
            "surface.cylinder.radius=100 mm",
            "grid={points: 64}",
            "friction=0.1",
            "stage.1.P=10 N/mm",
            "stage.2={Qx: 0.6 N/mm, bulk_2: {xx: 200 MPa}, increments: 4}",
        ],
    ],
)
def test_large_bulk_stress_leaves_the_stick_zone_unknown(tmp_path: Path, words: list[str]) -> None:
    """It is narrower than any closed form gives, but the case is solved."""
    path = write_case(tmp_path, LINE)
    changes = [word for one in words for word in ("--set", one)]
    shown = invoke("validate", path, *changes)
    assert (shown.exit_code, shown.stderr) == (0, "")
    assert "Hertz at the largest load" in shown.stdout and "smallest stick" not in shown.stdout
    assert invoke("run", path, "-q", *changes).exit_code == 0
    with open_result(tmp_path / "case.h5") as found:
        assert max(found.history["residual_stick"].max(), found.history["residual_slip"].max()) <= 1e-6


def test_validate_prints_the_stick_zone_of_dissimilar_bodies(tmp_path: Path) -> None:
    words = ["--set", "bodies.0.poisson_ratio=0.06", "--set", "bodies.1.poisson_ratio=0.42", "--set", "friction=0.2"]
    done = invoke("validate", write_case(tmp_path, LINE), *words, "--set", "load_path=[{P: 100 N/mm}]")
    assert "Dundurs' constant 0.1938" in done.stdout
    ratio = 0.73085851
    assert f"c = {ratio * A:.4g}"[:9] in done.stdout and "(Spence, one-way)" in done.stdout


def test_units_of_the_result_are_per_length(result: Path) -> None:
    with h5py.File(result) as file:
        units = {name: file["history"][name].attrs["units"] for name in ("P", "My", "Qx", "work_total", "contact_area")}
        assert "half-width" in file["history/contact_radius"].attrs["long_name"]
    assert units == {
        "P": "N/mm", "My": "N mm/mm", "Qx": "N/mm", "work_total": "mJ/mm", "contact_area": "mm^2/mm",
    }  # fmt: skip
    with open_result(result) as opened:
        assert (opened.units("P"), opened.units("max_pressure")) == ("N/mm", "MPa")
        assert opened.case is not None and opened.case.plane == "strain"


def test_unknown_displacements_are_stored_as_nan_and_not_shown(result: Path) -> None:
    with open_result(result) as opened:
        assert np.isnan(opened.history["delta_z"]).all() and np.isnan(opened.history["delta_x"]).all()
    shown = invoke("show", result)
    assert shown.exit_code == 0
    assert "N/mm" in shown.stdout and "mJ/mm" in shown.stdout
    assert "delta" not in shown.stdout and "nan" not in shown.stdout


@pytest.mark.parametrize("kind", ["csv", "npz", "vtk", "xdmf"])
def test_exports(result: Path, kind: str) -> None:
    done = invoke("export", result, "--to", kind, "--overwrite")
    assert done.exit_code == 0, done.stderr
    if kind == "csv":
        with result.with_suffix(".csv").open() as file:
            heading = next(csv.reader(file))
        assert {"P (N/mm)", "work_total (mJ/mm)"} <= set(heading)


@pytest.mark.parametrize("kind", ["map", "streamlines", "slip-angle", "animate", "loop"])
def test_pictures_of_areas_say_why_not(result: Path, kind: str) -> None:
    assert "line contact" in refused(2, "plot", result, kind)


def test_profile_of_one_column(tmp_path: Path) -> None:
    x = (np.arange(401) - 200) * 1e-3
    np.save(tmp_path / "profile.npy", x**2 / 20.0 * 1e3)
    surface = "{heights: {file: profile.npy, unit: um, spacing: 1 um}}"
    path = write_case(tmp_path, CYCLE.replace("{cylinder: {radius: 10 mm}}", surface))
    assert invoke("run", path, "-q").exit_code == 0
    with open_result(path.with_suffix(".h5")) as opened:
        assert opened.history["contact_radius"][0] == pytest.approx(A, rel=2e-3)
    np.save(tmp_path / "profile.npy", np.ones((20, 3)))
    message = refused(2, "run", path, "-q", "--overwrite")
    assert "'profile.npy' holds a 20 x 3 array; plane: strain takes one column of heights" in message
