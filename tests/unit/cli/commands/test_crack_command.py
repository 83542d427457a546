"""``fretsolve crack`` and `output.crack`: what is printed, stored and refused."""

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of

from fretsolve import open_result
from fretsolve.post.crack.crack_file import crack_bodies, read_crack
from fretsolve.post.stress.computed_file import opened_computed

CASE = """\
title: crack
plane: strain
bodies: [{young_modulus: 70 GPa, poisson_ratio: 0.33}, {young_modulus: 70 GPa, poisson_ratio: 0.33}]
surface: {cylinder: {radius: 10 mm}}
grid: {points: 144, size: 0.5 mm}
friction: 0.75
load_path:
  - {P: 50 N/mm}
  - cycle:
      times: 2
      stages: [{Qx: 20 N/mm, bulk_2: {xx: 60 MPa}, increments: 3}, {Qx: -20 N/mm, bulk_2: {xx: -60 MPa}, increments: 3}]
"""
PUNCH = CASE.replace("cylinder: {radius: 10 mm}", "punch: {half_width: 0.2 mm}")
MATERIAL = """\
threshold_range: 2.1 MPa m^0.5
fatigue_range: 248 MPa
paris: {coefficient: 1e-11, exponent: 3}
toughness: 30 MPa m^0.5
strain_life: {strength: 1015 MPa, strength_exponent: -0.11, ductility: 0.21, ductility_exponent: -0.52}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the result of the case and the file of a material."""
    found = tmp_path_factory.mktemp("crack")
    (found / "c.yaml").write_text(CASE)
    (found / "m.yaml").write_text(MATERIAL)
    result_of(found / "c.yaml")
    return found


@pytest.fixture
def crack(folder, tmp_path):
    """A function that looks at the crack of the result and returns what is printed, and the body in the file."""

    def of(*words):
        target = tmp_path / "x.h5"
        done = invoke("crack", folder / "c.h5", "-o", target, "--overwrite", *words)
        assert done.exit_code == 0, done.output
        with opened_computed(target) as computed:
            (body,) = crack_bodies(computed).values()
        return done, body

    return of


def test_all_is_printed_and_stored(folder, crack):
    done, body = crack("--material", folder / "m.yaml", "--thickness", "5 mm")
    out = done.stdout
    assert "edge of contact" in out
    assert "Paris's C = 1e-11 m/cycle/(MPa m^0.5)^3" in out
    assert "arrests at b = " in out
    assert "K_II is an upper bound" in out
    assert body.verdict == "arrests"
    arrest = body.values["arrest_length"]
    at_arrest = [np.interp(arrest, body.lengths, body.columns[name]) for name in ("range", "threshold")]
    assert at_arrest[0] == pytest.approx(at_arrest[1], rel=2e-3)
    ratios = body.lengths[1:] / body.lengths[:-1]
    np.testing.assert_allclose(ratios, 10.0 ** (1.0 / 30.0))
    half_width = body.values["half_width"]
    assert body.lengths[0] == pytest.approx(0.001 * half_width)
    assert body.lengths[-1] > 5.0 * half_width
    assert body.columns["K_I"].shape == (len(body.steps), len(body.lengths)) == body.columns["K_II"].shape
    assert (body.columns["K_error"] > 0.0).all()
    table = [line for line in out.splitlines() if line.startswith("   ")]
    assert len(table) == 8
    assert max(map(len, table)) <= 120
    assert (
        body.columns["K_I"].max(axis=0) - np.maximum(body.columns["K_I"].min(axis=0), 0.0) <= body.columns["range"]
    ).all()
    assert body.columns["K_I"].min() < 0.0
    total = body.columns["initiation_life"] + body.columns["propagation_life"]
    np.testing.assert_array_equal(body.columns["total_life"], total)
    assert np.isinf(body.columns["propagation_life"][body.lengths < arrest]).all()


def test_lives_beyond_the_end_are_unknown(folder, crack):
    done, body = crack("--material", folder / "m.yaml", "--final-length", "0.5 mm")
    beyond = body.lengths >= 0.5
    assert beyond.any()
    for name in ("propagation_life", "total_life"):
        np.testing.assert_array_equal(np.isnan(body.columns[name]), beyond)
    assert not np.isnan(body.columns["initiation_life"]).any()
    assert "warning" not in done.stderr
    assert "not closed" not in done.stderr


