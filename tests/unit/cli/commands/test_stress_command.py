"""``fretsolve stress``, its pictures and its file."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from command_line import invoke, refused, result_of
from small_cases import CYCLES_UNDER_BULK, write_case

from fretsolve import open_result
from fretsolve.cli.commands import stress
from fretsolve.post.plots import stress_cycle, stress_map
from fretsolve.post.plots.pictures.stresses import SIDE_MARGIN
from fretsolve.post.stress.cycles import cycles_of
from fretsolve.post.stress.influence import COMPONENTS, point_influence
from fretsolve.post.stress.invariants import invariant
from fretsolve.post.stress.stress_file import read_peaks
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.result.state import stage_ends


def test_of_very_many_stages_the_first_and_the_last_ones_count(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stress, "MOST_ENDS", 3)
    monkeypatch.setattr(stress, "FIRST_ENDS", 1)
    with open_result(folder / "case.h5") as result:
        ends = stage_ends(result.history["stage"]).tolist()
    done = invoke("stress", folder / "case.h5", "--depth", "30 um", "-o", tmp_path / "s.h5")
    told = f"of {len(ends)} ends of stages the first 1 and the last 2 are computed; --cycle, --stage or --step choose"
    assert told in done.stderr
    with h5py.File(tmp_path / "s.h5") as file:
        assert file["stress/body_2/step"][:].tolist() == [ends[0], *ends[-2:]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return result_of(write_case(tmp_path_factory.mktemp("stress"), CYCLES_UNDER_BULK)).parent


def test_the_file_opens_in_xarray_and_holds_the_direct_sum(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "s.h5"
    words = (
        "--body",
        1,
        "--body",
        2,
        "--depth",
        "0 mm",
        "--depth",
        "30 um",
        "--stage",
        2,
        "--window",
        "all",
        "-o",
        out,
    )
    done = invoke("stress", folder / "case.h5", *words)
    assert done.exit_code == 0, done.stderr
    assert "largest tension*" in done.stdout
    assert done.stdout.endswith(f"{out}\n")
    with open_result(folder / "case.h5") as result:
        tractions = TractionHistory(result)
        fields = tractions.read(2, (slice(None), slice(None)))
        for body in (1, 2):
            with xarray.open_dataset(out, group=f"stress/body_{body}", engine="h5netcdf") as data:
                assert data["xx"].dims == ("step", "depth", "x", "y")
                assert data["xx"].attrs["units"] == "MPa"
                assert data["depth"].values.tolist() == [0.0, 0.03]
                assert (data["step"].values.tolist(), data["stage"].values.tolist()) == ([2], [2])
                np.testing.assert_array_equal(data["x"], result.x)
                nu = tractions.poisson_ratios[body]
                for place, depth in enumerate((0.0, 0.03)):
                    exact = point_influence(tractions.grid, (result.x[7], result.y[11], depth), nu, body).stress(fields)
                    exact[0] += 50.0 if body == 2 else 0.0
                    found = [float(data[name][0, place, 7, 11]) for name in COMPONENTS]
                    np.testing.assert_allclose(found, exact, rtol=0, atol=2e-4)  # single precision


@pytest.mark.slow
def test_defaults_and_choices(folder: Path, tmp_path: Path) -> None:
    """The ends of all stages, graded depths from the surface on, the contact with a margin."""
    with open_result(folder / "case.h5") as result:
        radius = float(result.history["contact_radius"].max())
        assert cycles_of(result)[-1].states == (4, 5, 6, 7, 8)
    out = tmp_path / "s.h5"
    for words, steps in (
        ((), [0, 2, 4, 6, 8]),
        (("--cycle", "last"), [4, 5, 6, 7, 8]),
        (("--step", -1), [8]),
        (("--step", "3:5"), [3, 4, 5]),
    ):
        done = invoke("stress", folder / "case.h5", *words, "--plane", "y=0", "-o", out, "--overwrite", "-q")
        assert (done.exit_code, done.stdout) == (0, ""), done.stderr
        with h5py.File(out) as file:
            group = file["stress/body_2"]
            assert group["step"][:].tolist() == steps
            assert group["depth"][0] == 0.0
            assert group["depth"][-1] == pytest.approx(2.0 * radius, rel=1e-3)
            assert group["xx"].shape[3] == 1
            side = group["x"][1] - group["x"][0]
            assert group["x"][-1] == pytest.approx(1.5 * radius, abs=4 * side)
    assert sorted(read_peaks(out)["max_tension"]) == [3, 4, 5]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--depth", "-1 um"), "--depth: '-1 um' is negative"),
        (("--depth", "3 N"), "is a force; a length"),
        (("--stage", 9), "there is no stage 9; there are 1 to 5"),
        (("--step", 40), "there is no increment 40"),
        (("--step", "40:50"), "no increment from 40 to 50 has fields"),
        (("--step", "a:b"), "'a:b' is neither an increment such as 21 nor a range such as 21:60"),
        (("--body", 3), "--body: '3' is not one of '1', '2'"),
        (("-o", "s.txt"), "must end in .h5"),
    ],
)
def test_what_is_refused(folder: Path, words: tuple[object, ...], message: str) -> None:
    assert message in refused(2, "stress", folder / "case.h5", *words)


def test_a_shallow_depth_is_warned_of(folder: Path, tmp_path: Path) -> None:
    done = invoke("stress", folder / "case.h5", "--step", 0, "--depth", "1 um", "-o", tmp_path / "s.h5", "-q")
    assert done.exit_code == 0
    assert "warning: at 0.001 mm the stress shows the steps between cells" in done.stderr


def test_existing_files_stay(folder: Path, tmp_path: Path) -> None:
    assert "would replace the result itself" in refused(2, "stress", folder / "case.h5", "-o", folder / "case.h5")
    (tmp_path / "s.h5").write_text("mine")
    assert "exists: --overwrite" in refused(2, "stress", folder / "case.h5", "-o", tmp_path / "s.h5")


def test_what_a_result_may_lack(tmp_path: Path) -> None:
    (tmp_path / "c.yaml").write_text(CYCLES_UNDER_BULK.replace("points: 24", "points: 12"))
    done = invoke("run", tmp_path / "c.yaml", "-q", "--set", "output.fields=[zone]", "--set", "load_path=[{P: 400 N}]")
    assert done.exit_code == 0, done.stderr
    assert "does not hold pressure and shear" in refused(2, "stress", tmp_path / "c.h5")
    rigid = "bodies=[rigid, {young_modulus: 70 GPa, poisson_ratio: 0.5}]"
    words = ("--set", "load_path=[{P: 400 N}]", "--set", rigid, "--overwrite")
    assert invoke("run", tmp_path / "c.yaml", "-q", *words).exit_code == 0
    assert "body 1 is rigid" in refused(2, "stress", tmp_path / "c.h5", "--body", 1)
    done = invoke("stress", tmp_path / "c.h5", "--cycle", "last")
    assert "the load path has no `cycle`: the whole path counts as one" in done.stderr
    assert (done.exit_code, "largest von Mises" in done.stdout) == (0, True), done.stderr


@pytest.mark.slow
def test_pictures(folder: Path, tmp_path: Path) -> None:
    done = invoke("plot", folder / "case.h5", "stress-map", "stress-cycle", "-o", f"{tmp_path}/")
    assert done.exit_code == 0, done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"case.stress-map.png", "case.stress-cycle.png"}
    assert "is off the grid" in refused(
        2, "plot", folder / "case.h5", "stress-cycle", "--at", "9,9", "-o", tmp_path / "a.png"
    )


def test_cells_beyond_the_grid_hold_the_direct_sum(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "s.h5"
    words = ("--depth", 0, "--depth", "30 um", "--stage", 2, "--window", "0.4 mm", "-o", out, "-q")
    assert invoke("stress", folder / "case.h5", *words).exit_code == 0
    with h5py.File(out) as file, open_result(folder / "case.h5") as result:
        group, tractions = file["stress/body_2"], TractionHistory(result)
        step, x, y = int(group["step"][0]), group["x"][:], group["y"][:]
        assert x[0] < result.x[0] - 0.2
        assert y[-1] > result.y[-1] + 0.2
        np.testing.assert_allclose(np.diff(x), tractions.grid.dx, rtol=1e-9)
        assert abs(x - result.x[3]).min() < 1e-12
        loads = tractions.read(step, (slice(None), slice(None)))
        for place, depth in enumerate(group["depth"][:]):
            for i, j in ((0, 0), (0, len(y) // 2), (len(x) - 1, 2)):
                influence = point_influence(tractions.grid, (x[i], y[j], depth), tractions.poisson_ratios[2], 2)
                exact = influence.stress(loads)
                exact[[0, 1, 3]] += tractions.bulk_stress(2, step)
                found = [group[name][0, place, i, j] for name in COMPONENTS]
                np.testing.assert_allclose(found, exact, rtol=1e-5, atol=1e-5)
    for wrong, message in (("wide", "'wide'"), ("-1 mm", "is negative; a margin around the contact is needed")):
        assert message in refused(2, "stress", folder / "case.h5", "--window", wrong, "-o", tmp_path / "t.h5")
    words = ("--material", "tension_limit=300 MPa,torsion_limit=190 MPa", "--criterion", "findley", "--window", "1mm")
    assert "--window has no effect on a file of stresses" in refused(2, "fatigue", out, *words)


@pytest.mark.slow
def test_pictures_of_either_body(folder: Path, tmp_path: Path) -> None:
    with open_result(folder / "case.h5") as result:
        last = result.steps[-1]
        margin = f"{SIDE_MARGIN * float(result.history['contact_radius'][last])!r} mm"
        maps = {body: stress_map(result, body=body) for body in (1, 2)}
        cycles = {body: stress_cycle(result, body=body, at=(0.05, 0.0)) for body in (1, 2)}
    assert maps[1].axes[0].get_ylim() == maps[2].axes[0].get_ylim()[::-1]
    assert maps[1].axes[0].get_ylabel().replace("\n", " ") == "depth (mm)"
    # The section is that of the body: its stresses on the surface, which is row 0, are those of the file.
    for body, figure in maps.items():
        out = tmp_path / f"{body}.h5"
        words = ("--body", body, "--depth", 0, "--step", last, "--window", margin, "-o", out, "-q")
        assert invoke("stress", folder / "case.h5", *words).exit_code == 0
        with h5py.File(out) as file:
            group = file[f"stress/body_{body}"]
            row = int(np.abs(group["y"][:]).argmin())
            stress = np.array([group[name][0, 0, :, row] for name in COMPONENTS])
        drawn = np.asarray(figure.axes[0].collections[0].get_array()).reshape(-1, stress.shape[-1])[0]
        np.testing.assert_allclose(drawn, invariant("mises", stress), rtol=1e-5)
    # Bulk stress is that of body 2 alone.
    xx = {body: figure.axes[0].lines[0].get_ydata() for body, figure in cycles.items()}
    assert not np.allclose(xx[1], xx[2])
    assert "body 1 at x" in cycles[1].get_suptitle()
    done = invoke("plot", folder / "case.h5", "stress-map", "--body", 1, "-o", tmp_path / "one.png")
    assert done.exit_code == 0, done.stderr
    assert "--body has no effect on loop; leave it out" in refused(2, "plot", folder / "case.h5", "loop", "--body", 1)


def test_damaged_files(tmp_path: Path) -> None:
    path = tmp_path / "x.h5"
    with h5py.File(path, "w") as file:
        file.create_group("stress/body_2")
    assert "has no header with a checksum" in refused(4, "export", path, "--to", "vtk")


def test_a_sharp_edge_has_no_largest_stress(tmp_path: Path) -> None:
    """Neither a value that is extrapolated to cells of no size, nor an error bar."""
    case = tmp_path / "punch.yaml"
    text = CYCLES_UNDER_BULK.replace("{sphere: {radius: 10 mm}}", "{punch: {radius: 0.3 mm}}").partition("  - cycle")[0]
    case.write_text(text + "  - {Qx: 50 N, increments: 1}\n")
    assert invoke("run", case, "-q").exit_code == 0
    done = invoke("stress", case.with_suffix(".h5"), "--stage", 2)
    assert done.exit_code == 0, done.stderr
    assert "largest tension!" in done.stdout
    assert "±" not in done.stdout.splitlines()[2]
    assert "! on these cells; at a sharp edge or tip stress grows without bound" in done.stdout
    assert read_peaks(tmp_path / "punch.stress.h5")["max_tension"][1][1] == np.inf
