"""What is shown of wear, and worn profiles with which other cases and stresses go on."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from small_cases import CASE, WORN, write_case

from fretsolve.case.loading import load_case
from fretsolve.post.export.deformed_surfaces import DeformedSurfaces
from fretsolve.post.export.remarks import rows_of_wear, wear_totals
from fretsolve.post.export.selection import rows_of_stick_zones
from fretsolve.post.export.tables import require_wear, write_heights
from fretsolve.post.stress.cycles import cycles_of
from fretsolve.problem.setup.wear_warnings import error_by_grid
from fretsolve.result import Result, open_result
from fretsolve.result.state import stage_ends

ALPHA = 1e-7
ROOT = Path(__file__).parents[4]


@pytest.fixture
def result(worn: Path) -> Result:
    return open_result(worn)


def test_volume_balances_the_dissipated_energy(result: Result) -> None:
    history = result.history
    np.testing.assert_allclose(history["wear_volume"], ALPHA * history["work_total"], rtol=1e-12)
    assert history["cycles"][-1] == 1e4
    depth = result.field("wear_depth", result.increments - 1)
    cell = float(np.diff(result.x)[0] * np.diff(result.y)[0])
    assert depth.sum() * cell == pytest.approx(history["wear_volume"][-1], rel=1e-12)
    assert depth.max() == history["wear_depth_max"][-1]
    np.testing.assert_allclose(result.field("wear_depth_1", result.increments - 1), 0.25 * depth)


def test_show_has_the_changes_of_the_surfaces(worn: Path, result: Result) -> None:
    rows = rows_of_wear(result, stage_ends(result.history["stage"]))
    kept = result.history["jump"][rows]
    assert (result.history["cycles"][rows][kept == 0.0][:-1] == 0.0).all()  # but for the last one before any wear
    assert rows[-1] == result.increments - 1
    assert result.history["jump"].max() == 5000.0
    shown = invoke("show", worn).stdout
    cycles, stick = wear_totals(result)
    assert cycles in shown
    assert cycles.startswith("10000 cycles, for which ")
    assert f"{result.history['wear_volume'][-1]:.5g}" in cycles
    first, last = (result.history["stick_area"][step - 1] for step in _first_and_last_change(result))
    text = f"stick area at the end of the first solved cycle {first:.4g}, of the last one {last:.4g} mm^2"
    assert stick == f"{text} ({100.0 * (last / first - 1.0):+.2g} %)"


def _first_and_last_change(result: Result) -> tuple[int, int]:
    changes = np.flatnonzero(result.history["jump"] > 0.0)
    return int(changes[0]), int(changes[-1])


def test_show_says_that_the_stick_area_of_unlike_bodies_has_no_error_estimate(tmp_path: Path) -> None:
    path = write_case(tmp_path, WORN.replace("points: 24", "points: 16"))
    unlike = "bodies.1.young_modulus=70 GPa"
    assert invoke("run", path, "-q", "--set", unlike).exit_code == 0
    with open_result(path.with_suffix(".h5")) as result:
        cycles, stick = wear_totals(result)
        assert error_by_grid(result) is None  # unlike bodies have no closed form of the limit
    assert "by the cells" not in cycles
    assert stick.startswith("stick area at the end of the first solved cycle 0.0")
    assert stick.endswith(" %); its error is not estimated: compare a smaller tolerance")


def test_stick_zones_of_changes_are_those_of_the_cycle_before(worn: Path, result: Result) -> None:
    """In a change the cells that it brings into contact stick, whatever the load."""
    history = result.history
    changes = np.flatnonzero(history["jump"] > 0.0)
    assert (history["stick_radius"][changes] != history["stick_radius"][changes - 1]).all()
    expected = np.arange(result.increments)
    expected[changes] -= 1
    np.testing.assert_array_equal(rows_of_stick_zones(history), expected)
    lines = invoke("show", worn).stdout.splitlines()
    for step in changes:
        row = next(line for line in lines if line.split()[:2] == [str(step), str(history["stage"][step])])
        assert f" {history['stick_radius'][step - 1]:.4g} " in row
    assert "rows with a jump: the surfaces change after a solved cycle, at whose end the stick zone is given" in lines


def test_columns_of_wear_in_all_formats(worn: Path, tmp_path: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(invoke("show", worn, "--csv").stdout)))
    assert float(rows[-1]["cycles"]) == 1e4
    assert 0.0 < float(rows[-1]["wear_depth_max (mm)"]) < 1e-3
    assert json.loads(invoke("show", worn, "--json").stdout)["units"]["wear_volume"] == "mm^3"
    assert invoke("export", worn, "--to", "vtk", "--step", -1, "-o", tmp_path / "x.pvd").exit_code == 0
    grids = sorted((tmp_path / "x.vtk").iterdir())
    assert any(b"wear_depth" in grid.read_bytes() for grid in grids)
    assert invoke("export", worn, "--to", "npz", "--step", -1, "-o", tmp_path / "x.npz").exit_code == 0
    with np.load(tmp_path / "x.npz") as archive:
        assert archive["wear_depth"].shape == (1, 24, 24)
        assert archive["wear_volume"][-1] > 0.0
    with open_result(worn) as result:
        assert "wear_depth" in result.to_xarray()


def test_deformed_surfaces_are_worn(result: Result) -> None:
    """In contact both meet, and body 2 has lost its share."""
    last = result.increments - 1
    first, second = DeformedSurfaces(result).at(last)
    touching = np.asarray(result.field("pressure", last)) > 0.0
    gap = (first.points[2] - second.points[2])[touching]
    assert np.abs(gap).max() < 1e-4 * result.history["delta_z"][-1]
    lost = second.displacement[2] - second.points[2]
    np.testing.assert_allclose(lost, 0.75 * np.asarray(result.field("wear_depth", last)), atol=1e-15)


@pytest.mark.parametrize("surface", ["sum", "separation"])
def test_another_case_goes_on_with_the_worn_surfaces(worn: Path, surface: str, tmp_path: Path) -> None:
    """Pressed anew they have the contact that they had, but for what the locked shear adds."""
    heights = tmp_path / "worn.heights.hdf5"
    done = invoke("export", worn, "--to", "heights", "-o", heights)
    assert (done.exit_code, done.stdout) == (0, f"{heights}\n")
    with open_result(worn) as result:
        size = 24.0 * float(np.diff(result.x).mean())
        expected = {name: float(result.history[name][-1]) for name in ("delta_z", "max_pressure", "contact_area")}
    maps = {
        "sum": "[{sphere: {radius: 10 mm}}, {heights: {file: worn.heights.hdf5, dataset: wear_depth}}]",
        "separation": "{heights: {file: worn.heights.hdf5, dataset: separation}}",
    }
    case = CASE.replace("{sphere: {radius: 10 mm}}", maps[surface]).replace("points: 16", f"points: 24, size: {size!r}")
    path = write_case(tmp_path, case.partition("expect:")[0])
    assert invoke("run", path, "-q").exit_code == 0
    with open_result(path.with_suffix(".h5")) as again:
        assert again.history["delta_z"][-1] == pytest.approx(expected["delta_z"], rel=1e-4)
        assert again.history["max_pressure"][-1] == pytest.approx(expected["max_pressure"], rel=1e-3)
        assert again.history["contact_area"][-1] == pytest.approx(expected["contact_area"], rel=0.01)


def test_stresses_are_those_of_the_worn_contact(worn: Path, tmp_path: Path) -> None:
    """Below the surface's middle szz is minus the final pressure, which wear has raised."""
    stresses = tmp_path / "worn.stress.h5"
    done = invoke("stress", worn, "--step", -1, "--depth", 0, "-o", stresses)
    assert done.exit_code == 0, done.output
    with open_result(worn) as result, h5py.File(stresses) as file:
        last = result.increments - 1
        found: list[float] = []
        file.visititems(lambda name, node: found.append(float(np.min(node[()]))) if name.endswith("/zz") else None)
        assert min(found) == pytest.approx(-float(result.field("pressure", last).max()), rel=1e-6)
        assert result.history["max_pressure"][-1] > 1.001 * result.history["max_pressure"][0]


