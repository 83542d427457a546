"""The preconditioner (T7) of a slip law that is the same in all cells, for single waves: V F V + D without T."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.kernels.cg import MIDDLE, diagonal, share
from fretsolve.system.arrays import FloatArray

STIFFNESS = np.array([0.0, 1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e6])
WEIGHT = 1.0 / (1.0 + STIFFNESS)


def preconditioner(inverse: float) -> FloatArray:
    """Return M for a wave of compliance 1/F, where F is `inverse`, by the stiffness."""
    v = share(WEIGHT)
    return v * inverse * v + diagonal(WEIGHT, v)


def test_middle_wave_is_solved_exactly() -> None:
    assert preconditioner(MIDDLE) == pytest.approx(MIDDLE / (1.0 + MIDDLE * STIFFNESS), rel=1e-9)


@pytest.mark.parametrize("inverse", [0.0, 0.01, 1.0, 3.4])
def test_long_and_short_waves_meet_the_elastic_operator_in_stick_and_the_slip_law_in_stiff_slip(inverse: float) -> None:
    found = preconditioner(inverse)
    assert found[0] == inverse
    assert found[-1] == pytest.approx(1.0 / STIFFNESS[-1], rel=1e-5)


def test_diagonal_is_never_negative_by_rounding() -> None:
    near_one = 1.0 - np.arange(2000, dtype=np.float32) * np.finfo(np.float32).epsneg
    weight = np.concatenate([near_one, np.linspace(0.0, 1.0, 2000, dtype=np.float32)])
    v = share(weight)
    assert v.dtype == np.float32
    assert (MIDDLE * (weight / (weight + MIDDLE * (1 - weight)) - v * v)).min() < 0.0  # what the equation avoids
    assert diagonal(weight, v).min() >= 0.0
