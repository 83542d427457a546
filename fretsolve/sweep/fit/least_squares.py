"""Find the parameters with which a case follows a measured loop best, and how well the loop determines them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from fretsolve.sweep.fit.evaluation import Evaluator, LoopSolver, Show
from fretsolve.sweep.fit.measured_loop import MeasuredLoop
from fretsolve.sweep.fit.model_loop import Branches, area
from fretsolve.sweep.fit.plan import FitPlan
from fretsolve.system.arrays import DoubleArray

FARTHEST = 7.0
"""Largest logarithm of a parameter over its start: a factor of 1000 either way."""

STEPS = 30
"""Most steps of the search on one grid."""

TOLERANCE = 1e-3
"""Relative fall of the sum of squares at which a search ends. The next step would be far smaller."""

CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class Fit:
    """The outcome. values ``(p,)`` in the units of the parameters; covariance ``(p, p)`` of their logarithms.

    sensitivity: derivatives of the force by those logarithms ``(n, p)`` (N), without what offset and drift take up;
    fitted: force of the case at the measured points ``(n,)`` (N), with the offset and the drift that were found, whose
    sum is `drift`; freedom: points less what was found from them; branches: the loop of the case; solved: how many
    loops it took, in `seconds`.
    """

    plan: FitPlan
    values: DoubleArray
    covariance: DoubleArray
    sensitivity: DoubleArray
    fitted: DoubleArray
    drift: DoubleArray
    freedom: int
    branches: Branches
    solved: int
    seconds: float

    @property
    def residual(self) -> DoubleArray:
        """Measured less fitted force ``(n,)`` (N)."""
        return self.plan.loop.force - self.fitted

    @property
    def rms(self) -> float:
        """Standard deviation of the residual (N)."""
        return float(np.linalg.norm(self.residual)) / math.sqrt(self.freedom)

    @property
    def noise(self) -> float:
        """Standard deviation of the force along the loop by its noise and by the noise of the motion (N)."""
        loop, (_, slopes) = self.plan.loop, self.branches.at(self.plan.loop)
        left = max(loop.motion_noise**2 - loop.hidden**2, 0.0)
        return float(np.sqrt(loop.force_noise**2 + left * np.mean(slopes**2)))

    @property
    def quantile(self) -> float:
        """Half-width of the 95 % bounds in standard deviations."""
        return float(student.ppf(0.5 + 0.5 * CONFIDENCE, self.freedom))

    @property
    def widths(self) -> DoubleArray:
        """Half-widths of the 95 % bounds of the logarithms ``(p,)``."""
        found: DoubleArray = self.quantile * np.sqrt(np.diag(self.covariance))
        return found

    @property
    def bounds(self) -> tuple[DoubleArray, DoubleArray]:
        """The 95 % bounds of the values, two times ``(p,)``."""
        with np.errstate(over="ignore"):
            return self.values * np.exp(-self.widths), self.values * np.exp(self.widths)

    @property
    def correlation(self) -> DoubleArray:
        """The correlation matrix ``(p, p)``."""
        sizes = np.sqrt(np.diag(self.covariance))
        found: DoubleArray = self.covariance / np.outer(sizes, sizes)
        return found

    @property
    def energies(self) -> tuple[float, float]:
        """The areas of the measured and of the fitted loop, both at the measured motions and without the drift."""
        loop = self.plan.loop
        return area(loop.motion, loop.force - self.drift), area(loop.motion, self.fitted - self.drift)

    @property
    def undetermined(self) -> Iterator[DoubleArray]:
        """Directions of the logarithms ``(p,)`` along which the loop does not bound the parameters within a factor e.

        Each is so long that its largest component doubles a parameter.
        """
        _, sizes, directions = np.linalg.svd(self.sensitivity, full_matrices=False)
        for size, direction in zip(sizes, directions, strict=True):
            if self.quantile * self.rms > size:
                largest = direction[np.argmax(np.abs(direction))]
                yield direction * (np.log(2.0) / largest)


def fit_loop(plan: FitPlan, jobs: int = 1, show: Show = lambda *_: None) -> Fit:
    """Fit the models of a plan one after another, each from the values of the one before. Raises NoSolutionError.

    jobs: processes for loops that take long.
    """
    began, loop = time.perf_counter(), plan.loop
    basis = drift_basis(loop) if plan.request.offset else np.zeros((len(loop.force), 0))
    found = np.zeros(len(plan.parameters))
    with closing(LoopSolver(jobs)) as solver:
        for model in plan.models:
            evaluator = Evaluator(model, loop, basis, solver, show)
            last = model is plan.models[-1]
            search = least_squares(
                evaluator.residuals,
                found,
                evaluator.central if last else evaluator.forward,
                (-FARTHEST, FARTHEST),
                ftol=TOLERANCE,
                max_nfev=STEPS,
            )
            found = search.x
        branches, sensitivity = evaluator.branches(found), loop.range * search.jac
        # what a turn is off by moves the loop as a whole
        off = loop.range * evaluator.by_turns(found)
    computed, slope = branches.at(loop)
    drift = basis @ (basis.T @ (loop.force - computed))
    freedom = len(loop.force) - len(found) - basis.shape[1]
    residual = loop.force - computed - drift
    # smoothing of the motion hides noise that its mean values still have
    return Fit(
        plan,
        np.array(evaluator.values(found)),
        covariance(sensitivity, np.hypot(residual, slope * loop.hidden), off),
        sensitivity,
        computed + drift,
        drift,
        freedom,
        branches,
        solver.solved + 2,
        time.perf_counter() - began,
    )


def drift_basis(loop: MeasuredLoop) -> DoubleArray:
    """Return an offset and a drift, which is linear in time, as orthonormal columns ``(n, 2)``."""
    columns = np.stack([np.ones_like(loop.time), loop.time], axis=1)
    return np.linalg.qr(columns)[0]


def covariance(sensitivity: DoubleArray, residual: DoubleArray, common: DoubleArray) -> DoubleArray:
    """Return the covariance ``(p, p)`` of the parameters, for residuals whose size may differ along the loop.

    common: errors of all points together ``(n, k)``, one standard deviation of each.

    Where the loop is steep, noise of the motion adds to that of the force; so each point counts with its own residual
    (MacKinnon and White, Journal of Econometrics 29, 1985, 305).
    """
    left, sizes, directions = np.linalg.svd(sensitivity, full_matrices=False)
    least = 1e-9 * max(float(np.linalg.norm(residual)), float(sizes.max()))
    # a parameter without any effect has no direction of its own, and no part in the errors of others
    left[:, sizes < least] = 1.0 / math.sqrt(len(left))
    directions[np.abs(directions) < 1e-6] = 0.0
    inverse = directions.T @ (left / np.maximum(sizes, least)).T
    leverage = np.sum(left**2, axis=1)
    weighted = inverse * (residual / (1.0 - leverage))
    shared = inverse @ common
    found: DoubleArray = weighted @ weighted.T + shared @ shared.T
    return found
