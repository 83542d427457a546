"""What automatic increments leave of the error that their number makes, over varied cases.

    python benchmarks/increments.py            # all cases, about five minutes on one core
    python benchmarks/increments.py II III     # those whose names begin so

Each case is run with `increments: auto`, with as many equal steps in each stage, and with eight times as many
increments as auto takes, spaced as those: what the first two differ from the last by is their error. All on 32 points
per side; the error of the cells is the same in all three. Errors are in per cent of the largest value on the path.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import fretsolve
from fretsolve.case.models import Case
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import Summary
from fretsolve.simulation.problem_setup import set_up

STEEL = {"young_modulus": 200e3, "poisson_ratio": 0.3}
SIMILAR = [STEEL, STEEL]
DISSIMILAR = [{"young_modulus": 200e3, "poisson_ratio": 0.06}, {"young_modulus": 200e3, "poisson_ratio": 0.42}]
"""Dundurs' constant 0.19."""
STEEL_ON_ALUMINIUM = [STEEL, {"young_modulus": 70e3, "poisson_ratio": 0.33}]
"""Dundurs' constant -0.13."""
RIGID_ON_SOFT = ["rigid", {"young_modulus": 70e3, "poisson_ratio": 0.1}]
"""Dundurs' constant -0.44."""

POINTS, FINER = 32, 8
QUANTITIES = ("work_total", "delta_x", "phi_z", "max_pressure", "stick_radius")

P, Q = {"P": 400.0}, {"Qx": 36.0}
CASES: dict[str, dict[str, Any]] = {
    "II, friction 0.05": {"bodies": DISSIMILAR, "friction": 0.05, "load_path": [P]},
    "II": {"bodies": DISSIMILAR, "load_path": [P]},
    "II, friction 0.15": {"bodies": DISSIMILAR, "friction": 0.15, "load_path": [P]},
    "II, steel on aluminium": {"bodies": STEEL_ON_ALUMINIUM, "load_path": [P]},
    "II, rigid on soft, friction 0.3": {"bodies": RIGID_ON_SOFT, "friction": 0.3, "load_path": [P]},
    "II, ellipsoid": {
        "bodies": DISSIMILAR,
        "surface": {"ellipsoid": {"radius_x": 10.0, "radius_y": 25.0}},
        "load_path": [P],
    },
    "II, and unloaded": {"bodies": DISSIMILAR, "load_path": [P, {"P": 100.0}]},
    "I.3": {"bodies": DISSIMILAR, "load_path": [P, Q]},
    "I.3, cycle": {"bodies": DISSIMILAR, "load_path": [P, Q, {"Qx": -36.0}, Q]},
    "I.3, friction 0.3": {"bodies": DISSIMILAR, "friction": 0.3, "load_path": [P, {"Qx": 90.0}]},
    "I.3, friction 0.5": {"bodies": DISSIMILAR, "friction": 0.5, "load_path": [P, {"Qx": 120.0}]},
    "I.3, rigid on soft, friction 0.3": {"bodies": RIGID_ON_SOFT, "friction": 0.3, "load_path": [P, {"Qx": 84.0}]},
    "I.3, driven by delta_x": {"bodies": DISSIMILAR, "load_path": [P, {"delta_x": 1e-3}, {"delta_x": -1e-3}]},
    "III.3": {"bodies": DISSIMILAR, "load_path": [P, {"Mz": 5.0}]},
    "P and Q together": {"bodies": SIMILAR, "load_path": [{"P": 400.0, "Qx": 20.0}, {"P": 300.0, "Qx": 26.0}]},
    "P and Q together, dissimilar": {"bodies": DISSIMILAR, "load_path": [{"P": 200.0}, {"P": 400.0, "Qx": 24.0}]},
    "P in between": {"bodies": SIMILAR, "load_path": [P, {"Qx": 20.0}, {"P": 300.0}, {"P": 500.0}]},
    "x, then y": {"bodies": SIMILAR, "load_path": [P, {"Qx": 24.0}, {"Qy": 28.0}]},
}


@dataclass(frozen=True)
class Outcome:
    """The ends of the stages of a run."""

    counts: tuple[int, ...]
    ends: list[Summary]

    def errors(self, reference: Outcome) -> dict[str, float]:
        """Return the worst error at the ends of stages by quantity, in parts of its largest value."""
        errors = {}
        for name in QUANTITIES:
            exact, found = ([getattr(row, name) for row in rows] for rows in (reference.ends, self.ends))
            largest = max(map(abs, exact))
            moved = largest > (1e-3 * max(row.delta_z for row in reference.ends) if name.startswith("delta") else 1e-6)
            if moved:
                errors[name] = max(abs(a - b) for a, b in zip(exact, found, strict=True)) / largest
        return errors


def setup_of(parts: dict[str, Any]) -> ProblemSetup:
    """Return the case on the benchmark's grid."""
    base = {"surface": {"sphere": {"radius": 10.0}}, "friction": 0.1, "grid": {"points": POINTS}}
    return set_up(Case.model_validate({**base, **parts}))


def outcome(setup: ProblemSetup, counts: Sequence[int] | None = None) -> Outcome:
    """Run a case, with other numbers of increments if they are given."""
    if counts is not None:
        setup = replace(setup, load_path=setup.load_path.with_counts(counts))
    rows = [state.summary for state in fretsolve.run(setup)]
    return Outcome(setup.load_path.counts, [rows[step] for step in setup.load_path.last_steps])


def with_equal_steps(parts: dict[str, Any], counts: Sequence[int]) -> dict[str, Any]:
    """Return the case with these numbers of equal steps."""
    path = [{**stage, "increments": count} for stage, count in zip(parts["load_path"], counts, strict=True)]
    return {**parts, "load_path": path}


def report(names: Sequence[str]) -> Iterator[str]:
    """Print a row per case: the errors with automatic increments, then with equal steps."""
    yield "| case | increments | " + " | ".join(QUANTITIES) + " |"
    yield "| --- " * (2 + len(QUANTITIES)) + "|"
    for name, parts in CASES.items():
        if names and not name.startswith(tuple(names)):
            continue
        setup = setup_of(parts)
        counts = setup.load_path.counts
        reference = outcome(setup, [FINER * count for count in counts])
        runs = (outcome(setup), outcome(setup_of(with_equal_steps(parts, counts))))
        errors = [run.errors(reference) for run in runs]
        cells = (
            ", ".join(f"{100 * error[quantity]:.2f}" for error in errors) if quantity in errors[0] else "-"
            for quantity in QUANTITIES
        )
        yield f"| {name} | {', '.join(map(str, counts))} | " + " | ".join(cells) + " |"


def print_table(names: Sequence[str] = ()) -> None:
    """Print the table of all cases, or of those whose names begin so."""
    for line in report(names):
        print(line, flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="beginnings of the names of cases")
    print_table(parser.parse_args().names)
