"""Several cycles: the largest parameter, Miner's rule, blocks, and error bars of values and lives."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import invoke, refused, result_of
from small_cases import TWO_CYCLES, write_case

from fretsolve.post.fatigue.criteria import FatigueField
from fretsolve.post.fatigue.fatigue_file import read_worst
from fretsolve.post.fatigue.over_cycles import OverCycles, miner_life
from fretsolve.post.stress.cycles import LoadCycle

CURVE = "{strength: 900 MPa, strength_exponent: -0.09, ductility: 0.6, ductility_exponent: -0.6}"
STEEL = f"tension_limit: 300 MPa\ntorsion_limit: 190 MPa\nstrain_life: {CURVE}\n"
LARGER = "  - cycle: {times: 1, stages: [{Qx: -150 N, increments: 2}, {Qx: 150 N, increments: 2}]}\n"
NAMES = ("--criterion", "crossland,swt", "--average", "point:60um", "-q")


def cycle(number: int, times: float = 1.0) -> LoadCycle:
    return LoadCycle(number, (0, 1, 2), (0, 2), times)


def test_damage_adds_up_by_miners_rule() -> None:
    """1000 cycles that use up a hundredth of a life and 10 that use up as much: 1010 cycles have damage 0.02."""
    lives = [np.array([1e5, np.inf, np.inf, 0.0]), np.array([1e3, 1e3, np.inf, 1e3])]
    found = miner_life(lives, [cycle(1, 1000.0), cycle(2, 10.0)])
    np.testing.assert_allclose(found, [1010.0 / 0.02, 1010.0 / 0.01, np.inf, 0.0])


def test_the_largest_value_counts_with_its_plane() -> None:
    over = OverCycles()
    for value, normal in (([1.0, 5.0], 0.0), ([2.0, 4.0], 1.0)):
        normals = np.full((3, 2), normal)
        over.add(FatigueField("findley", "MPa", np.array(value), 10.0, normals, np.array([normal > 0.0] * 2)))
    field = over.field([cycle(1), cycle(2)])
    assert field.value.tolist() == [2.0, 5.0]
    assert field.normal is not None
    assert field.refined is not None
    assert (field.normal[0].tolist(), field.refined.tolist()) == ([1.0, 0.0], [True, False])
    assert (field.life, field.limit) == (None, 10.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result with two cycles of 100 N and one of 150 N, the stresses of all, and a material."""
    path = tmp_path_factory.mktemp("blocks")
    (path / "steel.yaml").write_text(STEEL)
    (path / "blocks.csv").write_text("cycle,times\n2,1000\n3,10\n")
    out = result_of(write_case(path, TWO_CYCLES + LARGER, "c.yaml"))
    done = invoke("stress", out, "--cycle", "all", "--depth", "30 um", "-q", "-o", path / "s.h5")
    assert done.exit_code == 0, done.stderr
    return path


def computed(folder: Path, out: str, *words: str, of: str = "c.h5") -> dict[str, tuple[float, float]]:
    done = invoke("fatigue", folder / of, "--material", folder / "steel.yaml", *NAMES, *words, "-o", folder / out)
    assert done.exit_code == 0, done.stderr
    return read_worst(folder / out)


