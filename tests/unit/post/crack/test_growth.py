"""Ranges, arrest and lives of cracks from stress intensities over their length."""

import math

import numpy as np
import pytest

from fretsolve.case.keys.material_spec import Material, ParisLaw
from fretsolve.post.crack.growth import (
    GrowthRule,
    arrest_length,
    difference,
    end_length,
    propagation_lives,
    stress_range,
    threshold_of,
)

LENGTHS = 1e-3 * 10.0 ** (np.arange(91) / 30)  # to 1 mm
LAW = ParisLaw(exponent=2.0, coefficient=1e-9)


def test_ranges_of_a_cycle():
    K = np.array([[4.0, 4.0, -1.0], [1.0, -3.0, -2.0], [2.0, 0.0, -5.0]])
    np.testing.assert_allclose(stress_range(K), [3.0, 4.0, 0.0])
    np.testing.assert_allclose(stress_range(K, 0.5), [4.0 * math.sqrt(0.75), 4.0, 0.0])


def test_arrest_where_the_range_first_falls_below():
    threshold = lambda lengths: np.full(len(lengths), 2.0)  # noqa: E731
    falling = 2.0 - 0.3 * np.log(LENGTHS / 0.0345)
    assert arrest_length(LENGTHS, falling, threshold) == pytest.approx(0.0345, rel=1e-9)
    again = np.where(LENGTHS > 0.2, 9.0, falling)
    assert arrest_length(LENGTHS, again, threshold) == pytest.approx(0.0345, rel=1e-9)
    assert arrest_length(LENGTHS, np.full(91, 1.9), threshold) == 0.0
    assert arrest_length(LENGTHS, np.full(91, 2.0), threshold) == math.inf


def test_the_end_of_life():
    largest = 10.0 * np.sqrt(LENGTHS)
    assert end_length(LENGTHS, largest, 5.0, None) == pytest.approx(0.25, rel=1e-9)
    assert end_length(LENGTHS, largest, 5.0, 0.1) == 0.1
    assert end_length(LENGTHS, largest, 5.0, 0.4) == pytest.approx(0.25, rel=1e-9)
    assert end_length(LENGTHS, largest, 50.0, None) is None
    assert end_length(LENGTHS, largest, None, 0.4) == 0.4
    assert end_length(LENGTHS, 100.0 + largest, 5.0, None) == LENGTHS[0]


def test_a_crack_that_stops_does_not_reach_the_end():
    ranges = np.where(LENGTHS < 0.05, 3.0, np.where(LENGTHS < 0.1, 1.0, 3.0))[None]
    threshold = lambda lengths: np.full(lengths.shape, 2.0)  # noqa: E731
    lives = propagation_lives(LENGTHS, ranges, [1.0], LAW, threshold, 0.5)
    assert np.isinf(lives[LENGTHS < 0.05]).all()
    assert np.isfinite(lives[(LENGTHS > 0.11) & (LENGTHS < 0.5)]).all()
    free = propagation_lives(LENGTHS, ranges, [1.0], LAW, None, 0.5)
    assert np.isfinite(free[LENGTHS < 0.5]).all()
    assert np.isnan(free[-1])


def test_a_block_adds_the_growth_of_its_cycles():
    """Two cycles at K, and one at K/2: in three cycles 2 K^2 + K^2/4, unless the small one is below the threshold."""
    ranges = np.array([4.0, 2.0])[:, None] * np.ones(91)
    start, end = 1e-3 * LENGTHS[0], 0.5e-3
    lives = propagation_lives(LENGTHS, ranges, [2.0, 1.0], LAW, None, 0.5)
    assert lives[0] == pytest.approx(3.0 * (end - start) / (1e-9 * 36.0), rel=1e-5)
    three = lambda lengths: np.full(lengths.shape, 3.0)  # noqa: E731
    lives = propagation_lives(LENGTHS, ranges, [2.0, 1.0], LAW, three, 0.5)
    assert lives[0] == pytest.approx(3.0 * (end - start) / (1e-9 * 32.0), rel=1e-5)


def test_the_least_total_life_and_where_both_parts_are_equal():
    material = Material(paris=LAW, toughness=100.0)
    initiation = 1e5 * LENGTHS
    ranges = np.full((1, 91), 10.0)
    growth = GrowthRule(material, (1.0,), final_length=0.5).growth(LENGTHS, ranges, ranges[0], initiation)
    # propagation is 1e4 (0.5 - b) per mm; the sum rises with b
    assert growth.life == pytest.approx(1e2 + 1e4 * 0.499, rel=1e-4)
    assert growth.first == LENGTHS[0]
    assert growth.crossing == pytest.approx(0.5 / 11.0, rel=2e-3)
    assert growth.arrest is None


def test_a_crack_begins_near_and_stops_from_a_length_on():
    """Initiation that falls with the depth does not move a crack away from the contact."""
    material = Material(paris=LAW, toughness=100.0, threshold_range=2.0, fatigue_range=1e6)
    rule = GrowthRule(material, (1.0,), final_length=0.5, judged_from=0.0099, begins_below=0.05)
    ranges = np.where(LENGTHS < 0.0099, 1.0, 10.0)[None]
    growth = rule.growth(LENGTHS, ranges, ranges[0], 1e9 / LENGTHS)
    assert growth.arrest == math.inf  # a range below the threshold in shorter cracks does not count
    assert growth.first == LENGTHS[LENGTHS <= 0.05][-1]
    assert growth.life == pytest.approx(1e9 / growth.first + 1e4 * (0.5 - growth.first), rel=1e-5)
    assert np.isinf(growth.propagation[LENGTHS < 0.0099]).all()


def test_a_contact_that_breaks_at_once():
    material = Material(paris=LAW, toughness=5.0)
    growth = GrowthRule(material, (1.0,)).growth(LENGTHS, np.full((1, 91), 10.0), np.full(91, 10.0), 1e5 * LENGTHS)
    assert growth.life == 1e5 * LENGTHS[0]
    assert np.isnan(growth.total).all()


def test_thresholds_need_both_constants():
    assert threshold_of(Material(threshold_range=2.0)) is None
    assert threshold_of(Material(fatigue_range=200.0)) is None
    with_factor = threshold_of(Material(threshold_range=2.0, fatigue_range=200.0, surface_factor=1.12))
    assert with_factor(np.array([1e-7]))[0] == pytest.approx(1.12 * 200.0 * math.sqrt(math.pi * 1e-10), rel=1e-4)


def test_differences_of_endless_lives():
    assert difference(math.inf, math.inf) == 0.0
    assert difference(5.0, 4.0, math.inf) == math.inf
    assert difference(math.inf, 4.0) == math.inf
    assert difference(5.0, 4.0, 7.0) == 2.0
