"""Memory and time of a case before it is run, from what such cases took.

The constants were measured on single-thread runs of a sphere under normal and tangential load, on grids of 256 x 256
to 2048 x 2048 points that the contact fills. There memory comes out within a fifth; a contact that is small against
its grid takes less. Time is an order of magnitude: it depends on the machine, on how near the load is to sliding,
and on the tolerance.
"""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.case.load_components import TANGENTIAL
from fretsolve.errors import CaseError
from fretsolve.model.grid import LARGE_GRID
from fretsolve.system.optional import compiler_wanted

if TYPE_CHECKING:
    from fretsolve.model.required_terms import Part
    from fretsolve.setup.problem_setup import ProblemSetup

PROCESS_BYTES = 145e6
"""Python and its libraries."""

COMPILER_BYTES = 60e6
"""numba, where it is installed."""

BUFFER_BYTES = 10e6
"""Blocks of the transforms that stay in cache, for the normal problem and for each term that is kept."""

CELL_BYTES: dict[Part, float] = {
    "normal problem": 115.0,
    "tangential problem": 110.0,
    "ux from qy, uy from qx": 20.0,
    "between pressure and shear": 110.0,
    "slip and work": 75.0,
}
"""Per cell, of each part of the model that is kept: influence coefficients, padded spectra, work arrays of the solvers,
the states before and after an increment, buffers of the result file (`python benchmarks/scenes.py`)."""

KEPT = 1.8
"""Memory per cell on grids up to `LARGE_GRID`, where windows and coarser grids are kept, over that on larger ones."""

PRESSED_APPLICATIONS = 20
FOLLOWED_APPLICATIONS = 10
SHEARED_APPLICATIONS = 20
COUPLED_APPLICATIONS = 10
"""Applications of the elastic operator per increment: where the normal load changes, or the pressure follows the shear;
where there is shear; and more where both act on each other."""

APPLICATION_SECONDS: dict[Part, float] = {
    "normal problem": 0.033e-6,
    "tangential problem": 0.03e-6,
    "between pressure and shear": 0.033e-6,
}
"""Per application and cell, with all that is done besides."""

NUMPY_SLOWNESS = 2.0
"""How many times as long all takes where numba is not installed: mode I.3 on 256 x 256 points does, Hertz 1.6 times."""

CALL_SECONDS = 0.4e-3
"""Per application, however few the cells are."""

LARGE_CELLS, GROWTH = 2**20, 0.2
"""Beyond so many cells the time of a cell grows like this power of their number: larger transforms leave the caches,
and iterations become more."""

CROSS_SHARE = 0.45
"""What ux from qy and uy from qx add to the time of the tangential problem."""

PROOF_SECONDS = 0.08e-6
SLIP_SECONDS = 0.055e-6
"""Per increment and cell: the certificate's application and the gap; slip and work with their part of it."""

COMPANIONS = 0.25
"""Work of the runs for error bars over that of the run itself. There are up to two, on a quarter of its cells each."""

SINGLE = 0.75
"""Memory per cell in single precision over that in double."""

FIELD_BYTES = {"shear": 16, "slip": 16, "zone": 1}
"""Bytes per cell of the stored fields other than 8, before compression."""

COMPRESSION = 0.35
"""What is left of the fields in the file where the contact fills the grid."""

EMPTIEST = 0.1
"""What is left of that where the grid is several times as wide as the contact."""


@dataclass(frozen=True)
class Share:
    """What a part of the model takes: bytes that grow with the grid, seconds of one thread."""

    memory: float
    seconds: float


@dataclass(frozen=True)
class Estimate:
    """memory, file: bytes; applications: of the elastic operator over the whole path; seconds: of one thread.

    shares: of the parts of the model that are kept, without the companion runs of error bars; saved: bytes of memory
    that single precision does not need, 0 in double.
    """

    shares: dict[Part, Share]
    memory: float
    file: float
    increments: int
    applications: int
    seconds: float
    saved: float = 0.0

    def lines(self) -> Iterator[str]:
        """For people."""
        yield f"about {rounded_bytes(self.memory)} of memory, a result file of about {rounded_bytes(self.file)}"
        yield (
            f"about {self.applications // self.increments} operator applications per increment,"
            f" in all in the order of {_rounded_time(self.seconds)}"
        )
        if self.saved:
            yield f"single precision saves {rounded_bytes(self.saved)} of memory and half of the file, but little time"


