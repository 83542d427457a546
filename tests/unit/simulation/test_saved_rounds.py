"""Results of runs in rounds: what a failure, a stop and a limit leave; sweeps, studies and checks in rounds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, refused
from small_cases import WORN, write_case

from fretsolve.case.loading import read_case
from fretsolve.result import open_result
from fretsolve.result.parts import ROUND_NAME
from fretsolve.sweep.case_run import solve
from fretsolve.sweep.manifest import is_finished
from fretsolve.sweep.plan import BaseCase
from fretsolve.system.signals import StopRequest

CASE = """\
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.06}, {young_modulus: 200 GPa, poisson_ratio: 0.42}]
surface: {sphere: {radius: 10 mm}}
friction: 0.1
load_path: [{P: 400 N}, {Qx: 20 N}]
solver: {accuracy: {target: 3 %}}
output: {fields: [pressure]}
"""


SHORT = ("--set", "solver.max_iterations=14")
"""With so few iterations 30 x 30 points are solved, and 36 x 36 are not."""


pytestmark = pytest.mark.usefixtures("handlers")


class Stop:
    """A request to stop that comes before a look at it."""

    def __init__(self, before: int) -> None:
        self.looks, self.before = 0, before

    @property
    def requested(self) -> bool:
        self.looks += 1
        return self.looks > self.before


def test_run_goes_through_rounds_and_keeps_the_last(tmp_path: Path) -> None:
    case, out = write_case(tmp_path, CASE), tmp_path / "case.h5"
    ran = invoke("run", case)
    assert ran.exit_code == 0, ran.stderr
    assert "round 2: " in ran.stdout
    assert "accuracy 3 % is met: " in ran.stdout
    with open_result(out) as result:
        rounds = json.loads(result.attributes["provenance"])["rounds"]
        points, refinement = result.effective_case["grid"]["points"], result.effective_case["solver"]["refinement"]
        assert points[0] > rounds[-1]["points"][0] or refinement > rounds[-1]["refinement"]
        assert all(one["worst"] > 0.03 for one in rounds)
        assert result.status == "complete"
    assert invoke("run", case, "--resume").output.startswith(f"{out}: already complete, ")
    assert (
        refused(4, "run", case, "--resume", "--set", "solver.accuracy=2 %").count("solver.accuracy.target is 0.03") == 1
    )


def test_a_stopped_round_is_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("whole", "parted"):
        (tmp_path / name).mkdir()
    whole, parted = (write_case(tmp_path / name, CASE) for name in ("whole", "parted"))
    assert invoke("run", whole, "-q").exit_code == 0
    from fretsolve.system.signals import StopRequest

    asked = iter([False] * 25 + [True] * 100)
    with monkeypatch.context() as patch:
        patch.setattr(StopRequest, "requested", property(lambda self: next(asked)))
        assert invoke("run", parted, "-q").exit_code == 75
    header = json.loads((tmp_path / "parted/case.h5.parts/header.json").read_text())
    assert json.loads(header["provenance"])["rounds"], "it was stopped in a later round"
    assert invoke("run", parted, "-q", "--resume").exit_code == 0
    with open_result(whole.with_suffix(".h5")) as one, open_result(parted.with_suffix(".h5")) as other:
        assert one.effective_case == other.effective_case
        assert np.array_equal(one.history["work_total"], other.history["work_total"])


def test_a_round_that_fails_leaves_the_round_before_as_the_result(tmp_path: Path) -> None:
    case, out = write_case(tmp_path, CASE), tmp_path / "case.h5"
    asked = (*SHORT, "--set", "solver.accuracy={target: 0.5 %, at_most: {time: 1 h}}")
    ran = invoke("run", case, *asked)
    assert ran.exit_code == 0, ran.stderr
    assert "; the next round, on 60 x 60 points, has no solution: " in ran.stderr
    assert "accuracy 0.5 % is not met: " in ran.stdout
    with open_result(out) as result:
        assert (result.status, result.increments) == ("complete", 14)
    assert not (tmp_path / "case.h5.parts").exists()
    assert "already complete" in invoke("run", case, *asked, "--resume").stdout
    again = invoke("run", case, *asked, "--set", "solver.accuracy.at_most.time=2 h", "--resume")
    assert "; the next round, on 60 x 60 points, has no solution: " in again.stderr
    with open_result(out) as result:
        assert (result.status, result.increments) == ("complete", 14)
    checked = write_case(tmp_path, CASE + "expect: [{quantity: delta_z, value: 9.05 um, rel: 1 %}]\n", "checked.yaml")
    assert invoke("check", checked, *SHORT, "--set", "solver.accuracy=0.5 %").exit_code == 0


def test_json_lines_tell_the_rounds(tmp_path: Path) -> None:
    lines = invoke("run", write_case(tmp_path, CASE), "--log-json").stdout.splitlines()
    events = [json.loads(line) for line in lines]
    assert [one["event"] for one in events if one["event"] != "increment"] == ["start", "round", "end"]
    (second,) = (one for one in events if one["event"] == "round")
    assert (second["round"], second["points"], second["before"]["quantity"]) == (2, [36, 36], "work_total")
    assert events[-1]["accuracy"]["met"]


def test_a_first_round_that_fails_is_the_result(tmp_path: Path) -> None:
    assert invoke("run", write_case(tmp_path, CASE), "--set", "solver.max_iterations=2").exit_code == 3
    with open_result(tmp_path / "case.h5") as result:
        assert result.status == "failed"


def test_a_stop_between_two_rounds_loses_neither(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    case, out, whole = write_case(tmp_path, CASE), tmp_path / "case.h5", tmp_path / "whole.h5"
    assert invoke("run", case, "-q", "-o", whole).exit_code == 0
    stop = Stop(14)
    with monkeypatch.context() as patch:
        patch.setattr(StopRequest, "requested", property(lambda self: stop.requested))
        stopped = invoke("run", case, "-q")
    assert (stopped.exit_code, out.exists()) == (75, False)
    assert "stopped with 0 of " in stopped.stderr
    assert (tmp_path / "case.h5.parts" / ROUND_NAME).exists()
    assert "complete, 14 increments" in invoke("show", out).stdout
    refused(2, "run", case)
    refused(4, "run", case, "--resume", "--set", "friction=0.2")
    refused(4, "run", case, "--resume", "--set", "solver={}", "--set", "grid.points=16")
    resumed = invoke("run", case, "--resume")
    assert resumed.exit_code == 0, resumed.stderr
    assert "grid: 36 x 36 cells" in resumed.stdout, "it goes on with the second round"
    with open_result(whole) as one, open_result(out) as other:
        assert np.array_equal(one.history["work_total"], other.history["work_total"])


def test_a_sweep_does_not_take_a_round_for_the_result(tmp_path: Path) -> None:
    case = BaseCase.of(read_case(write_case(tmp_path, CASE)), ()).prepare({}, tmp_path)
    assert solve(case, 0, Stop(14)).code == 75
    assert not is_finished(case.out, ())
    assert solve(case, 0, Stop(10_000)).code == 0
    with open_result(case.out) as result:
        assert result.effective_case["grid"]["points"] == [36, 36]
        assert json.loads(result.attributes["provenance"])["rounds"][0]["points"] == [30, 30]
    assert is_finished(case.out, ())


@pytest.mark.slow
def test_check_compares_the_last_round_where_cycles_end_by_themselves(tmp_path: Path) -> None:
    cycle = "{until: periodic, at_most: 6, stages: [{Qx: 20 N}, {Qx: -20 N}]}"
    text = CASE.replace("{Qx: 20 N}", f"{{cycle: {cycle}}}").replace("target: 3 %", "target: 5 %")
    case = write_case(tmp_path, text + "expect: [{quantity: Qx, value: -20 N, rel: 1e-6}]\n")
    assert invoke("check", case).exit_code == 0


@pytest.mark.slow
def test_a_study_solves_rounds(tmp_path: Path) -> None:
    case = write_case(tmp_path, CASE)
    done = invoke("study", case, "--vary", "solver.accuracy=20 %,3 %", "--quantity", "work_total")
    assert done.exit_code == 0, done.output
    with open_result(next(iter(sorted((tmp_path / "case.study").glob("*.h5"))))) as result:
        assert "work_total_error" in result.history
    table = (tmp_path / "case.study/study.csv").read_text().splitlines()
    increments = table[0].split(",").index("increments")
    assert len({line.split(",")[increments] for line in table[1:]}) == 2, "3 % takes more of them"


@pytest.mark.slow
def test_a_larger_limit_goes_on_with_a_complete_result(tmp_path: Path) -> None:
    case, out = write_case(tmp_path, CASE.replace("target: 3 %", "target: 3 %, at_most: {cells: 1000}")), "case.h5"
    limited = invoke("run", case)
    assert "at_most.cells is 1000" in limited.stderr
    more = invoke("run", case, "--resume", "--set", "solver.accuracy.at_most.cells=10000")
    assert more.exit_code == 0, more.stderr
    assert "accuracy 3 % is met: " in more.stdout
    with open_result(tmp_path / out) as result:
        assert result.effective_case["grid"]["points"] == [36, 36]


@pytest.mark.slow
def test_worn_rounds_are_compared(tmp_path: Path) -> None:
    text = WORN.replace("points: 24", "size: 1.2 mm") + "solver: {accuracy: {target: 10 %, of: [P, wear_volume]}}\n"
    ran = invoke("run", write_case(tmp_path, text))
    assert ran.exit_code == 0, ran.stderr
    assert "round 1 has no error bars; round 2: " in ran.stdout
    assert "accuracy 10 % is met: " in ran.stdout
    given = invoke("run", write_case(tmp_path, text.replace("size: 1.2 mm", "points: 24"), "given.yaml"))
    assert "is not proved: there is no error bar of P at the end of stage " in given.stderr
    assert "no round follows: grid.points is given" in given.stderr


def test_validate_leaves_out_what_rounds_pick(tmp_path: Path) -> None:
    shown = invoke("validate", write_case(tmp_path, CASE)).stdout
    assert "picks 30 x 30 points, 4 to 10 increments per stage" in shown
    assert "; further rounds take at most 1000000 cells" in shown
    assert "# cost of the first round" in shown
    effective = shown.partition("# model")[0]
    assert "points" not in effective and "refinement" not in effective