@pytest.mark.slow
def test_a_cycle_between_worn_surfaces_begins_with_its_end(worn: Path, result: Result, tmp_path: Path) -> None:
    """Not with the change of the surfaces, in which the cells that have just come into contact carry no shear."""
    words = ("--material", ROOT / "cases" / "materials" / "ti-6al-4v.yaml", "--criterion", "findley", "--body", 2)
    done = invoke("fatigue", worn, *words, "-o", tmp_path / "worn.fatigue.h5")
    assert (done.exit_code, "not closed" in done.output) == (0, False)
    assert sum(cycle.times for cycle in cycles_of(result)) == result.history["cycles"][-1]
    _, *inside = cycles_of(result)[-1].states
    with h5py.File(tmp_path / "worn.fatigue.h5") as file:
        assert file["fatigue/body_2"].attrs["steps"].tolist() == [inside[-1], *inside]


def test_heights_need_wear_and_its_depth(worn: Path, tmp_path: Path) -> None:
    path = write_case(tmp_path)
    assert invoke("run", path, "-q").exit_code == 0
    out = path.with_suffix(".h5")
    told = refused(2, "export", out, "--to", "heights")
    assert told == f"{out}: nothing is worn, since the case has no wear\n"
    told = refused(2, "export", worn, "--to", "heights", "--step", 1, "--step", 2)
    assert told == f"{worn}: heights are those of one increment; give --step once\n"
    told = refused(2, "export", worn, "--to", "heights", "-o", tmp_path / "x.npy")
    assert told == f"{tmp_path / 'x.npy'}: the name of a heights file must end in .hdf5\n"
    path = write_case(tmp_path, WORN.replace(", wear_depth, wear_depth_1", "").replace("1e4", "2"), "bare.yaml")
    path.write_text(path.read_text().replace(", jump: 5000", ""))
    assert invoke("run", path, "-q").exit_code == 0
    told = refused(2, "export", path.with_suffix(".h5"), "--to", "heights")
    assert told.endswith("the worn depth is not stored; wear_depth in output.fields of the case file stores it\n")


