"""Increments of line contacts solved directly, against conjugate gradients."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from line_cases import DISSIMILAR, SIMILAR, line_case
from solving import LOAD, build

import fretsolve.contact.increment.grid_hierarchy as grid_hierarchy
import fretsolve.contact.increment.staggered_iteration as staggered
from fretsolve import run
from fretsolve.contact.solvers.line_direct import DirectSolution, LineDirectSolver, LineState, Strips
from fretsolve.elastic.operator_on_grid import operator_on, strip_influence
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.result.state import State
from fretsolve.simulation.problem_setup import set_up

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


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR])
@pytest.mark.parametrize("path", [LINE_PATH, TURNED])
@pytest.mark.parametrize("friction", [0.3, {"coefficient": 0.3, "shear_limit": 100.0}])
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


def test_areas_and_compiled_kernels_do_without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LineDirectSolver, "solve", lambda *_, **__: pytest.fail("a direct solver was called"))
    path = [{"P": LOAD}, {"Qx": 25.0, "increments": 2}]
    assert len(list(run(build(grid={"points": 12, "size": 0.9}, friction=0.1, load_path=path)))) == 3
    monkeypatch.setenv("FRETSOLVE_NUMBA", "1")
    assert len(list(run(line(LINE_PATH)))) == 13


def test_first_contacts_alone_are_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    touched: list[int] = []
    touch = staggered.StaggeredIteration._touch
    monkeypatch.setattr(staggered.StaggeredIteration, "_touch", lambda *a: touched.append(1) or touch(*a))
    path = [{"P": 100.0}, {"P": 110.0}, {"P": 0.0}, {"Qx": 0.0}, {"P": 100.0}, {"Qx": 10.0}]
    states = list(run(line([{**stage, "increments": 1} for stage in path])))
    assert [state.summary.contact_cells > 0 for state in states] == [True, True, False, False, True, True]
    assert len(touched) == 2


def test_where_steps_do_not_suffice_the_staggered_iteration_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretsolve.contact.solvers.line_direct.MOST_STEPS", 1)
    case = line(LINE_PATH)
    for one, other in zip(run(case), without_direct_solver(monkeypatch, case), strict=True):
        assert one.summary.iterations_normal > other.summary.iterations_normal
        assert one.fields.pressure == pytest.approx(other.fields.pressure, abs=1e-5 * other.summary.max_pressure)


def test_matrices_are_the_operator() -> None:
    setup = set_up(line([{"P": 100.0}]))
    grid, model = setup.grid, setup.model
    index = np.flatnonzero(np.random.default_rng(5).random(grid.nx) > 0.5)
    tables = {name: strip_influence(name, grid, model.compliances)[:, 0] for name in ("zz", "xx", "xz")}
    strips = Strips(index, grid, tables)
    tractions, displacements = np.zeros((3, *grid.shape)), np.zeros((3, *grid.shape))
    pressure, shear = np.random.default_rng(6).standard_normal((2, index.size))
    tractions[0, index, 0], tractions[1, index, 0] = pressure, shear
    operator_on(grid, model.compliances, model.terms).all(
        tractions[0], tractions[1:], displacements[0], displacements[1:]
    )
    uz, ux, _ = displacements[:, index, 0]
    from_pressure = strips.tangential_from_pressure
    np.testing.assert_allclose(strips.normal @ pressure + shear @ from_pressure, uz, atol=1e-13 * np.abs(uz).max())
    np.testing.assert_allclose(strips.tangential @ shear + from_pressure @ pressure, ux, atol=1e-13 * np.abs(ux).max())


def test_a_strip_that_joins_slips_as_its_neighbours_do() -> None:
    grid = set_up(line([{"P": 100.0}])).grid
    contact, slipping, shear = np.zeros(grid.shape, bool), np.zeros(grid.shape, bool), np.zeros((2, *grid.shape))
    contact[3:6], slipping[3], shear[0, 3] = True, True, -3.0
    estimate = DirectSolution(1000.0 * contact, shear, np.zeros(6))
    work = LineState(FrictionLimit(0.1), contact, Strips(np.arange(3, 6), grid, {}), estimate, slipping)
    grown = contact.copy()
    grown[[2, 6]] = True
    work.move_to(grown, Strips(np.arange(2, 7), grid, {}), np.full(5, 1000.0))
    assert work.slipping.tolist() == [True, True, False, False, False]
    work.return_map()
    assert work.shear.tolist() == [-100.0, -100.0, 0.0, 0.0, 0.0]


LITTLE_MORE = [{"P": 100.0, "increments": 2}, {"P": 100.5, "Qx": 5.0, "increments": 5}, {"P": 100.2, "increments": 2}]
RESUMED = {"line": line(LINE_PATH), "line of like bodies": line(LITTLE_MORE, bodies=SIMILAR)}


@pytest.mark.parametrize("name", RESUMED)
def test_a_resumed_run_gives_the_same_bits(name: str) -> None:
    """Nothing that a solver keeps of earlier increments may change them."""
    whole = list(run(RESUMED[name]))
    for count in range(1, len(whole)):
        history = [state.summary for state in whole[:count]]
        again = next(run(RESUMED[name], whole[count - 1], history))
        for field in ("pressure", "shear"):
            assert np.array_equal(getattr(again.fields, field), getattr(whole[count].fields, field)), (count, field)


def test_cells_beyond_the_contact_join_in_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "fretsolve.contact.solvers.line_direct.MAY_JOIN", 1e9
    )  # D1 looks beyond in the first step alone
    joined, solved = recorded(monkeypatch, "_penetrates"), recorded(monkeypatch, "solve")
    states = list(run(line(LINE_PATH)))
    assert any(joined) and not all(joined)
    assert all(one is not None for one in solved)
    assert len(solved) == len(states)  # no increment had to be solved again


def test_looking_beyond_the_contact_less_often_saves_applications(monkeypatch: pytest.MonkeyPatch) -> None:
    def applications() -> int:
        return sum(state.summary.operator_applications for state in run(line(LINE_PATH)))

    usual = applications()
    monkeypatch.setattr("fretsolve.contact.solvers.line_direct.MAY_JOIN", 0.0)
    assert usual < 0.8 * applications()


@pytest.mark.parametrize("friction", [0.02, 0.05])
@pytest.mark.parametrize("points", [16, 24])
def test_where_all_strips_slip_one_sticks_again(monkeypatch: pytest.MonkeyPatch, friction: float, points: int) -> None:
    found = recorded(monkeypatch, "solve")
    case = line([{"P": 100.0, "increments": 4}], friction=friction, grid={"points": points, "size": 0.32})
    assert all(state.summary.worst_residual < 1e-8 for state in run(case))
    assert len(found) == 4 and all(one is not None for one in found)
