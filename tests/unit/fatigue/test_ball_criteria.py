"""The criteria of the smallest ball under loads with known values."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.case.keys.material_spec import Material
from fretsolve.fatigue.criteria import crossland, dang_van

S, T = 300.0, 190.0
MATERIAL = Material(tension_limit=S, torsion_limit=T)
PHASE = 2.0 * np.pi * np.arange(24) / 24


def stresses(**components: np.ndarray) -> np.ndarray:
    """Stresses (steps, 6, 1) with some components xx, yy, zz, xy, xz, yz over a cycle."""
    names = ("xx", "yy", "zz", "xy", "xz", "yz")
    return np.stack([components.get(name, np.zeros_like(PHASE)) for name in names], axis=1)[..., None]


@pytest.mark.parametrize("criterion", [crossland, dang_van])
@pytest.mark.parametrize("load", [{"xx": S * np.cos(PHASE)}, {"zz": S * np.cos(PHASE)}, {"xy": T * np.cos(PHASE)}])
def test_reversed_tension_and_torsion_at_their_limits_reach_the_torsion_limit(criterion, load) -> None:
    assert criterion(MATERIAL, stresses(**load)) == pytest.approx(T, rel=1e-6)


def test_mean_shear_does_not_count_and_mean_pressure_does() -> None:
    turned = T * np.cos(PHASE)
    assert crossland(MATERIAL, stresses(xy=turned + 80.0)) == pytest.approx(T, rel=1e-6)
    pressed = stresses(xy=turned) - 90.0 * np.array([1, 1, 1, 0, 0, 0])[:, None]
    assert crossland(MATERIAL, pressed) == pytest.approx(T - 90.0 * MATERIAL.crossland_factor, rel=1e-6)
    assert dang_van(MATERIAL, pressed) == pytest.approx(T - 90.0 * MATERIAL.dang_van_factor, rel=1e-6)


def test_torsion_about_two_axes_out_of_phase_is_no_larger_than_one() -> None:
    around = stresses(xy=T * np.cos(PHASE), xz=T * np.sin(PHASE))
    assert crossland(MATERIAL, around) == pytest.approx(T, rel=1e-6)
