"""A case in lines of text."""

from __future__ import annotations

from typing import Any

import pytest
from line_cases import line_case
from solving import build

from fretsolve.cli.case_summary import (
    MOST_STAGES_LISTED,
    accuracy_lines,
    grid_line,
    material_lines,
    model_lines,
    model_table,
    path_length,
    represented_cycles,
    stage_lines,
)
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up

LOOP = [{"P": 400.0}, {"Qx": 36.0, "increments": 2}]
WEAR = {"law": "energy", "alpha": 1e-7}
BACK = [{"Qx": -36.0, "increments": 2}, {"Qx": 36.0, "increments": 2}]


def setup_of(**parts: Any) -> ProblemSetup:
    return set_up(build(**({"grid": {"points": 24, "size": 1.2}, "load_path": LOOP} | parts)))


def test_grid() -> None:
    assert grid_line(setup_of()) == "24 x 24 cells of 0.05 x 0.05 mm on 1.2 x 1.2 mm"
    wide = setup_of(grid={"points": [24, 12], "size": [1.2, 0.9], "center": [0.1, 0.0]})
    assert grid_line(wide) == "24 x 12 cells of 0.05 x 0.075 mm on 1.2 x 0.9 mm about (0.1, 0) mm"
    assert " (auto)" in grid_line(setup_of(grid={"points": 24}))
    line = set_up(line_case(grid={"points": 64, "size": 0.32}))
    assert grid_line(line) == "64 cells of 0.005 mm on 0.32 mm"


def test_model() -> None:
    setup = setup_of()
    for line, one in zip(model_lines(setup.model), setup.model.decisions, strict=True):
        assert line.split(maxsplit=1 + len(one.part.split()))[-2:] == ["on" if one.kept else "off", one.reason]
    head, *rows = model_table(setup)
    assert head.split() == ["part", "memory", "time", "what", "and", "why"]
    kept = [row for row, one in zip(rows, setup.model.decisions, strict=True) if one.kept]
    shares = [[int(word[:-1]) for word in row.split() if word.endswith("%")][:2] for row in kept]
    for share in zip(*shares, strict=True):
        assert sum(share) == pytest.approx(100, abs=len(kept))


def test_materials() -> None:
    body = {"material": "steel"}
    assert list(material_lines(setup_of())) == []
    one, other = material_lines(setup_of(bodies=[body, {**body, "poisson_ratio": 0.25}]))
    assert one.startswith("body 1: steel, by ")
    assert other == one.replace("body 1", "body 2") + "; the case changes poisson_ratio"
    assert [line[:6] for line in material_lines(setup_of(bodies=["rigid", body]))] == ["body 2"]


def test_accuracy() -> None:
    assert accuracy_lines(setup_of()) == []
    (line,) = accuracy_lines(setup_of(grid={"points": 32}, solver={"accuracy": 0.05}))
    assert line.startswith("accuracy 5 % picks ")


def test_stages_have_their_targets_and_increments() -> None:
    path = [{"P": 400.0}, {"delta_x": 1e-3, "increments": 3}, {"My": 2.0, "increments": 1}]
    pressed, moved, turned, sign = stage_lines(setup_of(load_path=path))
    assert pressed == "stage 1: P -> 400 N in 1 increment (auto)"
    assert moved == "stage 2: delta_x -> 1 um in 3 increments"
    assert turned == "stage 3: My -> 2 N mm in 1 increment"
    assert "My" in sign
    assert path_length(setup_of()) == "3 increments"


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
