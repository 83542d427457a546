"""Every kind of mistake in a case file gives one line: file, line, key, the value, what would be right."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest
import yaml
from small_cases import case_error, write_case

from fretsolve.case.loading import load_case
from fretsolve.errors import CaseErrors, FileError

CASE = """\
title: similar bodies
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
  - {young_modulus: 210 GPa, poisson_ratio: 0.3}
surface: {sphere: {radius: 10 mm}}
grid:
  points: 128
  size: [0.72 mm, 0.72 mm]
friction: 0.1
coupling: auto
load_path:
  - {P: 400 N, increments: 10}
  - {Qx: 36 N}
  - cycle: {times: 3, stages: [{Qx: -36 N}, {Qx: 36 N}]}
solver: {tolerance: 1e-6, precision: double}
output: {fields: [pressure, zone], every: 1}
expect:
  - {quantity: stick_radius, value: 0.1398 mm, rel: 0.01, stage: 2}
"""

BODY_1 = "{young_modulus: 200 GPa, poisson_ratio: 0.3}"
MISTAKES = [
    (mistake["right"], mistake["wrong"], mistake["says"])
    for mistake in yaml.safe_load((Path(__file__).parents[2] / "data" / "case_mistakes.yaml").read_text())
]


@pytest.mark.parametrize(
    ("right", "wrong", "message"), MISTAKES, ids=[message.partition("; ")[0] for _, _, message in MISTAKES]
)
def test_mistake_gives_one_line(tmp_path: Path, right: str, wrong: str, message: str) -> None:
    assert right in CASE
    path = write_case(tmp_path, CASE.replace(right, wrong, 1))
    error = case_error(path)
    assert (str(error), error.exit_code) == (f"{path}:{message}", 2)


@pytest.mark.parametrize("body", [1, 2])
def test_a_rigid_body_has_no_bulk_stress(tmp_path: Path, body: int) -> None:
    bodies = [BODY_1, BODY_1.replace("200", "210")]
    text = CASE.replace(f"  - {bodies[body - 1]}", "  - rigid")
    text = text.replace("{Qx: -36 N}", f"{{Qx: -36 N, bulk_{body}: {{xx: 70 MPa}}}}")
    error = case_error(write_case(tmp_path, text))
    message = f"body {body} is rigid, so it has no bulk stress; an elastic body is needed"
    assert (error.line, error.message) == (14, message)
    assert error.key == ("stage", 3, f"bulk_{body}")
    other = text.replace(f"bulk_{body}", f"bulk_{3 - body}")
    assert len(load_case(write_case(tmp_path, other)).stages()) == 8


def test_the_case_without_mistakes_loads(tmp_path: Path) -> None:
    assert len(load_case(write_case(tmp_path, CASE)).stages()) == 8


def test_all_problems_are_reported_in_order_of_their_lines(tmp_path: Path) -> None:
    text = CASE.replace("radius: 10 mm", "radius: 10 N").replace("rel: 0.01", "rel: 1 mm")
    text = text.replace("coupling: auto", "a:").replace("0.1\n", "-0.1\n").replace("stage: 2", "stage: 99")
    path = write_case(tmp_path, text)
    error = case_error(path)
    lines = str(error).split("\n")
    assert [line.removeprefix(f"{path}:").split(": ")[:2] for line in lines] == [
        ["5", "surface.sphere.radius"],
        ["9", "friction"],
        ["10", "a"],
        ["18", "expect.0.rel"],
    ]
    assert isinstance(error, CaseErrors)
    assert error.problems[0].key == error.key
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_rigid_bodies_alone_are_refused(tmp_path: Path) -> None:
    path = write_case(tmp_path, CASE.replace(BODY_1, "rigid").replace(BODY_1.replace("200", "210"), "rigid"))
    assert str(case_error(path)) == f"{path}:2: bodies: both bodies are rigid; at least one must be elastic"


NEEDED = "one with the keys bodies, surface, grid, load_path is needed"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", f":1: the file is empty; {NEEDED}"),
        ("# only a comment\n", f":1: the file is empty; {NEEDED}"),
        ("- a\n- b\n", f":1: the file does not hold a mapping; {NEEDED}"),
        ("\n\njust text\n", f":3: the file does not hold a mapping; {NEEDED}"),
    ],
)
def test_file_without_a_mapping(tmp_path: Path, text: str, message: str) -> None:
    path = write_case(tmp_path, text)
    assert str(case_error(path)) == f"{path}{message}"


def test_missing_file_is_a_file_error(tmp_path: Path) -> None:
    with pytest.raises(FileError) as caught:
        load_case(tmp_path / "none.yaml")
    assert caught.value.exit_code == 4
