"""Errors of the stick radius of like bodies, in cells, for kinds of paths of a shear force: against closed forms.

    python benchmarks/stick_edges.py [--into docs/verification.md]      # some minutes on one core
    python benchmarks/stick_edges.py --bars                             # how many error bars hold, a quarter of an hour

A force to the part f of mu P leaves the stick zone c = a sqrt(1 - f) in line contact, and a (1 - f)^(1/3) between
spheres. So does one that turns and goes on by twice that, as long as it stays below the largest one before.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from marked import parser_of, report

import fretsolve
from fretsolve.case.history import Summary
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.line import HertzLine
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.system.arrays import DoubleArray

Measure = Callable[[dict[str, object], int, Sequence[float], float], list[float]]
"""Errors at the turns of a case: its increments per stage, exact stick radii and side of a cell (mm)."""

Solved = Callable[[Sequence[float], int, Measure], Iterator[list[float]]]
"""Errors of a path on all grids of a contact."""

YOUNG_MODULUS, POISSON_RATIO = 200e3, 0.3
FRICTION, RADIUS, LINE_LOAD, LOAD = 0.3, 10.0, 100.0, 400.0
CELLS = (12, 15, 20, 33, 41, 80)
"""Cells per half-width of the line contacts."""
SPHERES = ((32, 0.74), (33, 0.74), (48, 0.7226), (64, 0.74), (64, 0.71))
"""Points per side and size (mm) of the grids of spheres, 12 to 25 cells per contact radius."""
INCREMENTS = (1, 5, 30)


@dataclass(frozen=True)
class Kind:
    """Paths of the same kind: shares of mu P at their turns, of which those from `first` on to `last` are looked at."""

    name: str
    paths: tuple[tuple[float, ...], ...]
    first: int
    last: int


KINDS = (
    Kind("first shear", ((0.3,), (0.6,), (0.8,)), 0, 0),
    Kind("to the opposite and back", ((0.6, -0.6, 0.6), (0.8, -0.8, 0.8)), 1, 2),
    Kind("growing by a sixth", ((0.3, -0.35, 0.41, -0.48),), 1, 3),
    Kind("falling by a tenth", ((0.6, -0.54, 0.48, -0.43),), 1, 3),
    Kind("falling by 4 %", ((0.6, -0.576, 0.553, -0.53),), 1, 3),
    Kind("after a larger one", ((0.8, -0.5, 0.5), (0.7, -0.3, 0.3)), 1, 2),
    Kind("about a mean, at the least", ((0.6, 0.0), (0.7, 0.35), (0.8, 0.2)), 1, 1),
    Kind("about a mean, at the most", ((0.6, 0.0, 0.6), (0.7, 0.35, 0.7), (0.8, 0.2, 0.8)), 2, 2),
)


def shares(path: Sequence[float]) -> Iterator[float]:
    """Yield what of mu P a first force would be that leaves the same stick zone, after each turn."""
    largest, before = 0.0, 0.0
    for force in path:
        yield abs(force) if abs(force) > largest else 0.5 * abs(force - before)
        largest, before = max(largest, abs(force)), force


def contact_modulus() -> float:
    """Return E* of the bodies (MPa)."""
    return 0.5 * YOUNG_MODULUS / (1.0 - POISSON_RATIO**2)


def line_errors(path: Sequence[float], increments: int, measured: Measure) -> Iterator[list[float]]:
    """Yield the errors at the turns of a line contact, as `measured`, grid by grid."""
    half_width = HertzLine(LINE_LOAD, RADIUS, contact_modulus()).half_width
    for cells in CELLS:
        side = half_width / cells
        points = 2 * math.ceil(1.3 * cells) + 1
        case = case_of({"cylinder": {"radius": RADIUS}}, LINE_LOAD, path, increments)
        case |= {"plane": "strain", "grid": {"points": points, "size": points * side}}
        exact = [half_width * math.sqrt(1.0 - share) for share in shares(path)]
        yield measured(case, increments, exact, side)


def sphere_errors(path: Sequence[float], increments: int, measured: Measure) -> Iterator[list[float]]:
    """Yield the errors at the turns of a sphere, as `measured`, grid by grid."""
    radius = hertz_sphere(LOAD, RADIUS, contact_modulus()).contact_radius
    for points, size in SPHERES:
        case = case_of({"sphere": {"radius": RADIUS}}, LOAD, path, increments)
        case |= {"coupling": "none", "grid": {"points": points, "size": size}}
        yield measured(case, increments, [radius * math.cbrt(1.0 - share) for share in shares(path)], size / points)


def case_of(surface: dict[str, object], load: float, path: Sequence[float], increments: int) -> dict[str, object]:
    """Return a case without its grid."""
    stages = [{"Qx": part * FRICTION * load, "increments": increments} for part in path]
    load_path = [{"P": load, "increments": 1}, *stages]
    steel = {"young_modulus": YOUNG_MODULUS, "poisson_ratio": POISSON_RATIO}
    return {"bodies": [steel, steel], "surface": surface, "friction": FRICTION, "load_path": load_path}


def errors(case: dict[str, object], increments: int, exact: Sequence[float], side: float) -> list[float]:
    """Return the errors of the stick radius at the turns, in cells of this side."""
    rows: list[Summary] = [state.summary for state in fretsolve.run(fretsolve.case_from_dict(case))]
    turns = rows[increments::increments]
    return [(row.stick_radius - radius) / side for row, radius in zip(turns, exact, strict=True)]


def errors_over_bars(case: dict[str, object], increments: int, exact: Sequence[float], side: float) -> list[float]:
    """Return the errors of the stick radius at the turns over their error bars."""
    states = list(run_with_error_bars(fretsolve.case_from_dict(case)))[increments::increments]
    return [
        (state.summary.stick_radius - radius) / state.errors.stick_radius_error
        for state, radius in zip(states, exact, strict=True)
        if state.errors is not None
    ]


def values_of(kind: Kind, solved: Solved, increments: int, measured: Measure) -> DoubleArray:
    """Return the sizes of the errors at the turns of a kind that are looked at."""
    found = [turns[kind.first : kind.last + 1] for path in kind.paths for turns in solved(path, increments, measured)]
    return np.abs(np.array(found)).ravel()


def bar_rows() -> Iterator[str]:
    """Yield how many bars of each kind hold, and the largest error over its bar."""
    yield "| force | bars | hold | largest error over its bar |"
    yield "| --- | --- | --- | --- |"
    for kind in KINDS:
        parts = [
            values_of(kind, solved, count, errors_over_bars)
            for solved in (line_errors, sphere_errors)
            for count in INCREMENTS
        ]
        sizes = np.concatenate(parts)
        yield f"| {kind.name} | {sizes.size} | {np.count_nonzero(sizes <= 1.0)} | {sizes.max():.2f} |"


def rows() -> Iterator[str]:
    """Yield the table: root mean square and largest error of each kind, by increments per stage."""
    heads = [f"{contact}, {count}" for contact in ("line", "sphere") for count in INCREMENTS]
    yield "| force | " + " | ".join(heads) + " |"
    yield "| --- " * (1 + len(heads)) + "|"
    for kind in KINDS:
        found = []
        for solved in (line_errors, sphere_errors):
            for count in INCREMENTS:
                sizes = values_of(kind, solved, count, errors)
                found.append(f"{np.sqrt(np.mean(sizes**2)):.3f} / {sizes.max():.2f}")
        yield f"| {kind.name} | " + " | ".join(found) + " |"


def main() -> None:
    """Print the table, or put it into a page."""
    parser = parser_of(__doc__)
    parser.add_argument("--bars", action="store_true", help="count the error bars that hold instead")
    options = parser.parse_args()
    if options.bars:
        for row in bar_rows():
            print(row, flush=True)
    else:
        report({"stick edges": lambda: print(*rows(), sep="\n", flush=True)}, options.into)


if __name__ == "__main__":
    main()