def estimate(setup: ProblemSetup) -> Estimate:
    """What running `scene` with one thread takes."""
    cells, increments = math.prod(setup.grid.shape), setup.load_path.increments
    terms = setup.model.terms
    applications = _applications(setup)
    effort = cells * max(1.0, cells / LARGE_CELLS) ** GROWTH * (1.0 if compiler_wanted() else NUMPY_SLOWNESS)
    each = {part: APPLICATION_SECONDS[part] * effort + CALL_SECONDS for part in applications}
    seconds = {part: each[part] * count for part, count in applications.items()}
    seconds["normal problem"] += PROOF_SECONDS * increments * effort
    if terms.in_plane_coupling:
        seconds["ux from qy, uy from qx"] = CROSS_SHARE * seconds["tangential problem"]
    if setup.model.may_slip:
        seconds["slip and work"] = SLIP_SECONDS * increments * effort
    kept = [decision.part for decision in setup.model.decisions if decision.kept]
    single = setup.case.solver.precision == "single"
    bytes_each = (SINGLE if single else 1.0) * (KEPT if cells <= LARGE_GRID else 1.0)
    shares = {part: Share(bytes_each * CELL_BYTES[part] * cells, seconds.get(part, 0.0)) for part in kept}
    fixed = PROCESS_BYTES + COMPILER_BYTES * compiler_wanted()
    fixed += BUFFER_BYTES * (1 + sum((terms.tangential, terms.in_plane_coupling, terms.normal_tangential_coupling)))
    companions = COMPANIONS if setup.case.solver.error_bars else 0.0
    output = setup.case.output
    stored = sum(FIELD_BYTES.get(name, 8) for name in output.fields) * -(-increments // output.every)
    of_cells = sum(share.memory for share in shares.values()) * (1.0 + 2.0 * companions)
    return Estimate(
        shares=shares,
        memory=fixed + of_cells,
        file=COMPRESSION * stored * cells * (0.5 if single else 1.0) + 300.0 * increments + 100e3,
        increments=increments,
        applications=round(sum(applications.values()) * (1.0 + companions)),
        seconds=sum(share.seconds for share in shares.values()) * (1.0 + companions),
        saved=of_cells * (1.0 / SINGLE - 1.0) if single else 0.0,
    )


def _applications(setup: ProblemSetup) -> dict[Part, int]:
    """Applications of the elastic operator over the whole path, by the part of the model that needs them."""
    model, increments = setup.model, setup.load_path.increments
    stages = zip(setup.case.stages(), setup.load_path.counts, strict=True)
    pressed = sum(
        count for stage, count in stages if any(name not in TANGENTIAL for name, _ in stage.targets)
    )
    interact = model.has_shear and model.terms.normal_tangential_coupling
    pressing = FOLLOWED_APPLICATIONS * increments if interact else PRESSED_APPLICATIONS * pressed
    needed: dict[Part, int] = {"normal problem": pressing}
    if model.has_shear:
        needed["tangential problem"] = SHEARED_APPLICATIONS * increments
    if model.terms.normal_tangential_coupling:
        needed["between pressure and shear"] = COUPLED_APPLICATIONS * increments if interact else increments
    return needed


def memory_problem(setup: ProblemSetup, expected: Estimate | None = None) -> CaseError | None:
    """The error of a grid that this machine's memory cannot hold; None where it can, or where that is unknown."""
    needed, there = (expected or estimate(setup)).memory, _machine_bytes()
    if there is None or needed <= there:
        return None
    nx, ny = setup.grid.shape
    return setup.case.source.problem(
        f"{nx} x {ny} cells take about {rounded_bytes(needed)} of memory, this machine has {rounded_bytes(there)};"
        " fewer points are needed",
        ("grid", "points"),
    )


def require_memory(setup: ProblemSetup) -> Estimate:
    """The estimate of a case. Raises CaseError where it cannot fit in this machine's memory, rather than be killed."""
    expected = estimate(setup)
    problem = memory_problem(setup, expected)
    if problem is not None:
        raise problem
    return expected


def disk_problem(setup: ProblemSetup, out: Path) -> CaseError | None:
    """The error of a result that may not fit on the disk of `out`; None where it does, or where that is unknown.

    It lies there twice for a moment, as the increments that were saved and as the file made of them.
    """
    return _on_disk(setup, out)[0]


def require_disk(setup: ProblemSetup, out: Path) -> None:
    """Raise CaseError where the result cannot fit on the disk of `out`, however much of its fields is empty."""
    problem, certain = _on_disk(setup, out)
    if problem is not None and certain:
        raise problem


def _on_disk(setup: ProblemSetup, out: Path) -> tuple[CaseError | None, bool]:
    """The error of a result that may not fit, and whether it cannot."""
    file, free = estimate(setup).file, free_bytes(out)
    if free is None or 2.0 * file <= free:
        return None, False
    certain = EMPTIEST * file > free
    if certain:
        verdict, advice = "is too much for", "a larger output.every, fewer output.fields or another disk is needed"
    else:
        verdict, advice = "may be too much for", "empty cells compress, the run goes on"
    problem = setup.case.source.problem(
        f"a result of about {rounded_bytes(file)}, twice that while it is written, {verdict} the"
        f" {rounded_bytes(free)} that are free in {out.parent}; {advice}",
        ("output", "every"),
    )
    return problem, certain


def free_bytes(out: Path) -> int | None:
    """What a file `out` may take, in place of what is there; None where that is unknown."""
    try:
        return shutil.disk_usage(out.parent).free + (out.stat().st_size if out.is_file() else 0)
    except OSError:
        return None


def _machine_bytes() -> int | None:
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):
        return None


def rounded_bytes(size: float) -> str:
    """For people, such as ``1.7 MB``."""
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
