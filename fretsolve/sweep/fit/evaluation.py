"""Evaluate a case along a measured loop: residuals and their derivatives by the parameters, on several processes."""

from __future__ import annotations

import multiprocessing
import signal
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from fretsolve.errors import CaseError, NoSolutionError
from fretsolve.sweep.fit.measured_loop import MeasuredLoop
from fretsolve.sweep.fit.model_loop import Branches, LoopModel
from fretsolve.system.arrays import DoubleArray

STEP = 0.02
"""Relative change of a parameter for a derivative."""

WORTH_PROCESSES = 1.0
"""Seconds of a solved loop from which further processes save more time than their start takes."""

Show = Callable[[int, LoopModel, Sequence[float], float], None]
"""Told at each step of the search: the solved loops so far, the model, the values, the residual (N)."""


class LoopSolver:
    """Solves loops, several at a time on `jobs` processes where one takes long. solved: how many so far."""

    def __init__(self, jobs: int):
        self.solved = 0
        self._jobs, self._seconds = jobs, 0.0
        self._pool: ProcessPoolExecutor | None = None

    def solve(self, model: LoopModel, points: Sequence[Sequence[float]]) -> list[Branches | None]:
        """Return the loops at values of the parameters, None where the case has no solution."""
        self.solved += len(points)
        if len(points) > 1 and self._jobs > 1 and self._seconds > WORTH_PROCESSES:
            if self._pool is None:
                context = multiprocessing.get_context("spawn")
                # Ctrl-C of the terminal is meant for the command
                ignored = (signal.SIGINT, signal.SIG_IGN)
                self._pool = ProcessPoolExecutor(self._jobs, context, signal.signal, ignored)
            return list(self._pool.map(_solved, [model] * len(points), points))
        began = time.perf_counter()
        found = [_solved(model, values) for values in points]
        self._seconds = (time.perf_counter() - began) / len(points)
        return found

    def close(self) -> None:
        """End the processes."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)


def _solved(model: LoopModel, values: Sequence[float]) -> Branches | None:
    try:
        return model.branches(values)
    except (NoSolutionError, CaseError):  # such values are beyond what the case can have
        return None


class Evaluator:
    """The residuals of a model, computed less measured forces over the measured range, as functions of coordinates.

    basis: orthonormal columns ``(n, k)`` that may be added to the forces, of an offset and a drift.
    """

    def __init__(self, model: LoopModel, loop: MeasuredLoop, basis: DoubleArray, solver: LoopSolver, show: Show):
        self._model, self._loop, self._basis = model, loop, basis
        self._solver, self._show = solver, show
        self._known: dict[tuple[float, ...], Branches] = {}

    def residuals(self, coordinates: DoubleArray) -> DoubleArray:
        """Return the residuals ``(n,)``, without offset and drift; infinite where the case has no solution.

        Raises NoSolutionError or CaseError at the first coordinates.
        """
        key, values = tuple(map(float, coordinates)), self.values(coordinates)
        if key not in self._known:
            (branches,) = self._solver.solve(self._model, [values])
            if branches is None and not self._known:
                branches = self._model.branches(values)  # which raises the error that says why
            if branches is None:
                return np.full(len(self._loop.force), np.inf)
            self._known[key] = branches
        residuals = self._residuals(self._known[key])
        rms = self._loop.range * float(np.sqrt(np.mean(residuals**2)))
        self._show(self._solver.solved, self._model, values, rms)
        return residuals

    def branches(self, coordinates: DoubleArray) -> Branches:
        """Return the loop at coordinates whose residuals have been asked for."""
        return self._known[tuple(map(float, coordinates))]

    def forward(self, coordinates: DoubleArray) -> DoubleArray:
        """Return the derivatives of the residuals ``(n, p)`` by forward differences. Raises NoSolutionError."""
        here = self._residuals(self.branches(coordinates))
        derivatives: DoubleArray = (self._beside(coordinates, STEP) - here).T / STEP
        return derivatives

    def central(self, coordinates: DoubleArray) -> DoubleArray:
        """Return the derivatives of the residuals ``(n, p)`` by central differences. Raises NoSolutionError."""
        ways = self._beside(coordinates, STEP, -STEP)
        ahead, back = np.split(ways, 2)
        derivatives: DoubleArray = (ahead - back).T / (2.0 * STEP)
        return derivatives

    def by_turns(self, coordinates: DoubleArray) -> DoubleArray:
        """Return what the residuals are off by where each turn of the motion is off by its error ``(n, 3)``."""
        values = self.values(coordinates)
        ahead, back = (self._residuals(self._model.stretched(1.0 + step).branches(values)) for step in (STEP, -STEP))
        by_reach = (ahead - back) / (2.0 * STEP * self._model.reach)
        slope = self.branches(coordinates).at(self._loop)[1] / self._loop.range
        found = [self._without_drift(slope * moved) + by_reach * reach for moved, reach in self._loop.errors]
        return np.stack(found, axis=1)

    def _beside(self, coordinates: DoubleArray, *steps: float) -> DoubleArray:
        """Return the residuals at coordinates of which each in turn has made each step ``(steps p, n)``."""
        points = [coordinates + step * one for step in steps for one in np.eye(len(coordinates))]
        solved = self._solver.solve(self._model, [self.values(point) for point in points])
        found = [self._residuals(one) for one in solved if one is not None]
        if len(found) < len(points):
            named = zip(self._model.parameters, self.values(coordinates), strict=True)
            near = ", ".join(f"{one.name} = {one.written(value, 4)}" for one, value in named)
            raise NoSolutionError(f"the case has no solution close to the values found, {near}")
        return np.array(found)

    def values(self, coordinates: DoubleArray) -> list[float]:
        """Return the values of the parameters at coordinates."""
        return [one.value(float(c)) for one, c in zip(self._model.parameters, coordinates, strict=True)]

    def _residuals(self, branches: Branches) -> DoubleArray:
        return self._without_drift((branches.at(self._loop)[0] - self._loop.force) / self._loop.range)

    def _without_drift(self, forces: DoubleArray) -> DoubleArray:
        rest: DoubleArray = forces - self._basis @ (self._basis.T @ forces)
        return rest
