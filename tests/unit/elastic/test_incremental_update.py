from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.incremental_update import NOTHING, SHARE, UpdateArrays
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import SINGLE_ROUNDING
from fretsolve.model.materials import Compliances
from fretsolve.model.terms import Terms

SHAPE = (48, 40)
OPERATOR = ElasticOperator(
    SHAPE, (0.02, 0.025), Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6), Terms(True, True, True)
)
UPDATES = {
    "normal": (OPERATOR.incremental_normal, lambda p, u: OPERATOR.normal(p[0], u[0])),
    "tangential": (OPERATOR.incremental_tangential, OPERATOR.tangential),
    "from pressure": (
        OPERATOR.incremental_tangential_from_pressure,
        lambda p, u: OPERATOR.tangential_from_pressure(p[0], u),
    ),
    "from shear": (OPERATOR.incremental_normal_from_shear, lambda q, u: OPERATOR.normal_from_shear(q, u[0])),
}


def arrays(change):
    double = np.zeros((2, *SHAPE))
    double[: len(change)] = change
    return UpdateArrays(double, (np.zeros((2, *SHAPE), np.float32), np.zeros((2, *SHAPE), np.float32)))


def exact(name, traction):
    update, apply = UPDATES[name]
    displacement = np.empty((update.displacements, *SHAPE))
    apply(traction, displacement)
    return displacement


def steps(name, sizes, seed=0):
    """A traction and its changes."""
    random = np.random.default_rng(seed)
    return [size * random.normal(size=(UPDATES[name][0].tractions, *SHAPE)) for size in sizes]


@pytest.mark.parametrize("name", UPDATES)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-13])
def test_errors_stay_below_the_allowed_one(name, sign, tolerance):
    changes = steps(name, (100.0, 10.0, 1.0, 1e-2, 1e-5))
    total, displacement = np.sum(changes, axis=0), 0.0
    for change in changes:
        displacement = displacement + sign * exact(name, change)
    found = sign * exact(name, changes[0])
    allowed = tolerance * np.abs(found).max()
    for change in changes[1:]:
        UPDATES[name][0].add(found, arrays(change), allowed, sign)
    np.testing.assert_allclose(found, sign * exact(name, total), rtol=1e-12, atol=allowed)


@pytest.mark.parametrize("name", UPDATES)
def test_precision_follows_the_allowed_error(name):
    (change,) = steps(name, (3.0,))
    wanted = exact(name, change)
    largest = np.abs(wanted).max()
    errors = []
    for allowed in (1.5 * SINGLE_ROUNDING / SHARE * largest, 0.7 * SINGLE_ROUNDING / SHARE * largest, 0.0):
        found = np.zeros_like(wanted)
        UPDATES[name][0].add(found, arrays(change), allowed)
        errors.append(np.abs(found - wanted).max() / largest)
    assert 1e-9 < errors[0] < SINGLE_ROUNDING
    assert errors[1:] == pytest.approx([0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize("name", UPDATES)
def test_a_negligible_change_is_left_out(name):
    """The displacement left out is below the bound by which it is judged."""
    (change,) = steps(name, (1e-9,))
    update = UPDATES[name][0]
    found = np.zeros((update.displacements, *SHAPE))
    applications = OPERATOR.total_applications
    allowed = update.unit * np.abs(change).max() * max(SHAPE) / NOTHING
    update.add(found, arrays(change), 1.01 * allowed)
    assert not found.any()
    assert OPERATOR.total_applications == applications
    assert np.abs(exact(name, np.full_like(change, np.abs(change).max()))).max() < NOTHING * allowed
    update.add(found, arrays(change), 0.99 * allowed)
    assert found.any()


def test_a_nan_comes_through():
    found, change = np.zeros((2, *SHAPE)), np.zeros((2, *SHAPE))
    change[0, 3, 3] = np.nan
    UPDATES["tangential"][0].add(found, arrays(change), 1.0)
    assert np.isnan(found).any()