@pytest.mark.slow
def test_the_least_life_may_begin_at_the_shortest_crack(folder, crack, tmp_path):
    text = MATERIAL.replace("coefficient: 1e-11", "coefficient: 1e-3").replace(
        "threshold_range: 2.1", "threshold_range: 0.1"
    )
    (tmp_path / "fast.yaml").write_text(text)
    done, body = crack("--material", tmp_path / "fast.yaml", "--final-length", "0.5 mm")
    assert body.values["initiation_length"] == body.lengths[0]
    assert "  that is the shortest crack looked at: the life may be less\n" in done.stdout
    assert "may be less" not in crack("--material", folder / "m.yaml")[0].stdout


def test_too_little_memory(folder, tmp_path, monkeypatch):
    monkeypatch.setattr("fretsolve.post.crack.stress_line.machine_memory", lambda: 1e4)
    message = refused(2, "crack", folder / "c.h5", "-o", tmp_path / "y.h5")
    assert "the tractions of 7 increments take " in message
    assert "GB of memory, this machine has 1e-05 GB; fewer cycles, or a larger output.every in the case" in message


@pytest.mark.slow
def test_the_row_of_a_crack_below_a_sphere(folder, tmp_path):
    surface = CASE.replace("plane: strain\n", "").replace("cylinder", "sphere").replace("points: 144", "points: 16")
    (tmp_path / "s.yaml").write_text(surface.replace("N/mm", "N"))
    out, middle = result_of(tmp_path / "s.yaml"), "the stress is that of the row through the middle of the contact"
    assert middle in invoke("crack", out, "--overwrite").stdout
    done = invoke("crack", out, "--overwrite", "--material", folder / "m.yaml", "--at", "max")
    assert done.exit_code == 0, done.output
    assert middle not in done.stdout
    assert "the stress is that of the row through the place: K is an estimate" in done.stdout


def test_axes_and_units(folder, crack, tmp_path):
    crack("--material", folder / "m.yaml")
    with h5py.File(tmp_path / "x.h5") as file:
        group = file["crack/body_2"]
        assert [group["K_I"].dims[axis][0].name for axis in (0, 1)] == ["/crack/body_2/step", "/crack/body_2/length"]
        units = {name: group[name].attrs["units"] for name in ("length", "K_II", "range", "threshold", "total_life")}
        assert list(units.values()) == ["mm", "MPa m^0.5", "MPa m^0.5", "MPa m^0.5", "1"]
        assert group["range"].dims[0][0].name == "/crack/body_2/length"
    with open_result(folder / "c.h5") as result:
        found = read_crack(tmp_path / "x.h5", result)
    assert 0.0 < found["crack_arrest_length"][1] < 0.2 * found["crack_arrest_length"][0]
    assert found["crack_life"][0] > 0.0
    assert np.isnan(read_crack(tmp_path / "none.h5")["crack_life"]).all()


def test_what_is_missing_is_left_out(folder, crack):
    done, body = crack()
    lines = [line.strip() for line in done.stdout.splitlines() if "lacks" in line]
    assert lines == [
        "no verdict: the material lacks threshold_range and fatigue_range",
        "no propagation and total life: the material lacks paris",
        "no initiation and total life: the material lacks strain_life or shear_strain_life",
    ]
    assert {"range", "K_I"} <= set(body.columns)
    assert not {"threshold", "initiation_life", "propagation_life", "total_life"} & set(body.columns)
    assert body.verdict is None
    assert "arrest_length" not in body.values
    (folder / "part.yaml").write_text(MATERIAL.replace("toughness: 30 MPa m^0.5\n", "") + "yield_stress: 500 MPa\n")
    done, _ = crack("--material", folder / "part.yaml", "--criterion", "fatemi-socie")
    assert "toughness of the material, or a final length, is missing" in done.stdout
    assert "no initiation and total life: the material lacks shear_strain_life" in done.stdout


@pytest.mark.slow
def test_cycles_and_blocks(folder, crack, tmp_path):
    (tmp_path / "b.csv").write_text("cycle,times\n1,1000\n2,1\n")
    words = ("--material", folder / "m.yaml", "--final-length", "0.05 mm")
    done, body = crack(*words, "--blocks", tmp_path / "b.csv", "--at", "max")
    assert "largest swt parameter on the surface" in done.stdout
    assert "cycle 1, 1000 times: range" in done.stdout
    assert "cycle 2, 1 time: range" in done.stdout
    assert body.cycles.tolist() == [1, 2]
    assert body.columns["cycle_range"].shape == (2, len(body.lengths))
    np.testing.assert_array_equal(body.columns["range"], body.columns["cycle_range"].max(axis=0))
    _, one = crack(*words, "--cycle", "1")
    assert len(one.steps) < len(body.steps)
    assert one.values["final_length"] == 0.05
    message = refused(2, "crack", folder / "c.h5", "-o", tmp_path / "y.h5", "--cycle", "7")
    assert message == "--cycle: there is no cycle 7; there are 1 to 2\n"
    both = ("--cycle", "1", "--blocks", tmp_path / "b.csv")
    assert "--blocks names the cycles; leave --cycle out" in refused(2, "crack", folder / "c.h5", *both)


