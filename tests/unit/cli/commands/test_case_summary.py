"""Long load paths and cycles of wear in lines of text."""

from __future__ import annotations

from typing import Any

from solving import build

from fretsolve.cli.case_summary import MOST_STAGES_LISTED, path_length, represented_cycles, stage_lines
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up

LOOP = [{"P": 400.0}, {"Qx": 36.0, "increments": 2}]
WEAR = {"law": "energy", "alpha": 1e-7}
BACK = [{"Qx": -36.0, "increments": 2}, {"Qx": 36.0, "increments": 2}]


def setup_of(**parts: Any) -> ProblemSetup:
    return set_up(build(**({"grid": {"points": 24, "size": 1.2}, "load_path": LOOP} | parts)))


def test_of_very_many_stages_the_first_ones_are_listed() -> None:
    lines = list(stage_lines(setup_of(load_path=[*LOOP, {"cycle": {"times": 30, "stages": BACK}}])))
    assert len(lines) == MOST_STAGES_LISTED + 1
    assert lines[-1] == "... and 22 more stages, up to stage 62"


def test_cycles_that_stand_for_others_are_listed_once() -> None:
    worn = setup_of(wear=WEAR, load_path=[*LOOP, {"cycle": {"represents": 1e4, "jump": 2500, "stages": BACK}}])
    lines = list(stage_lines(worn))
    assert lines[4].endswith("change by the wear of the cycles that the last one stands for")
    assert lines[5].startswith("cycles that stand for others repeat, so that there are at most ")
    assert len(lines) == 6
    assert represented_cycles(worn) == 1e4
    assert path_length(worn).startswith("about ")
    assert represented_cycles(setup_of()) == 0.0
