"""The measures of one loop of force over displacement, on loops that are drawn by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.result.cycles.loops import area, ends_of_loop, half_width, reversal_stiffness

STIFF, LIMIT, END = 50.0, 10.0, 1.0
"""Slope (N/mm) and friction force (N) of a slider on a spring that is moved between -END and END (mm)."""


def slider() -> tuple[np.ndarray, np.ndarray]:
    """Force and motion of a cycle from END to END, with a point at each corner and two more on the stiff branches."""
    back = END - 2.0 * LIMIT / STIFF
    motion = np.array([END, 0.5 * (END + back), back, -END, -0.5 * (END + back), -back, END])
    force = LIMIT * np.array([1.0, 0.0, -1.0, -1.0, 0.0, 1.0, 1.0])
    return force, motion


def test_a_parallelogram() -> None:
    force, motion = slider()
    begin, end = ends_of_loop(motion)
    assert (begin, end) == (0, 3)
    assert half_width(force, motion, begin, end) == (pytest.approx(END - LIMIT / STIFF), pytest.approx(0.0, abs=1e-12))
    assert reversal_stiffness(force, motion) == (pytest.approx(STIFF), pytest.approx(0.0, abs=1e-12))


def test_a_line_has_no_width() -> None:
    motion = np.array([1.0, 0.0, -1.0, 0.0, 1.0])
    assert half_width(3.0 * motion, motion, *ends_of_loop(motion)) == (0.0, 0.0)
    assert reversal_stiffness(3.0 * motion, motion) == (pytest.approx(3.0), pytest.approx(0.0, abs=1e-12))


def test_a_slope_that_falls_in_proportion_to_the_force_is_extrapolated() -> None:
    """u = F/k (1 + F/c): the compliance of increments 1 and 2 lies on a line to that of none."""
    force = np.array([0.0, 1.0, 2.0, 3.0])
    motion = force / 20.0 * (1.0 + force / 10.0)
    back, moved_back = 3.0 - force[1:], motion[-1] - motion[1:]
    found, error = reversal_stiffness(np.concatenate([force, back]), np.concatenate([motion, moved_back]))
    assert found == pytest.approx(20.0)
    assert error == pytest.approx(20.0 - 20.0 / 1.1)


def test_a_branch_that_does_not_reach_the_mean_force_has_no_width() -> None:
    force, motion = np.array([4.0, 3.0, 2.5, 0.0]), np.array([0.0, 0.5, 1.0, 0.5])
    assert math.isnan(half_width(force, motion, 0, 2).value)


def test_rounding_of_a_held_force_is_no_chord_and_no_reversal() -> None:
    """The normal load changes at both ends: the force is held but for rounding, and the motion turns a little."""
    force = np.array([-60.0, -60.0 + 2e-14, 0.0, 60.0, 60.0 - 2e-14, 0.0, -60.0])
    motion = np.array([-1.0, -1.0 + 1e-9, 0.2, 1.0, 1.0 - 1e-9, -0.2, -1.0])
    width = half_width(force, motion, *ends_of_loop(motion))
    assert abs(width.value - 0.2) <= width.error + 1e-12 < 1.0
    # the motion turns back at the ends, before it goes on with the force
    back = np.array([-1.0, -1.0 - 1e-9, -0.5, 0.0, 1.0, 1.0 + 1e-9, 0.5, 0.0, -1.0])
    forces = np.array([-60.0, -60.0, -20.0, 17.0, 60.0, 60.0, 20.0, -17.0, -60.0])
    # compliances of 1/80 and 1/77 over 40 and 77 N
    exact = 1.0 / (1.0 / 80.0 - (1.0 / 77.0 - 1.0 / 80.0) * 40.0 / 37.0)
    assert reversal_stiffness(forces, back).value == pytest.approx(exact, rel=1e-6)


def test_branches_of_one_increment_have_no_width() -> None:
    assert math.isnan(half_width(np.array([1.0, -1.0, 1.0]), np.array([1.0, -1.0, 1.0]), 0, 1).value)


def test_the_branch_back_of_a_first_cycle_does_not_go_by_the_virgin_curve() -> None:
    """From 0 to an end, to the other one and back to 0: the branch back crosses the mean force where it ends."""
    force = np.array([0.0, 2.0, 4.0, 0.0, -4.0, -2.0, 0.0])
    motion = np.array([0.0, 0.1, 1.0, 0.6, -0.6, -0.5, -0.3])
    width = half_width(force, motion, *ends_of_loop(motion))
    assert abs(width.value - 0.45) <= width.error + 1e-12 < 0.2


@pytest.mark.parametrize(("increments", "known"), [(4, False), (12, True), (40, True)])
def test_the_area_of_a_polygon_of_few_increments_is_unbounded(increments: int, known: bool) -> None:
    """An ellipse of area pi, by chords."""
    angle = np.linspace(0.0, 2.0 * math.pi, increments + 1)
    found = area(np.cos(angle), np.sin(angle))
    assert abs(found.value - math.pi) <= found.error
    assert math.isfinite(found.error) == known


def test_nothing_that_moves_has_no_slope() -> None:
    assert all(map(math.isnan, reversal_stiffness(np.zeros(4), np.zeros(4))))
