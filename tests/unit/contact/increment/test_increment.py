from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, SIMILAR, build

from fretsolve import run
from fretsolve.contact.increment import increment as increment_module
from fretsolve.contact.increment.increment import IncrementSolver
from fretsolve.contact.increment.states import InitialState
from fretsolve.errors import ContactLostError, GridEdgeError, NotConvergedError, SlidingError
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.problem.model.load_path import Increment
from fretsolve.simulation.problem_setup import set_up

PRESSED = LoadControl((True, False, False), (LOAD, 0.0, 0.0))
FREE = LoadControl((True, True, False), (0.0, 0.0, 0.0))


def setup_of(bodies=SIMILAR, points=28, size=0.76, **parts):
    moved = [{"P": LOAD}, {"Qx": 1.0}]
    return set_up(build(bodies=bodies, grid={"points": points, "size": size}, load_path=moved, **parts))


def solver_of(setup, tolerance=1e-7, most=2000):
    return IncrementSolver(setup.grid, setup.separation(), setup.model, tolerance, most)


def nothing(grid):
    shear = np.zeros((2, *grid.shape))
    return InitialState(shear[0].copy(), shear, shear.copy(), np.zeros(6), FrictionLimit(0.1))


def increment(setup, normal=PRESSED, tangential=FREE, step=0):
    return Increment(step, setup.case.stages()[0], normal, tangential)


def after(solved, normal=PRESSED):
    return InitialState(solved.pressure, solved.shear, solved.displacement, solved.rigid, solved.friction, normal)


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR], ids=["similar", "dissimilar"])
def test_two_increments(bodies):
    setup = setup_of(bodies)
    solver = solver_of(setup)
    first = solver.solve(increment(setup), nothing(setup.grid))
    assert first.certificate.worst <= 1e-7
    assert first.resultants[0] == pytest.approx(LOAD)
    pulled = increment(setup, tangential=LoadControl((True, True, False), (25.0, -5.0, 0.0)))
    second = solver.solve(pulled, after(first))
    assert second.certificate.worst <= 1e-7
    assert second.resultants[3:5] == pytest.approx((25.0, -5.0))
    assert second.motion == pytest.approx(second.rigid - first.rigid)
    assert min(second.iterations_tangential, second.staggered_iterations, second.operator_applications) > 0


def test_the_start_is_left_alone():
    setup = setup_of(DISSIMILAR)
    solver = solver_of(setup)
    start = after(solver.solve(increment(setup), nothing(setup.grid)))
    kept = deepcopy(start)
    solver.solve(increment(setup, tangential=LoadControl((True, True, False), (20.0, 0.0, 0.0))), start)
    for name in ("pressure", "shear", "displacement", "rigid"):
        np.testing.assert_array_equal(getattr(start, name), getattr(kept, name))


def test_what_was_solved_before_does_not_matter():
    """The same increment from the same start, by a new solver and by one that has done other work."""
    setup = setup_of(DISSIMILAR)
    pulled = increment(setup, tangential=LoadControl((True, True, False), (20.0, 0.0, 0.0)))
    used = solver_of(setup)
    start = after(used.solve(increment(setup), nothing(setup.grid)))
    used.solve(increment(setup, normal=LoadControl((True, False, False), (50.0, 0.0, 0.0))), nothing(setup.grid))
    again, fresh = used.solve(pulled, start), solver_of(setup).solve(pulled, start)
    np.testing.assert_array_equal(again.shear, fresh.shear)
    np.testing.assert_array_equal(again.pressure, fresh.pressure)


class TestNoSolution:
    def test_too_few_iterations(self):
        setup = setup_of()
        with pytest.raises(NotConvergedError, match=r"max_iterations"):
            solver_of(setup, most=1).solve(increment(setup), nothing(setup.grid))

    def test_too_few_tangential_iterations(self):
        setup = setup_of()
        first = solver_of(setup).solve(increment(setup), nothing(setup.grid))
        pulled = increment(setup, tangential=LoadControl((True, True, False), (36.0, 0.0, 0.0)))
        with pytest.raises(NotConvergedError, match="tangential"):
            solver_of(setup, most=1).solve(pulled, after(first))

    @pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR], ids=["similar", "dissimilar"])
    def test_sliding(self, bodies):
        setup = setup_of(bodies)
        solver = solver_of(setup)
        start = after(solver.solve(increment(setup), nothing(setup.grid)))
        with pytest.raises(SlidingError) as caught:
            solver.solve(increment(setup, tangential=LoadControl((True, True, True), (0.0, 41.0, 0.0))), start)
        assert caught.value.component == "Qy"

    def test_tilting_over(self):
        setup = setup_of()
        with pytest.raises(ContactLostError):
            solver_of(setup).solve(
                increment(setup, normal=LoadControl((True, True, True), (LOAD, 0.0, LOAD))), nothing(setup.grid)
            )

    def test_edge(self):
        setup = setup_of(size=0.5)
        with pytest.raises(GridEdgeError):
            solver_of(setup).solve(increment(setup), nothing(setup.grid))


def test_a_solver_goes_on_after_an_error():
    setup = setup_of()
    solver = solver_of(setup)
    start = after(solver.solve(increment(setup), nothing(setup.grid)))
    with pytest.raises(SlidingError):
        solver.solve(increment(setup, tangential=LoadControl((True, True, False), (50.0, 0.0, 0.0))), start)
    pulled = increment(setup, tangential=LoadControl((True, True, False), (20.0, 0.0, 0.0)))
    np.testing.assert_array_equal(solver.solve(pulled, start).shear, solver_of(setup).solve(pulled, start).shear)


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR], ids=["similar", "dissimilar"])
def test_a_large_grid_gives_memory_back_and_solves_the_same(bodies, monkeypatch):
    """The solvers' arrays are made anew for each increment there; nothing of the result may hang on what they held."""
    setup = setup_of(bodies, points=64)
    pulled = increment(setup, tangential=LoadControl((True, True, False), (25.0, -5.0, 0.0)))
    shears = []
    for limit in (np.inf, 0.0):
        monkeypatch.setattr(increment_module, "LARGE_GRID", limit)
        solver = solver_of(setup)
        first = solver.solve(increment(setup), nothing(setup.grid))
        shears.append(solver.solve(pulled, after(first)).shear)
    assert not any(name in vars(solver.level) for name in ("normal", "tangential"))
    np.testing.assert_array_equal(shears[0], shears[1])


@pytest.mark.parametrize("points", [47, 48])
def test_a_contact_that_moves_by_more_than_its_size(points):
    """Pressed in the middle, then by a moment that shifts it past its edge: solved as if nothing had touched before."""
    parts = {"surface": {"sphere": {"radius": 12.0}}, "bodies": SIMILAR, "friction": 0.7}
    path = [{"P": 200.0, "increments": 1}, {"Mx": 100.0, "increments": 1}]
    *_, last = run(build(**parts, grid={"points": points}, load_path=path))
    assert last.summary.residual_gap <= 1e-6
    columns = np.flatnonzero(last.fields.pressure.any(axis=0))
    y = set_up(build(**parts, grid={"points": points}, load_path=path)).grid.y
    assert 0.5 * (y[columns[0]] + y[columns[-1]]) == pytest.approx(0.5, abs=y[1] - y[0])
    assert last.summary.Mx == pytest.approx(100.0, rel=1e-6)
