"""Estimate memory and time of a case before it is run, from measurements on such cases.

The constants were measured on single-thread runs of a sphere under normal and tangential load, on grids of 256 x 256
to 2048 x 2048 points that the contact fills (`python benchmarks/scenes.py`). Memory is right within a fifth there, and
less for a contact that is small against its grid. Time is an order of magnitude: it depends on the machine, the
tolerance, and how near the load is to gross slip.
"""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.case.dimensions import cell_counts
from fretsolve.case.history import SHEARING
from fretsolve.errors import CaseError
from fretsolve.model.grid import LARGE_GRID
from fretsolve.model.required_terms import ModelPart
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.system.environment import address_space

PROCESS_BYTES, COMPILER_BYTES, BUFFER_BYTES = 145e6, 60e6, 10e6
"""Python with its libraries; numba, where it is used; blocks of the transforms that stay in cache, for the normal
problem and for each term that is kept."""

UNUSED_BYTES = 350e6
"""Address space that libraries reserve and do not use."""

CELL_COSTS: dict[ModelPart, tuple[float, float]] = {
    "normal problem": (115.0, 0.033e-6),
    "tangential problem": (110.0, 0.03e-6),
    "ux from qy, uy from qx": (20.0, 0.0),
    "between pressure and shear": (110.0, 0.033e-6),
    "slip and dissipated energy": (75.0, 0.0),
}
"""Of each part of the model, bytes per cell: influence coefficients, padded spectra, work arrays of the solvers, states
before and after an increment, buffers of the result file; and seconds per cell and application of the operator."""

TREND_BYTES = 28.0
"""Bytes per cell of the change over an increment, from which the next one of its stage starts."""

SMALL_GRID, SINGLE = 1.8, 0.75
"""Factors on the memory per cell: on grids up to `LARGE_GRID`, where active regions and coarser grids are kept, and in
single precision."""

APPLICATIONS, COUPLED_APPLICATIONS = 20, 10
"""Applications of the elastic operator per increment: in the tangential problem, and in the normal problem where the
normal load changes; where the pressure follows the shear, in the normal problem and of the coefficients between both.
"""

CALL_SECONDS, NUMPY_SLOWNESS = 0.1e-3, 2.0
"""Seconds per application for any number of cells, and factor on all times without numba. With both, mode I.3 takes a
quarter more at most than measured on 32 x 32 to 256 x 256 points (`python benchmarks/bench_path.py`)."""

COARSE_CELLS, COARSE_APPLICATIONS, COARSE_CALLS = 0.5, 0.33, 3.0
"""Of the coarse runs for error bars over those of the run: cells, applications in units of one on the run's grid, and
applications on their own grids."""

LARGE_CELLS, GROWTH = 2**20, 0.2
"""Beyond this many cells the time per cell grows with this power of their number: larger transforms leave the caches,
and more iterations are needed."""

CERTIFICATE_SECONDS, SLIP_SECONDS = 0.08e-6, 0.055e-6
"""Per increment and cell: the certificate with the gap; slip and dissipated energy with their part of it."""

FIELD_BYTES = {"shear": 16, "slip": 16, "zone": 1}
"""Bytes per cell of the stored fields, before compression; 8 for all others."""

COMPRESSION, EMPTIEST = 0.35, 0.1
"""Size of the compressed fields over that before, where the contact fills the grid; factor on it where the grid is
several times as wide as the contact."""


@dataclass(frozen=True)
class Estimate:
    """Cost of a run on one thread: memory and file in bytes, applications of the elastic operator, time in seconds.

    increments: that are likely to be solved; shares: bytes that grow with the grid and seconds, of each part of the
    model that is kept, without coarse runs; saved: bytes of memory that single precision saves, 0 in double.
    """

    increments: int
    shares: dict[ModelPart, tuple[float, float]]
    memory: float
    file: float
    applications: int
    seconds: float
    saved: float


