"""Least errors of moments and tilts."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_states import fake_states
from line_cases import MATERIAL, line_case
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.model.edges import rounding
from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors.moments import (
    MOMENT,
    MOMENT_LINE,
    MOMENT_SHEARED,
    add_moments_and_tilts,
)
from fretsolve.simulation.error_bars.quantity_estimates import MX, MY, MZ, PHI_Y, QX

ROUND = replace(next(fake_states(1)).summary, P=400.0, contact_radius=0.3)
SQUARE = np.full(len(ESTIMATED), 0.01)
"""Squares of h/a on square cells."""


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR])
def test_shear_adds_to_the_moments_of_unlike_bodies_alone(bodies: Any) -> None:
    model = set_up(build(bodies=bodies, friction=0.3, grid={"points": 16})).model
    largest = np.zeros(len(ESTIMATED))
    largest[QX] = 100.0
    found = np.zeros(len(ESTIMATED))
    add_moments_and_tilts(found, model, ROUND, largest, SQUARE, ends=False)
    mismatch = abs(model.compliances.dundurs_constant)
    assert (mismatch > 0.0) is (bodies is DISSIMILAR)
    expected = 0.01 * 0.3 * np.hypot(MOMENT * 400.0, MOMENT_SHEARED * mismatch * 100.0)
    assert found[[MX, MY]].tolist() == pytest.approx([expected, expected], rel=1e-12)
    assert found[MZ] == pytest.approx(0.01 * 0.3 * MOMENT * 100.0, rel=1e-12)


def test_shear_adds_nothing_to_moments_where_pressure_does_not_depend_on_it() -> None:
    model = set_up(build(bodies=DISSIMILAR, friction=0.3, coupling="tangential", grid={"points": 16})).model
    largest, found = np.zeros(len(ESTIMATED)), np.zeros(len(ESTIMATED))
    largest[QX] = 100.0
    add_moments_and_tilts(found, model, ROUND, largest, SQUARE, ends=False)
    assert model.compliances.dundurs_constant != 0.0
    assert found[MY] == pytest.approx(0.01 * 0.3 * MOMENT * 400.0, rel=1e-12)


def test_moments_of_line_contacts_have_a_least_error_of_their_own() -> None:
    """Also where a body ends, as nothing averages the two edges."""
    for surface in ({"cylinder": {"radius": 10.0}}, {"punch": {"half_width": 0.1, "edge_radius": 10.0}}):
        setup, found = set_up(line_case(surface=surface)), np.zeros(len(ESTIMATED))
        ends = rounding(setup.case.surface[0]) is not None
        add_moments_and_tilts(found, setup.model, ROUND, np.zeros(len(ESTIMATED)), SQUARE, ends=ends)
        assert found[MY] == pytest.approx(0.01 * 0.3 * MOMENT_LINE * 400.0, rel=1e-12)
        stiffness = 0.25 * math.pi * MATERIAL.contact_modulus * 0.3**2  # of a cylinder against tilting
        assert found[PHI_Y] == pytest.approx(found[MY] / stiffness, rel=1e-12)
        assert np.count_nonzero(found) == 2
