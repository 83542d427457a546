"""The zone of each cell: open, stick or slip."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.increment.stick_and_slip import least_slip_of_zones, zones
from fretsolve.result.state import Zone


def test_cells_that_slip_do_so_in_contact_alone() -> None:
    contact, slipping = np.array([[True, True, False]]), np.array([[True, False, True]])
    assert zones(contact, slipping)[0].tolist() == [Zone.SLIP, Zone.STICK, Zone.OPEN]


@pytest.mark.parametrize(("tolerance", "part"), [(1e-9, 1e-8), (1e-6, 1e-5), (1e-4, 1e-4), (1e-2, 1e-2)])
def test_a_slip_counts_from_ten_times_the_tolerance_on(tolerance: float, part: float) -> None:
    """But no less than the tolerance itself, and it hides no slip that a coarse tolerance resolves."""
    assert least_slip_of_zones(tolerance, 3.0) == pytest.approx(3.0 * part)
