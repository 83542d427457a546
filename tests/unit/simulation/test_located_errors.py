"""An increment without a solution is told with its place in the case file, and with a size that would do."""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path

import pytest
from small_cases import CASE, write_case

from fretsolve import run
from fretsolve.case.loading import load_case
from fretsolve.errors import GridEdgeError, NoSolutionError
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.simulation import locate


def located(folder: Path, error: NoSolutionError, *sets: str, step: int) -> NoSolutionError:
    setup = set_up(load_case(write_case(folder, CASE), sets))
    before = [state.summary for state in islice(run(setup.case), step)]
    increment = setup.load_path.increment(step, before)
    locate(error, setup, increment)
    return error


def test_a_contact_at_the_edge_of_the_grid(tmp_path):
    error = located(tmp_path, GridEdgeError("reaches the edge"), "grid.size=0.4 mm", step=0)
    assert error.key == ("grid", "size")
    assert error.message.startswith("reaches the edge; size: [0.")
    assert error.message.endswith("] would do (increment 0, stage 1)")


@pytest.mark.parametrize(
    ("sets", "advice"),
    [
        (
            ("grid={points: 16, size: 4 mm}",),
            "the size would hold the contact under the normal load alone: try size: [6 mm",
        ),
        (("grid={points: 2, size: 4 mm}",), "size: [4 mm, 4 mm] would do with more points, which resolve the contact"),
    ],
)
def test_advice_where_the_size_is_not_too_small(tmp_path, sets, advice):
    assert advice in located(tmp_path, GridEdgeError("reaches the edge"), *sets, step=0).message


LINE = """\
plane: strain
bodies: [{young_modulus: 200 GPa, poisson_ratio: 0.3}, {young_modulus: 200 GPa, poisson_ratio: 0.3}]
surface: {cylinder: {radius: 10 mm}}
grid: {points: 4}
load_path: [{P: 100 N/mm}]
"""


@pytest.mark.parametrize("text", [LINE, LINE.replace("plane: strain\n", "").replace("cylinder", "sphere")])
@pytest.mark.parametrize("size", ["auto", "0.05 mm", "0.2 mm"])
def test_the_size_that_is_advised_holds_the_contact_also_on_few_points(tmp_path, text, size):
    text = text if "plane" in text else text.replace("N/mm", "N")
    case, advised = write_case(tmp_path, text), 0
    for points in (1, 2, 3, 4, 5, 6, 7, 8, 9, 12):
        try:
            list(run(load_case(case, [f"grid={{points: {points}, size: {size}}}"])))
        except GridEdgeError as error:
            found = re.search(r"size: (.*mm\]?) would do( with more points)?", error.message)
            again = f"grid={{points: {12 if found[2] else points}, size: {found[1]}}}"
            assert bool(found[2]) == (points < 3)
            assert len(list(run(load_case(case, [again])))) == 1
            advised += 1
    assert advised >= 5


def test_the_end_of_a_map_is_a_matter_of_the_surface(tmp_path):
    error = located(tmp_path, GridEdgeError("reaches the end of the map", "map"), step=0)
    assert error.key == ("surface",)
    assert error.message == "reaches the end of the map (increment 0, stage 1)"
