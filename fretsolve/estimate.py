"""Memory and time of a case before it is run, from what such cases took.

The constants were measured on single-thread runs of a sphere under normal and tangential load, on grids of 256 x 256
to 2048 x 2048 points that the contact fills. There memory comes out within a fifth; a contact that is small against
its grid takes less. Time is an order of magnitude: it depends on the machine, on how near the load is to sliding,
and on the tolerance.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.compiler import compiler_wanted
from fretsolve.errors import CaseError

if TYPE_CHECKING:
    from fretsolve.scene import Scene

PROCESS_BYTES = 145e6
"""Python and its libraries."""

COMPILER_BYTES = 60e6
"""numba, where it is installed."""

BUFFER_BYTES = 10e6
"""Blocks of the transforms that stay in cache, for the normal problem and for each term that is kept."""

CELL_BYTES = 245
CELL_BYTES_TANGENTIAL = 110
CELL_BYTES_CROSS = 25
CELL_BYTES_COUPLED = 100
"""Per cell, of the normal problem and more for each term that is kept: influence coefficients, padded spectra, work
arrays of the solvers, the states before and after an increment, buffers of the result file."""

APPLICATIONS_NORMAL = 20
APPLICATIONS_TANGENTIAL = 25
APPLICATIONS_COUPLED = 50
"""Applications of the elastic operator per increment."""

SECONDS_NORMAL = 0.06e-6
SECONDS_TANGENTIAL = 0.1e-6
"""Per application and cell, with all that is done besides."""

COMPANIONS = 0.25
"""Work of the runs for error bars over that of the run itself. There are up to two, on a quarter of its cells each."""

FIELD_BYTES = {"shear": 16, "slip": 16, "zone": 1}
"""Bytes per cell of the stored fields other than 8, before compression."""

COMPRESSION = 0.35
"""What is left of the fields in the file."""


@dataclass(frozen=True)
class Estimate:
    """memory, file: bytes; applications: of the elastic operator over the whole path; seconds: of one thread."""

    memory: float
    file: float
    increments: int
    applications: int
    seconds: float

    def lines(self) -> Iterator[str]:
        """For people."""
        yield f"about {_rounded_bytes(self.memory)} of memory, a result file of about {_rounded_bytes(self.file)}"
        yield (
            f"about {self.applications // self.increments} operator applications per increment,"
            f" in all in the order of {_rounded_time(self.seconds)}"
        )


def estimate(scene: Scene) -> Estimate:
    """What running `scene` with one thread takes."""
    cells, increments = math.prod(scene.grid.shape), scene.load_path.increments
    terms = scene.model.terms
    kept = (terms.tangential, terms.cross, terms.coupled)
    per_cell = CELL_BYTES + sum(
        size * term
        for size, term in zip((CELL_BYTES_TANGENTIAL, CELL_BYTES_CROSS, CELL_BYTES_COUPLED), kept, strict=True)
    )
    fixed = PROCESS_BYTES + COMPILER_BYTES * compiler_wanted() + BUFFER_BYTES * (1 + sum(kept))
    applications, seconds = APPLICATIONS_NORMAL, SECONDS_NORMAL
    if scene.model.sheared:
        applications = APPLICATIONS_COUPLED if terms.coupled else APPLICATIONS_TANGENTIAL
        seconds = SECONDS_TANGENTIAL
    companions = COMPANIONS if scene.case.solver.error_estimate else 0.0
    output = scene.case.output
    stored = sum(FIELD_BYTES.get(name, 8) for name in output.fields) * -(-increments // output.every)
    return Estimate(
        memory=fixed + per_cell * cells * (1.0 + 2.0 * companions),
        file=COMPRESSION * stored * cells + 300.0 * increments + 100e3,
        increments=increments,
        applications=round(applications * increments * (1.0 + companions)),
        seconds=seconds * applications * increments * cells * (1.0 + companions),
    )


def memory_problem(scene: Scene) -> CaseError | None:
    """The error of a grid that this machine's memory cannot hold; None where it can, or where that is unknown."""
    needed, there = estimate(scene).memory, _machine_bytes()
    if there is None or needed <= there:
        return None
    nx, ny = scene.grid.shape
    return scene.case.source.problem(
        f"{nx} x {ny} cells take about {_rounded_bytes(needed)} of memory, this machine has {_rounded_bytes(there)};"
        " fewer points are needed",
        ("grid", "points"),
    )


def require_memory(scene: Scene) -> None:
    """Raise CaseError where the case cannot fit in this machine's memory, rather than be killed for it."""
    problem = memory_problem(scene)
    if problem is not None:
        raise problem


def _machine_bytes() -> int | None:
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):
        return None


def _rounded_bytes(size: float) -> str:
    for unit, factor in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6)):
        if size >= factor:
            return f"{_two_digits(size / factor)} {unit}"
    return f"{_two_digits(size / 1e3)} kB"


def _rounded_time(seconds: float) -> str:
    for unit, factor in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * factor:
            return f"{_two_digits(seconds / factor)} {unit}"
    return f"{_two_digits(max(seconds, 0.1))} s"


def _two_digits(value: float) -> str:
    return f"{value:.2g}" if value < 10.0 else f"{value:.0f}"
