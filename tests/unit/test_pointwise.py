"""The compiled kernels give what the plain ones give."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

from fretsolve.pointwise import cg_plain, friction_plain, spectral_plain

pytest.importorskip("numba")

from fretsolve.pointwise import cg_compiled, friction_compiled, spectral_compiled

SHAPES = [(1, 1), (7, 5), (40, 33)]
CG = ["finish_search", "turn", "finish_image", "advance", "restrict", "weigh_moments", "remove"]
FRICTION = ["take_slip", "move", "gram", "add_motion", "violation", "scale_tangential", "return_to_circle", "excess"]


def arguments(function, shape, components, dtype, seed=0):
    """Random arguments by the names of the function's parameters."""
    random = np.random.default_rng(seed)
    nx, ny = shape
    contact = random.random(shape) < 0.8
    slipping = contact & (random.random(shape) < 0.5)
    angle = random.uniform(0.0, 6.3, shape)
    single = {"residual", "solution", "direction", "image", "field", "constraints", "stiffness"}

    def value(name):
        if name in ("contact", "zone"):
            return contact.copy()
        if name == "slipping":
            return slipping.copy()
        if name == "normal":
            normal = np.array([np.cos(angle), np.sin(angle)]) * slipping
            return normal.astype(dtype) if function in CG else normal
        if name == "weight":
            return (random.random(shape) * contact).astype(dtype)
        if name in ("x", "y"):
            return random.normal(size=nx if name == "x" else ny)
        if name == "bound":
            return random.random(shape) * contact
        if name in ("growth", "length", "unit", "factor"):
            return 0.7
        if name == "stiffest":
            return 1.5
        plane = {"stiffness": shape, "constraints": (2, components, *shape), "moments": (2,), "rigid": (3,)}
        plane |= {"sums": (3,), "result": (3, 3) if function == "gram" else (2, *shape)}
        size = plane.get(name, (components, *shape))
        array = random.normal(size=size)
        return array.astype(dtype) if name in single else array

    plain = cg_plain if function in CG else friction_plain
    return [value(name) for name in inspect.signature(getattr(plain, function)).parameters]


def assert_same(plain, compiled, found, expected, tolerance):
    np.testing.assert_allclose(found, expected, rtol=tolerance, atol=tolerance)
    for one, other in zip(plain, compiled, strict=True):
        np.testing.assert_allclose(np.asarray(other, float), np.asarray(one, float), rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("components", [1, 2])
@pytest.mark.parametrize("function", CG)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_inner_iterations(function, components, shape, dtype):
    plain, compiled = (arguments(function, shape, components, dtype) for _ in range(2))
    expected = getattr(cg_plain, function)(*plain)
    found = getattr(cg_compiled, function)(*compiled)
    tolerance = 2e-4 if dtype == np.float32 else 1e-10
    assert_same(plain, compiled, 0.0 if found is None else found, 0.0 if expected is None else expected, tolerance)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("function", FRICTION)
def test_slip_law(function, shape):
    plain, compiled = (arguments(function, shape, 2, np.float64) for _ in range(2))
    expected = getattr(friction_plain, function)(*plain)
    found = getattr(friction_compiled, function)(*compiled)
    assert_same(plain, compiled, 0.0 if found is None else found, 0.0 if expected is None else expected, 1e-10)


@pytest.mark.parametrize("rows", [1, 4, 10])
@pytest.mark.parametrize("odd", [False, True])
def test_products_of_spectra(rows, odd):
    random = np.random.default_rng(1)
    kernels = tuple(random.normal(size=(rows // 2 + 1, 3)) for _ in range(3))
    fields = tuple(random.normal(size=(rows, 3)) + 1j * random.normal(size=(rows, 3)) for _ in range(2))
    results = []
    for module in (spectral_plain, spectral_compiled):
        alone, pair = np.empty_like(fields[0]), tuple(np.empty_like(fields[0]) for _ in range(2))
        room = tuple(np.empty_like(fields[0]) for _ in range(2))
        module.multiply(kernels[0], odd, fields[0], alone)
        module.multiply_pair(kernels, odd, fields, pair, room)
        results.append((alone, *pair))
    np.testing.assert_allclose(results[1], results[0], rtol=1e-13)


def test_a_nan_is_not_lost():
    """A residual that is not a number must not look like a small one."""
    slip, normal = np.zeros((2, 4, 4)), np.zeros((2, 4, 4))
    slip[0, 1, 1] = np.nan
    for module in (friction_plain, friction_compiled):
        assert not module.violation(slip, normal, np.zeros((4, 4), dtype=bool))[0] <= 1.0
