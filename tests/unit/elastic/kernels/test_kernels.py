"""The kernels compiled by numba give the same as those in NumPy."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fretsolve
from fretsolve.contact.kernels import GridKernels, kernels_on

pytest.importorskip("numba")

from fretsolve.elastic import thread_team
from fretsolve.elastic.thread_team import ThreadTeam

FORMS = ["numpy", "numpy in parts", "compiled", "compiled in parts"]
SHAPES = [(1, 1), (40, 33)]
CG = ["constrain", "start", "search", "step", "add", "largest", "normalise"]
NORMAL = ["sum_gaps", "take_gap", "largest_change", "gram", "sum_modes", "stretch"]
FRICTION = ["take_slip", "move", "gram", "balance", "add_motion", "sum_motions", "violation", "scale_tangential"]
FRICTION += ["return_map", "excess"]


@pytest.fixture(autouse=True)
def many_parts(monkeypatch):
    monkeypatch.setattr(thread_team, "PART_CELLS", 20)


def kernels(form: str, shape, threads: int = 2) -> GridKernels:
    """Return the kernels for a grid: in one call for all of its rows, or in parts that threads share."""
    share = ThreadTeam(threads).share if "parts" in form else None
    return kernels_on(shape, "compiled" in form, share)


def parameters(kind, function):
    """Return the names of the arguments of a kernel."""
    return list(inspect.signature(getattr(getattr(kernels_on((1, 1), False), kind), function)).parameters)


def arguments(function, shape, components, dtype, seed=0):
    """Random arguments by the names of the function's parameters."""
    random = np.random.default_rng(seed)
    nx, ny = shape
    contact = random.random(shape) < 0.8
    slipping = contact & (random.random(shape) < 0.5)
    angle = random.uniform(0.0, 6.3, shape)
    single = {"residual", "solution", "direction", "image", "field", "constraints", "stiffness", "result"}
    single |= {"moved", "displacement"}

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
        if name == "limit":
            return random.random(shape) * contact
        if name in ("rho", "rho_before", "unit", "factor"):
            return 0.7
        if name == "stiffest":
            return 1.5
        plane = {
            "stiffness": shape,
            "constraints": (2, components, *shape),
            "motions": (2, 3),
            "inverse_gram": (2, 2),
            "rigid": (3,),
        }
        size = plane.get(name, (components, *shape))
        array = random.normal(size=size)
        return array.astype(dtype) if name in single else array

    return [value(name) for name in parameters("cg" if function in CG else "friction", function)]


def normal_arguments(function, shape, dtype):
    """The same for the kernels of the normal problem; no material in a corner out of contact."""
    random = np.random.default_rng(0)
    contact = random.random(shape) < 0.6
    separation = random.normal(size=shape)
    separation[-1, -1], contact[-1, -1] = np.inf, False
    values = {
        "separation": separation,
        "contact": contact,
        "weight": contact.copy() if dtype is bool else random.random(shape) * contact,
        "x": random.normal(size=shape[0]),
        "y": random.normal(size=shape[1]),
        "rigid": random.normal(size=3),
    }
    names = parameters("normal", function)
    return [values[name] if name in values else random.normal(size=shape) for name in names]


def assert_same(kind, form, shape, function, arguments, tolerance):
    """The same return value as those in NumPy at once, and the same in the arrays that are written to."""
    given, taken = arguments(), arguments()
    plain, other = getattr(kernels("numpy", shape), kind), getattr(kernels(form, shape), kind)
    expected, found = getattr(plain, function)(*given), getattr(other, function)(*taken)
    assert (expected is None) == (found is None)
    if expected is None:
        returned = []
    else:
        returned = list(zip(expected, found, strict=True)) if isinstance(expected, tuple) else [(expected, found)]
    for one, other in [*returned, *zip(given, taken, strict=True)]:
        np.testing.assert_allclose(np.asarray(other, float), np.asarray(one, float), rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("form", FORMS[1:])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("components", [1, 2])
@pytest.mark.parametrize("function", CG)
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float32, 2e-4), (np.float64, 1e-10)])
def test_inner_iterations(function, components, shape, dtype, tolerance, form):
    assert_same("cg", form, shape, function, lambda: arguments(function, shape, components, dtype), tolerance)


@pytest.mark.parametrize("form", FORMS[1:])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("function", FRICTION)
def test_slip_law(function, shape, form):
    assert_same("friction", form, shape, function, lambda: arguments(function, shape, 2, np.float64), 1e-10)


@pytest.mark.parametrize("form", FORMS[1:])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("function", "dtype"), [*((name, float) for name in NORMAL), ("gram", bool)])
def test_normal_problem(function, dtype, shape, form):
    assert_same("normal", form, shape, function, lambda: normal_arguments(function, shape, dtype), 1e-11)


