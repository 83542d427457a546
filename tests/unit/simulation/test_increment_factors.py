"""Factors on the errors of the increments; `tests/verification/test_bars_hold.py` compares bars with true errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fake_states import fake_states

from fretsolve.simulation.increment_factors import (
    ALONE,
    ALONE_AT_ONCE,
    ASKEW,
    CORRECTED_ALONE,
    CORRECTED_ASKEW,
    CORRECTED_AT_ONCE,
    CORRECTED_LONG,
    CORRECTED_LONG_ASKEW,
    CORRECTED_SAFETY,
    LONG,
    LONG_ASKEW,
    LONG_ENERGY,
    LONG_MOTION,
    LONG_STEP,
    Steps,
    moved_sideways,
)
from fretsolve.simulation.quantity_estimates import DELTA_X, MX, SAFETY, STICK, TOTAL

LONG_STEPS = 1.01 * LONG_STEP


@pytest.mark.parametrize(
    ("steps", "displacement", "energy"),
    [
        (Steps(), (SAFETY[DELTA_X], CORRECTED_SAFETY), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(coarsest=LONG_STEP), (SAFETY[DELTA_X], CORRECTED_SAFETY), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(alone=True), (ALONE, CORRECTED_ALONE), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(coarsest=LONG_STEPS), (LONG, CORRECTED_LONG), (LONG, CORRECTED_LONG)),
        (Steps(askew=True), (ASKEW, CORRECTED_ASKEW), (SAFETY[TOTAL], CORRECTED_SAFETY)),
        (Steps(askew=True, coarsest=LONG_STEPS), (LONG_ASKEW, CORRECTED_LONG_ASKEW), (LONG, CORRECTED_LONG)),
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


def test_least_errors_of_long_steps_between_unlike_bodies() -> None:
    for coarsest, way in ((0.0, 0.0), (0.4, 0.4), (3.0, 1.0)):
        least = Steps(unlike=True, coarsest=coarsest).least()
        assert (least[DELTA_X], least[TOTAL], least[STICK]) == (LONG_MOTION * way, LONG_ENERGY * way, 0.0)
        assert not Steps(coarsest=coarsest).least().any()


def test_factors_are_new_arrays() -> None:
    before = SAFETY.copy()
    Steps(alone=True).factors()[0][:] = 0.0
    assert np.array_equal(SAFETY, before)


def test_way_sideways() -> None:
    pressed = replace(next(fake_states(1)).summary, delta_z=0.01, delta_x=0.0, delta_y=0.0)
    assert not moved_sideways(pressed)
    assert not moved_sideways(replace(pressed, delta_x=9e-8))
    assert moved_sideways(replace(pressed, delta_x=8e-8, delta_y=-8e-8))
