"""The settings that an accuracy picks, those that it leaves alone, and the messages of a run on it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import invoke, refused
from small_cases import write_case
from solving import DISSIMILAR, build

from fretsolve.case.loading import load_case
from fretsolve.problem.setup.picked_settings import Picks
from fretsolve.result import open_result
from fretsolve.result.verdict import verdict_of
from fretsolve.simulation.problem_setup import set_up

CASE = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {sphere: {radius: 10 mm}}
friction: 0.1
load_path: [{P: 400 N}, {Qx: 30 N, increments: 2}]
output: {fields: []}
"""


def write(folder: Path, accuracy: str, text: str = CASE) -> Path:
    return write_case(folder, f"{text}solver: {{accuracy: {accuracy}}}\n")


def solver(accuracy: object = 0.01, **settings: object) -> dict[str, object]:
    return {"accuracy": accuracy, **settings}


def test_it_picks_what_is_not_given() -> None:
    setup = set_up(build(solver=solver()))
    case = setup.case
    assert setup.grid.nx == setup.grid.ny == case.grid.points[0]
    assert setup.grid.nx % 6 == 0
    assert case.solver.tolerance == 1e-6
    assert case.solver.error_bars
    nx = setup.grid.nx
    assert setup.picked == (f"{nx} x {nx} points", "tolerance 1e-06", "error bars")


def test_settings_that_are_given_win() -> None:
    path = [{"P": 400.0, "increments": 3}]
    given = solver(tolerance=1e-7)
    setup = set_up(build(bodies=DISSIMILAR, grid={"points": [40, 44]}, load_path=path, solver=given))
    assert setup.grid.shape == (40, 44)
    assert setup.load_path.counts == (3,)
    assert setup.case.solver.tolerance == 1e-7
    assert setup.picked == ("error bars",)


def test_without_accuracy_nothing_changes() -> None:
    setup = set_up(build(grid={"points": 16}))
    assert setup.picked == ()
    assert setup.case.effective() == build(grid={"points": 16}).effective()
    assert setup.case.solver.refinement is None


def test_the_first_round_is_coarse_whatever_the_accuracy() -> None:
    setups = [set_up(build(bodies=DISSIMILAR, solver=solver(level))) for level in (0.1, "draft", "standard", 0.002)]
    assert {(setup.grid.shape, setup.load_path.counts) for setup in setups} == {((30, 30), (10,))}
    assert [setup.case.solver.tolerance for setup in setups] == [1e-5, 5e-6, 1e-6, 2e-7]


def test_a_round_has_its_picks() -> None:
    setup = set_up(build(bodies=DISSIMILAR, solver=solver()), picks=Picks((48, 54), 2.0))
    assert (setup.grid.shape, setup.load_path.counts, setup.case.solver.refinement) == ((48, 54), (48,), 2.0)
    assert setup.case.effective()["solver"]["refinement"] == 2.0, "so that the effective case repeats the run"
    given = set_up(
        build(bodies=DISSIMILAR, grid={"points": 20}, solver=solver(refinement=1.0)), picks=Picks((48, 54), 2.0)
    )
    assert (given.grid.shape, given.load_path.counts) == ((20, 20), (24,))


def test_points_follow_the_contact_not_the_area() -> None:
    automatic = set_up(build(solver=solver())).grid
    wide = set_up(build(grid={"size": [2.0 * automatic.size[0], automatic.size[1]]}, solver=solver())).grid
    assert wide.dx == pytest.approx(automatic.dx, rel=0.1)
    assert wide.ny == automatic.ny


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("0", "0 is out of range; a number >= 0.01 % and <= 20 % is needed"),
        ("150 %", "'150 %' is out of range; a number >= 0.01 % and <= 20 % is needed"),
        ("-1 %", "'-1 %' is out of range"),
        ("fast", "'fast' is not allowed; draft, standard, reference or a number such as 1 % is needed"),
        ("1 mm", "'1 mm' is a length; a number such as '0.1' is needed"),
        ("true", "true is not a number"),
        ("[1 %]", "[1 %] is not a number"),
    ],
)
def test_wrong_values(tmp_path: Path, value: str, says: str) -> None:
    assert f"case.yaml:6: solver.accuracy: {says}" in refused(2, "validate", write(tmp_path, value))


def test_without_points_and_accuracy(tmp_path: Path) -> None:
    case = write(tmp_path, "1 %")
    plain = ("--set", "solver={tolerance: 1e-6}")
    told = refused(2, "validate", case, *plain)
    assert "grid: missing; needed: grid of the potential contact area" in told
    told = refused(2, "validate", case, *plain, "--set", "grid.size=1 mm")
    assert "grid.points: missing; needed: cells per side, or [nx, ny], such as 128; or solver" in told
    told = refused(2, "validate", case, "--set", "grid.points=12")
    assert "grid.points: 12 x 12 are too few for the error bars that solver.accuracy takes; 16 or" in told


def test_a_share_may_be_written_in_many_ways(tmp_path: Path) -> None:
    cases = [load_case(write(tmp_path, text)) for text in ("1 %", "1%", "0.01", "standard", '"standard"')]
    assert [case.solver.accuracy.target for case in cases] == [0.01] * 5


def test_run_prints_picks_and_verdict(tmp_path: Path) -> None:
    case, out = write(tmp_path, "draft"), tmp_path / "case.h5"
    ran = invoke("run", case)
    assert ran.exit_code == 0, ran.stderr
    nx = set_up(load_case(case)).grid.nx
    assert f"accuracy 5 % picks {nx} x {nx} points, tolerance 5e-06, error bars" in ran.stdout
    assert "accuracy 5 % is met:" in ran.stdout
    assert "warning: accuracy" not in ran.stderr
    assert "accuracy 5 % is met:" in invoke("show", out).stdout
    with open_result(out) as result:
        assert result.effective_case["grid"]["points"] == [nx, nx]
        assert result.effective_case["solver"]["accuracy"]["target"] == 0.05
        assert json.loads(result.attributes["provenance"])["picked_by_accuracy"][0] == f"{nx} x {nx} points"
        reached = verdict_of(result.effective_case, result.history, result.cycle_columns)
        assert reached.met
    assert invoke("run", case, "--resume").output == f"{out}: already complete, 3 increments\n"


def test_run_warns_of_an_accuracy_that_is_not_met(tmp_path: Path) -> None:
    ran = invoke("run", write(tmp_path, "0.1 %"), "--set", "grid.points=20")
    assert ran.exit_code == 0
    assert "warning: accuracy 0.1 % is not met: " in ran.stderr
    assert " is known to " in ran.stderr
