"""Increments with few cells in contact solved directly, against conjugate gradients."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, RIGID, build

import fretsolve.increment.staggered_iteration as staggered
from fretsolve import run
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.result.state import State
from fretsolve.setup.problem_setup import set_up
from fretsolve.solvers.direct import DirectSolver
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


def by_conjugate_gradients(monkeypatch: pytest.MonkeyPatch, **parts: Any) -> list[State]:
    with monkeypatch.context() as patch:
        patch.setattr(staggered, "MOST_DIRECT_CELLS", 0)
        return list(run(small(**parts)))


@pytest.mark.parametrize("path", [SHEARED, PUSHED, TILTED])
@pytest.mark.parametrize("parts", [{}, {"bodies": DISSIMILAR}, {"bodies": RIGID, "friction": 0.6}])
def test_direct_as_by_conjugate_gradients(
    monkeypatch: pytest.MonkeyPatch, parts: dict[str, Any], path: list[dict[str, float]]
) -> None:
    found = []
    solve = DirectSolver.solve
    monkeypatch.setattr(DirectSolver, "solve", lambda *a, **k: found.append(solve(*a, **k)) or found[-1])
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
    grid, random = setup.grid, np.random.default_rng(5)
    operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), setup.model.compliances, setup.model.terms)
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
