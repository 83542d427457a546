"""The path of the shear, over what friction carries."""

import math
from types import SimpleNamespace
from typing import Any, cast

import pytest

from fretsolve.simulation.error_bars.shear_memory import NO_SHEAR
from fretsolve.simulation.error_bars.shear_path import LEAST_LEFT, TURNS_SEEN, ShearPath, StickEdges


def summary(**loads: float) -> Any:
    return cast(
        Any,
        SimpleNamespace(
            **{
                "Qx": 0.0,
                "Qy": 0.0,
                "Mz": 0.0,
                "P": 400.0,
                "contact_radius": 0.3,
                "stick_radius": 0.3,
                "stage": 1,
                "work": 0.0,
                **dict.fromkeys(("delta_x", "delta_y", "phi_z"), 0.0),
            }
            | loads
        ),
    )


def test_a_reversal_goes_twice_the_way_and_keeps_the_largest_share():
    path = ShearPath().after(summary(Qx=30.0), 40.0, 0.0, 1e-6).after(summary(Qx=-30.0), 40.0, 0.0, 2e-6)
    assert (path.last, path.length, path.largest) == pytest.approx((1.5, 2.25, 0.75))
    assert (path.last_at_edge, path.at_edge) == pytest.approx((2e-6, 3e-6))
    assert path.left == pytest.approx(0.25)


def test_the_part_of_the_work_that_strains_is_nothing_where_all_slides() -> None:
    stuck = ShearPath().after(summary(Qx=30.0, delta_x=1e-3), 40.0, 0.0, 0.0)
    assert stuck.strained == 1.0
    slid = stuck.after(summary(Qx=30.0, delta_x=3e-3, work=0.06), 40.0, 0.0, 0.0)
    assert slid.strained == pytest.approx(0.0, abs=1e-12)
    turned = slid.after(summary(Qx=30.0, Mz=3.0, delta_x=3e-3, phi_z=1e-3, work=1e-3), 40.0, 0.0, 0.0)
    assert turned.strained == pytest.approx(1.0 - 1e-3 / 1.5e-3)
    assert turned.after(summary(Qx=30.0, delta_x=math.nan, work=1.0), 40.0, 0.0, 0.0).strained == 1.0


def test_each_way_counts_under_its_own_load() -> None:
    """With the power 8/3 of the larger P of its ends, over that of now; pressing alone does not count."""
    path = ShearPath().after(summary(P=1000.0), 100.0, 0.0, 0.0).after(summary(P=400.0), 40.0, 0.0, 0.0)
    path = path.after(summary(P=400.0, Qx=10.0), 40.0, 0.0, 0.0)
    assert path.ways_under_load == pytest.approx((0.25, 0.25))
    path = path.after(summary(P=200.0, Qx=10.0), 20.0, 0.0, 0.0)
    assert path.ways_under_load == pytest.approx((0.25 * 2.0 ** (8 / 3), 0.5 * 2.0 ** (8 / 3)))
    assert path.after(summary(P=200.0, Qx=10.0), 20.0, 0.0, 0.0).ways_under_load[0] == 0.0
    opened = path.after(summary(P=0.0), 0.0, 0.0, 0.0)
    assert opened.ways_under_load == (0.0, 0.0)
    again = opened.after(summary(P=200.0, Qx=10.0), 20.0, 0.0, 0.0)
    assert again.ways_under_load == pytest.approx((0.0, 0.5 * 2.0 ** (8 / 3)))


def test_the_smallest_stick_radius_is_that_under_shear():
    path = ShearPath().after(summary(stick_radius=0.0), 0.0, 0.0, 0.0)
    for radius in (0.2, 0.1, 0.15):
        path = path.after(summary(Qx=30.0, stick_radius=radius), 40.0, 0.0, 0.0)
    assert path.edges == StickEdges(smallest=0.1)


def test_the_stick_radius_at_the_last_turn():
    path = ShearPath()
    for force, radius in ((20.0, 0.2), (30.0, 0.1), (0.0, 0.25), (-30.0, 0.12), (0.0, 0.26), (0.0, 0.26)):
        path = path.after(summary(Qx=force, stick_radius=radius), 40.0, 0.0, 0.0)
    assert path.edges.turned == 0.12
    assert path.after(summary(Qy=30.0, stick_radius=0.15), 40.0, 0.0, 0.0).edges.turned == 0.12


def test_the_coarsest_increment_is_the_longest_one_over_what_it_leaves():
    path = ShearPath().after(summary(Qx=20.0), 40.0, 0.0, 0.0)
    assert path.coarsest == pytest.approx(1.0)
    assert path.after(summary(Qx=22.0), 40.0, 0.0, 0.0).coarsest == pytest.approx(1.0)
    assert path.after(summary(Qx=36.0), 40.0, 0.0, 0.0).coarsest == pytest.approx(4.0)