def test_a_long_crack_in_a_thin_body(folder, crack):
    done, _ = crack("--material", folder / "m.yaml", "--thickness", "0.1mm")
    assert "more than a tenth of the thickness 0.1 mm" in done.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("--at", "0.3mm"),
            "--at: 0.3 mm is outside of the grid; edge, max, or a place from -0.25 to 0.25 mm is needed",
        ),
        (("--at", "3 N"), "; edge, max, or x of the crack such as -0.1mm is needed"),
        (("--at", "max"), "which needs strain_life or shear_strain_life of the material; it has none"),
        (("--final-length", "0.1 um"), "--final-length: 0.0001 mm is out of range; a length above"),
        (("--thickness", "0mm"), "--thickness: '0mm' is out of range; a length > 0 mm is needed"),
        (("--material", "fatigue_rnge=3 MPa"), "unknown key 'fatigue_rnge'; did you mean 'fatigue_range'?"),
        (("--cycle", "first"), "--cycle: 'first' is no cycle; last, all, or a number from 1 on is needed"),
        (("-o", "x.txt"), "x.txt"),
    ],
)
def test_refused_options(folder, tmp_path, words, message):
    assert message in refused(
        2, "crack", folder / "c.h5", *(() if "-o" in words else ("-o", tmp_path / "y.h5")), *words
    )
    assert not (tmp_path / "y.h5").exists()


def test_a_coefficient_of_a_wrong_dimension(folder):
    (folder / "wrong.yaml").write_text(MATERIAL.replace("1e-11", "1e-11 MPa"))
    message = refused(2, "crack", folder / "c.h5", "--material", folder / "wrong.yaml")
    assert "wrong.yaml:3: paris.coefficient: '1e-11 MPa' is not a coefficient of Paris's law" in message


def test_the_sharp_edge_of_a_punch(tmp_path):
    (tmp_path / "p.yaml").write_text(PUNCH)
    result_of(tmp_path / "p.yaml")
    for at, what in (("edge", "the sharp edge of the punch"), ("0.201 mm", "the sharp edge of the punch")):
        message = refused(2, "crack", tmp_path / "p.h5", "--at", at)
        assert what in message
        assert "stress is infinite" in message
        (tmp_path / "q.yaml").write_text(PUNCH + f"output: {{crack: {{at: {at}}}}}\n")
        assert "q.yaml:12: output.crack.at: " in refused(2, "run", tmp_path / "q.yaml")
    assert invoke("crack", tmp_path / "p.h5", "--at", "0.1 mm").exit_code == 0


def test_the_whole_path_is_a_cycle_without_one(tmp_path):
    path = CASE[: CASE.index("load_path")] + "load_path: [{P: 50 N/mm}, {Qx: 20 N/mm, increments: 2}]\n"
    (tmp_path / "w.yaml").write_text(path)
    done = invoke("crack", result_of(tmp_path / "w.yaml"))
    assert "the load path has no `cycle`: the whole path counts as one" in done.stderr
    assert "the whole load path is not closed: its last state differs from its first by" in done.stderr
    assert "a service that repeats it needs a path that ends as it begins, or a `cycle`" in done.stderr
    assert "more cycles" not in done.stderr
    (tmp_path / "s.yaml").write_text(path.replace(", increments: 2", ", increments: 1"))
    message = refused(2, "crack", result_of(tmp_path / "s.yaml"))
    assert "the whole load path has 2 stored states; 3 or more are needed" in message


@pytest.fixture(scope="module")
def ramps(tmp_path_factory):
    """Results of one ramp of all loads in 3 and in 30 increments."""
    folder, found = tmp_path_factory.mktemp("ramps"), []
    for increments in (3, 30):
        path = f"load_path: [{{P: 50 N/mm, Qx: 20 N/mm, bulk_2: {{xx: 60 MPa}}, increments: {increments}}}]\n"
        (folder / f"r{increments}.yaml").write_text(CASE[: CASE.index("load_path")].replace("144", "96") + path)
        found.append(result_of(folder / f"r{increments}.yaml", "-q"))
    return found