def test_a_block_of_cycles(folder: Path) -> None:
    single = {number: computed(folder, f"{number}.h5", "--cycle", str(number)) for number in (2, 3)}
    block = computed(folder, "block.h5", "--blocks", f"{folder}/blocks.csv")
    for name in ("crossland_max", "swt_max"):
        assert block[name] == single[3][name]
    with (
        h5py.File(folder / "block.h5") as file,
        h5py.File(folder / "2.h5") as second,
        h5py.File(folder / "3.h5") as third,
    ):
        group = file["fatigue/body_2"]
        assert (group["cycle"][()].tolist(), group["times"][()].tolist()) == ([2, 3], [1000.0, 10.0])
        of_cycle = group["swt_worst_of_cycle"]
        assert (of_cycle.dims[0][0].name, of_cycle.attrs["units"]) == ("/fatigue/body_2/cycle", "MPa")
        np.testing.assert_allclose(of_cycle, [single[n]["swt_max"][0] for n in (2, 3)], rtol=1e-12)
        np.testing.assert_allclose(group["swt_life_of_cycle"], [single[n]["swt_life"][0] for n in (2, 3)], rtol=1e-9)
        lives = [one["fatigue/body_2/swt_life"][()] for one in (second, third)]
        both = np.isfinite(lives[0]) & np.isfinite(lives[1])
        expected = 1010.0 / (1000.0 / lives[0][both] + 10.0 / lives[1][both])
        # the point of the shortest life is refined in both cycles
        np.testing.assert_allclose(group["swt_life"][()][both], expected, rtol=0.05)
        assert block["swt_life"][0] == pytest.approx(group["swt_life"][()].min())
        assert single[3]["swt_life"][0] < block["swt_life"][0] < single[2]["swt_life"][0]
        np.testing.assert_allclose(
            group["crossland"], np.maximum(second["fatigue/body_2/crossland"], third["fatigue/body_2/crossland"])
        )


def test_lives_have_bounds_from_the_error_of_the_value(folder: Path) -> None:
    found = computed(folder, "bars.h5", "--cycle", "3")
    value, error = found["swt_max"]
    assert 0.0 < error < 0.5 * value
    with h5py.File(folder / "bars.h5") as file:
        parameter = file["fatigue/body_2/swt"].attrs
        assert (parameter["worst"], parameter["worst_error"]) == (value, error)
        low, high = parameter["shortest_life_range"]
        life = parameter["shortest_life"]
    assert found["swt_life"] == (life, max(life - low, high - life))

    def swt_of(cycles: float) -> float:
        return float(900.0**2 / 200e3 * (2.0 * cycles) ** -0.18 + 900.0 * 0.6 * (2.0 * cycles) ** -0.69)

    assert [swt_of(one) for one in (low, life, high)] == pytest.approx([value + error, value, value - error])


def test_what_is_printed_of_several_cycles(folder: Path) -> None:
    words = ("--material", folder / "steel.yaml", *NAMES[:-1], "--cycle", "all", "-o", folder / "all.h5")
    header, names, *rows, crossland, swt, path = invoke("fatigue", folder / "c.h5", *words).stdout.splitlines()
    assert header == "body 2, 1 depth, 13 states of 3 cycles, point average over 0.06 mm:"
    assert names.split() == ["cycle", "times", "crossland,", "MPa", "swt,", "MPa"]
    assert [row.split()[:2] for row in rows] == [["1", "1"], ["2", "1"], ["3", "1"]]
    assert float(rows[2].split()[2]) > float(rows[1].split()[2])
    assert " ± " in crossland
    assert ", cycle 3" in crossland
    assert ", damage " in swt
    assert "a block, at x = " in swt
    assert path == str(folder / "all.h5")


def test_a_file_of_stresses_knows_its_cycles_but_no_error_bars(folder: Path) -> None:
    words = ("--material", folder / "steel.yaml", "--criterion", "swt", "--blocks", folder / "blocks.csv")
    done = invoke("fatigue", folder / "s.h5", *words, "-o", folder / "of_stresses.h5")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.count("no error bars: they follow from tractions, which the result has") == 1
    assert "±" not in done.stdout
    value, error = read_worst(folder / "of_stresses.h5")["swt_max"]
    assert value > 0.0
    assert np.isnan(error)
    few = ("--material", folder / "steel.yaml", "--criterion", "swt", "-o", folder / "none.h5")
    assert "there is no cycle 4; there are 1 to 3" in refused(2, "fatigue", folder / "s.h5", *few, "--cycle", "4")
    message = "--cycle: --blocks names the cycles; leave --cycle out"
    both = ("--cycle", "all", "--blocks", folder / "blocks.csv")
    assert message in refused(2, "fatigue", folder / "s.h5", *few, *both)
