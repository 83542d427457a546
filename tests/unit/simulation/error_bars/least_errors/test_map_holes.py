"""Least errors at holes of height maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fake_states import fake_states
from solving import DISSIMILAR, SIMILAR, build

from fretsolve.model.edges import Edge
from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors.least_errors import LeastErrors
from fretsolve.simulation.error_bars.least_errors.map_holes import (
    HOLE_ENERGY,
    HOLE_MOMENT,
    HOLE_MOTION,
    HOLE_TILT,
    Holes,
    holes_in_contact,
)
from fretsolve.simulation.error_bars.quantity_estimates import (
    DELTA_X,
    DELTA_Y,
    DELTA_Z,
    MX,
    MY,
    MZ,
    QX,
    QY,
    TILTS,
    TOTAL,
)

ROUND = replace(next(fake_states(1)).summary, P=400.0, contact_radius=0.3, max_pressure=2000.0)


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR])
def test_holes_of_a_map_shift_moments_and_tilts_by_the_cells_across_their_axes(bodies: list[dict[str, float]]) -> None:
    """And unlike bodies sideways, the more the farther they are off the middle."""
    model = set_up(build(bodies=bodies, friction=0.3, grid={"points": 16})).model
    holes = Holes(Edge(0.0, np.zeros((0, 0), dtype=bool)), 1.0, np.array([-5.0, 1.0]))
    found, largest = np.zeros(len(ESTIMATED)), np.zeros(len(ESTIMATED))
    largest[[QX, QY, DELTA_Z, TOTAL]] = 30.0, 40.0, 0.009, 0.002
    holes.add_to(found, model, ROUND, largest, (0.02, 0.05))
    assert found[[MX, MY]] == pytest.approx([HOLE_MOMENT * 400.0 * 0.05, HOLE_MOMENT * 400.0 * 0.02], rel=1e-12)
    assert found[MZ] == pytest.approx(HOLE_MOMENT * 50.0 * 0.05, rel=1e-12)
    assert found[TILTS] == pytest.approx(HOLE_TILT * 0.1 * np.array([0.05, 0.02]), rel=1e-12)
    assert found[TOTAL] == pytest.approx(HOLE_ENERGY * 0.05 / 0.3 * 0.002, rel=1e-12)
    stretch = abs(model.compliances.dundurs_constant) * 2000.0 * 0.05 / model.compliances.contact_modulus
    places = np.array([5 * 0.02 + 0.05, 0.05 + 0.05]) / 0.3
    assert (stretch > 0.0) is (bodies is DISSIMILAR)
    assert found[[DELTA_X, DELTA_Y]] == pytest.approx(HOLE_MOTION * stretch * places, rel=1e-12)


def test_the_contact_beside_holes_of_a_map_ends_sharply() -> None:
    """Its cells there are those of a sharp edge, for slip within them; none where the contact does not reach a hole."""
    least = LeastErrors.of(set_up(build(bodies=SIMILAR, friction=0.3, grid={"points": 16})))
    state = next(fake_states(1))
    pressure, gap = np.zeros_like(state.fields.gap), np.zeros_like(state.fields.gap)
    gap[0], pressure[3] = np.nan, 5.0
    apart = replace(state, fields=replace(state.fields, gap=gap, pressure=pressure))
    assert holes_in_contact(apart) is None
    assert least._with_holes(None) == least._unseen_slip
    pressure[1] = 2.0
    holes = holes_in_contact(replace(state, fields=replace(state.fields, gap=gap, pressure=pressure)))
    assert holes is not None
    assert holes.edge.near[:2].all() and not holes.edge.near[2:].any()
    assert holes.off == pytest.approx([-1.0, 0.0])
    assert holes.pressure == pytest.approx(2.0 / state.summary.max_pressure)
    assert least._with_holes(holes) == replace(least._unseen_slip, holes=True, edges=(holes.edge,))
