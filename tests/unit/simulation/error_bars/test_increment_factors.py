"""Factors on the errors of the increments; `tests/verification/test_bars_hold.py` compares bars with true errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fake_states import fake_states
from solving import build

from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.coarse_counts import sheared_stages
from fretsolve.simulation.error_bars.increment_factors import (
    ALONE,
    ALONE_AT_ONCE,
    ASKEW,
    CORRECTED_ALONE,
    CORRECTED_ASKEW,
    CORRECTED_ASKEW_ENERGY,
    CORRECTED_AT_ONCE,
    CORRECTED_LONG,
    CORRECTED_LONG_ASKEW,
    CORRECTED_SAFETY,
    HIDDEN_ENERGY,
    HIDDEN_MOTION,
    HIDDEN_TURNED,
    LONG,
    LONG_ASKEW,
    LONG_STEP,
    HiddenNearSliding,
    Steps,
    moved_sideways,
)
from fretsolve.simulation.error_bars.quantity_estimates import DELTA_X, DELTA_Y, MX, SAFETY, STICK, TOTAL, WORK
from fretsolve.simulation.error_bars.shear_path import ShearPath

LONG_STEPS = 1.01 * LONG_STEP


@pytest.mark.parametrize(
    ("steps", "displacement", "energy"),
    [
        (Steps(), (SAFETY[DELTA_X], CORRECTED_SAFETY), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(coarsest=LONG_STEP), (SAFETY[DELTA_X], CORRECTED_SAFETY), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(alone=True), (ALONE, CORRECTED_ALONE), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(coarsest=LONG_STEPS), (LONG, CORRECTED_LONG), (LONG, CORRECTED_LONG)),
        (Steps(askew=True), (ASKEW, CORRECTED_ASKEW), (ASKEW, CORRECTED_ASKEW_ENERGY)),
        (Steps(askew=True, coarsest=LONG_STEPS), (LONG_ASKEW, CORRECTED_LONG_ASKEW), (ASKEW, CORRECTED_ASKEW_ENERGY)),
        (Steps(pressed_at_once=True), (ALONE, CORRECTED_ALONE), (ALONE, CORRECTED_ALONE)),
        (
            Steps(pressed_at_once=True, sheared_at_once=True),
            (ALONE_AT_ONCE, CORRECTED_AT_ONCE),
            (ALONE_AT_ONCE, CORRECTED_AT_ONCE),
        ),
    ],
)
def test_long_increments_have_larger_factors(
    steps: Steps, displacement: tuple[float, float], energy: tuple[float, float]
) -> None:
    safety, corrected = steps.factors()
    assert (safety[DELTA_X], corrected[DELTA_X]) == displacement
    assert (safety[TOTAL], corrected[TOTAL]) == energy
    assert corrected[MX] == safety[MX] == SAFETY[MX]  # moments are as good uncorrected
    assert safety[STICK] == (ALONE if steps.pressed_at_once else SAFETY[STICK])


@pytest.mark.parametrize("steps", [Steps(), Steps(pressed_at_once=True, sheared_at_once=True)])
def test_bodies_that_end_have_smaller_factors(steps: Steps) -> None:
    for ended, other in zip(replace(steps, ends=True).factors(), steps.factors(), strict=True):
        assert ended == pytest.approx(0.7 * other, rel=1e-12)


PRESSED = replace(next(fake_states(1)).summary, P=400.0, Qx=0.0, Qy=0.0, Mz=0.0, contact_radius=0.3)


def sheared(*shares: float, work: float = 1e-3) -> tuple[HiddenNearSliding, float]:
    """Return what is hidden after shears by so many parts of the limit 40 N, and what was dissipated."""
    path, hidden, total = ShearPath(), HiddenNearSliding(), 0.0
    for share in shares:
        total += work
        summary = replace(PRESSED, Qx=40.0 * share, work=work, work_total=total)
        path = path.after(summary, 40.0, 0.0, 0.0)
        hidden = hidden.after(path, summary)
    return hidden, total


def test_increments_near_gross_slip_hide_errors() -> None:
    largest = np.full(len(ESTIMATED), 2.0)
    assert not sheared(0.4, 0.8)[0].least(largest).any()  # a fifth of the limit is left
    hidden, total = sheared(0.4, 0.86, 0.9)
    way = 0.46 / 0.14  # of the second increment, 1 at most
    assert way > 1.0
    least = hidden.least(largest)
    assert least[DELTA_X] == pytest.approx(HIDDEN_MOTION * 2.0)
    assert least[TOTAL] == pytest.approx(HIDDEN_ENERGY * 2e-3)  # what was dissipated up to the second one
    assert least[WORK] == pytest.approx(HIDDEN_ENERGY * 0.4 * 1e-3)
    assert least[STICK] == least[MX] == 0.0
    assert total == 3e-3


def test_increments_near_gross_slip_hide_of_one_displacement_what_the_other_shows_where_the_shear_has_turned() -> None:
    largest = np.zeros(len(ESTIMATED))
    largest[[DELTA_X, DELTA_Y]] = 3.0, 4.0
    hidden = replace(sheared(0.4, 0.86, 0.9)[0], turned=True)
    assert hidden.least(largest)[[DELTA_X, DELTA_Y]] == pytest.approx([HIDDEN_TURNED * 5.0] * 2)
    assert replace(hidden, slides=True).least(largest)[DELTA_Y] == 0.0
    for path, turned in ((ShearPath(), False), (replace(ShearPath(), turned_before=0.1), True)):
        assert HiddenNearSliding().after(path, PRESSED).turned is turned


def test_gross_slip_hides_nothing_more() -> None:
    largest = np.full(len(ESTIMATED), 2.0)
    before, after = sheared(0.5, 0.9)[0], sheared(0.5, 0.9, 1.0, 1.0)[0]
    assert after.least(largest)[DELTA_X] == 0.0
    assert after.energy == before.energy > 0.0
    assert before.least(largest)[DELTA_X] > 0.0
    assert not sheared(1.0)[0].least(largest).any()


def test_factors_are_new_arrays() -> None:
    before = SAFETY.copy()
    Steps(alone=True).factors()[0][:] = 0.0
    assert np.array_equal(SAFETY, before)


def test_way_sideways() -> None:
    pressed = replace(PRESSED, delta_z=0.01, delta_x=0.0, delta_y=0.0)
    assert not moved_sideways(pressed, 40.0)
    assert not moved_sideways(replace(pressed, delta_x=9e-8), 40.0)
    assert moved_sideways(replace(pressed, delta_x=8e-8, delta_y=-8e-8), 40.0)
    assert moved_sideways(replace(pressed, Qx=0.1), 40.0)  # held
    assert not moved_sideways(replace(pressed, Qx=0.03), 40.0)
    assert not moved_sideways(replace(pressed, delta_x=1e-3, contact_radius=0.0), 40.0)  # in the air


@pytest.mark.parametrize(
    ("path", "stages"),
    [
        ([{"P": 400.0}], 1),
        ([{"P": 100.0}, {"P": 400.0, "My": 2.0, "delta_x": 0.0}], 2),
        ([{"P": 100.0}, {"P": 400.0}, {"Qx": 2.0}, {"P": 300.0}], 2),
        ([{"P": 400.0, "Qy": 2.0}, {"P": 300.0}], 0),
    ],
)
def test_stages_that_press_alone(path: list[dict[str, float]], stages: int) -> None:
    assert sheared_stages(set_up(build(grid={"points": 16}, load_path=path))).count(False) == stages