@pytest.mark.parametrize("form", ["numpy in parts", "compiled in parts"])
@pytest.mark.parametrize(("kind", "function"), [("cg", "step"), ("friction", "take_slip"), ("normal", "sum_gaps")])
def test_threads_change_no_bit(kind, function, form):
    shape, found = (40, 33), []
    for threads in (1, 2, 3):
        if kind == "normal":
            given = normal_arguments(function, shape, float)
        else:
            given = arguments(function, shape, 2, np.float32)
        result = getattr(getattr(kernels(form, shape, threads), kind), function)(*given)
        whole = [*result] if isinstance(result, tuple) else [result]
        found.append(b"".join(np.asarray(value).tobytes() for value in [*whole, *given]))
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("touches", [False, True])
def test_a_nan_of_the_gap_is_not_lost(form, touches):
    uz, nothing = np.zeros((40, 4)), np.zeros(4)
    uz[1, 1] = np.nan
    contact = np.full((40, 4), touches)
    module = kernels(form, (40, 4)).normal
    errors = module.take_gap(np.zeros((40, 4)), uz, np.zeros(3), np.zeros(40), nothing, contact, np.zeros((40, 4)))
    assert np.isnan(errors[0] if touches else errors[1])


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("slips", [False, True])
def test_a_nan_of_the_slip_is_not_lost(form, slips):
    """A residual that is not a number must not look like a small one, whatever comes after it."""
    slip, normal, slipping = np.zeros((2, 40, 4)), np.zeros((2, 40, 4)), np.full((40, 4), slips)
    module = kernels(form, (40, 4)).friction
    normal[1] = slipping
    slip[0, 1, 1] = np.nan
    largest, in_slip, in_stick = module.violation(slip, normal, slipping)
    assert np.isnan(largest)
    assert np.isnan(in_slip if slips else in_stick)
    assert np.isnan(module.excess(slip, np.ones((40, 4))))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("components", [1, 2])
def test_a_nan_of_the_residual_is_not_lost(form, components):
    shape = 40, 4
    solution, displacement, residual, direction, moved, image = (np.ones((components, *shape)) for _ in range(6))
    residual[-1, 1, 1] = np.nan
    planes = np.zeros(shape), np.zeros((2, *shape)), np.ones(shape, bool), np.ones(shape)
    nothing = np.zeros((0, components, *shape)), np.zeros((0, 0))
    module = kernels(form, shape).cg
    assert np.isnan(module.largest(residual))
    step = module.step(solution, displacement, residual.copy(), direction, moved, image, *planes, *nothing, 1.0)
    assert np.isnan(step[1])
    assert np.isnan(module.start(solution, displacement, direction, residual, image, *planes, *nothing))


@pytest.mark.parametrize("form", ["numpy", "compiled"])
def test_nothing_from_outside_of_the_zone_comes_in(form):
    residual, zone = np.full((1, 2, 2), np.inf), np.array([[True, False], [False, False]])
    residual[0, 0, 0] = 1.0
    fields = [np.ones((1, 2, 2)) for _ in range(3)]
    unused, nothing = np.zeros((2, 1, 1)), (np.zeros((0, 1, 2, 2)), np.zeros((0, 0)))
    image = np.full((1, 2, 2), np.nan)
    kernels(form, (2, 2)).cg.start(*fields, residual, image, unused[0], unused, zone, np.ones((2, 2)), *nothing)
    assert residual.tolist() == image.tolist() == [[[1.0, 0.0], [0.0, 0.0]]]


SOLVE = """
from fretsolve import load_case, run
from fretsolve.elastic.kernels import load
from fretsolve.simulation.problem_setup import set_up
path = "load_path=[{P: 400, increments: 2}, {Qx: 30, increments: 2}]"
setup = set_up(load_case("cases/mode1_dissimilar.yaml", ["grid.points=32", "expect=[]", path]))
last = list(run(setup))[-1].summary
print(load(setup.compiled).compiled, last.iterations_tangential, repr(last.delta_x), repr(last.work_total))
"""


def solve_in_a_process(**environment):
    root = Path(fretsolve.__file__).parents[1]
    child = subprocess.run(
        [sys.executable, "-c", SOLVE],
        cwd=root,
        env=os.environ | {"PYTHONPATH": str(root)} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    compiled, iterations, *numbers = child.stdout.split()
    return compiled == "True", int(iterations), [float(number) for number in numbers]


@pytest.mark.slow
def test_a_case_is_solved_alike_with_and_without_the_compiler(tmp_path):
    """Also with a numba that is there and refuses to work: as if it were not there."""
    (tmp_path / "numba.py").write_text("raise ImportError('Numba needs another NumPy')\n")
    root = Path(fretsolve.__file__).parents[1]
    compiled = solve_in_a_process(FRETSOLVE_NUMBA="1")
    plain = solve_in_a_process(FRETSOLVE_NUMBA="0")
    refused = solve_in_a_process(FRETSOLVE_NUMBA="1", PYTHONPATH=f"{tmp_path}{os.pathsep}{root}")
    switched_off = solve_in_a_process(FRETSOLVE_NUMBA="1", NUMBA_DISABLE_JIT="1")
    assert (compiled[0], plain[0], refused[0], switched_off[0]) == (True, False, False, False)
    assert refused == switched_off == plain
    assert abs(compiled[1] - plain[1]) <= 2
    np.testing.assert_allclose(compiled[2], plain[2], rtol=1e-6)
