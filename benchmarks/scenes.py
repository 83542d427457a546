"""What each kind of case costs beside the full model: applications, time and memory.

    python benchmarks/scenes.py                     # a table, some minutes on one core
    python benchmarks/scenes.py --into docs/performance.md

The full model is `coupling: full` with friction 0.1: everything that a case may need. Both get the same grid and
increments. Seconds are those of the processor, on 256 x 256 cells; memory is the peak of a process of its own on
768 x 768 cells, per cell, beyond what the interpreter and its libraries take for a small grid.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections import deque
from dataclasses import dataclass
from pathlib import Path

from bench_path import peak_bytes
from helpers import parser_of, report

import fretsolve
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.simulation.problem_setup import set_up

CASES = Path(__file__).resolve().parent.parent / "cases"
PAPER = "bodies=[{young_modulus: 200 GPa, poisson_ratio: 0.06}, {young_modulus: 200 GPa, poisson_ratio: 0.42}]"
NO_POISSON = "bodies=[{young_modulus: 200 GPa, poisson_ratio: 0}, {young_modulus: 200 GPa, poisson_ratio: 0}]"
PRESSED = "load_path=[{P: 400 N, increments: 4}]"
PULLED = "load_path=[{P: 400 N, increments: 1}, {Qx: 36 N, increments: 4}]"
TWISTED = "load_path=[{P: 400 N, increments: 1}, {Mz: 5 N mm, Qx: 0 N, Qy: 0 N, increments: 4}]"
CYCLED = (
    "load_path=[{P: 400 N, increments: 1}, {Qx: 20 N, increments: 2},"
    " {cycle: {times: 3, stages: [{Qx: -20 N, increments: 2}, {Qx: 20 N, increments: 2}]}}]"
)
SCENES: dict[str, tuple[str, ...]] = {
    "frictionless": ("friction=0", PRESSED),
    "pressed, equal bodies": (PRESSED,),
    "frictionless, dissimilar bodies, slip stored": ("friction=0", PAPER, "output.fields=[slip]", PRESSED),
    "force, Poisson's ratio 0": (NO_POISSON, PULLED),
    "force, equal bodies": (PULLED,),
    "torque, equal bodies": (TWISTED,),
    "cycles at constant P, equal bodies": (CYCLED,),
    "pressed, dissimilar bodies": (PAPER, PRESSED),
    "force, dissimilar bodies": (PAPER, PULLED),
    "contact an eighth of the grid, dissimilar bodies": (PAPER, PULLED, "grid.size=4.8 mm"),
}
FULL = ("coupling=full", "friction=0.1")
POINTS, SMALL, LARGE = 256, 32, 768


@dataclass(frozen=True)
class Cost:
    """Of a run."""

    applications: int
    seconds: float


def setup_of(name: str, full: bool, points: int) -> ProblemSetup:
    """Return a case, or the same with the full model."""
    sets = ("expect=[]", "output.fields=[]", *SCENES[name], *(FULL if full else ()), f"grid.points={points}")
    return set_up(fretsolve.load_case(CASES / "mode1_similar.yaml", sets))


def cost(name: str, full: bool) -> Cost:
    """Return the cost of the whole path, once kernels are compiled and plans are made."""
    for _ in range(2):
        setup, began = setup_of(name, full, POINTS), time.process_time()
        applications = sum(state.summary.operator_applications for state in fretsolve.run(setup))
        seconds = time.process_time() - began
    return Cost(applications, seconds)


def bytes_per_cell(name: str, full: bool) -> float:
    """Return the memory of a run, in a process of its own."""
    words = [sys.executable, __file__, "--memory", name, str(int(full))]
    return float(subprocess.run(words, capture_output=True, check=True).stdout)


def print_bytes_per_cell(name: str, full: bool) -> None:
    """Return what `bytes_per_cell` asks its process for; two increments per stage need all that there is."""
    peaks = []
    for points in (SMALL, LARGE):
        case = setup_of(name, full, points).case
        stages = [stage.model_copy(update={"increments": min(stage.increments, 2)}) for stage in case.load_path[:2]]
        deque(fretsolve.run(case.model_copy(update={"load_path": tuple(stages)})), maxlen=0)
        peaks.append(peak_bytes())
    print((peaks[1] - peaks[0]) / LARGE**2)


def print_scenes() -> None:
    """Print the table of the scenes."""
    print("| case | kept | applications | full | seconds | full | bytes per cell | full |")
    print("| --- " * 8 + "|")
    for name in SCENES:
        least, full = cost(name, False), cost(name, True)
        memory = [f"{bytes_per_cell(name, whole):.0f}" for whole in (False, True)]
        decisions = setup_of(name, False, 16).model.decisions
        kept = ", ".join(KEPT[decision.part] for decision in decisions if decision.kept and decision.part in KEPT)
        print(
            f"| {name} | {kept} | {least.applications} | {full.applications} | {least.seconds:.2f} |"
            f" {full.seconds:.2f} | {memory[0]} | {memory[1]} |",
            flush=True,
        )


KEPT = {
    "normal problem": "p",
    "tangential problem": "q",
    "ux from qy, uy from qx": "in-plane",
    "between pressure and shear": "coupling",
    "slip and dissipated energy": "slip",
}
"""Short names of the parts."""


def main() -> None:
    """Read the arguments and print what they name."""
    parser = parser_of(__doc__)
    parser.add_argument("--memory", nargs=2, metavar=("SCENE", "FULL"), help="print the bytes per cell of one run")
    asked = parser.parse_args()
    if asked.memory:
        name, full = asked.memory
        print_bytes_per_cell(name, full == "1")
    else:
        report({"scenes": print_scenes}, asked.into)


if __name__ == "__main__":
    main()
