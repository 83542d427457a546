"""Nothing is computed or allocated that a scene does not require: coefficients, solves, transforms, arrays counted."""

from __future__ import annotations

import gc
import tracemalloc
from collections import Counter

import numpy as np
import pytest
from solving import DISSIMILAR, NO_POISSON, build, solve

from fretsolve import run
from fretsolve.contact.solvers.normal import NormalSolver
from fretsolve.contact.solvers.tangential import TangentialSolver
from fretsolve.elastic import influence
from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.mirrored_operator import MirroredConvolution
from fretsolve.elastic.operator import ElasticOperator

PRESS, PULL, TWIST = {"P": 400.0, "increments": 2}, {"Qx": 20.0, "increments": 2}, {"Mz": 2.0, "increments": 2}
GRID = {"points": [32, 34], "size": [0.8, 0.85]}
"""Not square, so that x and y share no coefficients."""

SCENES = {
    "frictionless": ({"friction": 0}, [PRESS], "zz"),
    "pressed, equal bodies": ({}, [PRESS], "zz"),
    "frictionless, moved": ({"friction": 0}, [PRESS, {"delta_x": 1e-3, "increments": 2}], "zz"),
    "frictionless, unlike bodies, slip stored": ({"friction": 0, "bodies": DISSIMILAR}, [PRESS], "zz xz yz"),
    "force, Poisson's ratio 0": ({"bodies": NO_POISSON}, [PRESS, PULL], "zz xx"),
    "force, equal bodies": ({}, [PRESS, PULL], "zz xx yy xy"),
    "torque, equal bodies": ({}, [PRESS, TWIST], "zz xx yy xy"),
    "pressed, unlike bodies": ({"bodies": DISSIMILAR}, [PRESS], "zz xx yy xy xz yz"),
    "force, unlike bodies": ({"bodies": DISSIMILAR}, [PRESS, PULL], "zz xx yy xy xz yz"),
}
"""Parts, load path, and the coefficients that they need."""
SHEARED = {name for name, (_, _, needed) in SCENES.items() if "xx" in needed}
SLIDING = SHEARED | {"frictionless, moved", "frictionless, unlike bodies, slip stored"}


def states_of(name):
    parts, path, _ = SCENES[name]
    return solve(grid=GRID, load_path=path, **parts)


@pytest.fixture
def calls(monkeypatch):
    """Return how often the methods that cost are called, and which coefficients are computed."""
    counted: Counter[str] = Counter()

    def counting(owner, method, label):
        original = getattr(owner, method)

        def counted_call(self, *arguments, **options):
            counted[label(self, *arguments)] += 1
            return original(self, *arguments, **options)

        monkeypatch.setattr(owner, method, counted_call)

    counting(influence, "influence_coefficients", lambda name, *_: f"coefficients {name}")
    counting(TangentialSolver, "__init__", lambda *_: "tangential solver")
    counting(NormalSolver, "solve", lambda *_: "normal solve")
    for method in ("normal", "tangential", "tangential_from_pressure", "normal_from_shear"):
        counting(ElasticOperator, method, lambda *_, method=method: f"operator {method}")
    counting(ElasticOperator, "all", lambda *_: "operator all")
    return counted


@pytest.mark.parametrize("name", SCENES)
def test_coefficients_and_solvers_are_those_that_the_scene_needs(name, calls):
    states_of(name)
    found = {key.split()[1] for key in calls if key.startswith("coefficients")}
    assert found == set(SCENES[name][2].split())
    assert (calls["tangential solver"] > 0) == (name in SHEARED)
    assert (calls["operator tangential"] > 0) == (name in SHEARED)
    assert (calls["operator normal_from_shear"] > 0) == ("unlike" in name and name in SHEARED)
    assert (calls["operator tangential_from_pressure"] > 0) == ("unlike" in name)


