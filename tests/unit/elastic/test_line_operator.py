"""The strips' influence coefficients against integrals of the line force, and the operator made of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from line_cases import DISSIMILAR, line_case
from scipy.integrate import quad

from fretsolve.elastic.operator_on_grid import LineOperator, LinePreconditioner, log_integral, strip_influence
from fretsolve.problem.model.grid import LineGrid
from fretsolve.problem.model.materials import compliances
from fretsolve.problem.model.required_terms import Terms

MATERIAL = compliances(*line_case(bodies=DISSIMILAR).bodies)
GRID = LineGrid.of_length(40, 0.8, 0.0, 1.5)
FULL = Terms(tangential=True, in_plane_coupling=False, normal_tangential_coupling=True)
RNG = np.random.default_rng(4)


@pytest.mark.parametrize("offset", [0, 1, 2, 17, 1000, 10**6])
def test_integral_of_the_logarithm(offset):
    side, length = 0.02, 1.5
    middle, half = offset * side, 0.5 * side
    exact = sum(quad(lambda t: math.log(abs(middle + t) / length), *ends)[0] for ends in ((-half, 0.0), (0.0, half)))
    found = log_integral(offset + 1, side, length)[-1]
    assert found == pytest.approx(exact, rel=1e-13 if offset else 1e-9)


def tractions():
    return RNG.standard_normal((40, 1)), RNG.standard_normal((2, 40, 1))


def direct(pressure, shear):
    """Sum the coefficients cell by cell."""
    between = np.subtract.outer(np.arange(40), np.arange(40))
    kernel = {name: strip_influence(name, GRID, MATERIAL)[:, 0][np.abs(between)] for name in ("zz", "xx", "yy", "xz")}
    sideways = kernel["xz"] * np.sign(between)
    uz = kernel["zz"] @ pressure - sideways @ shear[0]
    return uz, np.array([kernel["xx"] @ shear[0] + sideways @ pressure, kernel["yy"] @ shear[1]])


@pytest.mark.parametrize("antiplane", [True, False])
def test_operator_sums_the_coefficients(antiplane):
    operator = LineOperator(GRID, MATERIAL, FULL)
    (pressure, shear), uz, displacement = tractions(), np.empty((40, 1)), np.empty((2, 40, 1))
    shear[1] *= antiplane
    operator.all(pressure, shear, uz, displacement)
    expected = direct(pressure, shear)
    assert uz == pytest.approx(expected[0], rel=1e-11, abs=1e-18)
    assert displacement == pytest.approx(expected[1], rel=1e-11, abs=1e-18)


def test_operator_is_symmetric_and_positive_definite():
    """Also under a net force, since the logarithm's length is at least the grid's."""
    operator = LineOperator(LineGrid.of_length(40, 0.8, 0.0), MATERIAL, FULL)
    columns = []
    for cell in range(120):
        unit = np.zeros((3, 40, 1))
        unit.reshape(-1)[cell] = 1.0
        image = np.empty((3, 40, 1))
        operator.all(unit[0], unit[1:], image[0], image[1:])
        columns.append(image.ravel())
    matrix = np.array(columns)
    assert matrix == pytest.approx(matrix.T, abs=1e-14 * np.abs(matrix).max())
    assert np.linalg.eigvalsh(matrix)[0] > 0.0


@pytest.mark.parametrize("component", [0, 1])
def test_preconditioner_inverts_waves(component):
    grid = LineGrid.of_length(200, 1.0, 0.0)
    operator = LineOperator(grid, MATERIAL, FULL)
    inverse = LinePreconditioner(grid, MATERIAL, FULL, 1.0)
    envelope = np.sin(math.pi * np.arange(200) / 199) ** 4
    wave = np.zeros((2, 200, 1))
    wave[component, :, 0] = envelope * np.sin(2.0 * math.pi * 20 * grid.x)
    moved, back = np.empty_like(wave), np.empty_like(wave)
    operator.tangential(wave, moved)
    inverse.tangential(moved, back)
    assert back[component, 50:150, 0] == pytest.approx(wave[component, 50:150, 0], abs=0.05)
