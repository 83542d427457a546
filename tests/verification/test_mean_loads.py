"""Cyclic loads with a mean value: cells come to the friction limit in each cycle and do not move, so they stick."""

from __future__ import annotations

import math

import numpy as np
import pytest
import solving
from line_cases import FRICTION, HERTZ, LOAD, A, cells_per_half_width, solve_line

from fretsolve.result.state import Zone

LIMIT = FRICTION * LOAD


@pytest.mark.parametrize("least", [0.06, 0.35])
@pytest.mark.parametrize("increments", [1, 20])
def test_cylinder(least, increments):
    """Between 0.6 and `least` of mu P the stick zone is that of half their difference: c = a sqrt(1 - f).

    At 0.6 the cells that slipped in the first load alone are at the limit again, and little shows the zone's edge.
    """
    to_most = {"Qx": 0.6 * LIMIT, "increments": increments}
    path = [{"P": LOAD}, to_most, *[{"Qx": least * LIMIT, "increments": increments}, to_most] * 2]
    states = solve_line(grid=cells_per_half_width(80), load_path=path)
    exact, cell = A * math.sqrt(1.0 - 0.5 * (0.6 - least)), A / 80
    for end in range(2, 6):
        state = states[end * increments]
        within = 0.1 if increments == 1 or end in (2, 4) else 0.75
        assert state.summary.stick_radius == pytest.approx(exact, abs=within * cell)
        assert state.summary.stick_cells * 0.5 * cell == pytest.approx(exact, abs=0.75 * cell)
    # at the largest load more cells are at the friction limit than slip
    q, p, zone = states[-1].fields.shear[0], states[-1].fields.pressure, states[-1].fields.zone
    at_limit = (p > 0.0) & (q >= (1.0 - 1e-5) * FRICTION * p)
    first = A - A * math.sqrt(0.4)
    assert np.count_nonzero(at_limit) == pytest.approx(2.0 * first / cell, abs=4)
    assert np.count_nonzero(at_limit & (zone == Zone.STICK)) == pytest.approx(
        2.0 * (exact - A * math.sqrt(0.4)) / cell, abs=4
    )


@pytest.mark.parametrize("increments", [5, 40])
@pytest.mark.parametrize("cells", [10, 33])
@pytest.mark.parametrize("least", [0.1, 0.35])
def test_unloading_in_small_increments(least, cells, increments):
    """Behind the edge the shear traction still has its first direction, and is farther from the limit opposite to it.

    Measured to the limit in its own direction, the zone was up to 0.65 of a cell too large.
    """
    path = [{"P": LOAD}, *({"Qx": part * LIMIT, "increments": increments} for part in (0.7, least))]
    states = solve_line(grid=cells_per_half_width(cells), load_path=path)
    exact = A * math.sqrt(1.0 - 0.5 * (0.7 - least))
    assert states[-1].summary.stick_radius == pytest.approx(exact, abs=0.15 * A / cells)


@pytest.mark.slow
def test_a_force_that_turns_back_askew():
    """By 165 degrees from x, in small increments: the traction behind the edge is neither along nor against the slip.

    Measured to the limit in its own direction, the zone was 0.26 and 0.12 of a cell too large.
    """
    limit = solving.FRICTION * solving.LOAD
    back = 0.6 + 0.45 * math.cos(math.radians(165.0)), 0.45 * math.sin(math.radians(165.0))
    stages = [{"Qx": 0.6 * limit, "increments": 1}, {"Qx": back[0] * limit, "Qy": back[1] * limit, "increments": 20}]
    found = {}
    for cells in (13, 17, 64):
        points = 2 * math.ceil(1.2 * cells)
        grid = {"points": points, "size": points * solving.A / cells}
        (*_, last) = solving.solve(grid=grid, coupling="none", load_path=[{"P": solving.LOAD}, *stages])
        found[cells] = last.summary.stick_radius / solving.A
    assert found[13] == pytest.approx(found[64], abs=0.1 / 13)
    assert found[17] == pytest.approx(found[64], abs=0.1 / 17)


@pytest.mark.parametrize("cells", [12, 41])
def test_cycles_after_a_larger_load(cells):
    """The cells inside the edge slipped in the larger load: what they slipped then is not of this front."""
    turns = [{"Qx": part * LIMIT, "increments": 1} for part in (0.8, -0.5, 0.5)]
    states = solve_line(grid=cells_per_half_width(cells), load_path=[{"P": LOAD}, *turns])
    found = [state.summary.stick_radius for state in states[2:]]
    assert found == pytest.approx([A * math.sqrt(1.0 - 0.65), A * math.sqrt(0.5)], abs=0.03 * A / cells)


def test_bulk_stress_at_a_load_ratio_of_a_tenth():
    """After shakedown the stick zone is at both ends of the cycle that of half the ranges of force and stress."""
    unit = 4.0 * FRICTION * HERTZ.max_pressure
    most = {"Qx": 0.6 * LIMIT, "bulk_2": {"xx": 0.52 * unit}, "increments": 20, "spacing": "graded"}
    least = {**most, "Qx": -0.6 * LIMIT, "bulk_2": {"xx": 0.052 * unit}}
    mean = {"bulk_2": {"xx": 0.286 * unit}, "increments": 10}
    states = solve_line(grid=cells_per_half_width(160), load_path=[{"P": LOAD}, mean, *[most, least] * 3])
    shift = 0.5 * (0.52 - 0.052)
    for number in (4, 5, 6):
        summary = states[10 + 20 * number].summary
        assert summary.stick_half_width_x == pytest.approx(A * math.sqrt(0.4), abs=0.75 * A / 160)
        assert summary.stick_center_x == pytest.approx(A * shift, abs=0.75 * A / 160)


@pytest.mark.parametrize("least", [0.06, 0.3])
def test_sphere(least):
    """c = a (1 - f)^(1/3) with f half the difference, 10 % above that of the largest load."""
    limit = solving.FRICTION * solving.LOAD
    to_most = {"Qx": 0.6 * limit, "increments": 3}
    path = [{"P": solving.LOAD}, to_most, *[{"Qx": least * limit, "increments": 3}, to_most] * 2]
    states = solving.solve(grid={"points": 64, "size": 0.74}, coupling="none", load_path=path)
    exact = solving.A * math.cbrt(1.0 - 0.5 * (0.6 - least))
    for end in range(2, 6):
        assert states[3 * end].summary.stick_radius == pytest.approx(exact, abs=0.25 * 0.74 / 64)
