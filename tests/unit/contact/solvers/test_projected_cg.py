from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.solvers.incremental_update import Workspace
from fretsolve.contact.solvers.projected_cg import ProjectedCG
from fretsolve.contact.solvers.rigid_modes import NormalModes, TangentialModes
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

GRID = Grid.from_size((16, 14), (1.6, 1.4))
OPERATOR = ElasticOperator(GRID.shape, (0.1, 0.1), Compliances(1.1e-5, 3.4e-6, 0.0), Terms(True, True, False))
INNER_NORMAL = OPERATOR.inner.normal, OPERATOR.preconditioner.normal


def zone(radius=0.6, center=(0.0, 0.0)):
    return np.hypot(GRID.x[:, None] - center[0], GRID.y[None, :] - center[1]) < radius


def dense(components):
    """B as a matrix, in units of the inner iterations."""
    columns = []
    for unit in np.eye(components * GRID.nx * GRID.ny):
        field, image = unit.reshape((components, *GRID.shape)), np.empty((components, *GRID.shape))
        if components == 1:
            OPERATOR.normal(field[0], image[0])
        else:
            OPERATOR.tangential(field, image)
        columns.append(image.ravel() / OPERATOR.unit)
    return np.array(columns).T


@pytest.mark.parametrize("forced", [[], [0, 1, 2]])
def test_normal_solution_is_that_of_the_dense_system(forced):
    modes, contact = NormalModes(GRID), zone()
    cg = ProjectedCG(Workspace(1, GRID.shape, np.float32))
    residual = np.random.default_rng(0).normal(size=(1, *GRID.shape)) * contact
    cg.residual[:], cg.zone[:], cg.weight[:] = residual, contact, contact
    cg.constrain(np.eye(3)[forced], GRID.x, GRID.y)
    iterations = cg.solve(*INNER_NORMAL, 1e-4, 0.0, 100)
    inside = contact.ravel()
    rows = [constraint(modes, 1, mode).ravel()[inside] for mode in forced]
    constraints = np.array(rows).reshape(len(forced), inside.sum())
    expected = saddle_point(dense(1)[np.ix_(inside, inside)], constraints, residual.ravel()[inside])
    np.testing.assert_allclose(cg.solution.ravel()[inside], expected, atol=1e-3 * np.abs(expected).max())
    assert not cg.solution.ravel()[~inside].any()
    assert 1 < iterations < 20


@pytest.mark.parametrize("forced", [[], [0, 1, 2]])
def test_tangential_solution_is_that_of_the_dense_system(forced):
    """Slip in a ring, with directions and stiffnesses over ten decades."""
    random, modes, contact = np.random.default_rng(1), TangentialModes(GRID), zone()
    slipping = contact & ~zone(0.35)
    angle = random.uniform(0.0, 6.3, GRID.shape)
    normal = np.array([np.cos(angle), np.sin(angle)]) * slipping
    stiffness = 10.0 ** random.uniform(-5, 5, GRID.shape) * slipping
    cg = ProjectedCG(Workspace(2, GRID.shape, np.float32))
    residual = random.normal(size=(2, *GRID.shape)) * contact
    cg.residual[:], cg.zone[:], cg.normal[:], cg.stiffness[:] = residual, contact, normal, stiffness
    cg.weight[:] = contact / (1.0 + stiffness)
    cg.constrain(np.eye(3)[forced], GRID.x, GRID.y)
    cg.solve(OPERATOR.inner.tangential, OPERATOR.preconditioner.tangential, 1e-5, 0.0, 200)
    basis = tangent_basis(contact, normal)
    matrix = basis.T @ (dense(2) + np.diag(np.tile(stiffness.ravel(), 2))) @ basis
    rows = [constraint(modes, 2, mode).ravel() @ basis for mode in forced]
    constraints = np.array(rows).reshape(len(forced), basis.shape[1])
    expected = basis @ saddle_point(matrix, constraints, residual.ravel() @ basis)
    np.testing.assert_allclose(cg.solution.ravel(), expected, atol=2e-3 * np.abs(expected).max())
    solution, moved = cg.found
    wanted = np.empty_like(solution)
    OPERATOR.inner.tangential(solution, wanted)
    np.testing.assert_allclose(moved, wanted, atol=1e-5 * np.abs(wanted).max())  # outside of the zone, too


@pytest.mark.parametrize("softness", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("forced", "sprung"), [([], [0]), ([1, 2], [0]), ([0], [1, 2]), ([], [0, 1, 2])])
def test_a_rig_adds_its_compliance_to_the_dense_system(forced, sprung, softness):
    """And costs no iterations: softness is about the rig's compliance over the contact's."""
    modes, contact = NormalModes(GRID), zone(center=(0.05, -0.1))
    cg = ProjectedCG(Workspace(1, GRID.shape, np.float32))
    residual = np.random.default_rng(0).normal(size=(1, *GRID.shape)) * contact
    compliance = softness * np.diag([0.05, 0.2, 0.3])
    compliance[1, 2] = compliance[2, 1] = 0.1 * softness
    cg.residual[:], cg.zone[:], cg.weight[:] = residual, contact, contact
    cg.constrain(np.eye(3)[forced], GRID.x, GRID.y, (sprung, compliance))
    iterations = cg.solve(*INNER_NORMAL, 1e-5, 0.0, 200)
    inside = contact.ravel()
    rigid = np.array([constraint(modes, 1, mode).ravel()[inside] for mode in range(3)])
    matrix = dense(1)[np.ix_(inside, inside)]
    matrix += rigid[sprung].T @ compliance[np.ix_(sprung, sprung)] @ rigid[sprung]
    expected = saddle_point(matrix, rigid[forced].reshape(len(forced), inside.sum()), residual.ravel()[inside])
    np.testing.assert_allclose(cg.solution.ravel()[inside], expected, atol=2e-3 * np.abs(expected).max())
    solution, moved = cg.found
    wanted = np.empty_like(solution)
    OPERATOR.inner.normal(solution, wanted)
    np.testing.assert_allclose(moved, wanted, atol=1e-4 * max(1.0, softness**0.5) * np.abs(wanted).max())
    assert iterations < 20


def constraint(modes, components, mode):
    field = np.zeros((components, *GRID.shape))
    modes.displacement(np.eye(3)[mode], field[0] if components == 1 else field)
    return field


def saddle_point(matrix, constraints, right):
    """x of  matrix x + constraints' m = right,  constraints x = 0."""
    count = len(constraints)
    whole = np.block([[matrix, constraints.T], [constraints, np.zeros((count, count))]])
    return np.linalg.solve(whole, np.append(right, np.zeros(count)))[: len(right)]


def tangent_basis(contact, normal):
    """Orthonormal columns: both directions in the stick zone, the one across `normal` in the slip zone."""
    columns, cells = [], GRID.nx * GRID.ny
    for cell in np.flatnonzero(contact):
        n = normal[:, *np.unravel_index(cell, GRID.shape)]
        directions = [(1.0, 0.0), (0.0, 1.0)] if not n.any() else [(-n[1], n[0])]
        for x, y in directions:
            column = np.zeros(2 * cells)
            column[cell], column[cells + cell] = x, y
            columns.append(column)
    return np.array(columns).T