def test_jumps_beyond_the_tolerance_are_warned_of(tmp_path: Path) -> None:
    path = write_case(tmp_path, WORN)
    sets = ("--set", "load_path.2.cycle.represents=200000", "--set", "load_path.2.cycle.jump=150000")
    done = invoke("run", path, "-q", *sets)
    with open_result(path.with_suffix(".h5")) as worn:
        share = worn.history["wear_error"][-1] / worn.history["wear_volume"][-1]
    assert share > 0.01
    assert f"the jumps may have changed wear_volume by {100 * share:.3g} % (wear_error), more than" in done.stderr
    assert "give a smaller jump, or jump: auto" in done.stderr
    # within the tolerance nothing is said
    assert "wear_error" not in invoke("run", path, "-q", "--overwrite").stderr


@pytest.mark.slow
def test_the_error_by_cells_that_stick_is_shown_and_warned_of(tmp_path: Path) -> None:
    path = write_case(tmp_path, WORN)
    done = invoke("run", path, "-q", "--set", "load_path.2.cycle.represents=400000", "--set", "grid.size=1 mm")
    with open_result(path.with_suffix(".h5")) as worn:
        error, volume = error_by_grid(worn), worn.history["wear_volume"][-1]
        by_jumps = worn.history["wear_error"][-1]
        told = " ".join(wear_totals(worn))
    assert error is not None
    assert 0.01 * volume < error < 0.2 * volume
    assert f" mm^3 (± {by_jumps:.1e} by the jumps, ± {error:.1e} by the cells that stick)," in told
    assert f"which may have changed wear_volume by {100 * error / volume:.2g} %; finer cells" in done.stderr


