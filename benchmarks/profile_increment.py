"""Print where the time of one coupled increment goes: ``python benchmarks/profile_increment.py [POINTS ..]``.

Mode I.3 of the base case on 0.9 mm, increments 31 to 35 (from B on towards C), by the part of the package that spends
it. Time in functions of NumPy and FFTW counts for the part that calls them; elastic operator and preconditioner share
their convolutions in proportion to the time of their calls. The profiler itself adds about a tenth.
"""

from __future__ import annotations

import cProfile
import pstats
import sys
from collections import defaultdict
from pathlib import Path

from bench_path import JOBS, compile_kernels, setup_of
from work_unit import kernels_in_use

import fretsolve

FIRST, LAST = 31, 35

TRANSFORMS = "elastic operator: transforms"
PRODUCTS = "elastic operator: products with the influence spectra"
PRECONDITIONER = "preconditioner"

PARTS = {
    TRANSFORMS: (
        "convolution",
        "batched_convolution",
        "operator",
        "thread_team",
        "incremental_update",
        "spectral_numpy",
        "spectral_numba",
    ),
    PRODUCTS: (),
    PRECONDITIONER: ("preconditioner",),
    "conjugate gradients": ("projected_cg", "workspace", "cg_numpy", "cg_numba"),
    "slip law and balance": ("tangential", "rigid_modes", "friction_numpy", "friction_numba"),
    "normal problem": ("normal", "normal_numpy", "normal_numba"),
    "first estimates, active region, staggered iteration": (
        "staggered_iteration",
        "anderson",
        "increment",
        "grid_hierarchy",
        "grid_transfer",
        "active_region",
        "working_state",
        "load_checks",
        "failure_reasons",
        "limit_load",
        "load_path",
    ),
    "coupled Newton": ("coupled_step", "coupled_newton", "coupled_equations", "gmres"),
    "certificate and state": (
        "certificate",
        "simulation",
        "slip_and_work",
        "zone_edges",
        "edge_shares",
        "cell_front",
        "zone_areas",
        "zone_extents",
        "state",
    ),
    "influence coefficients": ("influence",),
}
"""Modules of the package by part, named by their stems."""

Function = tuple[str, int, str]


def profile(points: int) -> tuple[pstats.Stats, int]:
    """Profile the chosen increments; return their number too."""
    profiler, count = cProfile.Profile(), 0
    for step, _ in enumerate(fretsolve.run(setup_of(JOBS[3], points))):
        if step == FIRST - 1:
            profiler.enable()
        elif step >= FIRST:
            count += 1
        if step == LAST:
            profiler.disable()
            break
    return pstats.Stats(profiler), count


def by_part(stats: pstats.Stats) -> dict[str, float]:
    """Return the seconds of each part; a function outside of the package counts for its callers."""
    package = Path(fretsolve.__file__).parent
    part_of_module = {module: part for part, modules in PARTS.items() for module in modules}
    seconds: dict[str, float] = defaultdict(float)

    def share(function: Function, time: float, depth: int) -> None:
        file = Path(function[0])
        if package in file.parents:
            product = file.stem.startswith(("spectral", "batched")) and "multiply" in function[2]
            seconds[PRODUCTS if product else part_of_module.get(file.stem, "other")] += time
            return
        callers = stats.stats[function][4]
        whole = sum(entry[2] for entry in callers.values())
        if depth == 0 or not callers or whole == 0.0:
            seconds["other"] += time
            return
        for caller, entry in callers.items():
            share(caller, time * entry[2] / whole, depth - 1)

    for function, (_, _, own, _, _) in stats.stats.items():
        share(function, own, 6)
    inverse = share_of_inverse(stats)
    for part in (TRANSFORMS, PRODUCTS):
        seconds[PRECONDITIONER] += inverse * seconds[part]
        seconds[part] *= 1.0 - inverse
    return seconds


def share_of_inverse(stats: pstats.Stats) -> float:
    """Return the share of the preconditioner in the time of all convolutions."""
    times: dict[str, float] = defaultdict(float)
    for function, (*_, callers) in stats.stats.items():
        if Path(function[0]).stem == "convolution" and function[2] in ("apply", "apply_in_plane"):
            for caller, entry in callers.items():
                times[Path(caller[0]).stem] += entry[3]
    times.pop("convolution", None)
    return times["preconditioner"] / sum(times.values())


def print_table(grids: list[int]) -> None:
    """Print the shares of the parts on each grid."""
    compile_kernels()
    found = {}
    for points in grids:
        stats, count = profile(points)
        found[points] = {part: value / count for part, value in by_part(stats).items()}
    print(f"pointwise kernels: {'compiled' if kernels_in_use().compiled else 'NumPy'}\n")
    print("| share of the time, % |", " | ".join(f"{points} x {points}" for points in grids), "|")
    print("| --- " * (1 + len(grids)) + "|")
    for part in (*PARTS, "other"):
        shares = (found[points].get(part, 0.0) / sum(found[points].values()) for points in grids)
        print(f"| {part} |", " | ".join(f"{100 * value:.0f}" for value in shares), "|")
    print("| an increment, s |", " | ".join(f"{sum(found[points].values()):.3g}" for points in grids), "|")


if __name__ == "__main__":
    print_table([int(argument) for argument in sys.argv[1:]] or [256, 1024])
