"""What cells miss of tangential values where shear slips in a thin annulus."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from line_cases import line_case
from solving import DISSIMILAR, build

from fretsolve.result.state import ESTIMATED
from fretsolve.setup.problem_setup import set_up
from fretsolve.simulation.error_bars.least_errors import thin_shear
from fretsolve.simulation.error_bars.least_errors.unseen_slip import UnseenSlip
from fretsolve.simulation.error_bars.quantity_estimates import DELTA_X, PHI_Z, QX

LIKE = set_up(build(friction=0.3, grid={"points": 16})).model
UNLIKE = set_up(build(bodies=DISSIMILAR, friction=0.3, grid={"points": 16})).model
RADIUS, SIDE = 1.0, 0.05


def missed(slipping: float, largest: float, model: Any = LIKE, stick_radius: float = RADIUS) -> Any:
    """Return the least errors of values of 1 on a contact of 20 cells per radius."""
    least = np.zeros(len(ESTIMATED))
    summary = SimpleNamespace(contact_radius=RADIUS, stick_radius=stick_radius)
    path = SimpleNamespace(memory=SimpleNamespace(slipping=slipping), largest=largest)
    unseen = UnseenSlip(model, SIDE, slender=1.0, ends=False, edges=())
    thin_shear.add_thin_shear(least, unseen, cast(Any, summary), np.ones(len(ESTIMATED)), cast(Any, path))
    return least


def test_next_to_no_slip_misses_the_law_of_a_singular_edge() -> None:
    found = missed(1e-6, 1e-6)
    pair = np.sqrt(2.0)  # both components of a vector are 1
    assert found[DELTA_X] == pytest.approx(thin_shear.SHEARED * SIDE * pair, rel=1e-3)
    assert found[QX] == found[DELTA_X]
    assert found[PHI_Z] == pytest.approx(thin_shear.TURNED * SIDE, rel=1e-3)


def test_it_falls_with_the_width_of_the_annulus() -> None:
    # 1 - (1 - f)^(1/3) of the radius slips: f of 0.142625 is a width of 0.05, one cell
    wide = missed(0.142625, 0.142625)[PHI_Z]
    assert wide == pytest.approx(thin_shear.TURNED * SIDE / (1.0 + 2.0**1.5), rel=1e-3)


def test_after_a_turn_twice_what_slips_counts() -> None:
    assert missed(1e-4, 1e-3)[PHI_Z] == pytest.approx(0.2 * missed(1e-4, 1e-4)[PHI_Z])


def test_what_pressing_unlike_bodies_slips_widens_the_annulus() -> None:
    assert missed(1e-6, 1e-6, UNLIKE, stick_radius=RADIUS - 4.0 * SIDE)[PHI_Z] < 0.1 * missed(1e-6, 1e-6)[PHI_Z]


@pytest.mark.parametrize(("slipping", "largest"), [(0.0, 0.5), (0.0, 0.0)])
def test_without_slip_it_adds_nothing(slipping: float, largest: float) -> None:
    assert not missed(slipping, largest).any()


def test_a_line_contact_whose_displacements_have_a_free_constant_gets_nothing() -> None:
    assert not missed(0.1, 0.1, set_up(line_case()).model).any()
