"""Iterations allocate no array of as many numbers as the grid has cells: the arrays of a solver are made once."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from fretsolve.elastic import convolution, fftw
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.kernels import load, parts
from fretsolve.model.grid import Grid
from fretsolve.model.load_control import LoadControl
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms
from fretsolve.solvers.normal import NormalSolver
from fretsolve.solvers.tangential import SlipScales, TangentialSolver

GRID = Grid.from_size((150, 140), (0.7, 0.72))
CELLS = GRID.nx * GRID.ny
SPHERE = (GRID.x[:, None] ** 2 + GRID.y[None, :] ** 2) / 20.0
TOLERANCE = 1e-4


@pytest.fixture
def operator(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> ElasticOperator:
    """Return an operator whose transforms and kernels work on small parts of the grid, as on a large one."""
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", 0)
    monkeypatch.setattr(fftw, "CACHE_BYTES", 2**12)
    monkeypatch.setattr(parts, "PART_CELLS", 2**9)
    kernels = load(compiled=False)
    terms, material = Terms(True, True, False), Compliances(A=1.82e-5, B=7.8e-6, C=0.0)
    return ElasticOperator(GRID.shape, (GRID.dx, GRID.dy), material, terms, ThreadTeam(1, kernels))


@contextmanager
def peak_of_each(owner: object, *names: str) -> Iterator[list[float]]:
    """Measure what each call of some methods holds in between, in bytes per cell."""
    found: list[float] = []

    def measured(method: Callable[..., object]) -> Callable[..., object]:
        def call(*arguments: object) -> object:
            tracemalloc.reset_peak()
            before = tracemalloc.get_traced_memory()[0]
            try:
                return method(*arguments)
            finally:
                found.append((tracemalloc.get_traced_memory()[1] - before) / CELLS)

        return call

    for name in names:
        setattr(owner, name, measured(getattr(owner, name)))
    tracemalloc.start()
    try:
        yield found
    finally:
        tracemalloc.stop()
        for name in names:
            delattr(owner, name)


def normal(solver: NormalSolver, pressure: np.ndarray, load: float) -> int:
    control = LoadControl((True, False, False), (load, 0.0, 0.0))
    return solver.solve(SPHERE, control, pressure, TOLERANCE, 500, np.zeros(3)).iterations


def tangential(solver: TangentialSolver, limit: np.ndarray, shear: np.ndarray, load: float) -> int:
    control, elastic_slip = LoadControl((True, True, False), (load, 0.0, 0.0)), np.empty_like(shear)
    solver.operator.tangential(shear, elastic_slip)
    np.negative(elastic_slip, out=elastic_slip)
    return solver.solve(elastic_slip, control, limit, shear, TOLERANCE, 500, SlipScales()).iterations


TRIES = 3
"""Other threads of the process allocate now and then; what the solver allocates, it does in each try."""


def test_iterations_of_the_conjugate_gradients(operator: ElasticOperator) -> None:
    # a plane of numbers in single precision has 4 bytes per cell
    assert min(_peak_of_iterations(operator) for _ in range(TRIES)) < 3.0


def _peak_of_iterations(operator: ElasticOperator) -> float:
    """Return the largest peak of the conjugate gradients, in bytes per cell."""
    pressing, pressure = NormalSolver(operator, GRID), np.zeros(GRID.shape)
    normal(pressing, pressure, 300.0)
    with peak_of_each(pressing._cg, "solve") as peaks:
        iterations = normal(pressing, pressure, 330.0)
    sliding, shear = TangentialSolver(operator, GRID), np.zeros((2, *GRID.shape))
    tangential(sliding, 0.1 * pressure, shear, 10.0)
    with peak_of_each(sliding._cg, "solve") as more_peaks:
        iterations += tangential(sliding, 0.1 * pressure, shear, 14.0)
    assert iterations > 6
    return max(peaks + more_peaks)


def test_rounds_of_a_solve(operator: ElasticOperator) -> None:
    """Only masks, of a byte per cell, are made anew: a plane of numbers in single precision has 4."""
    assert min(_peak_of_rounds(operator) for _ in range(TRIES)) < 4.0


def _peak_of_rounds(operator: ElasticOperator) -> float:
    """Return the largest peak of a part of a solve, in bytes per cell."""
    pressing, pressure = NormalSolver(operator, GRID), np.zeros(GRID.shape)
    normal(pressing, pressure, 300.0)
    rounds = (
        "_rigid_displacement",
        "_update_gap_and_zone",
        "_release_tension",
        "_restore_balance",
        "_update_displacement",
    )
    with peak_of_each(pressing, *rounds) as peaks:
        normal(pressing, pressure, 330.0)
    sliding, shear = TangentialSolver(operator, GRID), np.zeros((2, *GRID.shape))
    tangential(sliding, 0.1 * pressure, shear, 10.0)
    rounds = (
        "_update_slip_and_zones",
        "_violation",
        "_unbalance",
        "_prepare_cg",
        "_restore_balance",
        "_update_elastic_slip",
    )
    with peak_of_each(sliding, *rounds) as more_peaks:
        tangential(sliding, 0.1 * pressure, shear, 14.0)
    assert len(peaks) > 5
    assert len(more_peaks) > 5
    return max(peaks + more_peaks)
