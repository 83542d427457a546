"""Least errors by few increments: `tests/verification/test_bars_hold.py` compares bars with true errors."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_states import fake_states
from line_cases import line_case
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.model.required_terms import Model
from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.few_increments import (
    EARLY_EDGE,
    FALL,
    FALL_ORDER,
    FALL_SHEARED,
    LEAST_SHEARED,
    PRESSED_ENERGY,
    PRESSED_FRICTION,
    PRESSED_RADIUS,
    PRESSED_RADIUS_LINE,
    PRESSED_STICKING,
    SHEARED_EDGE,
    SHEARED_EDGE_LINE,
    SHEARED_ENERGY,
    SHEARED_ENERGY_ORDER,
    SHEARED_MISMATCH,
    TURNED,
    TURNED_AGAIN,
    TURNED_EDGE,
    TURNED_ENERGY,
    TURNED_MOMENT,
    add_turned,
    early_edge,
    energy_of_fall,
    pressed_energy,
    pressed_radius,
    sheared_energy,
)
from fretsolve.simulation.error_bars.quantity_estimates import (
    ALL,
    DELTA_X,
    DELTA_Y,
    MZ,
    PHI_Z,
    QX,
    QY,
    STICK,
    STICK_EXTENTS,
    TOTAL,
    WORK,
)
from fretsolve.simulation.error_bars.shear_path import ShearPath

RADIUS = 0.3
PRESSED = [replace(next(fake_states(1)).summary, contact_radius=RADIUS, step=step, stage=1) for step in range(4)]
SHEARED = replace(PRESSED[0], step=4, stage=2, contact_cells=300, stick_cells=200)


def on_area(bodies: Any) -> Model:
    return set_up(build(grid={"points": 16}, bodies=bodies, friction=0.3)).model


def on_line(bodies: Any) -> Model:
    return set_up(line_case(bodies=bodies)).model


def test_the_stick_radius_of_unlike_bodies_is_uncertain_after_few_increments_that_press() -> None:
    found = [early_edge(on_area(DISSIMILAR), summary, 4) for summary in PRESSED]
    assert found == pytest.approx([EARLY_EDGE * RADIUS / made**1.5 for made in (1, 2, 3, 4)], rel=1e-12)
    assert early_edge(on_area(SIMILAR), PRESSED[0], 4) == 0.0


def test_in_line_contact_it_is_less_certain() -> None:
    found = [early_edge(on_line(DISSIMILAR), summary, 4) for summary in PRESSED]
    assert found == pytest.approx([EARLY_EDGE * RADIUS / made for made in (1, 2, 3, 4)], rel=1e-12)


@pytest.mark.parametrize(("on", "least"), [(on_area, SHEARED_EDGE), (on_line, SHEARED_EDGE_LINE)])
def test_it_stays_uncertain_in_later_stages(on: Any, least: float) -> None:
    model = replace(on(DISSIMILAR), friction=0.1)  # less than Dundurs' constant
    assert early_edge(model, SHEARED, 4) == pytest.approx(least * RADIUS / 4.0, rel=1e-12)
    assert early_edge(model, SHEARED, 0) == 0.0  # pressed and sheared at once
    assert early_edge(replace(on(SIMILAR), friction=0.1), SHEARED, 4) == 0.0


def test_in_later_stages_it_goes_with_what_pressing_has_left() -> None:
    """On areas: with Dundurs' constant over the friction, and nothing where all of the contact sticks."""
    model = on_area(DISSIMILAR)
    part = abs(model.compliances.dundurs_constant) / 0.9
    assert early_edge(replace(model, friction=0.9), SHEARED, 4) == pytest.approx(part * SHEARED_EDGE * RADIUS / 4.0)
    assert early_edge(model, replace(SHEARED, stick_cells=SHEARED.contact_cells), 4) == 0.0


@pytest.mark.parametrize(
    ("on", "least", "power"), [(on_area, PRESSED_RADIUS, 1.0), (on_line, PRESSED_RADIUS_LINE, 2.0)]
)
def test_the_contact_radius_of_unlike_bodies_is_uncertain_after_few_increments_that_press(
    on: Any, least: float, power: float
) -> None:
    model = on(DISSIMILAR)
    mismatch = abs(model.compliances.dundurs_constant)
    part = model.friction / (PRESSED_FRICTION * mismatch)
    assert 0.3 < part < 1.0
    smooth = least * mismatch * part**power
    assert pressed_radius(model, PRESSED[1], 4) == pytest.approx(smooth / 2.0, rel=1e-12)
    assert pressed_radius(model, SHEARED, 4) == pytest.approx(smooth / 4.0, rel=1e-12)
    rough = replace(model, friction=1.0)
    assert pressed_radius(rough, SHEARED, 4) == pytest.approx(least * mismatch / 4.0, rel=1e-12)
    assert pressed_radius(model, SHEARED, 0) == pressed_radius(on(SIMILAR), PRESSED[1], 4) == 0.0


