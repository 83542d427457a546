"""``fretsolve fatigue``: from a result or its stresses to the worst places."""

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from small_cases import SPHERE, TWO_CYCLES, write_case

from fretsolve import open_result
from fretsolve.post.fatigue.fatigue_file import read_worst
from fretsolve.post.fatigue.ruiz import sliding_in
from fretsolve.post.stress.cycles import cycles_of
from fretsolve.post.stress.tractions import TractionHistory

CASE = TWO_CYCLES.replace("points: 16", "points: 20")
KEYS = "tension_limit=300 MPa,torsion_limit=190 MPa,tensile_strength=700 MPa,yield_stress=500 MPa"
CURVE = "{strength: 900 MPa, strength_exponent: -0.09, ductility: 0.6, ductility_exponent: -0.6}"


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    """A result with two cycles, of four states each."""
    return result_of(write_case(tmp_path_factory.mktemp("fatigue"), CASE, "loop.yaml"))


@pytest.fixture(scope="module")
def stresses(loop):
    """The stresses of its last cycle."""
    target = loop.with_name("loop.stress.h5")
    depths = ["--depth", "0", "--depth", "20um", "--depth", "90um"]
    assert invoke("stress", loop, "--cycle", "last", *depths, "-q", "-o", target).exit_code == 0
    return target


@pytest.mark.slow
def test_all_criteria_from_a_result(loop):
    target = loop.with_name("all.h5")
    names = "crossland,dang-van,findley,mcdiarmid,fatemi-socie,swt"
    result = invoke("fatigue", loop, "--material", KEYS, "--criterion", names, "-o", target, "--window", "0mm")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[0] == "body 2, 13 depths, 5 states:"
    with h5py.File(target) as file:
        group = file["fatigue/body_2"]
        assert group["findley"].dims[0][0].name == "/fatigue/body_2/depth"
        assert group["findley_normal"].shape == (*group["findley"].shape, 3)
        np.testing.assert_allclose(np.linalg.norm(group["findley_normal"], axis=-1), 1.0, rtol=1e-9)
        np.testing.assert_allclose(group["crossland_utilisation"], group["crossland"][()] / 190.0)
        for name in names.replace("-", "_").split(","):
            assert group[name].attrs["worst"] == group[name][()].max() > 0.0
        place = tuple(np.unravel_index(group["findley"][()].argmax(), group["findley"].shape))
        assert group["findley_refined"][place] == 1
        axes = (group[axis][index] for axis, index in zip(("depth", "x", "y"), place, strict=True))
        depth, x, y = axes
        np.testing.assert_allclose(group["findley"].attrs["worst_place"], (x, y, depth))
    assert [path.name for path in loop.parent.glob(".fretsolve*")] == []


def test_lives_from_a_curve_in_a_file(stresses):
    material = stresses.with_name("steel.yaml")
    material.write_text(f"name: steel\nyield_stress: 500 MPa\nstrain_life: {CURVE}\nshear_strain_life: {CURVE}\n")
    target = stresses.with_name("lives.h5")
    result = invoke("fatigue", stresses, "--material", material, "--criterion", "swt,fatemi-socie", "-o", target)
    assert result.stdout.count(", life ") == 2
    with h5py.File(target) as file:
        group = file["fatigue/body_2"]
        assert group["swt_life"].attrs["units"] == "1"
        life = group["swt_life"][()].ravel()[np.argsort(group["swt"][()].ravel())]
        assert (life[1:] <= life[:-1]).all()


def test_averages_lower_the_worst(stresses):
    worst = []
    for average in ((), ("--average", "point:50um"), ("--average", "line:40um"), ("--average", "volume:60um")):
        target = stresses.with_name("average.h5")
        words = ("--material", KEYS, "--criterion", "crossland", "--overwrite", "-q", "-o", target, *average)
        assert invoke("fatigue", stresses, *words).exit_code == 0
        with h5py.File(target) as file:
            worst.append(float(file["fatigue/body_2/crossland"].attrs["worst"]))
            depths = file["fatigue/body_2/depth"][()]
        assert len(depths) == (1 if average else 3)
    assert worst[0] > max(worst[1:])


