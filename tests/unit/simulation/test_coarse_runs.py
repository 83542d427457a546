"""Coarse runs, also those whose larger cells do not hold the contact within the area of the run."""

from __future__ import annotations

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
from fretsolve.result.state import State
from fretsolve.simulation.error_bars.coarse_runs import MOST_RINGS, CoarseRun, coarser
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
