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
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fretsolve.case.dimensions import cell_counts
from fretsolve.case.history import SHEARING
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.errors import CaseError, KeyPath
from fretsolve.problem.model.grid import LARGE_GRID
from fretsolve.problem.model.required_terms import ModelPart
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.wear_forms import AnyWornCycle, worn_cycles
from fretsolve.system.environment import address_space

CELL_BYTES: dict[ModelPart, float] = {
    "normal problem": 115.0,
    "tangential problem": 110.0,
    "ux from qy, uy from qx": 20.0,
    "between pressure and shear": 110.0,
    "slip and dissipated energy": 75.0,
}
"""Of each part of the model: influence coefficients, padded spectra, work arrays of the solvers, states before and
after an increment, buffers of the result file. """

SINGLE = 0.75
"""Factor on the memory per cell in single precision."""

APPLICATIONS = 20
"""Applications per increment in the tangential problem, and in the normal problem where the normal load changes; half
as many in each where the pressure follows the shear."""


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
    cells, single = math.prod(setup.grid.shape), setup.case.solver.precision == "single"
    with_coarse = 1.0 + 0.4 * setup.case.solver.error_bars  # memory and time, over the run's alone
    increments, pressed = _increments(setup)
    # Applications, and what else takes as long, of each part over the whole path.
    model, coupling = setup.model, setup.model.terms.normal_tangential_coupling
    in_turn = model.has_shear and coupling
    counts: dict[ModelPart, float] = {
        "normal problem": APPLICATIONS // 2 * increments if in_turn else APPLICATIONS * pressed,
        "tangential problem": APPLICATIONS * increments * model.has_shear,
        "between pressure and shear": (APPLICATIONS // 2 if in_turn else 1) * increments * coupling,
    }
    applications = sum(counts.values())
    counts["normal problem"] += 2.5 * increments  # the certificate, with the gap
    counts["ux from qy, uy from qx"] = 0.45 * counts["tangential problem"]
    counts["slip and dissipated energy"] = 1.7 * increments
    solved, slowness = setup.share_of_cells, 1.0 if setup.compiled else 2.0
    # Mode I.3 takes as much within a factor of 2 on 32 x 32 to 2048 x 2048 points (`python benchmarks/bench_path.py`).
    per_application = slowness * (0.1e-3 + 0.033e-6 * solved * cells)
    kept_regions = 1.8 if cells <= LARGE_GRID else 1.0  # active regions that are kept
    cell_factor = (SINGLE if single else 1.0) * kept_regions * cells
    kept = [decision.part for decision in model.decisions if decision.kept]
    shares = {part: (cell_factor * CELL_BYTES[part], per_application * counts[part]) for part in kept}
    in_cells, seconds = map(sum, zip(*shares.values(), strict=True))
    output = setup.case.output
    bytes_of_fields = sum({"shear": 16, "slip": 16, "zone": 1}.get(name, 8) for name in output.fields)
    stored = bytes_of_fields * -(-increments // output.every) * cells * (0.5 if single else 1.0)
    process = 230e6 if setup.compiled else 170e6  # Python, libraries, and blocks of the transforms that stay in cache
    return Estimate(
        increments=increments,
        shares=shares,
        memory=process + in_cells * with_coarse,
        file=0.35 * stored + 300.0 * increments + 100e3,  # compressed, where the contact fills the grid
        applications=round(solved * applications * with_coarse),
        seconds=seconds * with_coarse,
        saved=in_cells * (1.0 / SINGLE - 1.0) * with_coarse if single else 0.0,
    )


def expected_increments(setup: ProblemSetup) -> int:
    """Return how many increments a run is likely to have: with wear fewer than the most that it may have."""
    return _increments(setup)[0]


def _increments(setup: ProblemSetup) -> tuple[int, int]:
    """Return how many increments are likely to be solved, and how many of them press or change the surfaces."""
    most = Counter(stage.wears.key for stage in setup.case.stages() if stage.wears is not None)
    shares = {key: min(max(counts.values()) / most[key], 1.0) for key, counts in _solved_cycles(setup).items()}
    solved = pressed = 0.0
    for stage, count in zip(setup.case.stages(), setup.load_path.counts, strict=True):
        cycle = stage.cycle or stage.wears
        solved += (weighed := count * (1.0 if cycle is None else shares.get(cycle.key, 1.0)))
        if stage.wears is not None or any(name not in SHEARING and name != "friction" for name, _ in stage.targets):
            pressed += weighed
    return max(1, round(solved)), round(pressed)


def _solved_cycles(setup: ProblemSetup) -> dict[KeyPath, dict[str, float]]:
    """Return of each cycle that stands for others about how many are solved, by each key that sets its jumps."""
    jumps = {stage.wears.key: stage.wears.jumps for stage in setup.case.stages() if stage.wears is not None}
    known = {cycle.key: cycle for cycle in worn_cycles(setup.closed_forms)} if jumps else {}
    return {key: _by_cause(one, known.get(key), setup.model.coupled) for key, one in jumps.items() if one is not None}


def _by_cause(jumps: WearJumps, cycle: AnyWornCycle | None, coupled: bool) -> dict[str, float]:
    """Return about how many cycles are solved because of each key. cycle: what closed forms say, None if nothing.

    coupled: whether pressure and shear change each other.
    """
    if jumps.jump is not None:
        return {"jump": jumps.represents / jumps.jump + 3.0}
    slow = 1.0 if cycle is None or cycle.slides else min(1.0, math.sqrt(0.1 * cycle.time))  # little wears below T = 10
    # Of solved cycles 13 to 38 were measured at a tolerance of 1 %, and 0.1 to 1.7 times the root of the tolerance.
    # Between dissimilar bodies a jump's error falls with its first power only.
    usual, per_tolerance = 25, 0.1 / jumps.tolerance if coupled else slow * 1.5 / math.sqrt(jumps.tolerance)
    found = {"represents": usual, "tolerance": per_tolerance}
    if cycle is not None and jumps.max_depth is not None:
        worn = 1.5 * cycle.depth_per_cycle * jumps.represents  # the deepest place, under Hertz's pressure
        if cycle.limit is not None and cycle.volume_at_first_rate > 0.0:
            worn *= min(1.0, cycle.limit.volume / cycle.volume_at_first_rate)
        found["max_depth"] = usual + worn / jumps.max_depth
    return {name: min(count, jumps.represents) for name, count in found.items()}


def too_many_cycles(setup: ProblemSetup) -> Iterator[tuple[KeyPath, float, int]]:
    """Yield the keys that have more cycles solved than are likely meant, about how many, and how many there may be."""
    most = Counter(stage.wears.key for stage in setup.case.stages() if stage.wears is not None)
    for key, counts in _solved_cycles(setup).items():
        name = max(counts, key=lambda one: counts[one])
        if counts[name] > 300 and name not in ("jump", "represents"):
            yield (*key, name), counts[name], most[key]


def memory_problem(setup: ProblemSetup, needed: float) -> CaseError | None:
    """Return the error of a grid that does not fit in this machine's memory; None if it does, or if unknown.

    needed: the `estimate` of its memory (bytes).
    """
    try:
        there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):
        return None
    cells = cell_counts(setup.grid.shape)
    reserved = needed + 350e6  # by libraries, which do not use it
    if reserved > (allowed := address_space()):
        return setup.case.source.problem(
            f"{cells} cells take about {rounded_bytes(reserved)} of address space, the limit (ulimit"
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
    if 0.1 * file > free:  # where the grid is several times as wide as the contact
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
    """Write a value with two digits, in the first of `units` in which it is at least `least`, else in the last unit."""
    unit = next((unit for unit, factor in units.items() if value >= least * factor), list(units)[-1])
    amount = value / units[unit]
    return f"{amount:.2g} {unit}" if amount < 10.0 else f"{amount:.0f} {unit}"
