"""Results in other formats, read back: by ParaView's own library where pyvista is there, by csv and by NumPy."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke, refused
from fake_states import fake_header, write_fake
from small_cases import write_case

from fretsolve import load_case, open_result
from fretsolve.post.export import FORMATS
from fretsolve.post.export.deformed_surfaces import DeformedSurfaces, FlatError
from fretsolve.result import HistoryWriter, Result
from fretsolve.result.parts import parts_folder
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header
from fretsolve.simulation.simulation import run

CASE = """\
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.06}
  - {young_modulus: 100 GPa, poisson_ratio: 0.42}
surface: {sphere: {radius: 10 mm}}
grid: {points: [26, 24]}
friction: 0.1
load_path:
  - {P: 400 N, Mx: 4 N mm, increments: 1}
  - {Qx: 15 N, Mz: 0.5 N mm, increments: 3}
output: {fields: [pressure, shear, slip, zone, gap], every: 2}
"""
"""All six components move, and the bodies differ: whatever is left out of the surfaces opens a gap."""


def solve(folder: Path, text: str, end: str) -> Path:
    """A result that is complete, or parts of one that was stopped after three increments."""
    setup = set_up(load_case(write_case(folder, text)))
    with HistoryWriter.open(folder / "out.h5", run_header(setup, 1, ())) as writer:
        for state in run(setup):
            writer.append(state)
            if end == "stopped" and state.summary.step == 2:
                break
        if end == "complete":
            writer.finish("complete")
    return folder / "out.h5"


@pytest.fixture(scope="module", params=["complete", "stopped"])
def solved(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return solve(tmp_path_factory.mktemp("export"), CASE, request.param)


def exported(out: Path, to: str, target: Path, *words: object) -> Path:
    done = invoke("export", out, "--to", to, "-o", target, *words)
    assert (done.exit_code, done.stdout, done.stderr) == (0, f"{target}\n", "")
    assert not list(target.parent.glob("*.tmp"))
    return target


def test_csv_has_every_digit_and_units(solved: Path, tmp_path: Path) -> None:
    with exported(solved, "csv", tmp_path / "h.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    with open_result(solved) as result:
        units = {name: result.units(name) for name in result.history}
        assert header == [name if unit == "1" else f"{name} ({unit})" for name, unit in units.items()]
        assert {"P (N)", "Mz (N mm)", "delta_x (mm)", "phi_z (rad)", "work (mJ)", "stage"} <= set(header)
        for column, values in zip(np.array(rows, float).T, result.history.values(), strict=True):
            np.testing.assert_array_equal(column, values)


def test_npz_holds_all_and_needs_no_pickle(solved: Path, tmp_path: Path) -> None:
    file = exported(solved, "npz", tmp_path / "all.npz")
    with np.load(file, allow_pickle=False) as archive, open_result(solved) as result:
        for name, column in result.history.items():
            np.testing.assert_array_equal(archive[name], column, strict=True)
        assert archive["field_steps"].tolist() == list(result.steps)
        for name in result.fields:
            planes = [result.field(name, step) for step in result.steps]
            np.testing.assert_array_equal(archive[name], planes, strict=True)
        np.testing.assert_array_equal(archive["x"], result.x)
        assert json.loads(str(archive["units"]))["pressure"] == "MPa"
        assert json.loads(str(archive["effective_case"])) == result.effective_case
        assert str(archive["case_yaml"]) == CASE


def test_chosen_increments(solved: Path, tmp_path: Path) -> None:
    file = exported(solved, "npz", tmp_path / "one.npz", "--step", -1, "--step", 1, "--step", 1)
    last = 2 if parts_folder(solved).exists() else 3
    with np.load(file) as archive:
        assert archive["field_steps"].tolist() == [1, last]
        assert archive["pressure"].shape == (2, 26, 24)
        assert len(archive["P"]) == last + 1
    fields = exported(solved, "vtk", tmp_path / "one.pvd", "--step", 1)
    assert fields.read_text().count("<DataSet") == 2
    assert sorted(path.name for path in (tmp_path / "one.vtk").iterdir()) == ["body_1.000001.vts", "body_2.000001.vts"]


def test_surfaces_touch_where_there_is_pressure(solved: Path) -> None:
    with open_result(solved) as result:
        surfaces = DeformedSurfaces(result)
        for step in result.steps:
            upper, lower = surfaces.at(step)
            gap = upper.points[2] - lower.points[2]
            np.testing.assert_allclose(gap, result.field("gap", step), atol=1e-9)
            contact = result.field("pressure", step) > 0.0
            assert np.abs(gap[contact]).max() < 1e-8
            assert gap[~contact].min() > -1e-8
            assert lower.points[2][contact].max() < 0.0  # pushed away from body 1
            flat = np.broadcast_to(result.x[:, None], contact.shape)
            np.testing.assert_allclose(lower.points[0], flat + lower.displacement[0])


@pytest.fixture
def paraview() -> Any:
    """ParaView's library, read by pyvista (extra ``test-paraview``)."""
    return pytest.importorskip("pyvista", exc_type=ImportError)


