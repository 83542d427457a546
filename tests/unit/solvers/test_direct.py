"""Increments with few cells in contact solved directly, against conjugate gradients."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from line_cases import DISSIMILAR as DISSIMILAR_STRIPS
from line_cases import SIMILAR, line_case
from solving import DISSIMILAR, LOAD, RIGID, build

import fretsolve.increment.grid_hierarchy as grid_hierarchy
import fretsolve.increment.staggered_iteration as staggered
from fretsolve import run
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.operator_on_grid import operator_on
from fretsolve.friction.limit import FrictionLimit
from fretsolve.model.grid import Grid
from fretsolve.result.state import State
from fretsolve.setup.problem_setup import set_up
from fretsolve.solvers.direct import DirectSolver
from fretsolve.solvers.direct_contact import DirectContact, Unknowns
from fretsolve.solvers.influence_matrices import Cells, InfluenceTables

SHEARED = [
    {"P": LOAD, "increments": 3},
    {"Qx": 25.0, "Mz": 1.0, "increments": 3},
    {"Qx": -20.0, "delta_y": 1e-4, "increments": 2},
    {"P": 0.6 * LOAD, "increments": 2},
]
PUSHED = [{"delta_z": 9e-3}, {"delta_x": 4e-4, "phi_z": 1e-3, "increments": 2}, {"delta_x": 6e-3}, {"delta_x": 0.0}]
TILTED = [{"P": LOAD, "My": 15.0, "increments": 2}, {"Qy": 20.0, "phi_x": 1e-4, "increments": 2}]


@pytest.fixture(autouse=True)
def without_compiled_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FRETSOLVE_NUMBA", "0")


def small(**parts: Any) -> Any:
    return build(**({"grid": {"points": [11, 12], "size": 0.9}, "solver": {"tolerance": 1e-7}} | parts))


def line(path: list[dict[str, Any]], **parts: Any) -> Any:
    usual = {"bodies": DISSIMILAR_STRIPS, "grid": {"points": 40, "size": 0.32}, "solver": {"tolerance": 1e-8}}
    return line_case(**usual | parts, load_path=path)


def recorded(monkeypatch: pytest.MonkeyPatch, name: str) -> list[Any]:
    """Return a list of what a method of the direct solver will return."""
    found: list[Any] = []
    method = getattr(DirectSolver, name)
    monkeypatch.setattr(DirectSolver, name, lambda *a, **k: found.append(method(*a, **k)) or found[-1])
    return found


def by_conjugate_gradients(monkeypatch: pytest.MonkeyPatch, **parts: Any) -> list[State]:
    return without_direct_solver(monkeypatch, small(**parts))


def without_direct_solver(monkeypatch: pytest.MonkeyPatch, case: Any) -> list[State]:
    with monkeypatch.context() as patch:
        patch.setattr(grid_hierarchy, "MOST_DIRECT_CELLS", 0)
        patch.setattr(grid_hierarchy, "MOST_DIRECT_STRIPS", 0)
        return list(run(case))


@pytest.mark.parametrize("path", [SHEARED, PUSHED, TILTED])
@pytest.mark.parametrize("parts", [{}, {"bodies": DISSIMILAR}, {"bodies": RIGID, "friction": 0.6}])
def test_direct_as_by_conjugate_gradients(
    monkeypatch: pytest.MonkeyPatch, parts: dict[str, Any], path: list[dict[str, float]]
) -> None:
    found = recorded(monkeypatch, "solve")
    parts = {"friction": 0.1, "load_path": path, **parts}
    directly = list(run(small(**parts)))
    assert len(found) == len(directly)
    assert sum(one is None for one in found) <= 1  # a cell at the edge may join and leave in turns
    peak = max(state.summary.max_pressure for state in directly)
    approach = max(state.summary.delta_z for state in directly)
    for one, other in zip(directly, by_conjugate_gradients(monkeypatch, **parts), strict=True):
        assert one.summary.worst_residual < 1e-7
        assert np.abs(one.fields.pressure - other.fields.pressure).max() < 2e-5 * peak
        assert np.abs(one.fields.shear - other.fields.shear).max() < 2e-5 * peak
        assert one.summary.contact_cells == other.summary.contact_cells
        assert one.summary.delta_x == pytest.approx(other.summary.delta_x, abs=1e-6 * approach)
        assert one.summary.work_total == pytest.approx(other.summary.work_total, rel=1e-4, abs=1e-8)


def test_first_contacts_alone_are_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    touched: list[int] = []
    touch = staggered.StaggeredIteration._touch
    monkeypatch.setattr(staggered.StaggeredIteration, "_touch", lambda *a: touched.append(1) or touch(*a))
    path = [{"P": LOAD}, {"P": 1.1 * LOAD}, {"P": 0.0}, {"Qx": 0.0}, {"P": LOAD}, {"Qx": 10.0}]
    states = list(run(small(bodies=DISSIMILAR, friction=0.1, load_path=[{**stage, "increments": 1} for stage in path])))
    assert [state.summary.contact_cells > 0 for state in states] == [True, True, False, False, True, True]
    assert len(touched) == 2
    touched.clear()
    list(run(small(friction=0.1, load_path=[{"P": LOAD, "increments": 2}])))  # there is no shear to solve for
    assert not touched


def test_compiled_kernels_do_without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FRETSOLVE_NUMBA", "1")
    monkeypatch.setattr(DirectSolver, "solve", lambda *_, **__: pytest.fail("a direct solver was called"))
    parts = {"friction": 0.1, "load_path": SHEARED}
    assert len(list(run(small(**parts)))) == sum(stage["increments"] for stage in SHEARED)


def test_friction_that_varies(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shear strength limits the friction."""
    parts = {"friction": {"coefficient": 0.3, "shear_limit": 150.0}, "load_path": SHEARED}
    for one, other in zip(run(small(**parts)), by_conjugate_gradients(monkeypatch, **parts), strict=True):
        assert np.abs(one.fields.shear - other.fields.shear).max() < 0.01


