"""What cells hide of the largest pressure: `tests/verification` compares bars with true errors."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fake_states import fake_states
from line_cases import LOAD, line_case
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors.hidden_pressure import (
    KINK,
    KINK_LINE,
    SLIP_MEETS,
    SMOOTH_EDGE,
    HiddenPressure,
    _drop_beside_peak,
)
from fretsolve.simulation.error_bars.least_errors.least_errors import LeastErrors
from fretsolve.simulation.simulation import run

PEAK = np.array([[1.0, 2.0, 1.0], [4.0, 6.0, 5.0], [0.0, 3.0, 0.0]])
PRESSED = next(fake_states(1))
PRESSED = replace(PRESSED, summary=replace(PRESSED.summary, contact_radius=0.3, max_pressure=2000.0))
SIDE = 0.03


def hidden_pressure(side: float = SIDE, **parts: Any) -> HiddenPressure:
    """Return that of a sphere on cells of a side."""
    return replace(LeastErrors.of(set_up(build(grid={"points": 16}, **parts)))._hidden_pressure, side=side)


@pytest.mark.parametrize(
    ("pressure", "drop"),
    [
        (PEAK, (2 * 6 - 2 - 3) + (2 * 6 - 4 - 5)),
        (PEAK[1:], (2 * 6 - 0 - 3) + (2 * 6 - 4 - 5)),  # at the border, beyond which nothing presses
        (PEAK[:, 1:2], 2 * 6 - 2 - 3),  # a line contact has one cell across
    ],
)
def test_the_pressure_drops_beside_its_peak(pressure, drop):
    assert _drop_beside_peak(pressure) == drop


def test_slip_that_meets_within_a_cell_raises_the_pressure() -> None:
    """The more, the smaller Spence's stick zone is against the cell; not between like bodies."""
    low, high = (hidden_pressure(0.06, bodies=DISSIMILAR, friction=friction) for friction in (0.02, 0.3))
    rise = [
        one.of(PRESSED, 0.0) / (one.model.friction * abs(one.model.compliances.dundurs_constant) * 2000.0)
        for one in (low, high)
    ]
    assert rise[0] > SLIP_MEETS > rise[1] > 0.0
    assert hidden_pressure(bodies=SIMILAR, friction=0.3).of(PRESSED, 0.0) == 0.0


def test_a_body_that_ends_sharply_at_a_hole_has_no_largest_pressure() -> None:
    smooth = SMOOTH_EDGE * math.sqrt(SIDE / 0.3)
    hidden = hidden_pressure(bodies=SIMILAR, friction=0.3)
    assert hidden.of(PRESSED, 1.001 * smooth) == math.inf
    assert hidden.of(PRESSED, 0.999 * smooth) == 0.0


@pytest.mark.parametrize("touches", [True, False])
@pytest.mark.parametrize("line", [True, False])
def test_the_pressure_where_a_punch_begins_to_bend(line: bool, touches: bool) -> None:
    """Its error is that of a rounding which cells show, and 0 where this is not in contact."""
    if line:
        surface = {"punch": {"half_width": 0.5, "edge_radius": 50.0}}
        case = line_case(surface=surface, load_path=[{"P": 2.0 * LOAD}])
    else:
        surface = {"punch": {"radius": 1.0, "edge_radius": 0.8}}
        case = build(surface=surface, friction=0.0, grid={"points": 48, "size": 1.6}, load_path=[{"P": 4000.0}])
    setup = set_up(case)
    hidden, (state,) = LeastErrors.of(setup)._hidden_pressure, list(run(setup))
    (edge,) = hidden.edges
    assert edge.touches(state.fields.pressure)
    if not touches:
        state = replace(state, fields=replace(state.fields, pressure=np.where(edge.near, 0.0, state.fields.pressure)))
    unit = setup.model.compliances.contact_modulus * setup.grid.dx / edge.radius
    expected = (KINK_LINE if line else KINK) * unit if touches else 0.0
    assert hidden.of(state, 0.0) == pytest.approx(expected, rel=1e-9)