def test_depths_far_apart_give_a_warning(stresses):
    """The file has 0, 20 and 90 um; the result itself has what an average needs."""
    words = ("--material", KEYS, "--criterion", "crossland", "--overwrite", "-q", "-o", stresses.with_name("gap.h5"))
    done = invoke("fatigue", stresses, *words, "--average", "point:110um")
    assert done.exit_code == 0
    assert "stresses are stored at depths 0.07 mm apart and taken as linear between" in done.stderr
    done = invoke("fatigue", stresses.with_name("loop.h5"), *words, "--average", "line:40um")
    assert (done.exit_code, "taken as linear" in done.stderr) == (0, False)


def test_volumes_for_paraview(stresses, tmp_path):
    """Values lie at their places, and normals point along the z axis of the grid, which is upwards."""
    pyvista = pytest.importorskip("pyvista")
    parameters = tmp_path / "f.h5"
    material = tmp_path / "steel.yaml"
    material.write_text("\n".join(KEYS.replace("=", ": ").split(",")) + f"\nstrain_life: {CURVE}\n")
    words = ("--material", material, "--criterion", "findley,crossland,swt", "-o", parameters, "-q")
    assert invoke("fatigue", stresses, *words).exit_code == 0
    done = invoke("export", parameters, "--to", "vtk")
    assert (done.exit_code, done.stdout) == (0, f"{tmp_path / 'f.pvd'}\n"), done.stderr
    grid = pyvista.read(tmp_path / "f.vtk" / "fatigue_body_2.000010.vtr")
    with h5py.File(parameters) as file:
        group = file["fatigue/body_2"]
        np.testing.assert_allclose(grid.z, -group["depth"][()][::-1], atol=1e-7)
        i, j, depth = 3, 5, 1
        index = i + len(group["x"]) * (j + len(group["y"]) * (len(group["depth"]) - 1 - depth))
        np.testing.assert_allclose(grid.points[index, :2], (group["x"][i], group["y"][j]), rtol=1e-6)
        for name in ("findley", "findley_utilisation", "crossland", "swt", "swt_life"):
            expected = min(float(group[name][depth, i, j]), 3.4e38)
            assert grid[name][index] == pytest.approx(expected, rel=1e-5)
        normal = group["findley_normal"][depth, i, j]
        np.testing.assert_allclose(grid["findley_normal"][index], normal * (1, 1, -1), atol=1e-6)
    assert "fatigue parameters can be exported to vtk, not to csv" in refused(2, "export", parameters, "--to", "csv")
    (tmp_path / "f.pvd").unlink()
    assert "holds grids: --overwrite replaces them" in refused(2, "export", parameters, "--to", "vtk")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--material", "tension_limit=300", "--criterion", "findley"], "--material: torsion_limit: is missing; a pre"),
        (["--material", KEYS.replace("190", "150"), "--criterion", "dang-van"], "= 0.5; a ratio above 0.5 is needed"),
        (["--material", KEYS, "--criterion", "finley"], "--criterion: 'finley' is not a criterion; did you mean 'fi"),
        (["--material", KEYS, "--criterion", "findley", "--average", "ball:1mm"], "'ball:1mm' is not an average; one "),
        (["--material", KEYS, "--criterion", "findley", "--average", "line:-1"], "'-1' is out of range; a length > 0"),
        (["--material", KEYS, "--criterion", "findley", "--average", "line:9um"], "0.009 mm is below a cell; 0.03"),
    ],
)
def test_mistakes(loop, words, message):
    assert message in refused(2, "fatigue", loop, *words, "-o", loop.with_name("none.h5"))
    assert not loop.with_name("none.h5").exists()


def test_mistakes_about_the_file_of_stresses(stresses):
    words = ("--material", KEYS, "--criterion", "findley", "-o", stresses.with_name("none.h5"))
    message = refused(2, "fatigue", stresses, *words, "--average", "line:50um")
    assert "needs depths from 0 to 0.1 mm, the stresses reach from 0 to 0.09 mm" in message
    assert "there are no stresses of body 1, only of body 2" in refused(2, "fatigue", stresses, *words, "--body", "1")
    assert "is the result of a run" in refused(
        2, "fatigue", stresses, *words[:-1], stresses.with_name("loop.yaml").with_suffix(".h5")
    )
    few = stresses.with_name("few.h5")
    assert invoke("stress", stresses.with_name("loop.h5"), "--step", 5, "--step", 6, "-q", "-o", few).exit_code == 0
    assert "no cycle is there whole" in refused(2, "fatigue", few, *words)
    assert "ruiz-1 needs slip, which a file of stresses does not hold" in refused(
        2, "fatigue", stresses, "--material", KEYS, "--criterion", "ruiz_1", "-o", stresses.with_name("none.h5")
    )


