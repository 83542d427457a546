"""The operator on scaled shear, M K M, and the choice of an operator for a grid."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.elastic.influence import KernelSpectrum
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.operator_on_grid import LineOperator, OrthotropicOperator, operator_on
from fretsolve.problem.model.grid import Grid, LineGrid
from fretsolve.problem.model.materials import Compliances, Orthotropy
from fretsolve.problem.model.required_terms import Terms

MATERIAL, GRID = Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6), Grid(10, 8, 0.1, 0.12)
FULL, TANGENTIAL = Terms(True, True, True), Terms(True, True, False)
SCALE = Orthotropy.of((0.2, 0.5), math.radians(30.0))
M = np.array([[SCALE.xx, SCALE.xy], [SCALE.xy, SCALE.yy]])


def scaled(field: np.ndarray) -> np.ndarray:
    return np.einsum("ij,jkl->ikl", M, field)


@pytest.fixture
def tractions() -> tuple[np.ndarray, np.ndarray]:
    normal, *shear = np.random.default_rng(7).normal(size=(3, *GRID.shape))
    return normal, np.array(shear)


@pytest.mark.parametrize("terms", [FULL, TANGENTIAL])
def test_shear_and_displacement_are_scaled(terms, tractions):
    pressure, shear = tractions
    plain, operator = operator_on(GRID, MATERIAL, terms), operator_on(GRID, MATERIAL, terms, orthotropy=SCALE)
    assert type(operator) is OrthotropicOperator
    found, expected = np.empty_like(shear), np.empty_like(shear)
    operator.tangential(shear, found)
    plain.tangential(scaled(shear), expected)
    np.testing.assert_allclose(found, scaled(expected), rtol=1e-12, atol=1e-20)
    uz, right = np.empty(GRID.shape), np.empty(GRID.shape)
    operator.all(pressure, shear, uz, found)
    plain.all(pressure, scaled(shear), right, expected)
    np.testing.assert_allclose(uz, right, rtol=1e-12, atol=1e-20)
    np.testing.assert_allclose(found, scaled(expected), rtol=1e-12, atol=1e-20)


def test_coupling_is_scaled(tractions):
    pressure, shear = tractions
    plain, operator = operator_on(GRID, MATERIAL, FULL), operator_on(GRID, MATERIAL, FULL, orthotropy=SCALE)
    found, expected = np.empty_like(shear), np.empty_like(shear)
    operator.tangential_from_pressure(pressure, found)
    plain.tangential_from_pressure(pressure, expected)
    np.testing.assert_allclose(found, scaled(expected), rtol=1e-12, atol=1e-20)
    uz, right = np.empty(GRID.shape), np.empty(GRID.shape)
    operator.normal_from_shear(shear, uz)
    plain.normal_from_shear(scaled(shear), right)
    np.testing.assert_allclose(uz, right, rtol=1e-12, atol=1e-20)


def test_the_inner_operator_is_the_same_in_its_unit(tractions):
    _, shear = tractions
    operator = operator_on(GRID, MATERIAL, TANGENTIAL, orthotropy=SCALE)
    found, inner = np.empty_like(shear), np.empty(shear.shape, np.float32)
    operator.tangential(shear, found)
    operator.inner.tangential(shear.astype(np.float32), inner)
    np.testing.assert_allclose(inner * operator.unit, found, atol=1e-5 * np.abs(found).max())


def test_the_preconditioner_inverts_the_scale(tractions):
    """M^-1 K^-1 M^-1 of M d is M^-1 of the plain preconditioner's shear."""
    _, displacement = tractions
    displacement = displacement.astype(np.float32)
    plain = operator_on(GRID, MATERIAL, TANGENTIAL).preconditioner
    operator = operator_on(GRID, MATERIAL, TANGENTIAL, orthotropy=SCALE).preconditioner
    found, expected = np.empty_like(displacement), np.empty_like(displacement)
    operator.tangential(SCALE.times(displacement), found)
    plain.tangential(displacement, expected)
    np.testing.assert_allclose(SCALE.times(found), expected, atol=1e-5 * np.abs(expected).max())


def test_a_line_has_strips_and_an_area_rectangles():
    assert type(operator_on(LineGrid.of_length(8, 1.0, 0.0), MATERIAL, TANGENTIAL)) is LineOperator
    assert type(operator_on(GRID, MATERIAL, FULL)) is ElasticOperator


def test_a_spectrum_in_another_unit_and_precision():
    spectrum = KernelSpectrum(np.array([[1.0, 3.0]]), odd_x=True).scaled(0.5, np.float32)
    assert (spectrum.values.tolist(), spectrum.values.dtype, spectrum.odd_x) == ([[0.5, 1.5]], np.float32, True)