def test_energy_that_few_increments_press_is_too_large() -> None:
    for share, at_once in ((0.0, PRESSED_ENERGY), (0.5, PRESSED_ENERGY + PRESSED_STICKING)):
        for summary in (replace(one, work_total=2e-3, stick_radius=share * RADIUS) for one in PRESSED):
            least = 2e-3 * min(at_once / (summary.step + 1) ** 1.5, ALL)
            assert pressed_energy(on_area(DISSIMILAR), summary) == pytest.approx(least, rel=1e-12)
            assert pressed_energy(on_area(SIMILAR), summary) == 0.0
    assert pressed_energy(on_area(DISSIMILAR), replace(SHEARED, work_total=2e-3)) == 0.0


def test_where_all_sticks_all_that_pressing_dissipates_is_uncertain() -> None:
    summary = replace(PRESSED[3], work_total=2e-3, stick_radius=RADIUS)
    assert pressed_energy(on_area(DISSIMILAR), summary) == ALL * 2e-3
    many = replace(summary, step=199)
    assert pressed_energy(on_area(DISSIMILAR), many) < 0.2 * 2e-3


@pytest.mark.parametrize(("poisson_ratio", "part"), [(0.3, 0.563), (0.06, 1.0)])
def test_what_few_increments_have_pressed_is_uncertain_once_it_is_sheared(poisson_ratio: float, part: float) -> None:
    bodies = ({"young_modulus": 200e3, "poisson_ratio": poisson_ratio}, DISSIMILAR[1])
    summary, model = replace(SHEARED, work_total=2e-3), on_area(bodies)
    assert min(abs(model.compliances.dundurs_constant) / SHEARED_MISMATCH, 1.0) == pytest.approx(part, abs=0.01)
    for pressed in (1, 3, 8):
        least = sheared_energy(model, summary, pressed) * pressed**SHEARED_ENERGY_ORDER
        assert least == pytest.approx(2e-3 * part * SHEARED_ENERGY, rel=0.01)
    assert sheared_energy(on_area(SIMILAR), summary, 1) == sheared_energy(model, summary, 0) == 0.0


@pytest.mark.parametrize(
    ("load", "share", "least"),
    [
        (200.0, 0.5, FALL * 0.5**-FALL_SHEARED),
        (320.0, 1.0, FALL * 0.25**FALL_ORDER),
        (320.0, 0.05, FALL * 0.25**FALL_ORDER * LEAST_SHEARED**-FALL_SHEARED),
        (20.0, 0.5, ALL),
        (1e-300, 0.5, ALL),
        (200.0, 1e-6, 0.0),  # without shear
        (0.0, 0.5, 0.0),
        (500.0, 0.5, 0.0),
    ],
)
def test_an_increment_whose_load_falls_under_shear_dissipates_too_much(load: float, share: float, least: float) -> None:
    before, summary = replace(SHEARED, P=400.0), replace(SHEARED, P=load, work=2e-3)
    assert energy_of_fall(before, summary, share) == pytest.approx(2e-3 * least, rel=1e-12)
    assert energy_of_fall(None, summary, share) == 0.0


def test_a_shear_that_turns_adds_a_part_of_the_largest_tangential_values() -> None:
    largest, found = np.arange(1.0, 1.0 + len(ESTIMATED)), np.zeros(len(ESTIMATED))
    add_turned(found, largest, SHEARED, ShearPath(turning=0.5))
    for pair in ([QX, QY], [DELTA_X, DELTA_Y]):
        assert found[pair] == pytest.approx(0.5 * TURNED * np.hypot(*largest[pair]), rel=1e-12)
    assert found[PHI_Z] == pytest.approx(0.5 * TURNED * largest[PHI_Z], rel=1e-12)
    assert found[MZ] == pytest.approx(0.5 * TURNED_MOMENT * largest[MZ], rel=1e-12)
    assert found[[WORK, TOTAL]] == pytest.approx(0.5 * TURNED_ENERGY * largest[[WORK, TOTAL]], rel=1e-12)
    assert found[[STICK, *STICK_EXTENTS]] == pytest.approx(0.5 * TURNED_EDGE * RADIUS, rel=1e-12)
    assert np.count_nonzero(found) == 9 + len(STICK_EXTENTS)


@pytest.mark.parametrize(
    ("path", "stick_cells", "least"),
    [
        (ShearPath(turned_before=0.2), 200, 0.2 * TURNED_EDGE),
        (ShearPath(turning=0.1, turned_before=0.2), 200, 0.2 * TURNED_AGAIN),
        (ShearPath(turning=1e-9, turned_before=0.2), 200, 0.2 * TURNED_EDGE),  # by a rounding
        (ShearPath(turning=0.1), 300, 0.0),  # all cells stick
        (ShearPath(turning=0.1), 0, 0.0),
    ],
)
def test_the_edge_of_a_stick_zone_is_less_certain_after_a_second_turn(
    path: ShearPath, stick_cells: int, least: float
) -> None:
    found = np.zeros(len(ESTIMATED))
    add_turned(found, np.ones(len(ESTIMATED)), replace(SHEARED, stick_cells=stick_cells), path)
    assert found[STICK] == pytest.approx(least * RADIUS, rel=1e-12)