def test_a_load_path_without_a_cycle_counts_as_one(tmp_path):
    case = tmp_path / "once.yaml"
    case.write_text(CASE.partition("  - cycle")[0])
    assert invoke("run", case, "-q").exit_code == 0
    done = invoke("fatigue", case.with_suffix(".h5"), "--material", KEYS, "--criterion", "findley", "-q")
    assert done.exit_code == 0, done.stderr
    assert done.stderr.count("the load path has no `cycle`: the whole path counts as one\n") == 1
    words = ("--material", KEYS, "--criterion", "findley", "--cycle", "2", "--overwrite")
    assert "there is no cycle 2; there is one" in refused(2, "fatigue", case.with_suffix(".h5"), *words)


def test_open_cycle_gives_a_warning(loop):
    once, path = loop.with_name("opened.yaml"), CASE.partition("load_path:\n")[0]
    stages = "[{Qx: 100 N, increments: 1}, {Qx: 50 N, increments: 1}]"
    once.write_text(f"{path}load_path:\n  - {{P: 400 N}}\n  - cycle: {{times: 1, stages: {stages}}}\n")
    words = ("--material", KEYS, "--criterion", "crossland", "--average", "point:60um", "-q")
    result = invoke("fatigue", result_of(once), *words)
    assert result.exit_code == 0, result.stderr
    assert "warning: the cycle is not closed" in result.stderr


def test_an_average_of_a_line_contact_is_drawn_over_x(tmp_path):
    case = tmp_path / "line.yaml"
    text = CASE.replace("{sphere: {radius: 10 mm}}", "{cylinder: {radius: 10 mm}}").replace("100 N", "10 N/mm")
    case.write_text("plane: strain\n" + text.replace("400 N", "100 N/mm"))
    assert invoke("run", case, "-q").exit_code == 0
    words = ("fatigue", case.with_suffix(".h5"), "--material", KEYS, "--criterion", "findley", "-q")
    assert invoke(*words, "--average", "point:60um").exit_code == 0
    done = invoke("plot", case.with_suffix(".h5"), "fatigue-map", "-o", tmp_path / "map.png")
    assert (done.exit_code, (tmp_path / "map.png").exists()) == (0, True), done.stderr
    # Parameters of another result are not drawn under this one's title.
    assert invoke("run", case, "-q", "--overwrite", "--set", "friction=0.5").exit_code == 0
    assert "line.fatigue.h5 is not of this result" in refused(2, "plot", case.with_suffix(".h5"), "fatigue-map")
    assert "a file of fatigue parameters, not the result" in refused(4, "plot", tmp_path / "line.fatigue.h5", "map")


def test_a_worst_place_in_the_last_cells_is_marked(tmp_path):
    """Away from a line contact the bulk stress is worse than what is below the contact, and what shear adds to it."""
    case = tmp_path / "bulk.yaml"
    text = CASE.replace("{sphere: {radius: 10 mm}}", "{cylinder: {radius: 10 mm}}").replace("400 N", "100 N/mm")
    for sign in ("", "-"):
        text = text.replace(f"Qx: {sign}100 N,", f"Qx: {sign}18 N/mm, bulk_2: {{xx: {sign}142 MPa}},")
    case.write_text("plane: strain\n" + text)
    assert invoke("run", case, "-q").exit_code == 0
    words = ("fatigue", case.with_suffix(".h5"), "--material", KEYS, "--criterion", "swt", "--average", "point:100um")
    done = invoke(*words, "--window", "all")
    assert done.exit_code == 0, done.stderr
    assert "# in the last cells that were looked at: it may be larger beyond" in done.stdout
    # Beyond the grid there is no traction: the parameter comes from the bulk stress in the end, from above.
    worst = {}
    for window in ("all", "auto", "6mm"):
        out = tmp_path / f"{window}.h5"
        done = invoke(*words, "--window", window, "-o", out)
        assert done.exit_code == 0, done.stderr
        worst[window] = read_worst(out)["swt_max"][0]
    assert "#" not in done.stdout
    with h5py.File(tmp_path / "6mm.h5") as file:
        far = file["fatigue/body_2/swt"][0, [0, -1], 0]
    assert worst["6mm"] > worst["all"]
    np.testing.assert_allclose(far, 142.0**2 * (1.0 - 0.3**2) / 200e3, rtol=0.05)
    assert worst["auto"] == worst["6mm"] > far.max()