def test_a_torque_counts_over_two_thirds_of_the_radius():
    assert ShearPath().after(summary(Mz=4.0), 40.0, 0.0, 0.0).largest == pytest.approx(0.5)


def test_gross_slip_leaves_the_least():
    path = ShearPath().after(summary(Qx=24.0, Qy=32.0), 40.0, 0.0, 0.0)
    assert path.left == LEAST_LEFT
    assert path.largest == 1.0


def test_pressing_unlike_bodies_is_no_way_and_neither_is_lost_contact():
    pressed = ShearPath().after(summary(), 40.0, 0.5, 1e-6)
    assert (pressed.length, pressed.largest) == (0.0, 0.5)
    lost = pressed.after(summary(Qx=1.0), 0.0, 0.0, 1.0)
    assert (lost.last, lost.length, lost.last_at_edge, lost.at_edge) == (0.0, pressed.length, 0.0, 1e-6)


def test_it_keeps_the_summary_of_the_largest_load_before():
    loads = [summary(P=10.0), summary(P=50.0), summary(P=20.0)]
    path = ShearPath()
    for one in loads:
        path = path.after(one, 40.0, 0.0, 0.0)
    assert (path.now, path.before) == (loads[2], max(loads[:2], key=lambda one: one.P))


def test_it_keeps_the_last_two_summaries():
    first, second = summary(Qx=30.0), summary(Qx=-30.0)
    path = ShearPath().after(first, 40.0, 0.0, 0.0)
    assert (path.now, path.before) == (first, None)
    for carried in (40.0, 0.0):
        after = path.after(second, carried, 0.0, 0.0)
        assert (after.now, after.before) == (second, first)


def test_a_shear_moves_on_unless_it_is_held_or_goes_back():
    path, found = ShearPath(), []
    for force in (20.0, 20.001, 30.0, 10.0, -10.0, -20.0):
        path = path.after(summary(Qx=force), 40.0, 0.0, 0.0)
        found.append(path.moves_on)
    assert found == [True, False, True, False, True, True]


def test_ways_across_the_shear_count_by_the_increments_of_their_stage():
    """The largest stage counts; a shear that grows, falls or is reversed does not turn."""
    path = ShearPath().after(summary(Qx=30.0, stage=1), 40.0, 0.0, 0.0, 4)
    assert path.turned == 0.0
    turned = path.after(summary(Qx=30.0, Qy=20.0, stage=2), 40.0, 0.0, 0.0, 2)
    assert turned.turned == pytest.approx(0.5 / (2 + TURNS_SEEN))
    on = turned.after(summary(Qx=-30.0, Qy=-20.0, stage=3), 40.0, 0.0, 0.0, 1)
    assert (on.turning, on.turned) == pytest.approx((0.0, turned.turned), abs=1e-12)
    twice = turned.after(summary(Qx=42.0, Qy=2.0, stage=2), 40.0, 0.0, 0.0, 2)
    assert twice.turned == pytest.approx((0.5 + math.hypot(12.0, -18.0) / 40.0) / (2 + TURNS_SEEN))


def test_shear_and_load_that_change_together_are_remembered_as_they_do_and_as_the_increments_do():
    """From 0 to P and Q below the friction limit nothing slips, but an increment shears all that it presses."""
    path = (
        ShearPath()
        .after(summary(P=50.0, Qx=5.0), 15.0, 0.0, 0.0)
        .after(summary(P=100.0, Qx=10.0, work=1e-3), 30.0, 0.0, 0.0)
    )
    assert path.memory.slipping == 0.0
    assert path.at_once.slipping == pytest.approx(5.0 / 30.0)
    assert path.last_at_edge == pytest.approx(1e-3)  # all that it dissipates
    held = (
        ShearPath().after(summary(P=100.0), 30.0, 0.0, 0.0).after(summary(P=100.0, Qx=10.0, work=1e-3), 30.0, 0.0, 0.0)
    )
    assert held.memory.slipping == pytest.approx(held.at_once.slipping) == pytest.approx(1.0 / 3.0)
    assert held.last_at_edge == pytest.approx(0.0, abs=1e-15)


def test_an_opened_contact_remembers_no_shear():
    path = ShearPath().after(summary(), 40.0, 0.0, 0.0).after(summary(Qx=30.0), 40.0, 0.0, 0.0)
    assert path.after(summary(P=0.0), 0.0, 0.0, 0.0).memory == NO_SHEAR
