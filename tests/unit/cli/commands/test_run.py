"""``fretsolve run``: what it prints, where the result goes, and how it ends."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_line import invoke, python, refused, saved_steps
from small_cases import CASE, write_case

from fretsolve import load_case, open_result
from fretsolve.cli.run_messages import COMPILING
from fretsolve.problem.setup.cost_estimate import estimate
from fretsolve.result.layout import HISTORY
from fretsolve.result.parts import parts_folder
from fretsolve.simulation.problem_setup import set_up
from fretsolve.system.environment import available


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, str]:
    """Result, output and messages of one run."""
    case = write_case(tmp_path_factory.mktemp("solved"))
    result = invoke("run", case)
    assert result.exit_code == 0, result.stderr
    return case.with_suffix(".h5"), result.stdout, result.stderr


def test_introduces_the_case_first(solved: tuple[Path, str, str]) -> None:
    out, output, messages = solved
    lines = output.splitlines()
    assert lines[:2] == ["tiny", f"result: {out}"]
    assert re.match(r"normal problem +on +the bodies", lines[2])
    assert re.match(r"tangential problem +on +the load path moves Qx", lines[3])
    assert re.match(r"between pressure and shear +off +Dundurs' constant is 0", lines[5])
    assert re.match(r"slip and dissipated energy +on +shear may cause slip", lines[6])
    assert lines[7] == "grid: 16 x 16 cells of 0.04517 x 0.04517 mm on 0.7227 x 0.7227 mm (auto)"
    assert lines[8] == "5 increments"
    assert messages.count("\n") == 1
    assert "warning: grid.points: only 13.3 cells across the contact" in messages


def test_progress_is_one_parsable_line_per_increment(solved: tuple[Path, str, str]) -> None:
    out, output, _ = solved
    lines = [line for line in output.splitlines() if line.startswith("step=")]
    rows = [dict(word.split("=") for word in line.split()) for line in lines]
    assert [int(row["step"]) for row in rows] == [0, 1, 2, 3, 4]
    assert [int(row["stage"]) for row in rows] == [1, 2, 2, 2, 2]
    assert {(row["increments"], row["stages"]) for row in rows} == {("5", "2")}
    with open_result(out) as result:
        found = [int(row["iterations_tangential"]) for row in rows]
        np.testing.assert_array_equal(found, result.history["iterations_tangential"])
        np.testing.assert_allclose([float(row["work_total"]) for row in rows], result.history["work_total"], 1e-5)
    assert all(0.0 < float(row["residual"]) <= 1e-6 for row in rows)


def test_ends_with_the_stages_and_the_place_of_the_result(solved: tuple[Path, str, str]) -> None:
    out, output, _ = solved
    lines = output.splitlines()
    assert lines[-1] == f"complete: {out}, 5 increments"
    table = output[output.index("─") :].splitlines()
    assert [line.split()[:4] for line in table[1:3]] == [["0", "1", "400", "0"], ["4", "2", "400", "20"]]
    assert "worst residual" in output
    assert "of wall time" in output


def test_result_tells_what_made_it(solved: tuple[Path, str, str]) -> None:
    out, _, _ = solved
    with open_result(out) as result:
        assert result.status == "complete"
        assert result.case_yaml == CASE
        assert result.effective_case["solver"]["tolerance"] == 1e-6
        provenance = json.loads(result.attributes["provenance"])
        assert result.fields == ("pressure", "shear_x", "shear_y", "slip_x", "slip_y", "zone")
        assert len(result.x) == 16
        assert result.x[-1] + result.x[0] == 0.0
    assert (provenance["threads"], provenance["precision"]) == (1, "double")
    assert {"python", "numpy", "scipy", "pyfftw", "h5py", "platform"} <= provenance.keys()


def test_set_and_threads_and_output(tmp_path: Path) -> None:
    case, out = write_case(tmp_path), tmp_path / "other.h5"
    words = ("--set", "grid.points=[12, 10]", "--set", "load_path.1.increments=2", "--threads", 2)
    result = invoke("run", case, "-o", out, *words)
    assert result.exit_code == 0, result.stderr
    assert saved_steps(result.stdout) == [0, 1, 2]
    assert not case.with_suffix(".h5").exists()
    with open_result(out) as found:
        assert (len(found.x), len(found.y)) == (12, 10)
        provenance = json.loads(found.attributes["provenance"])
    assert provenance["threads"] == available(2)
    assert provenance["overrides"] == ["grid.points=[12, 10]", "load_path.1.increments=2"]


def test_result_that_exists_is_not_touched(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    out = case.with_suffix(".h5")
    assert invoke("run", case, "-q").exit_code == 0
    before = out.read_bytes()
    told = f"{out}: exists: --overwrite replaces it, --resume goes on unless it is complete\n"
    assert refused(2, "run", case) == told
    resumed = invoke("run", case, "--resume")
    assert (resumed.exit_code, resumed.output) == (0, f"{out}: already complete, 5 increments\n")
    told = refused(4, "run", case, "--resume", "--set", "friction=0.2")
    assert "friction.coefficient is 0.1 there, 0.2 now" in told
    assert out.read_bytes() == before
    replaced = invoke("run", case, "-q", "--overwrite", "--set", "friction=0.2")
    assert replaced.exit_code == 0
    assert out.read_bytes() != before


def test_sliding_keeps_the_certified_increments(tmp_path: Path) -> None:
    case, out = write_case(tmp_path, CASE.replace("20 N", "50 N")), tmp_path / "case.h5"
    result = invoke("run", case)
    assert result.exit_code == 3
    first, *_, last = result.stderr.splitlines()
    assert first.startswith(f"{case}: warning: stage.2.Qx: 50 N is not below the 40 N (mu P) that friction carries")
    assert last.startswith(f"{case}:10: stage.2.Qx: gross slip under Qx = 50 N")
    assert result.stdout.endswith(f"failed: {out}, 4 increments\n")
    with open_result(out) as found:
        assert (found.status, found.increments) == ("failed", 4)
        assert found.attributes["failure"] == last
    assert invoke("show", out).exit_code == 0


def test_contact_at_the_grids_edge_advises_a_size(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("{points: 16}", "{points: 16, size: 0.4 mm}"))
    result = invoke("run", case)
    assert result.exit_code == 3
    first, *_, last = result.stderr.splitlines()
    assert first.startswith(f"{case}: warning: grid.size: the contact comes near the grid's edge or reaches it; [0.723")
    assert last.startswith(f"{case}:6: grid.size: the contact reaches the edge")
    advised = re.search(r"size: (\[.* mm\]) would do", result.stderr)
    assert advised is not None
    enlarged = invoke("run", case, "-q", "--overwrite", "--set", f"grid.size={advised[1]}")
    assert enlarged.exit_code == 0, enlarged.output


def test_not_converged_goes_on_with_more_iterations(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    result = invoke("run", case, "--set", "solver.max_iterations=6")
    assert result.exit_code == 3
    assert "solver.max_iterations" in result.stderr
    before = saved_steps(result.stdout)
    resumed = invoke("run", case, "--resume")
    assert resumed.exit_code == 0, resumed.stderr
    assert [*before, *saved_steps(resumed.stdout)] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("words", [(), ("--overwrite",)])
def test_case_is_never_replaced(tmp_path: Path, words: tuple[str, ...]) -> None:
    case = write_case(tmp_path)
    told = f"{case}: would replace the case itself; give another name with -o\n"
    assert refused(2, "run", case, "-o", case, *words) == told
    assert case.read_text() == CASE


@pytest.mark.parametrize("name", ["mine.yaml", "mine", "mine.npz"])
def test_result_has_the_ending_of_hdf5(tmp_path: Path, name: str) -> None:
    other = write_case(tmp_path, name=name)
    for words in ((), ("--overwrite",), ("--resume",)):
        told = f"{other}: the name of a result must end in .h5 or .hdf5\n"
        assert refused(2, "run", write_case(tmp_path), "-o", other, *words) == told
    assert other.read_text() == CASE
    assert not (tmp_path / f"{name}.parts").exists()


def test_height_map_is_never_replaced(tmp_path: Path) -> None:
    import h5py

    with h5py.File(tmp_path / "case.h5", "w") as file:
        file["gap"] = np.zeros((8, 8))
    heights = "surface: {heights: {file: case.h5, dataset: gap, spacing: 0.1 mm}}"
    case = write_case(tmp_path, CASE.replace("surface: {sphere: {radius: 10 mm}}", heights))
    before = (tmp_path / "case.h5").read_bytes()
    assert "would replace a height map of the case" in refused(2, "run", case, "--overwrite")
    assert (tmp_path / "case.h5").read_bytes() == before


def test_grid_beyond_the_memory_is_refused(tmp_path: Path) -> None:
    told = refused(2, "run", write_case(tmp_path), "--set", "grid.points=1000000")
    assert re.search(r"grid.points: 1000000 x 1000000 cells take about \d+ TB of memory, this machine", told)


def test_result_beyond_the_disk_is_warned_of_or_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case, out = write_case(tmp_path), tmp_path / "case.h5"
    size = estimate(set_up(load_case(case))).file
    certain = "which is too little"
    for share, code, words in ((3.0, 0, ""), (1.5, 0, "which may be too little"), (0.05, 2, certain)):
        monkeypatch.setattr(shutil, "disk_usage", lambda folder, share=share: SimpleNamespace(free=share * size))
        checked, result = invoke("validate", case), invoke("run", case, "-q")
        assert result.exit_code == code, result.stderr
        for told in (checked.stderr, result.stderr):
            assert words in told
            assert ("output.every: the result takes about" in told) == (share < 2.0)
            assert ("empty cells take less, so the run goes on" in told) == (share == 1.5)
            assert ("another disk is needed" in told) == (words == certain)
        assert out.exists() == (code == 0)
        assert not parts_folder(out).exists()
        out.unlink(missing_ok=True)
    assert result.stderr.startswith(f"{case}:1: output.every: the result takes about")
    assert result.stderr.count("\n") == 1


def test_quiet_run_without_warnings_prints_nothing(tmp_path: Path) -> None:
    result = invoke("run", write_case(tmp_path, CASE.replace("points: 16", "points: 32")), "-q")
    assert (result.exit_code, result.output) == (0, "")


def test_quiet_run_tells_that_it_waits_for_the_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretsolve.cli.commands.run.when_compiling", lambda tell: tell())
    result = invoke("run", write_case(tmp_path, CASE.replace("points: 16", "points: 32")), "-q")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", f"{COMPILING}\n")


def test_plain_run_loads_nothing_that_other_cases_need(tmp_path: Path) -> None:
    code = (
        "import os, sys; os.environ['FRETSOLVE_NUMBA'] = '0'\n"
        "from fretsolve.cli.main import main; sys.argv = ['fretsolve', 'run', sys.argv[1]]\n"
        "try: main()\nexcept SystemExit: pass\n"
        "parts = 'wear', 'post.stress', 'post.fatigue', 'sweep', 'simulation.error_bars', 'result.cycles'\n"
        "others = *(f'fretsolve.{part}' for part in parts), 'pint', 'matplotlib', 'xarray', 'scipy', 'numba',"
        " 'numpy.ma', 'difflib', 'subprocess', 'rich'\n"
        "print([name for name in others if name in sys.modules])"
    )
    assert python(code, write_case(tmp_path)).splitlines()[-1] == "[]"
    assert (tmp_path / "case.h5").exists()


def test_quiet_run_tells_what_makes_its_result_doubtful(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    result = invoke("run", case, "-q")
    assert (result.exit_code, result.stdout) == (0, "")
    needed = "20 or more are needed for errors below a few per cent"
    assert result.stderr == f"{case}: warning: grid.points: only 13.3 cells across the contact; {needed}\n"
    uncoupled = invoke("run", case, "-q", "--overwrite", "--set", "grid.points=32", "--set", "coupling=none")
    assert uncoupled.stdout == ""
    assert uncoupled.stderr.startswith(f"{case}: warning: coupling: none leaves out ux from qy")


@pytest.mark.parametrize("words", [(), ("-q",), ("--log-json",)])
def test_contact_of_few_cells_is_told_of_where_no_formula_knew(words: tuple[str, ...], tmp_path: Path) -> None:
    spheres = "surface=[{sphere: {radius: 20 mm}}, {sphere: {radius: 20 mm}}]"
    case = write_case(tmp_path)
    result = invoke("run", case, *words, "--set", spheres, "--set", "grid.size=3 mm")
    assert result.exit_code == 0
    told = "grid.points: the contact has at most 12 cells; errors below a few per cent need 315 or more"
    assert result.output.count(told) == 1
    result = invoke("run", case, *words, "--overwrite", "--set", spheres, "--set", "grid={points: 32, size: 0.8 mm}")
    assert (result.exit_code, "grid.points" in result.output) == (0, False)


def test_show_prints_one_row_per_stage_or_per_increment(solved: tuple[Path, str, str]) -> None:
    out, output, _ = solved
    shown = invoke("show", out).stdout.splitlines()
    assert shown[:2] == ["tiny", "complete, 5 increments"]
    assert "\n".join(shown[3:]) in output  # the table and totals that the run ended with
    every = invoke("show", out, "--all").stdout.splitlines()
    assert len(every) == len(shown) + 3


def test_resume_refuses_a_height_map_that_has_changed(tmp_path: Path) -> None:
    heights = np.add.outer(np.linspace(-1, 1, 40) ** 2, np.linspace(-1, 1, 40) ** 2) / 20
    np.save(tmp_path / "map.npy", heights)
    text = CASE.replace("sphere: {radius: 10 mm}", "heights: {file: map.npy, spacing: 0.05 mm}")
    case = write_case(tmp_path, text.replace("Qx: 20 N", "Qx: 50 N").split("expect:")[0])
    first = invoke("run", case)
    assert first.exit_code == 3  # gross slip: a failed result, which --resume takes up again
    np.save(tmp_path / "map.npy", 1.1 * heights)
    told = invoke("run", case, "--resume")
    assert told.exit_code == 4
    assert "holds a run of another case: content of.height map 1 is" in told.stderr


def test_quiet_run_still_tells_that_its_accuracy_is_not_met(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    result = invoke("run", str(case), "-q", "--set", "solver.accuracy=0.01 %")
    assert result.exit_code == 0
    assert result.stdout == ""
    assert "accuracy 0.01 % is not met" in result.stderr.splitlines()[-1]


NAMES = {quantity.name for quantity in HISTORY}


def events(output: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in output.splitlines()]


def test_json_lines_tell_the_whole_run(tmp_path: Path) -> None:
    case = write_case(tmp_path)
    result = invoke("run", case, "--log-json")
    assert (result.exit_code, result.stderr) == (0, "")
    start, warning, *increments, end = events(result.stdout)
    assert (start["event"], start["increments"], start["stages"], start["points"]) == ("start", 5, 2, [16, 16])
    assert (start["case"], start["result"]) == (str(case), str(case.with_suffix(".h5")))
    assert warning["event"] == "warning"
    assert warning["message"].startswith("grid.points: only 13.3 cells")
    assert [line["event"] for line in increments] == ["increment"] * 5
    assert all(line.keys() >= NAMES | {"step", "increments", "stages"} for line in increments)
    with open_result(case.with_suffix(".h5")) as found:
        for name in NAMES:
            assert [line[name] for line in increments] == found.history[name].tolist()
    assert (end["event"], end["status"], end["increments"]) == ("end", "complete", 5)
    again = events(invoke("run", case, "--log-json", "--resume").stdout)
    assert again == [{"event": "end", "status": "complete", "result": start["result"], "increments": 5}]


def test_json_lines_of_a_run_that_fails(tmp_path: Path) -> None:
    result = invoke("run", write_case(tmp_path, CASE.replace("20 N", "50 N")), "--log-json")
    assert result.exit_code == 3
    end = events(result.stdout)[-1]
    assert (end["event"], end["status"], end["increments"]) == ("end", "failed", 4)
    assert f"{end['message']}\n" == result.stderr


def test_json_has_no_nan(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE.replace("points: 16", "points: 32"))
    result = invoke("run", case, "--log-json", "--error-bars")
    assert result.exit_code == 0, result.stderr
    increments = [line for line in events(result.stdout) if line["event"] == "increment"]
    assert all("delta_x_error" in line for line in increments)
    assert "NaN" not in result.stdout


def test_verbose_tells_stages_settings_and_all_of_the_history(tmp_path: Path) -> None:
    result = invoke("run", write_case(tmp_path), "-v")
    assert result.exit_code == 0
    assert "stage 2: Qx -> 20 N in 4 increments" in result.stdout
    assert "threads: 1, tolerance: 1e-06, at most 2000 iterations" in result.stdout
    lines = [line.split() for line in result.stdout.splitlines() if line.startswith("step=")]
    assert len(lines) == 5
    assert all({word.split("=")[0] for word in words} >= NAMES for words in lines)


@pytest.mark.parametrize("words", [("-q", "-v"), ("-q", "--log-json"), ("-v", "--log-json")])
def test_one_way_of_telling_at_a_time(tmp_path: Path, words: tuple[str, ...]) -> None:
    assert "only one of -q, -v and --log-json is possible" in refused(2, "run", write_case(tmp_path), *words)
    assert not (tmp_path / "case.h5").exists()


def test_bodies_that_never_touch_are_warned_of(tmp_path: Path) -> None:
    path = "load_path=[{delta_z: -5 um}, {delta_x: 1 um}]"
    done = invoke("run", write_case(tmp_path), "--set", "grid.size=1 mm", "--set", path)
    assert done.exit_code == 0
    assert "load_path: the bodies never touch; a force P > 0 N, or a larger approach delta_z, presses" in done.stderr


def test_more_points_than_any_machine_holds_are_refused_at_once(tmp_path: Path) -> None:
    told = refused(2, "validate", write_case(tmp_path), "--set", "grid.points=1000000000")
    assert "1000000000 is too large; a whole number <= 1048576 is needed" in told
