"""Increments of line contacts solved directly, against conjugate gradients."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from line_cases import DISSIMILAR, SIMILAR, line_case

import fretsolve.contact.increment.grid_hierarchy as grid_hierarchy
from fretsolve import run
from fretsolve.contact.solvers.line_direct import LineDirectSolver
from fretsolve.result.state import State

LINE_PATH = [
    {"P": 100.0, "increments": 3},
    {"Qx": 15.0, "increments": 4},
    {"Qx": -10.0, "P": 60.0, "increments": 3},
    {"Qx": 5.0, "bulk_2": {"xx": 60.0}, "increments": 3},
]
TURNED = [{"P": 100.0, "My": 1.0, "increments": 2}, {"Qx": 10.0, "increments": 3}, {"Qx": -8.0, "increments": 3}]


@pytest.fixture(autouse=True)
def without_compiled_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FRETSOLVE_NUMBA", "0")


def line(path: list[dict[str, Any]], **parts: Any) -> Any:
    usual = {"bodies": DISSIMILAR, "grid": {"points": 40, "size": 0.32}, "solver": {"tolerance": 1e-8}}
    return line_case(**usual | parts, load_path=path)


def recorded(monkeypatch: pytest.MonkeyPatch, name: str) -> list[Any]:
    """Return a list of what a method of the direct solver will return."""
    found: list[Any] = []
    method = getattr(LineDirectSolver, name)
    monkeypatch.setattr(LineDirectSolver, name, lambda *a, **k: found.append(method(*a, **k)) or found[-1])
    return found


def without_direct_solver(monkeypatch: pytest.MonkeyPatch, case: Any) -> list[State]:
    with monkeypatch.context() as patch:
        patch.setattr(grid_hierarchy, "MOST_DIRECT_POINTS", 0)
        return list(run(case))


@pytest.mark.parametrize(
    ("bodies", "path", "friction"),
    [
        (SIMILAR, LINE_PATH, 0.3),
        (DISSIMILAR, LINE_PATH, {"coefficient": 0.3, "shear_limit": 100.0}),
        (DISSIMILAR, TURNED, 0.3),
    ],
)
def test_as_by_conjugate_gradients(
    monkeypatch: pytest.MonkeyPatch, bodies: list[Any], path: list[dict[str, Any]], friction: Any
) -> None:
    found = recorded(monkeypatch, "solve")
    case = line(path, bodies=bodies, friction=friction, solver={"tolerance": 3e-8})
    directly = list(run(case))
    assert len(found) == len(directly) == sum(stage.get("increments", 1) for stage in path)
    assert sum(one is None for one in found) <= 1
    others = without_direct_solver(monkeypatch, case)
    for one, other in zip(directly, others, strict=True):
        peak = other.summary.max_pressure
        assert one.summary.worst_residual < 3e-8
        assert np.abs(one.fields.pressure - other.fields.pressure).max() < 1e-5 * peak
        assert np.abs(one.fields.shear - other.fields.shear).max() < 1e-5 * peak
        assert one.summary.work_total == pytest.approx(other.summary.work_total, rel=3e-5, abs=3e-9)
    applications = [sum(state.summary.operator_applications for state in states) for states in (directly, others)]
    assert applications[0] < 0.6 * applications[1]


def test_what_acts_along_y_is_left_to_the_staggered_iteration(monkeypatch: pytest.MonkeyPatch) -> None:
    found = recorded(monkeypatch, "solve")
    states = list(run(line([{"P": 100.0, "Qy": 12.0, "increments": 2}, {"Qx": 20.0, "increments": 2}])))
    assert found == [None] * 4
    assert all(state.summary.worst_residual < 1e-8 for state in states)


def test_where_steps_do_not_suffice_the_staggered_iteration_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretsolve.contact.solvers.line_direct.MOST_STEPS", 1)
    case = line(LINE_PATH)
    for one, other in zip(run(case), without_direct_solver(monkeypatch, case), strict=True):
        assert one.summary.iterations_normal > other.summary.iterations_normal
        assert one.fields.pressure == pytest.approx(other.fields.pressure, abs=1e-5 * other.summary.max_pressure)


def test_a_resumed_run_gives_the_same_bits() -> None:
    """Nothing that a solver keeps of earlier increments may change them."""
    whole = list(run(line(LINE_PATH)))
    for count in (1, 4, 8, 11):
        history = [state.summary for state in whole[:count]]
        again = next(run(line(LINE_PATH), whole[count - 1], history))
        for field in ("pressure", "shear"):
            assert np.array_equal(getattr(again.fields, field), getattr(whole[count].fields, field)), (count, field)


@pytest.mark.parametrize("friction", [0.02, 0.05])
@pytest.mark.parametrize("points", [16, 24])
def test_where_all_strips_slip_one_sticks_again(monkeypatch: pytest.MonkeyPatch, friction: float, points: int) -> None:
    found = recorded(monkeypatch, "solve")
    case = line([{"P": 100.0, "increments": 4}], friction=friction, grid={"points": points, "size": 0.32})
    assert all(state.summary.worst_residual < 1e-8 for state in run(case))
    assert len(found) == 4 and all(one is not None for one in found)