def test_where_steps_do_not_suffice_the_staggered_iteration_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretsolve.solvers.direct.MOST_STEPS", 1)
    parts = {"bodies": DISSIMILAR, "friction": 0.1, "load_path": SHEARED}
    for one, other in zip(run(small(**parts)), by_conjugate_gradients(monkeypatch, **parts), strict=True):
        assert one.summary.iterations_normal > other.summary.iterations_normal
        assert np.array_equal(one.fields.pressure, other.fields.pressure)


def test_matrices_are_the_operator() -> None:
    setup = set_up(small(bodies=DISSIMILAR, friction=0.1, load_path=SHEARED))
    grid = setup.grid
    _require_equal(ElasticOperator(grid.shape, (grid.dx, grid.dy), setup.model.compliances, setup.model.terms), grid)


def _require_equal(operator: ElasticOperator, grid: Grid) -> None:
    """Require the matrices between some cells to be the operator's."""
    random = np.random.default_rng(5)
    index = np.flatnonzero(random.random(grid.shape) > 0.5)
    cells = Cells(index, grid, InfluenceTables(operator, grid))
    values = random.standard_normal((3, index.size))
    tractions, displacements = np.zeros((3, *grid.shape)), np.zeros((3, *grid.shape))
    tractions.reshape(3, -1)[:, index] = values
    operator.all(tractions[0], tractions[1:], displacements[0], displacements[1:])
    uz, *moved = displacements.reshape(3, -1)[:, index]
    pressure, shear = values[0], values[1:].ravel()
    np.testing.assert_allclose(cells.normal @ pressure + shear @ cells.sideways, uz, atol=1e-13 * np.abs(uz).max())
    sideways = cells.tangential @ shear + cells.sideways @ pressure
    np.testing.assert_allclose(sideways, np.ravel(moved), atol=1e-13 * np.abs(sideways).max())


LINE_PATH = [
    {"P": 100.0, "increments": 3},
    {"Qx": 15.0, "increments": 4},
    {"Qx": -10.0, "P": 60.0, "increments": 3},
    {"Qx": 5.0, "bulk_2": {"xx": 60.0}, "increments": 3},
]
ALONG_Y = [{"P": 100.0, "Qy": 12.0, "increments": 2}, {"Qx": 20.0, "increments": 2}]


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR_STRIPS])
@pytest.mark.parametrize("path", [LINE_PATH, ALONG_Y])
def test_line_contact_as_by_conjugate_gradients(
    monkeypatch: pytest.MonkeyPatch, bodies: list[Any], path: list[dict[str, Any]]
) -> None:
    found = recorded(monkeypatch, "solve")
    case = line(path, bodies=bodies)
    directly = list(run(case))
    assert len(found) == len(directly) == sum(stage["increments"] for stage in path)
    assert sum(one is None for one in found) <= 1
    others = without_direct_solver(monkeypatch, case)
    for one, other in zip(directly, others, strict=True):
        peak = other.summary.max_pressure
        assert one.summary.worst_residual < 1e-8
        assert np.abs(one.fields.pressure - other.fields.pressure).max() < 1e-5 * peak
        assert np.abs(one.fields.shear - other.fields.shear).max() < 1e-5 * peak
        assert one.summary.work_total == pytest.approx(other.summary.work_total, rel=1e-5, abs=1e-9)
    applications = [sum(state.summary.operator_applications for state in states) for states in (directly, others)]
    assert applications[0] < 0.6 * applications[1]


def test_matrices_are_the_operator_of_strips() -> None:
    setup = set_up(line_case(bodies=DISSIMILAR_STRIPS, grid={"points": 40, "size": 0.32}))
    grid, model = setup.grid, setup.model
    _require_equal(operator_on(grid, model.compliances, model.terms), grid)