def test_fields_that_are_not_stored_where_loads_turn_are_named(tmp_path):
    case = tmp_path / "few.yaml"
    case.write_text(CASE.replace("increments: 2", "increments: 4") + "output: {every: 3}\n")
    assert invoke("run", case, "-q").exit_code == 0
    message = refused(2, "fatigue", case.with_suffix(".h5"), "--material", KEYS, "--criterion", "findley")
    assert "output.every leaves out increments 12, 16, where a stage of the cycle begins or ends" in message


@pytest.mark.parametrize("increments", [3, 8])
def test_a_ramp_has_its_range_from_rest(tmp_path, increments):
    """Far below the contact S = 300 MPa acts alone: SWT is S (S/2)/E, and Crossland's amplitude S/(2 sqrt(3))."""
    path = f"load_path: [{{P: 1 N, bulk_2: {{xx: 300 MPa}}, increments: {increments}}}]\n"
    out = result_of(write_case(tmp_path, SPHERE.replace("points: 16", "points: 8") + path, "ramp.yaml"), "-q")
    assert invoke("stress", out, "--cycle", "last", "--depth", "1mm", "-q").exit_code == 0
    names = ("--material", KEYS, "--criterion", "swt,crossland")
    done = invoke("fatigue", out.with_suffix(".stress.h5"), *names)
    worst = read_worst(out.with_suffix(".fatigue.h5"))
    assert worst["swt_max"][0] == pytest.approx(300 * 150 / 200e3, rel=2e-3)
    weight = 3 * 190 / 300 - 3**0.5
    assert worst["crossland_max"][0] == pytest.approx(150 / 3**0.5 + weight * 100, rel=2e-3)
    assert "its last state differs from its first by 100 % of the range" in done.stderr
    if increments == 8:  # without its first increments the path begins loaded, by 3/8
        assert invoke("stress", out, "--depth", "1mm", "--step", "2:7", "--overwrite", "-q").exit_code == 0
        assert invoke("fatigue", out.with_suffix(".stress.h5"), *names, "--overwrite").exit_code == 0
        swt, _ = read_worst(out.with_suffix(".fatigue.h5"))["swt_max"]
        assert swt == pytest.approx(300 * 150 * 5 / 8 / 200e3, rel=2e-3)


def test_sliding_of_a_ramp_is_from_rest(tmp_path):
    """From rest to one state, the amplitude of slip is half of the slip there."""
    path = "load_path: [{P: 100 N, Qx: 30 N, bulk_2: {xx: 50 MPa}, increments: 1}]\n"
    with open_result(result_of(write_case(tmp_path, SPHERE.replace("0.1", "0.4") + path, "ramp.yaml"), "-q")) as result:
        (cycle,) = cycles_of(result)
        window = slice(0, len(result.x)), slice(0, len(result.y))
        found = sliding_in(TractionHistory(result), cycle, window, (1, 1))
        slip = np.hypot(*result.field("slip", 0)).ravel()
    assert slip.max() > 1e-5
    np.testing.assert_allclose(found.amplitude, 0.5 * slip, rtol=1e-9, atol=1e-15)
    assert found.shear.shape == (2, len(slip))


def test_a_result_that_ends_before_its_path_is_told(tmp_path):
    path = "load_path: [{P: 100 N, increments: 2}, {Qx: 20 N, increments: 4}]\n"
    out = write_case(tmp_path, SPHERE + path, "slide.yaml").with_suffix(".h5")
    assert invoke("run", out.with_suffix(".yaml"), "-q").exit_code == 3
    note = (
        f"{out}: warning: the load path has no `cycle`: the part of it that is there counts as one, not the whole path"
    )
    words = ("--material", KEYS, "--criterion", "crossland", "-q", "--overwrite")
    assert invoke("fatigue", out, *words).stderr.startswith(note)
    assert invoke("crack", out, "-q").stderr.startswith(note)
    assert invoke("stress", out, "--cycle", "last", "--depth", "0", "-q").stderr.startswith(note)
    told = invoke("fatigue", out.with_suffix(".stress.h5"), *words).stderr
    assert told.startswith(note.replace("slide.h5", "slide.stress.h5"))
