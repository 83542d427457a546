"""The base case solved by slippy, with the solvers behind its StaticStep and TangentialPartialSlip.

Those are called directly, as the steps time and log more than the solve, and tell no counts: `polonsky_and_keer`, which
the step takes for an imposed load, and `bccg`, Vollebregt's bound-constrained conjugate gradients. The influence
coefficients are the spatial ones, which are those of a free half-space; slippy's default, sampled in the frequency
domain, is off by 2 % in delta_z here. SI units, as in its examples.
"""

from __future__ import annotations

import sys
from importlib.metadata import version
from typing import Any

import numpy as np
import slippy
from task import Answer, Task, equal_area_radius, normal_contact, read_task, timed

slippy.CORES = 1
from slippy.core import Elastic, bccg, plan_convolve, polonsky_and_keer  # noqa: E402

MM, MPA = 1e-3, 1e6
MOST_ITERATIONS = 10_000


class Counted:
    """A convolution that counts its calls."""

    def __init__(self, convolve: Any):
        self.convolve, self.calls = convolve, 0

    def __call__(self, loads: np.ndarray, ignore_domain: bool = False) -> np.ndarray:
        self.calls += 1
        return self.convolve(loads, ignore_domain)


def convolution(task: Task, component: str, domain: np.ndarray | None = None) -> Counted:
    """Displacement of both bodies in the direction of a load, "zz" or "xx"; of cells in `domain` alone, if given."""
    properties = {"E": task.young_modulus * MPA, "v": task.poisson_ratio}
    material = Elastic(f"steel, {component}", properties, use_frequency_domain=False)
    span = (2 * task.points, 2 * task.points)
    coefficients = material.influence_matrix([component], [task.cell * MM] * 2, span)[component]
    return Counted(plan_convolve(task.separation(), 2.0 * coefficients, domain, [False, False]))


def solve_normal(task: Task, repeats: int) -> tuple[Answer, np.ndarray]:
    """The normal contact, and its pressure (Pa)."""
    convolve = convolution(task, "zz")
    gap, start = task.separation() * MM, np.ones((task.points, task.points))
    seconds, (failed, pressure, _) = timed(
        lambda: polonsky_and_keer(convolve, start, gap, task.load, task.cell * MM, task.tolerance, MOST_ITERATIONS),
        repeats,
    )
    calls = convolve.calls // repeats
    # It says "not failed" also where it has stopped short of the tolerance.
    if failed or calls >= 2 * MOST_ITERATIONS or not np.isfinite(pressure).all():
        sys.exit("not converged")
    found = normal_contact(task, pressure / MPA, convolve(pressure) / MM)
    return Answer(version("slippy"), seconds, **found, iterations=calls // 2, applications=calls), pressure


def solve_tangential(task: Task, pressure: np.ndarray) -> Answer:
    """Mode I with imposed delta_x at `pressure` (Pa)."""
    contact = pressure > 0.0
    convolve = convolution(task, "xx", contact)
    bound = task.friction * pressure[contact]
    imposed = np.full(bound.shape, task.delta_x * MM)
    seconds, (shear, failed) = timed(
        lambda: bccg(convolve, imposed, task.tolerance, MOST_ITERATIONS, 0.5 * bound, -bound, bound), task.repeats
    )
    calls = convolve.calls // task.repeats
    if failed:
        sys.exit("not converged")
    stick = np.abs(shear) < (1.0 - 1e-9) * bound
    slip = imposed - convolve(shear)
    return Answer(
        version("slippy"),
        seconds,
        rigid=float(shear.sum() * (task.cell * MM) ** 2),
        peak=float(np.abs(shear).max() / MPA),
        radius=equal_area_radius(stick, task.cell),
        residual=float(np.abs(slip[stick]).max() / (task.delta_x * MM)),
        iterations=None,
        applications=calls,
    )


def main() -> None:
    """Solve and answer."""
    task = read_task()
    if task.job == "normal":
        answer, _ = solve_normal(task, task.repeats)
    else:
        _, pressure = solve_normal(task, repeats=1)
        answer = solve_tangential(task, pressure)
    answer.send()


if __name__ == "__main__":
    main()
