"""The sphere that partial slip has worn to its limit, given as a height map and pressed.

The profile has a vertical tangent at the stick zone, where the pressure is infinite, so that errors fall like the side
of a cell. How circles cut the cells makes them fluctuate: each is the root mean square over six sizes of the grid.
"""

from __future__ import annotations

import numpy as np
import pytest
from solving import FRICTION, LOAD, MATERIAL, RADIUS, solve_last

from fretsolve.reference.worn_contact import worn_limit_at_force

pytestmark = pytest.mark.slow

LIMIT = worn_limit_at_force(LOAD, 35.0, FRICTION, RADIUS, MATERIAL.contact_modulus)  # c = a0/2
POINTS = (32, 64, 128)
SIZES = (2.2, 2.26, 2.32, 2.38, 2.44, 2.5)


def errors(points, width, file):
    """Return the errors of P under the exact approach, of the approach under the exact P, and of the scar radius."""
    size = width * LIMIT.scar_radius
    x = (np.arange(points) - 0.5 * (points - 1)) * size / points
    r = np.hypot(x[:, None], x)
    np.save(file, LIMIT.profile(r))
    parts = {
        "surface": {"heights": {"file": str(file), "spacing": size / points}},
        "grid": {"points": points, "size": size},
        "friction": 0.0,
        "output": {"fields": ["gap"]},
    }
    pressed = solve_last(load_path=[{"delta_z": LIMIT.delta_z}], **parts)
    loaded = solve_last(load_path=[{"P": LOAD}], **parts)
    outside = (r > LIMIT.scar_radius) & (r < 1.08 * LIMIT.scar_radius)
    assert pressed.fields.gap is not None
    # where the gap begins: its inverse, extrapolated to 0
    begins = np.polynomial.Polynomial.fit(pressed.fields.gap[outside], r[outside], 2)(0.0)
    return (
        pressed.summary.P / LOAD - 1.0,
        loaded.summary.delta_z / LIMIT.delta_z - 1.0,
        begins / LIMIT.scar_radius - 1.0,
    )


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Errors of the three quantities on the three grids, (3, 3)."""
    file = tmp_path_factory.mktemp("limit") / "heights.npy"
    return np.array([np.sqrt(np.mean(np.square([errors(n, width, file) for width in SIZES]), 0)) for n in POINTS])


def test_the_limit_is_approached_at_first_order(found):
    orders = -np.polyfit(np.log(POINTS), np.log(found[:, :2]), 1)[0]
    assert (orders > 0.8).all(), orders


def test_the_finest_grid(found):
    force, approach, scar = found[-1]
    assert force < 4e-3
    assert approach < 4e-3
    assert scar < 1e-3
