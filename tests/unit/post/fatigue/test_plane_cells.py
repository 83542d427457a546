"""Cells of planes cover the half sphere, and few points are refined where stress is nearly uniform."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.case.keys.material_spec import Material
from fretsolve.post.fatigue.criteria import fatigue_field
from fretsolve.post.fatigue.plane_cells import PlaneCells
from fretsolve.post.fatigue.planes import scan_normals

STEEL = Material(
    tension_limit=300.0,
    torsion_limit=190.0,
    tensile_strength=700.0,
    yield_stress=500.0,
    young_modulus=200e3,
    poisson_ratio=0.3,
)


def area(cells: PlaneCells) -> float:
    """Return the area of the unit sphere that cells cover."""
    (inclination, _), (high, wide) = cells.middles, cells.sides
    return float((2.0 * np.sin(inclination) * np.sin(0.5 * high) * wide).sum())


def test_cells_cover_the_half_sphere_once() -> None:
    cells = PlaneCells.of_half_sphere(10.0)
    assert len(cells) == len(scan_normals(10.0)) + 3  # the cap around z has four
    assert area(cells) == pytest.approx(2.0 * np.pi)
    halved = cells.halved().halved()
    assert (len(halved), halved.step) == (16 * len(cells), 2.5)
    assert area(halved) == pytest.approx(2.0 * np.pi)
    np.testing.assert_allclose(np.linalg.norm(halved.normals, axis=1), 1.0)
    # Every plane is within half a diagonal of a cell of the middle of one.
    random = np.random.default_rng(2).normal(size=(200, 3))
    random /= np.linalg.norm(random, axis=1, keepdims=True)
    farthest = np.degrees(np.arccos(np.abs(random @ halved.normals.T).max(axis=1).clip(0.0, 1.0))).max()
    assert farthest < 0.75 * halved.step


@pytest.mark.parametrize("name", ["findley", "mcdiarmid", "fatemi-socie", "swt"])
def test_the_worst_of_nearly_uniform_stress(name: str) -> None:
    """Planes on a cone about the tension are nearly equal at every point, which differ by a thousandth.

    A value that another layer nearly has is known, so that only points above it are refined.
    """
    load = np.array([1.0, 0.5, -0.9, 0.1, 1.0])[:, None, None]
    random = np.random.default_rng(1)
    stress = 300.0 * load * np.array([1.0, 0, 0, 0, 0, 0])[:, None] + 0.3 * load * random.normal(size=(6, 60))
    every = fatigue_field(name, STEEL, stress, refine_all=True)
    found = fatigue_field(name, STEEL, stress, known=float(every.value.max()) * (1.0 - 1e-4))
    assert found.value.max() == pytest.approx(every.value.max(), rel=2e-6)
    assert found.value.argmax() == every.value.argmax()
    assert found.refined is not None
    assert found.refined.sum() <= 20
