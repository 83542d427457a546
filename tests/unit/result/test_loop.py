"""The measures of one loop of force over displacement, on loops that are drawn by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.result.cycles.loop import ends_of_loop, half_width, reversal_stiffness

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


def test_nothing_that_moves_has_no_slope() -> None:
    assert all(map(math.isnan, reversal_stiffness(np.zeros(4), np.zeros(4))))
