from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.solvers.incremental_update import Workspace, add_displacement
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

SHAPE = (48, 40)
OPERATOR = ElasticOperator(SHAPE, (0.02, 0.025), Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6), Terms(True, True, True))
METHODS = {
    "normal": (ElasticOperator.normal, 1, 1),
    "tangential": (ElasticOperator.tangential, 2, 2),
    "from pressure": (ElasticOperator.tangential_from_pressure, 1, 2),
    "from shear": (ElasticOperator.normal_from_shear, 2, 1),
}
"""Method, and its numbers of components of traction and displacement."""


def add(name, displacement, change, allowed, sign=1.0):
    workspace = Workspace(2, SHAPE, np.float32)
    workspace.double[: len(change)] = change
    change = workspace.double[: len(change)]
    add_displacement(OPERATOR, METHODS[name][0], displacement, change, workspace, allowed, sign)


def exact(name, traction):
    method, _, components = METHODS[name]
    displacement = np.empty((components, *SHAPE))
    method(OPERATOR, traction, displacement)
    return displacement


def steps(name, sizes, seed=0):
    """A traction and its changes."""
    random = np.random.default_rng(seed)
    return [size * random.normal(size=(METHODS[name][1], *SHAPE)) for size in sizes]


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-13])
def test_errors_stay_below_the_allowed_one(name, sign, tolerance):
    changes = steps(name, (100.0, 10.0, 1.0, 1e-2, 1e-5))
    total, displacement = np.sum(changes, axis=0), 0.0
    for change in changes:
        displacement = displacement + sign * exact(name, change)
    found = sign * exact(name, changes[0])
    allowed = tolerance * np.abs(found).max()
    for change in changes[1:]:
        add(name, found, change, allowed, sign)
    np.testing.assert_allclose(found, sign * exact(name, total), rtol=1e-12, atol=allowed)
