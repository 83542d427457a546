"""The numbers of increments of the coarse runs, and where they matter."""

from __future__ import annotations

from typing import Any

import pytest
from solving import DISSIMILAR, SIMILAR, setup_of

from fretsolve.simulation.error_bars.coarse_runs import CoarseCounts, CoarseRuns, coarse_counts, slipping_stages


@pytest.mark.parametrize(
    ("count", "third", "other", "half"),
    [(1, 1, 2, 1), (2, 2, 4, 2), (3, 2, 4, 2), (4, 2, 1, 1), (5, 4, 2, 2), (8, 4, 2, 2), (9, 6, 3, 3)],
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
    ("bodies", "first", "third", "other"),
    [
        (SIMILAR, 1, (1, 4, 1, 2), (1, 8, 2, 4)),  # the pressing does not slip
        (DISSIMILAR, 4, (2, 4, 1, 2), (4, 8, 2, 4)),
        (DISSIMILAR, 3, (3, 8, 1, 3), (6, 16, 2, 6)),  # what few increments miss that press stays in later stages
    ],
)
def test_long_stages_beside_short_ones_have_fewer_increments(
    bodies: Any, first: int, third: tuple[int, ...], other: tuple[int, ...]
) -> None:
    short = {"Qx": 0.0, "increments": 1}, {"Qy": 9.0, "increments": 3}
    loads = [{"P": 400, "increments": first}, {"Qx": 20, "increments": 8}, *short]
    setup = setup_of(bodies=bodies, load_path=loads)
    counts = coarse_counts(setup, slipping_stages(setup))
    assert counts == CoarseCounts(third, other, third)


@pytest.mark.parametrize(("bodies", "third"), [(SIMILAR, (4, 2)), (DISSIMILAR, (8, 3))])
def test_unlike_bodies_that_tilt_keep_all_increments(bodies: Any, third: tuple[int, int]) -> None:
    loads = [{"P": 400, "My": 0.5, "increments": 8}, {"Qx": 20, "increments": 3}]
    setup = setup_of(bodies=bodies, load_path=loads)
    assert coarse_counts(setup, (True, True)).third == third


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
    ("count", "third", "half"), [(1, 1, 1), (4, 2, 1), (5, 5, 5), (6, 6, 3), (8, 4, 2), (12, 6, 3)]
)
def test_coarse_runs_press_in_fewer_increments_where_nothing_slips(count: int, third: int, half: int) -> None:
    pressed = coarse_counts(setup_of(load_path=[{"P": 400, "increments": count}]), (False,))
    assert pressed == CoarseCounts((third,), None, (half,))
    setup = setup_of(load_path=[{"P": 400, "increments": count}, {"Qx": 20, "increments": 8}])
    assert coarse_counts(setup, (False, True)) == CoarseCounts((third, 4), (1, 2), (half, 2))