def on_grid(mesh: Any, result: Result, values: np.ndarray) -> np.ndarray:
    """Point data (n, ...) of a plane mesh as (nx, ny, ...), by where the points lie."""
    placed = np.full((len(result.x), len(result.y), *values.shape[1:]), np.nan)
    i, j = (
        np.rint((mesh.points[:, axis] - centres[0]) / (centres[1] - centres[0])).astype(int)
        for axis, centres in enumerate((result.x, result.y))
    )
    placed[i, j] = values
    return placed


def test_paraview_reads_the_surfaces_over_time(paraview: Any, solved: Path, tmp_path: Path) -> None:
    reader = paraview.get_reader(str(exported(solved, "vtk", tmp_path / "a b.pvd")))
    with open_result(solved) as result:
        assert reader.time_values == list(result.steps)
        for step in result.steps:
            reader.set_active_time_value(step)
            bodies = reader.read()
            assert len(bodies) == 2
            for mesh, body in zip(bodies, DeformedSurfaces(result).at(step), strict=True):
                assert mesh.dimensions == (26, 24, 1)
                points = body.points.transpose(2, 1, 0).reshape(-1, 3)
                np.testing.assert_allclose(mesh.points, points, rtol=1e-6, atol=1e-9)
                for name in ("pressure", "zone", "gap"):
                    expected = result.field(name, step).T.ravel()
                    np.testing.assert_allclose(mesh.point_data[name], expected, rtol=1e-6, atol=1e-12)
                shear = mesh.point_data["shear"]
                assert not shear[:, 2].any()
                expected = result.field("shear", step).transpose(2, 1, 0).reshape(-1, 2)
                np.testing.assert_allclose(shear[:, :2], expected, rtol=1e-6, atol=1e-12)


def test_paraview_reads_xdmf_from_the_result_itself(paraview: Any, solved: Path, tmp_path: Path) -> None:
    target = exported(solved, "xdmf", tmp_path / "fields.xdmf")
    whole = solved.exists()
    assert (solved.name in target.read_text()) == whole
    reader = paraview.get_reader(str(target))
    with open_result(solved) as result:
        assert reader.time_values == list(result.steps)
        for step in result.steps:
            reader.set_active_time_value(step)
            mesh = reader.read()
            mesh = mesh[0] if isinstance(mesh, paraview.MultiBlock) else mesh
            for name in result.fields:
                found = on_grid(mesh, result, mesh.point_data[name])
                np.testing.assert_array_equal(found, result.field(name, step))


@pytest.mark.parametrize("name", ["a:b", " a", "a\\b"])
def test_names_that_xdmf_cannot_hold_are_refused(solved: Path, tmp_path: Path, name: str) -> None:
    """Read with VTK 9.7: a finished result in such a folder, and a text with such a name, give no points or no fields.

    A backslash matters in the path of the text alone.
    """
    message = "which readers of XDMF do not find: rename files and folders whose names have a colon, a backslash"
    assert message in refused(2, "export", solved, "--to", "xdmf", "-o", tmp_path / f"{name}.xdmf")
    assert list(tmp_path.iterdir()) == []
    folder = tmp_path / name
    folder.mkdir()
    there = solved.rename(folder / "out.h5") if solved.exists() else None
    if there is not None:
        words = "export", there, "--to", "xdmf", "-o", tmp_path / "out.xdmf"
        done = invoke(*words)
        there.rename(solved)
        assert (message in done.stderr, done.exit_code) == ((False, 0) if "\\" in name else (True, 2))


def test_where_there_is_no_material_points_are_hidden(paraview: Any, tmp_path: Path) -> None:
    text = CASE.replace("sphere: {radius: 10 mm}", "punch: {radius: 0.3 mm, edge_radius: 0.1 mm}")
    text = text.replace("points: [26, 24]", "points: [26, 24], size: 0.8 mm").replace("Mx: 4 N mm, ", "")
    out = solve(tmp_path, text, "complete")
    reader = paraview.get_reader(str(exported(out, "vtk", tmp_path / "punch.pvd", "--step", 1)))
    upper, lower = reader.read()
    with open_result(out) as result:
        outside = np.isinf(result.field("gap", 1))
    assert outside.any()
    assert np.isfinite(upper.points).all()
    np.testing.assert_array_equal(upper.point_data["vtkGhostType"] == 2, outside.T.ravel())
    assert "vtkGhostType" not in lower.point_data


def made_up(folder: Path, **options: Any) -> Path:
    return write_fake(folder / "fake.h5", count=3, **options)


def test_without_a_case_of_this_version_the_surfaces_stay_flat(paraview: Any, tmp_path: Path) -> None:
    out = made_up(tmp_path)
    done = invoke("export", out, "--to", "vtk")
    assert (done.exit_code, done.stdout) == (0, f"{tmp_path}/fake.pvd\n")
    why = "the case in the result is not one of this version"
    assert done.stderr == f"{out}: warning: the surfaces are left flat: {why}\n"
    reader = paraview.get_reader(str(tmp_path / "fake.pvd"))
    reader.set_active_time_value(2)
    (plane,) = reader.read()
    assert not plane.points[:, 2].any()
    with open_result(out) as result:
        np.testing.assert_allclose(plane.point_data["pressure"], result.field("pressure", 2).T.ravel(), rtol=1e-6)


