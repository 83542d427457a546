"""A case run into its result file: what is written, what a stop leaves, and what a resume adds."""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import assert_same_result
from solving import DISSIMILAR, build

from fretsolve import open_result, run, run_with_error_bars
from fretsolve.errors import FileError, SlidingError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result import HistoryWriter
from fretsolve.result.history import History
from fretsolve.result.state import Summary, SummaryErrors
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header, solve_missing

PATH = [{"P": 400.0, "increments": 2}, {"Qx": 20.0, "increments": 3}]


@dataclass
class StopAfter:
    """Asks to stop after so many increments."""

    increments: int = 1000

    @property
    def requested(self) -> bool:
        self.increments -= 1
        return self.increments < 0


def setup_of(**parts: Any) -> ProblemSetup:
    grid = {"points": 16, "size": 0.8}
    return set_up(build(**{"bodies": DISSIMILAR, "grid": grid, "load_path": PATH, **parts}))


def solve(out: Path, setup: ProblemSetup, increments: int = 1000, **options: Any) -> tuple[bool, list[Any]]:
    """Solve up to so many increments; return whether the result is complete, and what was shown."""
    shown: list[tuple[Summary, SummaryErrors | None]] = []

    def show(summary: Summary, errors: SummaryErrors | None) -> None:
        shown.append((summary, errors))

    with HistoryWriter.open(out, run_header(setup, 1, ()), resume=True) as writer:
        return solve_missing(setup, writer, StopAfter(increments), show=show, **options), shown


@pytest.mark.parametrize("beside", [False, True])
def test_result_has_each_increment_of_the_run(tmp_path: Path, beside: bool) -> None:
    setup, out = setup_of(), tmp_path / "out.h5"
    complete, shown = solve(out, setup, beside=beside)
    assert complete
    assert list(tmp_path.iterdir()) == [out]
    states = list(run(setup))
    with open_result(out) as result:
        assert (result.status, result.steps) == ("complete", tuple(range(5)))
        for name in result.history.keys() - {"wall_time"}:
            assert result.history[name].tolist() == [getattr(state.summary, name) for state in states]
        for state in states:
            np.testing.assert_array_equal(result.field("shear", state.summary.step), state.fields.shear)
            np.testing.assert_array_equal(result.field("zone", state.summary.step), state.fields.zone)
        assert [(row.step, row.P, errors) for row, errors in shown] == [
            (step, load, None) for step, load in enumerate(result.history["P"])
        ]


@pytest.mark.parametrize("beside", [False, True])
def test_the_summaries_of_a_run_are_kept_once(tmp_path: Path, beside: bool) -> None:
    setup = setup_of()
    with HistoryWriter.open(tmp_path / "out.h5", run_header(setup, 1, ())) as writer:
        solve_missing(setup, writer, StopAfter(3), beside=beside)
        assert (writer.increments, [one.step for one in writer.summaries]) == (3, [0, 1, 2])
    own, history = [state.summary for state in run(setup)], History()
    assert [state.summary is history[-1] for state in run(setup, history=history)] == [True] * 5
    assert [one.P for one in history] == [one.P for one in own]
    begin = list(run(setup))[2]
    given = [one.summary for one in run(setup)][:3]
    assert [state.summary.step for state in run(setup, begin, given)] == [3, 4]
    assert len(given) == 3  # what is no `History` stays as it is


def test_stopped_run_goes_on_to_the_same_result(tmp_path: Path) -> None:
    setup, out = setup_of(), tmp_path / "halves.h5"
    complete, shown = solve(out, setup, increments=3, beside=True)
    assert (complete, [row.step for row, _ in shown]) == (False, [0, 1, 2])
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", 3)
    complete, shown = solve(out, setup)
    assert (complete, [row.step for row, _ in shown]) == (True, [3, 4])
    solve(tmp_path / "whole.h5", setup)
    assert_same_result(out, tmp_path / "whole.h5")