@pytest.mark.slow
def test_a_ramp_has_its_range_from_rest(ramps):
    """Below b = a, the shear at the edge depends on the increments by more than K_I's error bar of one solution."""
    found, material = [], ramps[0].with_name("m.yaml")
    material.write_text(MATERIAL.replace("2.1 MPa", "1 MPa").replace("248 MPa", "100 MPa"))
    for out in ramps:
        done = invoke("crack", out, "--material", material)
        assert "the whole load path is not closed: its last state differs from its first by 100 % of" in done.stderr
        with opened_computed(out.with_suffix(".crack.h5")) as computed:
            found.extend(crack_bodies(computed).values())
    few, many = found
    wide = few.lengths >= 0.127  # mm, a
    apart = np.abs(few.columns["range"] - many.columns["range"])
    assert (apart <= few.columns["range_error"] + many.columns["range_error"])[wide].all()
    for one in found:
        np.testing.assert_allclose(one.columns["range"], one.columns["K_I"].max(axis=0))
        assert one.verdict == "goes through"
    lives = [one.columns["initiation_life"][(few.lengths > 0.3) & (few.lengths < 0.5)] for one in found]
    np.testing.assert_allclose(*lives, rtol=0.05)  # 3 increments alone give none
    places = []
    for out in ramps:
        done = invoke("crack", out, "--material", material, "--at", "max", "--overwrite")
        places.append(float(done.stdout.partition("x = ")[2].partition(",")[0]))
    assert places[0] == pytest.approx(places[1], abs=0.006)  # a cell


def test_a_case_asks_for_a_crack(folder, tmp_path):
    (tmp_path / "m.yaml").write_text(MATERIAL)
    (tmp_path / "c.yaml").write_text(CASE + "output: {crack: {material: m.yaml}}\n")
    done = invoke("run", tmp_path / "c.yaml")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.endswith(f"{tmp_path / 'c.crack.h5'}\n")
    assert "crack:" in invoke("validate", tmp_path / "c.yaml").stdout
    with open_result(tmp_path / "c.h5") as result:
        assert read_crack(tmp_path / "c.crack.h5", result)["crack_arrest_length"][0] > 0.0
    before = (tmp_path / "c.crack.h5").stat().st_mtime_ns
    assert invoke("run", tmp_path / "c.yaml", "--resume", "-q").exit_code == 0
    assert (tmp_path / "c.crack.h5").stat().st_mtime_ns == before
    assert "a crack, not the result that it was" in refused(4, "show", tmp_path / "c.crack.h5")
    assert "a crack cannot be exported" in refused(2, "export", tmp_path / "c.crack.h5", "--to", "vtk")
    assert "was not computed from" in refused_reading(tmp_path / "c.crack.h5", folder / "c.h5")


def refused_reading(path, out):
    with open_result(out) as result, pytest.raises(Exception) as error:
        read_crack(path, result)
    return str(error.value)


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("output.crack.at=1 mm", "output.crack.at: 1 mm is outside of the grid"),
        (
            "output.crack.at=max",
            "output.crack.at: max is where a fatigue parameter is largest, which needs strain_life",
        ),
        (
            "output.crack={thickness: 5 mm, final_length: 6 mm}",
            "output.crack.final_length: 6 mm is more than the thickness 5 mm of the body; a shorter length is needed",
        ),
        ("output.crack.cycle=3", "output.crack.cycle: there is no cycle 3; there are 1 to 2"),
        ("output.crack.blocks={1: 5, 4: 2}", "output.crack.blocks: there is no cycle 4; there are 1 to 2"),
        ("output.every=3", "output.every: output.every leaves out increments 6, 9, where a stage of the cycle begins"),
    ],
)
def test_refused_before_the_run(tmp_path, key, message):
    (tmp_path / "c.yaml").write_text(CASE)
    for command in ("run", "validate"):
        assert message in refused(2, command, tmp_path / "c.yaml", "--set", "output.crack={}", "--set", key)


def test_damage_is_found(folder, crack, tmp_path):
    crack()
    with h5py.File(tmp_path / "x.h5", "r+") as file:
        file["crack/body_2/K_I"][1, 3] += 1.0
    with pytest.raises(Exception, match="K_I must hold what the header says, it was changed"):
        read_crack(tmp_path / "x.h5")