def estimate(setup: ProblemSetup) -> Estimate:
    """Estimate the cost of running the case on one thread."""
    weights = _weights(setup)
    cells, increments, terms = math.prod(setup.grid.shape), _expected(setup, weights), setup.model.terms
    solved = setup.share_of_cells
    compiled, single = setup.compiled, setup.case.solver.precision == "single"
    bars = setup.case.solver.error_bars
    # Seconds of each part over the whole path.
    applications = _applications(setup, increments, weights)
    slowness = 1.0 if compiled else NUMPY_SLOWNESS
    effort = solved * cells * max(1.0, cells / LARGE_CELLS) ** GROWTH * slowness
    seconds = {part: CELL_COSTS[part][1] * effort * count for part, count in applications.items()}
    seconds["normal problem"] += CERTIFICATE_SECONDS * increments * effort
    seconds["ux from qy, uy from qx"] = 0.45 * seconds["tangential problem"]
    seconds["slip and dissipated energy"] = SLIP_SECONDS * increments * effort
    called = {part: CALL_SECONDS * slowness * count for part, count in applications.items()}
    called["ux from qy, uy from qx"] = 0.45 * called["tangential problem"]
    # Bytes of each part that grow with the grid, those that do not, and those of the fields that are stored.
    cell_factor = (SINGLE if single else 1.0) * (SMALL_GRID if cells <= LARGE_GRID else 1.0)
    kept = [decision.part for decision in setup.model.decisions if decision.kept]
    shares = {part: (cell_factor * CELL_COSTS[part][0] * cells, seconds[part] + called.get(part, 0.0)) for part in kept}
    cell_bytes, own_seconds = map(sum, zip(*shares.values(), strict=True))
    # the trend of the increments is kept in double precision alone
    trend = TREND_BYTES * cells * (setup.model.has_shear and max(setup.load_path.counts) > 1)
    on_coarse_grids = COARSE_APPLICATIONS * sum(seconds[part] for part in kept)
    on_coarse_grids += COARSE_CALLS * sum(called.get(part, 0.0) for part in kept)
    with_coarse = 1.0 + COARSE_CELLS * bars
    in_cells = (cell_bytes + trend * (not single)) * with_coarse
    fixed = PROCESS_BYTES + COMPILER_BYTES * compiled
    fixed += BUFFER_BYTES * (1 + sum((terms.tangential, terms.in_plane_coupling, terms.normal_tangential_coupling)))
    output = setup.case.output
    stored = sum(FIELD_BYTES.get(name, 8) for name in output.fields) * -(-increments // output.every)
    return Estimate(
        increments=increments,
        shares=shares,
        memory=fixed + in_cells,
        file=COMPRESSION * stored * cells * (0.5 if single else 1.0) + 300.0 * increments + 100e3,
        applications=round(solved * sum(applications.values()) * (1.0 + COARSE_APPLICATIONS * bars)),
        seconds=own_seconds + on_coarse_grids * bars,
        saved=(cell_bytes * (1.0 / SINGLE - 1.0) + trend) * with_coarse if single else 0.0,
    )


def expected_increments(setup: ProblemSetup) -> int:
    """Return how many increments a run is likely to have: with wear fewer than the most that it may have."""
    return _expected(setup, _weights(setup))


def _expected(setup: ProblemSetup, weights: Sequence[float]) -> int:
    return max(1, round(sum(count * weight for count, weight in zip(setup.load_path.counts, weights, strict=True))))


def _weights(setup: ProblemSetup) -> list[float]:
    """Return for each stage the share of its increments that is likely to be solved."""
    if setup.case.wear is None:
        return [1.0] * len(setup.load_path.counts)
    from fretsolve.setup.solved_cycles import stage_weights  # few cases have wear

    return stage_weights(setup)


def _applications(setup: ProblemSetup, increments: int, weights: Sequence[float]) -> dict[ModelPart, int]:
    """Return the applications of the elastic operator over the whole path, by the part of the model that needs them.

    increments: that are likely to be solved; weights: of each stage the share of its increments that are.
    """
    model = setup.model
    coupling = model.terms.normal_tangential_coupling
    stages = zip(setup.case.stages(), setup.load_path.counts, weights, strict=True)
    unpressed = {*SHEARING, "friction"}
    pressed = round(
        sum(
            count * weight
            for stage, count, weight in stages
            if stage.wears is not None or any(name not in unpressed for name, _ in stage.targets)
        )
    )
    in_turn = model.has_shear and coupling
    return {
        "normal problem": COUPLED_APPLICATIONS * increments if in_turn else APPLICATIONS * pressed,
        "tangential problem": APPLICATIONS * increments * model.has_shear,
        "between pressure and shear": (COUPLED_APPLICATIONS if in_turn else 1) * increments * coupling,
    }


def memory_problem(setup: ProblemSetup, needed: float) -> CaseError | None:
    """Return the error of a grid that does not fit in this machine's memory; None if it does, or if unknown.

    needed: the `estimate` of its memory (bytes).
    """
    try:
        there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):
        return None
    cells = cell_counts(setup.grid.shape)
    if needed + UNUSED_BYTES > (allowed := address_space()):
        return setup.case.source.problem(
            f"{cells} cells take about {rounded_bytes(needed + UNUSED_BYTES)} of address space, the limit (ulimit"
            f" -v or -d) is {rounded_bytes(allowed)}; a higher one or fewer points are needed",
            ("grid", "points"),
        )
    if needed <= there:
        return None
    return setup.case.source.problem(
        f"{cells} cells take about {rounded_bytes(needed)} of memory, this machine has {rounded_bytes(there)};"
        " fewer points are needed",
        ("grid", "points"),
    )


