"""The base case solved by Tamaas: Polonsky, Keer and Rey's conjugate gradients with its non-periodic operator."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import version

import numpy as np
import tamaas
from task import Answer, normal_contact, read_task, timed

MOST_ITERATIONS = 10_000


def logged_iterations(solve: Callable[[], object]) -> int | None:
    """Iterations of a solve, told by its log alone, which goes past Python: the number, from 0, that ends it."""
    kept = os.dup(2)
    with tempfile.TemporaryFile(mode="w+") as log:
        os.dup2(log.fileno(), 2)
        tamaas.set_log_level(tamaas.LogLevel.info)
        try:
            solve()
        finally:
            tamaas.set_log_level(tamaas.LogLevel.error)
            sys.stderr.flush()
            os.dup2(kept, 2)
            os.close(kept)
        log.seek(0)
        rows = re.findall(r"^\s*(\d+)\s+\S+\s+\S+\s*$", log.read(), flags=re.MULTILINE)
    return int(rows[-1]) + 1 if rows else None


def main() -> None:
    """Solve and answer."""
    task = read_task()
    tamaas.set_log_level(tamaas.LogLevel.error)
    grid = [task.points, task.points]
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [task.size, task.size], grid)
    model.E, model.nu = task.contact_modulus, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "free")
    heights = -task.separation()
    solver = tamaas.PolonskyKeerRey(model, heights, task.tolerance)
    solver.setIntegralOperator("free")  # without this the registered operator is not used
    solver.max_iter = MOST_ITERATIONS

    def solve() -> float:
        model.traction[:] = 0.0  # otherwise it goes on from the last solution
        return solver.solve(task.load / task.size**2)

    seconds, error = timed(solve, task.repeats)
    if not error <= task.tolerance:
        sys.exit(f"not converged: error {error:.1e}")
    pressure, displacement = np.array(model.traction), np.zeros(grid)
    model.operators["free"](pressure, displacement)
    found = normal_contact(task, pressure, displacement)
    counted = logged_iterations(solve)
    Answer(version("tamaas"), seconds, **found, iterations=counted, applications=None).send()


if __name__ == "__main__":
    main()
