"""A line contact whose edge slips backwards at first: in many increments it sticks again, in one step it does not."""

from __future__ import annotations

import pytest
from line_cases import FRICTION, HERTZ, LOAD, MATERIAL, A, cells_per_half_width, solve_line

from fretsolve.reference.line_slip import LinePartialSlip


def ends_of(f, b, increments):
    """Ends of the stick zone over a, by the closed form and found."""
    strain = MATERIAL.A * FRICTION * HERTZ.max_pressure
    exact = LinePartialSlip(HERTZ, FRICTION, f * FRICTION * LOAD, MATERIAL.A, b * strain)
    stage = {"Qx": exact.shear_force, "bulk_2": {"xx": 4.0 * b * FRICTION * HERTZ.max_pressure}}
    path = [{"P": LOAD}, {**stage, "increments": increments}]
    found = solve_line(grid=cells_per_half_width(80), load_path=path)[-1].summary
    half, middle = found.stick_half_width_x, found.stick_center_x
    return exact, (middle - half) / A, (middle + half) / A


@pytest.mark.parametrize("increments", [1, pytest.param(40, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("f", "b"), [(0.3, 0.2), (0.1, 0.3), (0.0, 0.3)])
def test_a_growing_zone_of_backward_slip_is_that_of_the_closed_form(f, b, increments):
    exact, low, high = ends_of(f, b, increments)
    assert exact.is_reached_in_proportion
    assert (low, high) == pytest.approx([end / A for end in exact.stick_zone], abs=0.1 / 80)


def test_a_shrinking_one_sticks_at_once():
    exact, low, high = ends_of(0.6, 0.5, 1)
    assert not exact.is_reached_in_proportion
    assert (low, high) == pytest.approx([end / A for end in exact.stick_zone], abs=0.02 / 80)
    _, low, high = ends_of(0.6, 0.5, 40)
    assert low == pytest.approx(exact.stick_zone[0] / A, abs=0.1 / 80)
    assert high == pytest.approx(1.0, abs=0.5 / 80)