def test_error_bars_are_saved_and_go_on_after_a_stop(tmp_path: Path) -> None:
    setup = setup_of(solver={"error_bars": True})
    complete, shown = solve(tmp_path / "halves.h5", setup, increments=3)
    assert not complete
    _, later = solve(tmp_path / "halves.h5", setup)
    states = list(run_with_error_bars(setup))
    with open_result(tmp_path / "halves.h5") as result:
        for name in ("delta_x_error", "stick_radius_error", "work_total_error"):
            assert result.history[name].tolist() == [getattr(state.errors, name) for state in states]
            assert result.history[name].tolist() == [getattr(errors, name) for _, errors in (*shown, *later)]
            assert result.history[name][-1] > 0.0


def test_run_without_a_solution_is_saved_as_failed(tmp_path: Path) -> None:
    setup, out = setup_of(load_path=[PATH[0], {"Qx": 90.0, "increments": 3}]), tmp_path / "out.h5"
    with pytest.raises(SlidingError, match="stage 2"):
        solve(out, setup, beside=True)
    with open_result(out) as result:
        assert (result.status, result.attributes["failure_kind"]) == ("failed", "sliding")
        assert result.history["Qx"] == pytest.approx([0.0, 0.0, 30.0], abs=1e-3)
        assert "stage 2" in result.attributes["failure"]


@pytest.mark.parametrize("beside", [False, True])
def test_increments_before_a_fault_stay(tmp_path: Path, beside: bool) -> None:
    def show(summary: Summary, errors: SummaryErrors | None) -> None:
        if summary.step == 1:
            raise RuntimeError("the reader of the messages is gone")

    setup, out = setup_of(), tmp_path / "out.h5"
    with HistoryWriter.open(out, run_header(setup, 1, ())) as writer, pytest.raises(RuntimeError, match="is gone"):
        solve_missing(setup, writer, StopAfter(), show=show, beside=beside)
    with open_result(out) as result:
        assert (result.status, result.increments) == ("stopped", 2)
    assert solve(out, setup)[0]


def test_header_says_what_makes_the_numbers(tmp_path: Path) -> None:
    heights = tmp_path / "heights.npy"
    np.save(heights, np.add.outer(np.linspace(-1, 1, 32) ** 2, np.linspace(-1, 1, 32) ** 2))
    setup = setup_of(surface={"heights": {"file": str(heights), "spacing": 0.05}})
    header = run_header(setup, 2, ("friction=0.1",))
    assert json.loads(header.inputs) == {"height map 1": hashlib.sha256(heights.read_bytes()).hexdigest()}
    provenance = json.loads(header.provenance)
    assert (provenance["threads"], provenance["overrides"]) == (2, ["friction=0.1"])
    for name in ("numpy", "scipy", "pyfftw", "h5py"):
        assert provenance[name] == version(name)
    assert provenance["python"] == platform.python_version()
    assert provenance["platform"].split("-with-")[0] == f"Linux-{platform.release()}-{platform.machine()}"
    assert json.loads(header.effective_case)["friction"] == {"coefficient": 0.1}
    heights.unlink()
    with pytest.raises(FileError, match=r"heights\.npy: cannot be read: No such file"):
        run_header(setup, 1, ())


@pytest.mark.parametrize("increments", [3, 1000])
def test_an_increment_is_shown_once_it_is_saved(tmp_path: Path, increments: int) -> None:
    """With a pause, the increments are saved together, and shown after that."""
    setup, out = setup_of(), tmp_path / "out.h5"
    files: list[set[str]] = []
    with HistoryWriter.open(out, run_header(setup, 1, ()), pause=1000.0) as writer:

        def show(summary: Summary, errors: SummaryErrors | None) -> None:
            assert writer.is_saved(summary.step)
            files.append({path.name for path in tmp_path.rglob("*.h5")})

        complete = solve_missing(setup, writer, StopAfter(increments), show=show)
    assert complete == (increments > 3)
    if complete:
        assert files == [{out.name}] * 5
    else:
        assert files == [{"000000-000002.h5"}] * 3
