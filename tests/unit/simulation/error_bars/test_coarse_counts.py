"""The numbers of increments of the coarse runs, and what they show together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from solving import DISSIMILAR, build

from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.error_bars.coarse_counts import CoarseCounts, coarse_counts
from fretsolve.simulation.error_bars.coarse_runs import CoarseRun, CoarseRuns, coarser


def setup_of(points: int = 16, **parts: Any) -> ProblemSetup:
    return set_up(build(grid={"points": points}, **parts))


@pytest.mark.parametrize(
    ("count", "third", "other", "half"),
    [(1, 1, 2, 1), (3, 3, 6, 3), (4, 2, 1, 1), (5, 4, 2, 2), (8, 4, 2, 2), (9, 6, 3, 3)],
)
def test_other_increments_show_how_slip_turns(count: int, third: int, other: int, half: int) -> None:
    setup = setup_of(load_path=[{"P": 400, "increments": 3}, {"Qx": 20, "increments": count}])
    runs = CoarseRuns(setup, 1)
    assert runs.other_increments is not None
    # the pressing does not slip: as many increments as the run to compare with it, one where nothing is compared
    assert runs.third.setup.load_path.counts == (3, third)
    assert runs.other_increments.setup.load_path.counts == (1, other)
    assert runs.half.setup.load_path.counts == (3, half)


@pytest.mark.parametrize(
    ("parts", "matter"),
    [
        ({}, False),
        ({"friction": 0.0, "bodies": DISSIMILAR}, False),
        ({"bodies": DISSIMILAR}, True),
        ({"load_path": [{"P": 400}, {"Qx": 20}, {"Qx": -20}]}, False),
        ({"load_path": [{"P": 400}, {"Qx": 20, "Qy": 0.0}]}, False),
        ({"load_path": [{"P": 400}, {"Qx": 20}, {"Qy": 20}]}, True),
        ({"load_path": [{"P": 200}, {"P": 400, "Qx": 20}]}, True),
        ({"load_path": [{"P": 200}, {"Qx": 10}, {"delta_z": 9e-3}]}, True),
    ],
)
def test_increments_matter_where_the_slip_depends_on_the_path(parts: dict[str, Any], matter: bool) -> None:
    assert setup_of(**parts).load_path.path_dependent is matter


@pytest.mark.parametrize(
    ("counts", "third", "other", "half"),
    [
        ((1, 8), (1, 8), (2, 16), (1, 8)),
        ((2, 8), (2, 8), (4, 16), (1, 4)),
        ((6, 7), (4, 4), (2, 2), (2, 2)),
        ((12, 13), (6, 8), (3, 4), (3, 4)),
    ],
)
def test_coarse_runs_stand_for_some_with_all_increments(
    counts: tuple[int, int], third: tuple[int, int], other: tuple[int, int], half: tuple[int, int]
) -> None:
    path = [{"P": 400, "increments": counts[0]}, {"Qx": 30, "increments": counts[1]}]
    setup = setup_of(36, bodies=DISSIMILAR, load_path=path)
    runs, last = CoarseRuns(setup, 1), sum(counts) - 1
    assert [one.setup.load_path.counts for one in runs.all] == [third, other, half]
    of_third, of_half = (CoarseRun(coarser(setup, factor, counts), 1).values(last) for factor in (3, 2))
    point, values = runs.point(last), np.abs(of_third)
    assert runs.last_known(last) == point
    for name in ("delta_z", "delta_x", "work_total"):
        place = ESTIMATED.index(name)
        assert abs(runs.third_at(point)[place] - of_third[place]) < 0.03 * values[place], name
        assert abs(runs.half_less_third(point)[place] - (of_half - of_third)[place]) < 0.05 * values[place], name


@pytest.mark.parametrize(
    ("count", "third", "half"), [(1, 1, 1), (4, 2, 1), (5, 5, 5), (6, 6, 3), (8, 4, 2), (12, 6, 3)]
)
def test_coarse_runs_press_in_fewer_increments_where_nothing_slips(count: int, third: int, half: int) -> None:
    pressed = coarse_counts(setup_of(load_path=[{"P": 400, "increments": count}]), (False,))
    assert pressed == CoarseCounts((third,), None, (half,))
    setup = setup_of(load_path=[{"P": 400, "increments": count}, {"Qx": 20, "increments": 8}])
    assert coarse_counts(setup, (False, True)) == CoarseCounts((third, 4), (1, 2), (half, 2))
