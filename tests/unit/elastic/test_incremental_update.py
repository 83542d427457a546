from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.incremental_update import NOTHING, SHARE, Room
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.rounding import SINGLE_ROUNDING
from fretsolve.model.materials import Compliances
from fretsolve.model.terms import Terms

SHAPE = (48, 40)
OPERATOR = ElasticOperator(
    SHAPE, (0.02, 0.025), Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6), Terms(True, True, True)
)
FOLLOWERS = {
    "normal": (OPERATOR.following_normal, lambda p, u: OPERATOR.normal(p[0], u[0])),
    "tangential": (OPERATOR.following_tangential, OPERATOR.tangential),
    "from pressure": (
        OPERATOR.following_tangential_from_pressure,
        lambda p, u: OPERATOR.tangential_from_pressure(p[0], u),
    ),
    "from shear": (OPERATOR.following_normal_from_shear, lambda q, u: OPERATOR.normal_from_shear(q, u[0])),
}


def room(change):
    double = np.zeros((2, *SHAPE))
    double[: len(change)] = change
    return Room(double, (np.zeros((2, *SHAPE), np.float32), np.zeros((2, *SHAPE), np.float32)))


def exact(name, traction):
    follower, apply = FOLLOWERS[name]
    displacement = np.empty((follower.found, *SHAPE))
    apply(traction, displacement)
    return displacement


def steps(name, sizes, seed=0):
    """A traction and its changes."""
    random = np.random.default_rng(seed)
    return [size * random.normal(size=(FOLLOWERS[name][0].given, *SHAPE)) for size in sizes]


@pytest.mark.parametrize("name", FOLLOWERS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-13])
def test_errors_stay_bearable(name, sign, tolerance):
    changes = steps(name, (100.0, 10.0, 1.0, 1e-2, 1e-5))
    total, displacement = np.sum(changes, axis=0), 0.0
    for change in changes:
        displacement = displacement + sign * exact(name, change)
    found = sign * exact(name, changes[0])
    bearable = tolerance * np.abs(found).max()
    for change in changes[1:]:
        FOLLOWERS[name][0].follow(found, room(change), bearable, sign)
    np.testing.assert_allclose(found, sign * exact(name, total), rtol=1e-12, atol=bearable)


@pytest.mark.parametrize("name", FOLLOWERS)
def test_precision_goes_with_what_is_bearable(name):
    (change,) = steps(name, (3.0,))
    wanted = exact(name, change)
    largest = np.abs(wanted).max()
    errors = []
    for bearable in (1.5 * SINGLE_ROUNDING / SHARE * largest, 0.7 * SINGLE_ROUNDING / SHARE * largest, 0.0):
        found = np.zeros_like(wanted)
        FOLLOWERS[name][0].follow(found, room(change), bearable)
        errors.append(np.abs(found - wanted).max() / largest)
    assert 1e-9 < errors[0] < SINGLE_ROUNDING
    assert errors[1:] == pytest.approx([0.0, 0.0], abs=1e-15)


@pytest.mark.parametrize("name", FOLLOWERS)
def test_what_moves_nothing_is_left_out(name):
    """The displacement left out is smaller than what the change is judged by."""
    (change,) = steps(name, (1e-9,))
    follower = FOLLOWERS[name][0]
    found = np.zeros((follower.found, *SHAPE))
    applications = OPERATOR.total_applications
    bearable = follower.unit * np.abs(change).max() * max(SHAPE) / NOTHING
    follower.follow(found, room(change), 1.01 * bearable)
    assert not found.any()
    assert OPERATOR.total_applications == applications
    assert np.abs(exact(name, np.full_like(change, np.abs(change).max()))).max() < NOTHING * bearable
    follower.follow(found, room(change), 0.99 * bearable)
    assert found.any()


def test_a_nan_comes_through():
    found, change = np.zeros((2, *SHAPE)), np.zeros((2, *SHAPE))
    change[0, 3, 3] = np.nan
    FOLLOWERS["tangential"][0].follow(found, room(change), 1.0)
    assert np.isnan(found).any()