@pytest.mark.parametrize(
    ("surface", "told"),
    [("ellipsoid: {radius_x: 10 mm, radius_y: 12 mm}", "slips 0.0583 mm, 19 %"), ("sphere: {radius: 10 mm}", "19 %")],
)
def test_long_slip_is_warned_of_once_whatever_the_surface(surface: str, told: str, tmp_path: Path) -> None:
    """Closed forms tell of a sphere before the run, the dissipated energy of another surface after it."""
    text = CASE.partition("load_path:")[0].replace("sphere: {radius: 10 mm}", surface) + (
        "wear: {law: energy, alpha: 1e-4 mm^3/J}\nload_path: [{P: 400 N}, {delta_x: 30 um, increments: 1}, {cycle:"
        " {represents: 4, jump: 2, stages: [{delta_x: -30 um, increments: 1}, {delta_x: 30 um, increments: 1}]}}]\n"
    )
    path = write_case(tmp_path, text.replace("points: 16", "points: 16, size: 1.2 mm"))
    done = invoke("run", path, "-q")
    assert done.exit_code == 0, done.output
    assert done.stderr.count("wear: half a cycle slips") == 1
    assert told in done.stderr
    short = path.read_text().replace("30 um", "15 um")
    assert "slips" not in invoke("run", write_case(tmp_path, short, "short.yaml"), "-q").stderr


def test_a_stopped_run_says_about_how_many_increments_there_are(tmp_path: Path, capsys) -> None:
    from fretsolve.cli.run_messages import QuietMessages, TextMessages
    from fretsolve.problem.setup.cost_estimate import expected_increments
    from fretsolve.simulation.accuracy.rounds import first_round

    current = first_round(load_case(write_case(tmp_path, WORN.replace("jump: 5000", "jump: auto"))))
    expected = expected_increments(current.setup)
    assert expected < 200 < current.setup.load_path.increments
    for messages in (TextMessages, QuietMessages):
        messages(current, tmp_path / "worn.h5", 1, resume=False).stopped(7)
        said = capsys.readouterr()
        assert f"stopped with 7 of about {expected} increments saved; to go on: fretsolve run" in said.err
        assert not said.out


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A worn result on a grid beside the middle."""
    text = WORN.replace("points: 24", "points: [12, 10], size: [1.2 mm, 1.1 mm], center: [0.05 mm, -0.02 mm]")
    return result_of(write_case(tmp_path_factory.mktemp("worn"), text))


def test_maps_have_their_place_and_the_worn_separation(out: Path, tmp_path: Path) -> None:
    target = tmp_path / "maps.hdf5"
    with open_result(out) as result:
        step = result.increments - 1
        require_wear(result, step)
        write_heights(result, step, target, exclusive=True)
        depth = result.field("wear_depth", step).astype(float)
        sphere = (result.x[:, None] ** 2 + result.y**2) / 20.0
    assert depth.max() > 0.0
    with h5py.File(target) as file:
        for values in file.values():
            assert values.attrs["units"] == "mm"
            assert values.attrs["spacing"] == pytest.approx((0.1, 0.11))
            assert values.attrs["center"] == pytest.approx((0.05, -0.02))
        np.testing.assert_array_equal(file["wear_depth"], depth)
        np.testing.assert_allclose(file["separation"], sphere + depth, rtol=1e-12)


def test_wear_of_surfaces_that_keep_their_shape_is_told(tmp_path: Path) -> None:
    path = "[{P: 400 N}, {cycle: {times: 3, stages: [{Qx: 36 N, increments: 1}, {Qx: -36 N, increments: 1}]}}]"
    case = CASE[: CASE.index("load_path")] + f"wear: {{law: energy, alpha: {ALPHA} mm^3/mJ}}\nload_path: {path}\n"
    with open_result(result_of(write_case(tmp_path, case))) as worn:
        assert not worn.history["jump"].any()
        volume = worn.history["wear_volume"][-1]
        (told,) = wear_totals(worn)
        assert told.startswith(f"wear {volume:.5g} mm^3, ")
        assert told.endswith("at the deepest place; the surfaces have kept their shape")
        ends = stage_ends(worn.history["stage"])
        assert rows_of_wear(worn, ends).tolist() == ends.tolist()  # the table leaves out none