def test_surfaces_need_the_tractions_and_the_height_map(tmp_path: Path) -> None:
    heights = np.add.outer(np.linspace(-1, 1, 40) ** 2, np.linspace(-1, 1, 40) ** 2) / 20
    np.save(tmp_path / "map.npy", heights)
    mapped = CASE.replace("sphere: {radius: 10 mm}", "heights: {file: map.npy, spacing: 0.05 mm}")
    out = solve(tmp_path, mapped, "complete")
    (tmp_path / "map.npy").unlink()
    with open_result(out) as result, pytest.raises(FlatError, match=r"map\.npy: the height map cannot be read"):
        DeformedSurfaces(result)
    (tmp_path / "less").mkdir()
    out = solve(tmp_path / "less", CASE.replace("[pressure, shear, slip, zone, gap]", "[pressure, zone]"), "complete")
    with open_result(out) as result, pytest.raises(FlatError, match="the result holds no shear"):
        DeformedSurfaces(result)


WRONG = {
    ("csv", "--step", "1"): "fake.h5: csv holds the history of all increments, so --step has no effect; leave it out",
    ("npz", "--step", "9"): "there is no increment 9; there are 0 to 2",
    ("npz", "--step", "-4"): "there is no increment -4; there are 0 to 2",
    ("vtk", "-o", "x.vtk"): "x.vtk: the name of a vtk file must end in .pvd",
    ("csv", "-o", "."): ".: the name of a csv file must end in .csv",
    ("hdf5",): "'hdf5' is not one of 'vtk', 'xdmf', 'csv', 'npz', 'heights'",
}


@pytest.mark.parametrize("words", WRONG, ids=" ".join)
def test_wrong_orders_are_one_line(words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert WRONG[words] in refused(2, "export", made_up(tmp_path), "--to", *words)
    assert [path.name for path in tmp_path.iterdir()] == ["fake.h5"]


def test_increments_and_fields_that_are_not_stored(tmp_path: Path) -> None:
    out = made_up(tmp_path, every=2, stored=())
    told = refused(2, "export", out, "--to", "npz", "--step", 0)
    assert "the fields of increment 0 are not stored (output.every); the nearest ones are those of 1" in told
    for to in ("vtk", "xdmf"):
        told = refused(2, "export", out, "--to", to)
        assert told == f"{out}: no fields are stored; output.fields in the case file chooses them\n"
    assert invoke("export", out, "--to", "npz").exit_code == 0


def test_result_is_never_replaced(tmp_path: Path) -> None:
    out = made_up(tmp_path).rename(tmp_path / "odd.csv")
    before, told = out.read_bytes(), "would replace the result itself; give another name with -o\n"
    assert refused(2, "export", out, "--to", "csv") == f"{out}: {told}"
    assert out.read_bytes() == before
    out = out.rename(tmp_path / "odd.xdmf.h5")  # where the points of odd.xdmf would lie
    assert refused(2, "export", out, "--to", "xdmf", "-o", tmp_path / "odd.xdmf") == f"{out}: {told}"
    assert out.read_bytes() == before


@pytest.mark.parametrize("to", [name for name in FORMATS if name != "heights"])
def test_files_are_replaced_only_where_that_is_asked_for(to: str, tmp_path: Path) -> None:
    out = made_up(tmp_path)
    first = invoke("export", out, "--to", to)
    assert first.exit_code == 0
    target = Path(first.stdout.strip())
    content = target.read_bytes()
    target.write_text("mine")
    told = f"{target}: exists: --overwrite replaces it, or give another name with -o\n"
    assert refused(2, "export", out, "--to", to) == told
    assert target.read_text() == "mine"
    assert invoke("export", out, "--to", to, "--overwrite").exit_code == 0
    assert len(target.read_bytes()) == len(content)


@pytest.mark.parametrize("to", [name for name in FORMATS if name != "heights"])
def test_what_cannot_be_written_is_one_line(to: str, tmp_path: Path) -> None:
    suffix = {"vtk": "pvd"}.get(to, to)
    target = tmp_path / "none" / f"x.{suffix}"
    told = f"{target}: cannot be written: No such file or directory\n"
    assert refused(4, "export", made_up(tmp_path), "--to", to, "-o", target) == told


def test_missing_and_empty_results(tmp_path: Path) -> None:
    assert refused(4, "export", tmp_path / "none.h5", "--to", "csv")
    with HistoryWriter.open(tmp_path / "new.h5", fake_header()):
        assert "has no increment yet" in refused(2, "export", tmp_path / "new.h5", "--to", "csv")
    failed = tmp_path / "failed.h5"
    with HistoryWriter.open(failed, fake_header()) as writer:
        writer.finish("failed", "everything slides", "sliding")
    told = "the run failed before its first increment: everything slides\n"
    assert refused(2, "export", failed, "--to", "csv") == f"{failed}: {told}"
    assert refused(2, "plot", failed) == f"{failed}: loop: {told}"