def test_a_cell_that_joins_slips_as_its_neighbours_do() -> None:
    setup = set_up(small(bodies=DISSIMILAR, friction=0.1, load_path=SHEARED))
    grid, model = setup.grid, setup.model
    tables = InfluenceTables(operator_on(grid, model.compliances, model.terms), grid)
    contact = np.zeros(grid.shape, bool)
    contact[3:6, 3:6] = True
    cells = Cells(np.flatnonzero(contact), grid, tables)
    shear, slipping = np.zeros((2, 3, 3)), np.zeros((3, 3), bool)
    slipping[0], shear[0, 0], shear[1, 0] = True, 3.0, [0.0, 0.0, 6.0]  # the row 3 of the grid slips
    arguments = np.full(9, 1000.0), shear.reshape(2, -1).ravel(), slipping.ravel(), np.zeros(6)
    work = DirectContact(FrictionLimit(0.1), contact, cells, *arguments)
    grown = contact.copy()
    grown[2, 4] = grown[6, 4] = True
    index = np.flatnonzero(grown)
    work.move_to(grown, Cells(index, grid, tables), np.full(index.size, 1000.0))
    new, count = [int(np.searchsorted(index, row * grid.ny + 4)) for row in (2, 6)], index.size
    assert work.slipping[new].tolist() == [True, False]
    assert work.shear[new].tolist() == [9.0, 0.0]
    assert work.shear[count + np.array(new)].tolist() == [6.0, 0.0]
    work.put_on_circle()
    assert np.hypot(work.shear[new[0]], work.shear[count + new[0]]) == pytest.approx(100.0)


LITTLE_MORE = [{"P": 100.0, "increments": 2}, {"P": 100.5, "Qx": 5.0, "increments": 5}, {"P": 100.2, "increments": 2}]
RESUMED = {
    "area": small(bodies=DISSIMILAR, friction=0.1, load_path=SHEARED),
    "line": line(LINE_PATH),
    "line of like bodies": line(LITTLE_MORE, bodies=SIMILAR),
}


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
    monkeypatch.setattr("fretsolve.solvers.direct.MAY_JOIN", 1e9)  # D1 looks beyond in the first step alone
    joined, solved = recorded(monkeypatch, "_penetrates"), recorded(monkeypatch, "solve")
    states = list(run(line(LINE_PATH)))
    assert any(joined) and not all(joined)
    assert all(one is not None for one in solved)
    assert len(solved) == len(states)  # no increment had to be solved again


def test_looking_beyond_the_contact_less_often_saves_applications(monkeypatch: pytest.MonkeyPatch) -> None:
    def applications() -> int:
        return sum(state.summary.operator_applications for state in run(line(LINE_PATH)))

    usual = applications()
    monkeypatch.setattr("fretsolve.solvers.direct.MAY_JOIN", 0.0)
    assert usual < 0.8 * applications()


@pytest.mark.parametrize(("path", "in_plane"), [(LINE_PATH, True), (ALONG_Y, False)])
def test_unknowns_in_the_plane_are_those_of_sticking_strips(
    monkeypatch: pytest.MonkeyPatch, path: list[dict[str, Any]], in_plane: bool
) -> None:
    sizes: list[tuple[int, int, int]] = []
    matrix = Unknowns.matrix

    def counted(self: Unknowns, forward: Any) -> Any:
        found = matrix(self, forward)
        sizes.append((len(found), self.contact.cells.count, int(np.count_nonzero(~self.contact.slipping))))
        return found

    monkeypatch.setattr(Unknowns, "matrix", counted)
    list(run(line(path)))
    assert sizes
    assert all(size == (sticking if in_plane else count + sticking) for size, count, sticking in sizes)


@pytest.mark.parametrize("friction", [0.02, 0.05])
@pytest.mark.parametrize("points", [16, 24])
def test_where_all_strips_slip_one_sticks_again(monkeypatch: pytest.MonkeyPatch, friction: float, points: int) -> None:
    found = recorded(monkeypatch, "solve")
    case = line([{"P": 100.0, "increments": 4}], friction=friction, grid={"points": points, "size": 0.32})
    assert all(state.summary.worst_residual < 1e-8 for state in run(case))
    assert len(found) == 4 and all(one is not None for one in found)


def test_cells_without_friction_that_join_are_left_to_the_staggered_iteration() -> None:
    path = [{"P": 3.0, "increments": 3}, {"Qx": 0.2, "increments": 2}, {"P": 8.0, "increments": 4}]
    friction = {"expression": "0.3*(abs(x) < 0.024)"}
    case = build(bodies=DISSIMILAR, grid={"points": 8, "size": 0.4}, friction=friction, load_path=path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(list(run(case))) == 9
