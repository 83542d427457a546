"""What coarse runs do not show of tangential motion."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_states import fake_states
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.result.state import ESTIMATED, Summary
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors.least_errors import STRETCH, LeastErrors
from fretsolve.simulation.error_bars.missed_motion import (
    LATE,
    LATE_EDGE,
    LATE_ENERGY,
    LATER_EDGE,
    NOTHING_MISSED,
    UNLOADED,
    UNLOADED_STICK,
    MissedMotion,
    edge_of_unloading,
    of_unloading,
    pressed_up_to,
)
from fretsolve.simulation.error_bars.quantity_estimates import ALL


def summary(**values: Any) -> Summary:
    (state,) = fake_states(1)
    return replace(state.summary, **values)


def least(missed: MissedMotion, now: Summary) -> dict[str, float]:
    """Return the least errors by name."""
    errors = np.zeros(len(ESTIMATED))
    missed.add_to(errors, now)
    return dict(zip(ESTIMATED, errors.tolist(), strict=True))


BEFORE = summary(contact_radius=0.24, delta_x=1e-4, Qx=5.0, delta_z=8e-3, work=1e-5, work_total=1e-5)
LATE_ONE = summary(contact_radius=0.30, delta_x=6e-4, Qx=30.0, delta_z=9e-3, work=3e-5, work_total=4e-5)


def test_late_contact_may_err_by_a_part_of_what_the_increment_moves() -> None:
    errors = least(NOTHING_MISSED.after_late_contact(BEFORE, LATE_ONE, 0.3), LATE_ONE)
    assert errors["delta_x"] == pytest.approx(LATE * 0.2 * 5e-4)
    assert errors["Qx"] == pytest.approx(LATE * 0.2 * 25.0)
    assert (errors["work"], errors["work_total"]) == pytest.approx((LATE_ENERGY * 0.2 * 3e-5, LATE_ENERGY * 0.2 * 3e-5))
    assert errors["stick_radius"] == pytest.approx(LATE_EDGE * 0.06)
    assert errors["delta_z"] == errors["max_pressure"] == errors["contact_radius"] == 0.0


def test_it_stays_in_what_comes_later_and_does_not_add_up() -> None:
    missed = NOTHING_MISSED.after_late_contact(BEFORE, LATE_ONE, 0.3)
    later = least(missed.after(0.0), replace(LATE_ONE, work=0.0))
    assert later["delta_x"] == pytest.approx(LATE * 0.2 * 5e-4)
    assert (later["work"], later["work_total"]) == (0.0, pytest.approx(LATE_ENERGY * 0.2 * 3e-5))
    assert later["stick_radius"] == pytest.approx(LATER_EDGE * 0.06)
    again = least(missed.after_late_contact(BEFORE, LATE_ONE, 0.3), LATE_ONE)
    assert again["delta_x"] == later["delta_x"]


def test_all_contact_is_late_where_nothing_touched_before() -> None:
    errors = least(NOTHING_MISSED.after_late_contact(None, LATE_ONE, 0.3), LATE_ONE)
    assert errors["work_total"] == pytest.approx(ALL * 4e-5)
    assert errors["delta_x"] == pytest.approx(LATE * 6e-4)


def test_middles_of_no_zone_leave_other_errors_known() -> None:
    unknown = replace(BEFORE, stick_center_x=math.nan)
    errors = least(NOTHING_MISSED.after_late_contact(unknown, LATE_ONE, 0.3), LATE_ONE)
    assert not any(map(math.isnan, errors.values()))


@pytest.mark.parametrize(
    ("radius", "shear"), [(0.3, 5.0), (0.30, 30.0), (0.35, 30.0)], ids=["no shear", "no growth", "shrinks"]
)
def test_contact_is_late_only_if_it_grows_and_is_sheared(radius: float, shear: float) -> None:
    now = replace(LATE_ONE, Qx=shear)
    before = replace(BEFORE, contact_radius=radius if shear == 30.0 else 0.24)
    missed = NOTHING_MISSED.after_late_contact(before, now, 0.3)
    assert not any(least(missed, now).values())


def test_the_largest_unseen_middle_stays() -> None:
    missed = NOTHING_MISSED.after(2e-5).after(1e-5)
    errors = least(missed, LATE_ONE)
    assert errors["delta_x"] == errors["delta_y"] == 2e-5


def test_the_middle_is_unseen_where_unlike_bodies_are_tilted_and_slip_in_all_cells() -> None:
    path = [{"P": 400.0}]
    unlike, like = (
        LeastErrors.of(set_up(build(bodies=bodies, friction=0.02, grid={"points": 32, "size": 0.9}, load_path=path)))
        for bodies in (DISSIMILAR, SIMILAR)
    )
    tilted = summary(contact_radius=0.3, delta_z=9e-3, phi_y=1e-3, phi_x=0.0, max_pressure=2000.0)
    materials = unlike.model.compliances
    stretched = abs(materials.dundurs_constant) * 2000.0 / materials.contact_modulus * unlike.side
    assert unlike.unseen_middle(tilted) == pytest.approx(STRETCH * stretched)
    assert unlike.unseen_middle(replace(tilted, phi_y=0.0)) == 0.0
    assert like.unseen_middle(tilted) == 0.0
    sticking = LeastErrors.of(
        set_up(build(bodies=DISSIMILAR, friction=1.0, grid={"points": 32, "size": 0.9}, load_path=path))
    )
    assert sticking.unseen_middle(tilted) == 0.0


def test_unloading_goes_back_to_what_few_increments_had_pressed() -> None:
    unlike, like = (
        set_up(build(bodies=bodies, friction=0.4, grid={"points": 16})).model for bodies in (DISSIMILAR, SIMILAR)
    )
    pressed = [summary(P=load, contact_radius=0.3) for load in (100.0, 200.0, 300.0, 400.0)]
    counts = [pressed_up_to([*pressed, summary(P=load)], 400.0) for load in (50.0, 100.0, 250.0, 400.0, 0.0)]
    assert counts == [1, 1, 2, 0, 0]
    mismatch = abs(unlike.compliances.dundurs_constant)
    assert of_unloading(unlike, 1) == pytest.approx(UNLOADED * (mismatch * 0.4 / (mismatch + 0.4)) ** 2)
    assert of_unloading(unlike, 2) == pytest.approx(of_unloading(unlike, 1) / 2.0)
    assert edge_of_unloading(unlike, pressed[0], 2) == pytest.approx(UNLOADED_STICK * 0.3 / 4.0)
    slipping = replace(unlike, friction=0.5 * mismatch)
    assert edge_of_unloading(slipping, pressed[0], 1) == pytest.approx(0.5 * UNLOADED_STICK * 0.3)
    for law in (of_unloading(unlike, 0), of_unloading(like, 1), edge_of_unloading(like, pressed[0], 1)):
        assert law == 0.0
    assert edge_of_unloading(unlike, pressed[0], 0) == 0.0
