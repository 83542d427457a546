"""The zone of each cell: open, stick or slip."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.increment.stick_and_slip import zones
from fretsolve.result.state import Zone

CONTACT = np.array([[True, True, True, False]])
LIMIT = np.array([[10.0, 10.0, 10.0, 0.0]])
SHEAR = np.array([[[6.0, 6.0, 9.9, 0.0]], [[8.0, 0.0, 0.0, 0.0]]])
"""The first cell has reached the limit, with both components; the last is open."""


def zones_of(
    slip: float, friction: float = 0.1, precision: type[np.floating] = np.float64, part: float = 1.0
) -> list[int]:
    field = np.full(SHEAR.shape, slip) * CONTACT
    return zones(CONTACT, part * SHEAR, field, LIMIT if friction else 0.0 * LIMIT, friction, precision)[0].tolist()


def test_cells_slip_where_shear_has_reached_the_friction_limit() -> None:
    assert zones_of(1e-6) == [Zone.SLIP, Zone.STICK, Zone.STICK, Zone.OPEN]


def test_all_stick_where_nothing_has_slipped() -> None:
    assert zones_of(0.0) == [Zone.STICK, Zone.STICK, Zone.STICK, Zone.OPEN]


@pytest.mark.parametrize("slip", [0.0, 1e-6])
def test_all_slip_without_friction(slip: float) -> None:
    assert zones_of(slip, friction=0.0) == [Zone.SLIP, Zone.SLIP, Zone.SLIP, Zone.OPEN]


def test_the_limit_allows_for_the_rounding_of_the_precision() -> None:
    assert zones_of(1e-6, precision=np.float32, part=1.0 - 1e-7)[0] == Zone.SLIP
    assert zones_of(1e-6, precision=np.float64, part=1.0 - 1e-7)[0] == Zone.STICK