def require_memory(setup: ProblemSetup) -> Estimate:
    """Return the estimate of a case. Raises CaseError where this machine's memory cannot hold it."""
    expected = estimate(setup)
    if (problem := memory_problem(setup, expected.memory)) is not None:
        raise problem
    return expected


def disk_problem(setup: ProblemSetup, out: Path, certain: bool = False) -> CaseError | None:
    """Return the error of a result that may not fit on the disk of `out`, with `certain` of one that cannot fit.

    It needs its size twice for a moment, for the saved increments and for the file made of them. Empty fields take
    less. None where it fits, or where that is unknown.
    """
    file, free = estimate(setup).file, free_bytes(out)
    if free is None or 2.0 * file <= free:
        return None
    if EMPTIEST * file > free:
        advice = "is too little; a larger output.every, fewer output.fields or another disk is needed"
    elif certain:
        return None
    else:
        advice = "may be too little; empty cells take less, so the run goes on"
    return setup.case.source.problem(
        f"the result takes about {rounded_bytes(file)}, and twice that while it is written; {rounded_bytes(free)} are"
        f" free in {out.parent}, which {advice}",
        ("output", "every"),
    )


def free_bytes(out: Path) -> int | None:
    """Return the bytes free for a file `out` that replaces an earlier one; None where that is unknown."""
    try:
        return shutil.disk_usage(out.parent).free + (out.stat().st_size if out.is_file() else 0)
    except OSError:
        return None


def rounded_bytes(size: float) -> str:
    """Write a size such as ``1.7 MB``."""
    return _in_units(size, {"TB": 1e12, "GB": 1e9, "MB": 1e6, "kB": 1e3}, 1.0)


def rounded_time(seconds: float) -> str:
    """Write a time such as ``1.7 s``, no less than 0.1 s."""
    return _in_units(max(seconds, 0.1), {"days": 86400.0, "hours": 3600.0, "minutes": 60.0, "s": 1.0}, 2.0)


def _in_units(value: float, units: dict[str, float], least: float) -> str:
    """Write a value with two digits, in the first of `units` of which it has at least `least`, or in the last one."""
    unit = next((unit for unit, factor in units.items() if value >= least * factor), list(units)[-1])
    amount = value / units[unit]
    return f"{amount:.2g} {unit}" if amount < 10.0 else f"{amount:.0f} {unit}"
