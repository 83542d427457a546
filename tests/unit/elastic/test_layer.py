"""A layer adds its compliance times the traction at its place, in every operator, and preconditioners know it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fretsolve.elastic.influence import influence_coefficients
from fretsolve.elastic.mirrored_operator import MirroredOperator
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.operator_on_grid import operator_on, strip_influence
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.model.materials import Compliances, Orthotropy
from fretsolve.problem.model.required_terms import Terms

BARE = Compliances(A=1.1e-5, B=3.4e-6, C=2e-6)
LAYERED = replace(BARE, layer_shear=3e-6, layer_normal=5e-7)
SHAPE, SPACING, ALL = (12, 10), (0.1, 0.12), Terms(True, True, True)
GRID = Grid.from_size(SHAPE, (SHAPE[0] * SPACING[0], SHAPE[1] * SPACING[1]), (0.0, 0.0))
LINE = LineGrid.of_length(24, 2.4, 0.0, 1.0)


def tractions(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    return random.random(shape), random.standard_normal((2, *shape))


def displacements(operator: ElasticOperator) -> tuple[np.ndarray, np.ndarray]:
    pressure, shear = (field.astype(operator.dtype) for field in tractions(operator.shape))
    uz, ut = np.empty_like(pressure), np.empty_like(shear)
    operator.all(pressure, shear, uz, ut)
    return uz, ut


def test_only_a_cells_own_coefficients_change() -> None:
    for name, added in (("zz", 5e-7), ("xx", 3e-6), ("yy", 3e-6), ("xy", 0.0), ("xz", 0.0), ("yz", 0.0)):
        change = influence_coefficients(name, SHAPE, SPACING, LAYERED)
        change -= influence_coefficients(name, SHAPE, SPACING, BARE)
        assert change[0, 0] == pytest.approx(added, abs=1e-18)
        assert np.count_nonzero(change) == bool(added)
        line = strip_influence(name, LINE, LAYERED) - strip_influence(name, LINE, BARE)
        assert line[0, 0] == pytest.approx(added, abs=1e-18)
        assert np.count_nonzero(line) == bool(added)


@pytest.mark.parametrize("kind", ["whole", "mirrored", "line", "single"])
def test_the_displacement_grows_by_the_compliance_times_the_traction(kind: str) -> None:
    dtype = np.float32 if kind == "single" else np.float64

    def made(material: Compliances) -> ElasticOperator:
        if kind == "line":
            return operator_on(LINE, material, Terms(True, False, True))
        of = MirroredOperator if kind == "mirrored" else ElasticOperator
        return of(SHAPE, SPACING, material, ALL, dtype=dtype)

    (uz, ut), (bare_z, bare_t) = displacements(made(LAYERED)), displacements(made(BARE))
    pressure, shear = tractions(uz.shape)
    tolerance = 1e-6 if kind == "single" else 1e-14
    np.testing.assert_allclose(uz - bare_z, 5e-7 * pressure, atol=tolerance * uz.max())
    np.testing.assert_allclose(ut - bare_t, 3e-6 * shear, atol=tolerance * np.abs(ut).max())


def test_the_layer_between_bodies_with_friction_of_two_coefficients() -> None:
    """The displacement of the scaled traction is scaled, too: M L M q' for q = M q'."""
    orthotropy, terms = Orthotropy.of((0.4, 0.1), 0.3), Terms(True, True, False)
    ut = np.empty((2, *SHAPE))
    _, shear = tractions(SHAPE)
    found = []
    for material in (LAYERED, BARE):
        operator = operator_on(GRID, material, terms, orthotropy=orthotropy)
        operator.tangential(shear, ut)
        found.append(ut.copy())
    np.testing.assert_allclose(found[0] - found[1], 3e-6 * orthotropy.times(orthotropy.times(shear)), atol=1e-18)


@pytest.mark.parametrize("line", [False, True])
def test_the_preconditioner_inverts_a_compliant_layer(line: bool) -> None:
    """The layer alone has the inverse 1/L, whatever the bodies do."""
    material = replace(BARE, layer_shear=1.0, layer_normal=10.0)
    operator = operator_on(LINE if line else GRID, material, Terms(True, not line, False))
    pressure, shear = (field.astype(np.float32) for field in tractions(operator.shape))
    back_z, back_t = np.empty_like(pressure[None]), np.empty_like(shear)
    operator.preconditioner.normal(10.0 / operator.unit * pressure[None], back_z)
    operator.preconditioner.tangential(1.0 / operator.unit * shear, back_t)
    np.testing.assert_allclose(back_z[0], pressure, atol=1e-5)
    np.testing.assert_allclose(back_t, shear, atol=1e-4)


@pytest.mark.parametrize("line", [False, True])
def test_the_unit_of_the_inner_iterations_has_the_layer(line: bool) -> None:
    bare, layered = (operator_on(LINE if line else GRID, one, ALL) for one in (BARE, LAYERED))
    assert layered.self_coefficient - bare.self_coefficient == pytest.approx(3e-6)
