"""Find the parameters with which a case follows a measured loop best, and how well the loop determines them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.stats import t as student

from fretsolve.sweep.fit.evaluation import Evaluator, LoopSolver, Show
from fretsolve.sweep.fit.measured_loop import MeasuredLoop, noise_of
from fretsolve.sweep.fit.model_loop import Branches, area
from fretsolve.sweep.fit.plan import FitPlan
from fretsolve.system.arrays import BoolArray, DoubleArray

FARTHEST = 7.0
"""Largest logarithm of a parameter over its start: a factor of 1000 either way."""

STEPS = 30
"""Most steps of the search on one grid."""

TOLERANCE = 1e-3
"""Relative fall of the sum of squares at which a search ends. The next step would be far smaller."""

CONFIDENCE = 0.95

DOUBLED = math.log(2.0)
"""Half-width of the bounds of a logarithm from which the upper bound is twice the value: the bound exceeds it."""


@dataclass(frozen=True, eq=False)
class Fit:
    """The outcome. values ``(p,)`` in the units of the parameters; covariance ``(p, p)`` of their logarithms.

    fitted: force of the case at the measured points ``(n,)`` (N), with the offset and the drift that were found, whose
    sum is `drift`; freedom: points less what was found from them; neighbours: correlation of the noise of neighbouring
    points; branches: the loop of the case; solved: how many loops it took, in `seconds`; ended: whether the search came
    to its end; at_limit: which parameters ``(p,)`` went as far as the search does.
    """

    plan: FitPlan
    values: DoubleArray
    covariance: DoubleArray
    fitted: DoubleArray
    drift: DoubleArray
    freedom: int
    neighbours: float
    branches: Branches
    solved: int
    seconds: float
    ended: bool
    at_limit: BoolArray

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
        """Standard deviation of the residual from point to point (N), which no smooth error of the model has."""
        return noise_of(self.residual[np.argsort(self.plan.loop.time)])

    @property
    def quantile(self) -> float:
        """Half-width of the 95 % bounds in standard deviations. Correlated points count as fewer ones."""
        freedom = max(1.0, self.freedom * (1.0 - self.neighbours) / (1.0 + self.neighbours))
        return float(student.ppf(0.5 + 0.5 * CONFIDENCE, freedom))

    @property
    def widths(self) -> DoubleArray:
        """Half-widths of the 95 % bounds of the logarithms ``(p,)``."""
        found: DoubleArray = self.quantile * np.sqrt(np.diag(self.covariance))
        return found

    @property
    def bounds(self) -> tuple[DoubleArray, DoubleArray]:
        """The 95 % bounds of the values, two times ``(p,)``."""
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
    def exceeded(self) -> BoolArray:
        """Which bounds exceed their parameters ``(p,)``."""
        found: BoolArray = self.widths > DOUBLED
        return found

    @property
    def undetermined(self) -> Iterator[DoubleArray]:
        """Directions of the logarithms ``(p,)`` along which a bound exceeds its parameter.

        Each is so long that its largest component doubles a parameter.
        """
        variances, directions = np.linalg.eigh(self.covariance)
        for variance, direction in zip(variances, directions.T, strict=True):
            largest = direction[np.argmax(np.abs(direction))]
            if self.quantile * math.sqrt(max(variance, 0.0)) * abs(largest) > DOUBLED:
                yield direction * (DOUBLED / largest)


def fit_loop(plan: FitPlan, jobs: int = 1, show: Show = lambda *_: None) -> Fit:
    """Fit the models of a plan one after another, each from the values of the one before. Raises NoSolutionError.

    jobs: processes for loops that take long.
    """
    began, loop = time.perf_counter(), plan.loop
    basis = drift_basis(loop) if plan.request.offset else np.zeros((len(loop.force), 0))
    freedom = len(loop.force) - len(plan.parameters) - basis.shape[1]
    found = np.zeros(len(plan.parameters))
    with closing(LoopSolver(jobs)) as solver:
        for model in plan.models:
            last = model is plan.models[-1]
            evaluator = Evaluator(model.stretched(loop.reach / model.reach), loop, basis, solver, show)
            search = least_squares(
                evaluator.residuals,
                found,
                evaluator.central if last else evaluator.forward,
                (-FARTHEST, FARTHEST),
                ftol=TOLERANCE,
                max_nfev=STEPS,
            )
            found, turns = search.x, evaluator.by_turns(search.x)
            if not last:
                # the loop itself tells more of its turns
                sigma = float(np.linalg.norm(search.fun)) / math.sqrt(freedom)
                inverse = _inverse(search.jac, turns, sigma)[len(found) :, : len(search.fun)]
                loop = loop.corrected(-inverse @ search.fun)
        branches = evaluator.branches(found)
    computed, slope = branches.at(loop)
    drift = basis @ (basis.T @ (loop.force - computed))
    residual = loop.force - computed - drift
    # smoothing of the motion hides noise that its mean values still have
    spread, neighbours = covariance(loop.range * search.jac, loop.range * turns, residual - slope * loop.hidden, basis)
    return Fit(
        replace(plan, loop=loop),
        np.array(evaluator.values(found)),
        spread,
        computed + drift,
        drift,
        freedom,
        neighbours,
        branches,
        solver.solved + 2 * len(plan.models),  # two for the turns
        time.perf_counter() - began,
        search.status > 0,
        search.active_mask != 0,
    )


def drift_basis(loop: MeasuredLoop) -> DoubleArray:
    """Return an offset and a drift, which is linear in time, as orthonormal columns ``(n, 2)``."""
    columns = np.stack([np.ones_like(loop.time), loop.time], axis=1)
    return np.linalg.qr(columns)[0]


def covariance(
    sensitivity: DoubleArray, turns: DoubleArray, residual: DoubleArray, basis: DoubleArray
) -> tuple[DoubleArray, float]:
    """Return the covariance ``(p, p)`` of the parameters, and the correlation of the noise of neighbouring points.

    turns: errors of all points together ``(n, k)``, one standard deviation of each; basis: what else was found from
    the residual, as orthonormal columns.

    Noise decays along the loop as a process of first order. What comes in at each point counts with its own size, since
    noise of the motion adds to the noise of the force where the loop is steep (MacKinnon and White, Journal of
    Econometrics 29, 1985, 305).
    """
    (points, number), taken = sensitivity.shape, sensitivity.shape[1] + basis.shape[1]
    sigma = float(np.linalg.norm(residual)) / math.sqrt(points - taken)
    inverse = _inverse(sensitivity, turns, sigma)
    leverage = np.sum(np.hstack([sensitivity, turns]) * inverse[:, :points].T, axis=1) + np.sum(basis**2, axis=1)
    noise = residual / (1.0 - leverage)
    neighbours = _correlation(noise, taken)
    comes_in = lfilter([1.0, -neighbours], [1.0], noise)
    carries_on = lfilter([1.0], [1.0, -neighbours], inverse[:number, points - 1 :: -1])[:, ::-1]
    parts = np.hstack([carries_on * comes_in, sigma * inverse[:number, points:]])
    return parts @ parts.T, neighbours


def _correlation(noise: DoubleArray, taken: int) -> float:
    """Return the correlation of neighbouring points. taken: how many numbers were found from the same points.

    Each of those takes slow noise out (Kendall, Biometrika 41, 1954, 403, for a mean value). Noise does not alternate
    from point to point, and noise that outlasts the record is an offset.
    """
    points, found = len(noise), float(noise[1:] @ noise[:-1] / (noise @ noise))
    return float(np.clip((points * found + taken) / (points - taken - 2), 0.0, 1.0 - 1.0 / points))


def _inverse(sensitivity: DoubleArray, turns: DoubleArray, sigma: float) -> DoubleArray:
    """Return the parameters and turns that residuals of size sigma give ``(p + k, n + p + k)``.

    The last p + k residuals are what is known before: each logarithm is within the limits of the search, and each turn
    within its error.
    """
    number, others = sensitivity.shape[1], turns.shape[1]
    before = sigma * np.diag([*[1.0 / FARTHEST] * number, *[1.0] * others])
    inverse: DoubleArray = np.linalg.pinv(np.vstack([np.hstack([sensitivity, turns]), before]))
    return inverse
