"""Single against double precision: which tolerance holds, what differs, what is saved.

    python benchmarks/precision.py limits                  # cases and tolerances; some minutes
    python benchmarks/precision.py savings 256 512 1024    # memory of mode I.3 by grid

Both print a Markdown table. A tolerance holds where all increments are certified to it; what differs is measured
against the same case in double precision at the same tolerance, so that only the precision is told.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from bench_path import CASES, compile_kernels, peak_bytes

import fretsolve
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import State, Summary
from fretsolve.simulation.problem_setup import set_up

TOLERANCES = (1e-4, 1e-5, 1e-6)
"""The last is one that a case may not ask for in single precision."""

POINTS = 48

PATHS = {
    "sliding": "load_path=[{P: 400, increments: 2}, {Qx: 39.96, increments: 4}]",
    "tiny": "load_path=[{P: 400, increments: 2}, {Qx: 20, increments: 2}, {Qx: 20.0004, increments: 2}]",
    "slippery": "load_path=[{P: 400, increments: 4}, {Qx: 0.2, increments: 4}, {Qx: -0.2, increments: 4}]",
    "rough": "load_path=[{P: 400, increments: 4}, {Qx: 200, increments: 4}]",
}


@dataclass(frozen=True)
class Probe:
    """A case and what is changed in it."""

    name: str
    case: str
    overrides: tuple[str, ...] = ()


BETA_HALF = "bodies=[{young_modulus: 1e5, poisson_ratio: 0}, rigid]"

PROBES = (
    Probe("Hertz", "hertz"),
    Probe("mode I.1", "mode1_similar_uncoupled"),
    Probe("mode I.2", "mode1_similar"),
    Probe("mode I.3", "mode1_dissimilar"),
    Probe("mode I.3, 40 increments of Q", "mode1_dissimilar", ("load_path=[{P: 400}, {Qx: 36, increments: 40}]",)),
    Probe("mode II", "mode2_dissimilar"),
    Probe("mode III", "mode3_dissimilar"),
    Probe("gross slip", "gross_slip"),
    Probe("mode I.3, friction 1e-3", "mode1_dissimilar", ("friction=1e-3", PATHS["slippery"])),
    Probe("mode I.3, friction 1", "mode1_dissimilar", ("friction=1", PATHS["rough"])),
    Probe("mode I.2 up to 0.999 mu P", "mode1_similar", (PATHS["sliding"],)),
    Probe("mode I.3 up to 0.999 mu P", "mode1_dissimilar", (PATHS["sliding"],)),
    Probe("mode I.2, Q changed by 1e-6 P", "mode1_similar", (PATHS["tiny"],)),
    Probe("mode I.3, Q changed by 1e-6 P", "mode1_dissimilar", (PATHS["tiny"],)),
    Probe("mode II on a rigid body, beta 1/2", "mode2_dissimilar", (BETA_HALF,)),
    Probe("tilted punch, moments", "tilted"),
)


def setup_of(probe: Probe, points: int, precision: str, tolerance: float) -> ProblemSetup:
    """Return the case on `points` by `points` cells; the tolerance may be one that a case file may not ask for."""
    overrides = ["expect=[]", f"grid.points={points}", *probe.overrides]
    setup = set_up(fretsolve.load_case(CASES / f"{probe.case}.yaml", overrides))
    settings = setup.case.solver.model_copy(update={"precision": precision, "tolerance": tolerance})
    return replace(setup, case=setup.case.model_copy(update={"solver": settings}))


def history_of(setup: ProblemSetup) -> list[Summary]:
    """Return the history of the path, up to where it fails."""
    history: list[Summary] = []
    with suppress(NoSolutionError):
        history.extend(state.summary for state in fretsolve.run(setup))
    return history


def difference(one: Sequence[Summary], other: Sequence[Summary]) -> float:
    """Return the largest difference over its scale: of displacements the largest one, of radii the contact's."""

    def column(rows: Sequence[Summary], name: str) -> np.ndarray:
        return np.array([getattr(row, name) for row in rows])

    radius, pressure, work = (
        float(np.abs(column(other, name)).max()) for name in ("contact_radius", "max_pressure", "work_total")
    )
    displacement = max(float(np.abs(column(other, name)).max()) for name in ("delta_z", "delta_x"))
    scales = {"delta_z": displacement, "delta_x": displacement, "phi_z": displacement / radius}
    scales |= {"contact_radius": radius, "stick_radius": radius, "max_pressure": pressure, "work_total": work}
    return max(
        float(np.abs(column(one, name) - column(other, name)).max()) / scale for name, scale in scales.items() if scale
    )


def print_limits() -> None:
    """Print the largest difference from double precision, at each tolerance that is certified."""
    print("| case | increments |", " | ".join(f"tolerance {tolerance:.0e}" for tolerance in TOLERANCES), "|")
    print("| --- " * (2 + len(TOLERANCES)) + "|")
    for probe in PROBES:
        told = []
        for tolerance in TOLERANCES:
            double, single = (history_of(setup_of(probe, POINTS, name, tolerance)) for name in ("double", "single"))
            failed = f"not from increment {len(single)} on"
            told.append(f"{difference(single, double):.0e}" if len(single) == len(double) else failed)
        print(f"| {probe.name} | {len(double)} |", " | ".join(told), "|", flush=True)


def measured(points: int, precision: str) -> tuple[float, float]:
    """Return peak bytes per cell, and bytes per cell of a state, of mode I.3."""
    command = [sys.executable, __file__, "--measure", str(points), precision]
    output = subprocess.run(command, capture_output=True, check=True).stdout.split()
    return float(output[0]), float(output[1])


def measure(points: int, precision: str) -> None:
    """Print what `measured` asks its process for: of two increments of P and two of Q."""
    compile_kernels()
    path = "load_path=[{P: 400, increments: 2}, {Qx: 36, increments: 10}]"
    probe = Probe("", "mode1_dissimilar", ("grid.size=0.9", path))
    before = peak_bytes()
    (state,) = deque(islice(fretsolve.run(setup_of(probe, points, precision, 1e-4)), 4), maxlen=1)
    print((peak_bytes() - before) / points**2, size_of(state) / points**2)


def size_of(state: State) -> int:
    """Return the bytes of the arrays of a state."""
    arrays = (*vars(state.fields).values(), state.displacement)
    return sum(array.nbytes for array in arrays if array is not None)


def print_savings(grids: Sequence[int]) -> None:
    """Print the memory of mode I.3."""
    print("| points | precision | peak memory, bytes per cell | fields of a state, bytes per cell |")
    print("| --- | --- | --- | --- |")
    for points in grids:
        for precision in ("double", "single"):
            memory, fields = measured(points, precision)
            print(f"| {points} | {precision} | {memory:.0f} | {fields:.0f} |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", nargs="?", choices=("limits", "savings"))
    parser.add_argument("points", nargs="*", type=int, default=[512, 1024, 2048])
    parser.add_argument("--measure", nargs=2, metavar=("POINTS", "PRECISION"), help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.measure:
        measure(int(asked.measure[0]), asked.measure[1])
    elif asked.table == "limits":
        print_limits()
    else:
        print_savings(asked.points)
