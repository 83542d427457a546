"""Coarse runs, also those whose larger cells do not hold the contact within the area of the run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from line_cases import HERTZ as LINE_HERTZ
from line_cases import LOAD as LINE_LOAD
from line_cases import line_case
from solving import DISSIMILAR, FRICTION, HERTZ, LOAD, MATERIAL, A, build, setup_of

from fretsolve.errors import GridEdgeError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.reference.tangential import cattaneo_mindlin
from fretsolve.result.state import ESTIMATED, State
from fretsolve.simulation.error_bars.coarse_runs import (
    MOST_RINGS,
    CoarseRun,
    CoarseRuns,
    PathPoint,
    coarser,
    common_points,
)
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up

FORCE = 0.6 * FRICTION * LOAD
PATH = [{"P": LOAD, "increments": 4}, {"Qx": FORCE, "increments": 4}]
TIGHT = 0.66
"""Size (mm) of an area that holds the contact on 24 points, but not on 8."""


def with_bars(setup: ProblemSetup) -> tuple[State, list[str]]:
    """Return the last state, and what was told of the bars."""
    told: list[str] = []
    *_, last = run_with_error_bars(setup, warn=told.append)
    return last, told


def bar(state: State, name: str) -> float:
    found: float = getattr(state.errors, f"{name}_error")
    return found


def test_a_tight_area_has_bars_as_a_wide_one_has() -> None:
    """The contact reaches the last cells of the coarsest run when it is nearly pressed."""
    tight, wide = (
        set_up(build(coupling="none", grid={"points": points, "size": points * TIGHT / 24}, load_path=PATH))
        for points in (24, 36)
    )
    (found, told), (expected, _) = with_bars(tight), with_bars(wide)
    assert not told
    stick = cattaneo_mindlin(HERTZ, FRICTION, FORCE, MATERIAL.tangential).stick_radius
    for name, exact in {"contact_radius": A, "delta_z": HERTZ.delta_z, "stick_radius": stick}.items():
        assert abs(getattr(found.summary, name) - exact) <= bar(found, name)
        assert bar(found, name) == pytest.approx(bar(expected, name), rel=0.5)


def test_a_tight_line_has_bars() -> None:
    """On 24 points across 2.15 half-widths a cell is free at each end, and the 8 cells of the coarsest run are not."""
    grid = {"points": 24, "size": 2.15 * LINE_HERTZ.half_width}
    found, told = with_bars(set_up(line_case(grid=grid, load_path=[{"P": LINE_LOAD}])))
    assert not told
    half_width = LINE_HERTZ.half_width
    assert abs(found.summary.contact_radius - half_width) <= bar(found, "contact_radius") < 0.1 * half_width


def test_a_ring_leaves_the_values_as_they_were() -> None:
    setup = coarser(set_up(build(grid={"points": 24, "size": TIGHT}, load_path=PATH[:1])), 3, (4,))
    ring = replace(setup, grid=setup.grid.with_ring())
    values = [[CoarseRun(one, 1).values(step) for step in range(2)] for one in (setup, ring)]
    known = np.isfinite(values[0])
    np.testing.assert_allclose(*(np.array(one)[known] for one in values), rtol=1e-3, atol=1e-4)
    assert known.mean() > 0.8


def test_an_area_that_no_ring_makes_large_enough() -> None:
    setup = set_up(build(grid={"points": 24, "size": 0.2}, load_path=PATH[:1]))
    run = CoarseRun(coarser(setup, 3, (4,)), 1)
    assert np.isnan(run.values(3)).all()
    assert isinstance(run.failure, GridEdgeError)
    assert run.setup.grid.shape == (8 + 2 * MOST_RINGS, 8 + 2 * MOST_RINGS)


@pytest.mark.parametrize("half", [33, 45])
def test_height_maps_have_bars_where_they_end_beside_the_contact(tmp_path: Path, half: int) -> None:
    """The larger cells at their end may be in contact. half: heights on each side of the middle, one at 0.01 mm."""
    x = np.arange(-half, half + 1) * 0.01
    np.save(tmp_path / "sphere.npy", (x[:, None] ** 2 + x**2) / 20.0)
    surface: list[Any] = [{"heights": {"file": str(tmp_path / "sphere.npy"), "spacing": 0.01}}]
    setup = set_up(build(surface=surface, grid={"points": 24, "size": TIGHT}, load_path=PATH[:1]))
    found, told = with_bars(setup)
    assert not told
    for name, exact in {"contact_radius": A, "delta_z": HERTZ.delta_z, "max_pressure": HERTZ.max_pressure}.items():
        assert abs(getattr(found.summary, name) - exact) <= bar(found, name) < 0.05 * exact, name


def test_coarser_scene_has_half_of_the_points_on_the_same_area() -> None:
    setup = set_up(build(grid={"points": [17, 24], "size": 0.8}, load_path=[{"P": 400, "increments": 3}]))
    coarse = coarser(setup, 2, (2,))
    assert coarse.grid.shape == (9, 12)
    assert coarse.grid.size == pytest.approx(setup.grid.size)
    assert coarse.load_path.counts == (2,)
    assert coarse.case.solver.tolerance == pytest.approx(3e-5)
    assert setup.load_path.counts == (3,)
    assert coarser(setup, 3, (2,)).grid.shape == (8, 8)


@pytest.mark.parametrize(("tolerance", "looser"), [(1e-9, 3e-8), (5e-5, 1e-4), (1e-3, 1e-3)])
def test_coarse_runs_are_never_stricter(tolerance: float, looser: float) -> None:
    setup = setup_of(solver={"tolerance": tolerance})
    assert coarser(setup, 2, (1,)).case.solver.tolerance == pytest.approx(looser)


def test_coarse_run_goes_as_far_as_it_is_asked() -> None:
    path = [{"P": 400}, {"Qx": 20, "increments": 4}]
    coarse = CoarseRun(setup_of(load_path=path), 1)
    assert coarse.values(-1) is not None
    assert coarse.applications == 0
    one, three = coarse.values(1), coarse.values(3)
    assert one is not None and three is not None
    spent = coarse.applications
    middle = coarse.values_at(PathPoint(1, 0.5))
    between = coarse.values_at(PathPoint(1, 0.625))
    assert coarse.applications == spent
    assert middle is not None and between is not None
    assert between[ESTIMATED.index("Qx")] == pytest.approx(12.5)
    np.testing.assert_allclose(between, 0.5 * (middle + three))


@pytest.mark.parametrize(
    ("counts", "third", "other", "half"),
    [
        ((1, 8), (1, 8), (2, 16), (1, 8)),
        ((2, 8), (2, 8), (4, 16), (2, 8)),
        ((8, 3), (4, 2), (8, 4), (4, 2)),
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


def test_points_at_which_both_coarse_runs_have_an_increment() -> None:
    path = [{"P": 400, "increments": 4}, {"Qx": 20, "increments": 1}, {"Qx": 30, "increments": 5}]
    fine = setup_of(bodies=DISSIMILAR, load_path=path).load_path
    fewer = fine.with_counts((2, 1, 2))
    assert common_points(fine, fewer, PathPoint(0, 0.25)) == (PathPoint(0, 0.0), PathPoint(0, 0.5), 0.5)
    assert common_points(fine, fewer, PathPoint(0, 0.5)) == (PathPoint(0, 0.5), PathPoint(0, 0.5), 0.0)
    first, second, share = common_points(fine, fewer, PathPoint(2, 0.2))
    assert (first, second) == (PathPoint(1, 1.0), PathPoint(2, 0.5))
    assert share == pytest.approx(0.4)
