"""What every worker is asked and answers: a Task as its argument, an Answer as its last line of output, both JSON.

Lengths in mm, forces in N, stresses in MPa. NumPy is all that this module needs, as it runs in each program's own
environment.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TypeVar

import numpy as np

Result = TypeVar("Result")


@dataclass(frozen=True)
class Task:
    """A sphere on a flat of the same material, a square area of `size` with `points` per side, and what to solve.

    job: "normal", the load alone; "mode1", then delta_x imposed, with shear in x acting on displacement in x alone.
    delta_z: Hertz's, the scale of absolute tolerances; repeats: solves whose median time is asked for.
    """

    job: str
    points: int
    size: float
    radius: float
    young_modulus: float
    poisson_ratio: float
    load: float
    friction: float
    delta_x: float
    delta_z: float
    tolerance: float
    repeats: int

    @property
    def cell(self) -> float:
        """Side of a cell."""
        return self.size / self.points

    @property
    def contact_modulus(self) -> float:
        """E* of the two equal bodies."""
        return 0.5 * self.young_modulus / (1.0 - self.poisson_ratio**2)

    def separation(self) -> np.ndarray:
        """The sphere's paraboloid at the cells' centres, ``(points, points)``."""
        x = (np.arange(self.points) + 0.5) * self.cell - 0.5 * self.size
        return (x[:, None] ** 2 + x**2) / (2.0 * self.radius)


@dataclass(frozen=True)
class Answer:
    """What a program found. Of "normal" and "mode1" in turn, with None for counts that the program does not tell:

    rigid: delta_z, Qx; peak: largest pressure, shear; radius: of the circle with the area of contact, of stick;
    residual: largest |gap| in contact or penetration outside over delta_z, largest |slip| in the stick zone over
    delta_x, by the program's own convolution. applications: convolutions of the influence coefficients.
    """

    version: str
    seconds: float
    rigid: float
    peak: float
    radius: float
    residual: float
    iterations: int | None
    applications: int | None

    def send(self) -> None:
        """Print as one line."""
        print(json.dumps(asdict(self)), flush=True)


def read_task() -> Task:
    """The task in the command line's only argument."""
    return Task(**json.loads(sys.argv[1]))


def timed(solve: Callable[[], Result], repeats: int) -> tuple[float, Result]:
    """Median seconds of `solve`, and what its last call gave."""
    seconds = []
    for _ in range(repeats):
        began = time.perf_counter()
        result = solve()
        seconds.append(time.perf_counter() - began)
    return statistics.median(seconds), result


def normal_contact(task: Task, pressure: np.ndarray, displacement: np.ndarray) -> dict[str, float]:
    """Return what an Answer has of a pressure (MPa) and the elastic displacement (mm) that belongs to it."""
    contact = pressure > 0.0
    gap = task.separation() + displacement
    approach = gap[contact].mean()
    gap -= approach
    return {
        "rigid": float(approach),
        "peak": float(pressure.max()),
        "radius": equal_area_radius(contact, task.cell),
        "residual": float(max(np.abs(gap[contact]).max(), -gap.min()) / approach),
    }


def equal_area_radius(cells: np.ndarray, cell: float) -> float:
    """Radius of the circle of the same area as the marked cells."""
    return float(np.sqrt(np.count_nonzero(cells) / np.pi) * cell)