@pytest.mark.parametrize("name", SCENES)
def test_fields_of_nothing_take_no_memory(name):
    state = states_of(name)[-1]
    fields = state.fields
    for field in (fields.shear, fields.slip, fields.slip_path, fields.work_density):
        assert any(field.strides) == (name in SLIDING)
        assert field.any() or name not in SHEARED or field is fields.work_density
    assert any(state.displacement.strides) == (name in SHEARED or "unlike" in name)
    assert fields.shear.shape == fields.slip.shape == (2, *fields.pressure.shape)


def test_pressure_is_not_solved_again_while_its_load_stays(calls):
    """Cycles of a force between equal bodies; only with unlike ones does the pressure follow the shear."""
    path = [{"P": 400.0}, {"cycle": {"times": 2, "stages": [PULL, {"Qx": -20.0, "increments": 2}]}}]
    for bodies, follows in ((DISSIMILAR, True), (None, False)):
        parts = {"bodies": bodies} if bodies else {}
        states = run(build(grid={"points": 32}, load_path=path, **parts))
        while next(states).summary.stage < 2:
            pass
        calls.clear()
        rest = [state.summary for state in states]
        assert len(rest) == 7
        assert (calls["normal solve"] > 0) == follows
        assert all((summary.iterations_normal > 0) == follows for summary in rest)
        assert follows or calls["operator normal"] == len(rest)  # the proofs alone


def test_an_increment_that_changes_nothing_costs_its_proof_alone(calls):
    """One application of one field: the certificate's."""
    states = run(build(grid={"points": 32}, load_path=[{"P": 400.0}, {"Qx": 0.0}]))
    first = next(states)
    calls.clear()
    second = next(states)
    assert second.summary.operator_applications == 1
    assert {key: count for key, count in calls.items() if key.startswith("operator")} == {"operator normal": 1}
    np.testing.assert_array_equal(first.fields.pressure, second.fields.pressure)


def test_a_direction_without_load_is_not_transformed(monkeypatch):
    """Poisson's ratio 0 and a force along x: uy is 0 with qy, so no transform is spent on it."""
    transformed = []

    def watch(convolution, method, fields_of):
        original = getattr(convolution, method)

        def watched(self, *arguments):
            transformed.append(len(fields_of(*arguments)))
            assert any(field.any() for field in fields_of(*arguments))
            original(self, *arguments)

        monkeypatch.setattr(convolution, method, watched)

    watch(PaddedConvolution, "apply", lambda kernels, fields, *_: fields)
    watch(MirroredConvolution, "_apply", lambda task, fields, *_: fields)
    states_of("force, Poisson's ratio 0")
    assert set(transformed) == {1}
    transformed.clear()
    monkeypatch.setattr("fretsolve.simulation.simulation.is_mirrored", lambda *_: False)
    states_of("force, Poisson's ratio 0")
    assert set(transformed) == {1}


POINTS = 128


def memory(**parts):
    """Memory of arrays in a second run, in bytes per cell: its peak, and what the run holds at the last state."""
    case = build(grid={"points": POINTS, "size": 0.8}, output={"fields": []}, **parts)
    for _ in run(case):  # plans are made and kernels compiled
        pass
    held = 0
    gc.collect()  # what earlier tests left is not of this run
    tracemalloc.start()
    try:
        for _ in run(case):
            gc.collect()
            held = tracemalloc.get_traced_memory()[0]
        return tracemalloc.get_traced_memory()[1] / POINTS**2, held / POINTS**2
    finally:
        tracemalloc.stop()


def test_memory_grows_with_what_is_needed():
    press, pull = {"P": 400.0}, {"Qx": 20.0, "increments": 1}
    pressed, _ = memory(load_path=[press])
    assert memory(friction=0, load_path=[press])[0] == pytest.approx(pressed, rel=0.02)
    pulled, pulled_holds = memory(load_path=[press, pull])
    _, coupled_holds = memory(bodies=DISSIMILAR, load_path=[press | {"increments": 1}, pull])
    assert pressed < 0.8 * pulled
    assert pulled_holds < coupled_holds  # the spectra of the coupling
