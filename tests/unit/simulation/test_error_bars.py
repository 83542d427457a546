"""Error bars: the sum of the errors, and their way through files and commands."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from command_line import invoke
from fake_states import fake_header, fake_states, some_errors
from line_cases import LOAD, SHEAR_FORCE, A, line_case
from small_cases import CASE, case_error, write_case
from solving import DISSIMILAR, SPHERE, build, setup_of

from fretsolve import load_case, open_result
from fretsolve.errors import CaseError
from fretsolve.problem.setup.cost_estimate import estimate
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter
from fretsolve.result.layout import ERRORS, HISTORY, RIG_ERRORS
from fretsolve.result.state import ESTIMATED, State, SummaryErrors
from fretsolve.simulation.error_bars import coarse_runs
from fretsolve.simulation.error_bars.coarse_runs import coarser
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up

COUPLED = CASE.split("expect:")[0].replace("0.3}", "0.1}", 1).replace("increments: 1}", "increments: 4}")
"""A case whose increments matter."""


def with_bars(setup: ProblemSetup, **options: Any) -> list[tuple[State, SummaryErrors]]:
    rows = [(state, state.errors) for state in run_with_error_bars(setup, **options)]
    return [(state, errors) for state, errors in rows if errors is not None]


def test_every_estimated_value_is_one_of_the_history() -> None:
    names = {quantity.name: quantity for quantity in HISTORY}
    assert set(ESTIMATED) <= names.keys()
    for quantity in ERRORS[: len(ESTIMATED)]:
        assert quantity.units == names[quantity.name.removesuffix("_error")].units
        assert quantity.long_name.startswith("estimated error of ")
    assert [quantity.name for quantity in (*ERRORS, *RIG_ERRORS)] == list(SummaryErrors.__dataclass_fields__)


def test_bars_hold_the_errors_of_half_widths_and_middles() -> None:
    """Under bulk stress and a force, against Hills and Nowell; a line contact has no extent along y."""
    path = [{"P": LOAD}, {"Qx": SHEAR_FORCE, "bulk_2": {"xx": 141.9435}, "increments": 10}]
    *_, (state, errors) = with_bars(set_up(line_case(grid={"points": 129}, load_path=path)))
    exact = {
        "contact_half_width_x": A,
        "contact_center_x": 0.0,
        "stick_half_width_x": 0.0680778,
        "stick_center_x": 0.0215281,
    }
    for name, value in exact.items():
        bar = getattr(errors, f"{name}_error")
        assert abs(getattr(state.summary, name) - value) < bar < 0.02 * A, name
    assert math.isnan(errors.stick_center_y_error)


def test_increments_have_their_part_in_the_bar() -> None:
    path = [{"P": 400, "increments": 4}, {"Qx": 30, "increments": 4}]
    rows = with_bars(setup_of(36, bodies=DISSIMILAR, load_path=path))
    fine = [{**stage, "increments": 16} for stage in path]
    few, many = rows[-1], with_bars(setup_of(36, bodies=DISSIMILAR, load_path=fine))[-1]
    assert few[1].work_total_error > 2.0 * many[1].work_total_error
    assert abs(few[0].summary.work_total - many[0].summary.work_total) < few[1].work_total_error
    assert sum(errors.work_error for _, errors in rows) >= 0.5 * few[1].work_total_error


def test_bars_go_on_where_a_run_goes_on() -> None:
    setup = setup_of(bodies=DISSIMILAR, load_path=[{"P": 400, "increments": 3}, {"Qx": 20, "increments": 4}])
    whole = with_bars(setup)
    summaries = [state.summary for state, _ in whole]
    for done in (1, 4):
        resumed = with_bars(setup, start=whole[done - 1][0], history=summaries[:done])
        for (state, errors), (expected, bars) in zip(resumed, whole[done:], strict=True):
            assert state.summary.delta_x == expected.summary.delta_x
            for name in vars(bars).keys() - {"coarse_runs_wall_time"}:
                # NaN stands for the middle of a stick zone that a coarse grid does not show
                unknown = name.startswith("stick_center")
                assert np.array_equal(getattr(errors, name), getattr(bars, name), equal_nan=unknown), name


def test_coarse_run_without_a_solution_leaves_unknown_bars(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = setup_of(load_path=[{"P": 400}, {"Qx": 20, "increments": 3}])

    def slides(one: ProblemSetup, factor: int, counts: tuple[int, ...], *left_out: object) -> ProblemSetup:
        coarse = coarser(one, factor, counts)
        path = build(grid={"points": 8}, load_path=[{"P": 400}, {"Qx": 59, "increments": 3}])
        return replace(coarse, case=path, load_path=set_up(path).load_path.with_counts(counts))

    monkeypatch.setattr(coarse_runs, "coarser", slides)
    told: list[str] = []
    rows = with_bars(setup, warn=told.append)
    assert len(rows) == 4
    assert [math.isnan(errors.delta_x_error) for _, errors in rows] == [False, False, True, True]
    assert len(told) == 1
    # two increments stand for three, so that the second and the third one need the end of the stage
    what = "the coarse run on 8 x 8 cells with 3 increments has no solution: gross slip under Qx = 59 N"
    assert told[0].startswith(f"no error bars from increment 2 on: {what}")
    assert "\n" not in told[0]


def test_surface_that_the_coarse_cells_miss_leaves_unknown_bars(tmp_path: Path) -> None:
    """A map of a small island with nothing around it, which no centre of the coarsest cells meets."""
    heights = np.full((201, 201), np.nan)
    heights[96:105, 96:105] = 0.0
    np.save(tmp_path / "island.npy", heights)
    surface = [SPHERE, {"heights": {"file": str(tmp_path / "island.npy"), "spacing": 4e-3}}]
    setup = set_up(build(surface=surface, friction=0.0, grid={"points": 24, "size": 0.71}, load_path=[{"P": 1.0}]))
    told: list[str] = []
    ((state, errors),) = with_bars(setup, warn=told.append)
    assert state.summary.contact_cells > 0
    assert math.isnan(errors.delta_z_error)
    assert told and "the coarse run on 8 x 8 cells with 1 increment has no solution" in told[0]


def test_an_automatic_area_leaves_room_for_coarse_runs_in_python_too() -> None:
    case = build(
        bodies=["rigid", {"young_modulus": 200e3, "poisson_ratio": 0.2}],
        friction=0.6,
        grid={"points": 24},
        load_path=[{"P": 260.0, "increments": 4}, {"Qx": 109.0, "increments": 4}],
    )
    assert not case.solver.error_bars
    *_, last = run_with_error_bars(case)
    assert last.errors is not None
    assert math.isfinite(last.errors.delta_x_error)


def test_too_few_points_are_refused_at_their_line(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("16", "[32, 15]") + "solver: {error_bars: true}\n")
    what = "32 x 15 are too few for error bars; 16 or more per side are needed"
    assert str(case_error(case)) == f"{case}:6: grid.points: {what}"
    assert load_case(case, ["grid.points=16"]).solver.error_bars
    assert "solver.error_bars: 'maybe' is not allowed" in str(case_error(case, ["solver.error_bars=maybe"]))


def test_memory_and_time_count_the_coarse_runs() -> None:
    plain, barred = (
        estimate(setup_of(2048, solver={"error_bars": asked}, load_path=[{"P": 400}, {"Qx": 20}]))
        for asked in (False, True)
    )
    assert 1.2 * plain.memory < barred.memory < 1.6 * plain.memory
    assert 1.3 * plain.seconds < barred.seconds < 1.6 * plain.seconds


def test_bars_come_with_every_increment_or_none(tmp_path: Path) -> None:
    state = next(fake_states(1))
    with HistoryWriter.open(tmp_path / "a.h5", fake_header()) as writer, pytest.raises(ValueError, match="error bars"):
        writer.append(replace(state, errors=some_errors(0)))
    with HistoryWriter.open(tmp_path / "b.h5", fake_header(errors=True)) as writer, pytest.raises(ValueError):
        writer.append(state)


def test_run_stores_and_shows_them(tmp_path: Path) -> None:
    case, out = write_case(tmp_path), tmp_path / "case.h5"
    ran = invoke("run", case, "--error-bars")
    assert ran.exit_code == 0, ran.stderr
    assert "error bars: coarse runs took" in ran.stdout
    with h5py.File(out) as file:
        column = file["history/delta_x_error"]
        assert (column.attrs["units"], column.shape) == ("mm", (5,))
        assert column.attrs["long_name"] == "estimated error of rigid displacement along x"
        assert column.dims[0][0].name == "/history/step"
    with open_result(out) as result:
        value, error = (float(result.history[name][-1]) for name in ("max_pressure", "max_pressure_error"))
        assert result.effective_case["solver"]["error_bars"] is True
    assert 0.0 < error < 0.05 * value
    shown = [line.split() for line in invoke("show", out).stdout.splitlines()]
    assert ["max_pressure", f"{value:.6g}", "±", f"{error:.1e}", "MPa"] in shown
    assert invoke("run", case, "--error-bars", "--resume").output == f"{out}: already complete, 5 increments\n"
    other = invoke("run", case, "--resume")
    assert other.exit_code == 4
    assert "holds a run with error bars; add --error-bars" in other.output


def test_infinite_pressures_have_no_bound(tmp_path: Path) -> None:
    """The largest pressure of a cone, or of a sharp edge once it is in contact."""
    case = tmp_path / "cone.yaml"
    case.write_text(
        "surface: {cone: {angle: 2 deg}}\nfriction: 0\ngrid: {points: 16}\nload_path: [{P: 100 N}]\n"
        "bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, rigid]\n"
        "solver: {accuracy: {target: 20 %, of: [delta_z, max_pressure]}}\n"
    )
    assert invoke("run", case).exit_code == 0
    out = case.with_suffix(".h5")
    shown = invoke("show", out).stdout
    row = next(line for line in shown.splitlines() if "unbounded" in line)
    assert row.split()[-2:] == ["unbounded", "MPa"]
    assert "accuracy 20 % is not proved: max_pressure is unbounded" in shown
    assert invoke("export", out, "--to", "csv").exit_code == 0
    assert "inf" in out.with_suffix(".csv").read_text().splitlines()[1].split(",")
    assert invoke("plot", out).exit_code == 0
    ball, punch = {"sphere": {"radius": 10.0}}, {"punch": {"radius": 0.2}}
    path = [{"P": 10.0}, {"P": 400.0}]
    grid = {"points": 24, "size": 0.7}
    sharp = set_up(build(surface=[ball, punch], friction=0.0, load_path=path, grid=grid))
    bars = [errors.max_pressure_error for _, errors in with_bars(sharp)]
    assert [np.isfinite(bar) for bar in bars] == [True, False]


def test_corrected_values_are_shown_where_they_differ(tmp_path: Path) -> None:
    case, out = write_case(tmp_path, COUPLED), tmp_path / "case.h5"
    assert invoke("run", case, "--error-bars", "-q").exit_code == 0
    with open_result(out) as result:
        names = ("delta_x", "delta_x_corrected")
        value, corrected = (float(result.history[name][-1]) for name in names)
        errors = [float(result.history[f"{name}_error"][-1]) for name in names]
        assert result.units("delta_x_corrected_error") == "mm"
    assert value != corrected
    assert "corrected for" not in invoke("show", out, "--columns", "P,delta_x_error").stdout
    shown = invoke("show", out).stdout
    assert "corrected for" in shown
    in_um = [1e3 * one for one in (value, errors[0], corrected, errors[1])]
    texts = "delta_x {:.6g} ± {:.1e} {:.6g} ± {:.1e} um".format(*in_um)
    assert texts.split() in [line.split() for line in shown.splitlines()]


def test_values_next_to_nothing_are_marked(tmp_path: Path) -> None:
    """Bars of a torque of 2e-4 P times the radius were 4 times too small."""
    case, out = write_case(tmp_path, COUPLED), tmp_path / "case.h5"

    def marked(phi_z: float) -> tuple[list[str], str]:
        sets = ("--set", "grid.points=24", "--set", f"load_path.1={{phi_z: {phi_z}, increments: 1}}")
        assert invoke("run", case, "--error-bars", "--overwrite", *sets).exit_code == 0
        lines = invoke("show", out).stdout.splitlines()
        return [line.split()[1] for line in lines if line.startswith(" ") and "* " in line], " ".join(lines)

    names, shown = marked(4e-6)
    with open_result(out) as result:
        assert 1e-4 < result.history["Mz"][-1] / (400.0 * result.history["contact_radius"][-1]) < 3e-4
    assert names == ["Mz", "phi_z"]
    assert "* below a thousandth of P times the contact radius or delta_z over the radius: next to nothing" in shown
    names, shown = marked(1e-3)
    assert names == [] and "next to nothing" not in shown


@pytest.mark.slow
def test_study_compares_corrected_values(tmp_path: Path) -> None:
    case = write_case(tmp_path, COUPLED)
    vary = ("--vary", "grid.points=24,36", "--vary", "load_path.*.increments=2,8", "--quantity", "delta_x")
    vary = (*vary, "--quantity", "max_pressure")
    found = {}
    for option in ((), ("--corrected",)):
        folder = tmp_path / f"study{len(option)}"
        ran = invoke("study", case, *vary, *option, "-o", folder)
        assert ran.exit_code == 0, ran.stderr
        assert ("values are corrected for the number of increments" in ran.stdout) == bool(option)
        assert ("but for max_pressure, which no correction helps" in ran.stdout) == bool(option)
        with h5py.File(folder / "study.h5") as file:
            row = list(zip(file["cost/points"][:, 0], file["cost/increments"][:], strict=True)).index((36, 4))
            name = f"delta_x{'_corrected' * bool(option)}@2"
            assert bool(file.attrs["corrected"]) == bool(option)
            assert file[f"values/{name}"].attrs["long_name"] == f"{name[:-2]} (stage 2)"
            found[option] = float(file[f"errors/{name}"][row]), float(file["cost/operator_applications"][row])
    (as_run, cheap), (corrected, costly) = found.values()
    assert corrected < 0.5 * as_run
    assert cheap < costly < 1.8 * cheap
    refusal = invoke("study", case, "--vary", "grid.points=16,20", "--quantity", "delta_x_corrected")
    assert refusal.exit_code == 2
    assert "--quantity delta_x_corrected: corrected values are compared with --corrected; give it" in refusal.stderr


def test_it_is_said_why_there_are_no_bars_and_no_corrected_values(tmp_path: Path) -> None:
    """A map of a small island with nothing around it, which no centre of the coarsest cells of 24 points meets."""
    heights = np.full((201, 201), np.nan)
    heights[92:109, 92:109] = 0.0
    np.save(tmp_path / "island.npy", heights)
    text = COUPLED.replace("16}", "24, size: 0.9 mm}").replace("P: 400", "P: 1").replace("Qx: 20", "Qx: 0.01")
    island = "  - heights: {file: island.npy, spacing: 4 um}\n"
    case = write_case(tmp_path, text.replace("surface: {sphere: ", "surface:\n" + island + "  - {sphere: "))
    ran = invoke("run", case, "--error-bars")
    assert ran.exit_code == 0, ran.stderr
    why = "no error bars from increment 0 (stage 1) on: a coarse run has no solution there; lower loads near"
    assert why in invoke("show", tmp_path / "case.h5").stdout.replace("\n", " ")
    compared = invoke("study", case, "--corrected", "--vary", "grid.points=24,60", "-o", tmp_path / "study")
    assert compared.exit_code == 0, compared.stderr
    assert f"not corrected: 24 x 24: {why}" in compared.stdout
    assert "not corrected: 60" not in compared.stdout


def test_study_makes_its_runs_without_them(tmp_path: Path) -> None:
    case = write_case(tmp_path, COUPLED + "solver: {error_bars: true}\n")
    ran = invoke("study", case, "--vary", "grid.points=16,20", "-o", tmp_path / "study", "-q")
    assert ran.exit_code == 0, ran.stderr
    files = [path for path in (tmp_path / "study").rglob("*.h5") if path.name != "study.h5"]
    results = [open_result(path) for path in files]
    assert len(results) == 2
    for result in results:
        with result:
            assert "delta_x_error" not in result.history


@pytest.mark.parametrize(
    ("parts", "few"), [({"grid": {"points": [24, 12]}}, "24 x 12"), ({"grid": {"points": 12}}, "12 x 12")]
)
def test_too_few_points_for_coarse_runs_are_refused(parts: dict[str, Any], few: str) -> None:
    with pytest.raises(CaseError, match=f"^grid.points: {few} are too few for error bars; 16 or more per side are"):
        next(run_with_error_bars(build(**parts)))
