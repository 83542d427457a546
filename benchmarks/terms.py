"""Print what each term of the model costs and buys: `coupling: none | tangential | full` beside one another.

    python benchmarks/terms.py                                  # tables, some five minutes on one core
    python benchmarks/terms.py --points 128                     # on a finer grid
    python benchmarks/terms.py --into docs/howto/grid_and_increments.md --picture docs/pictures/terms.png

A sphere on a flat between pairs of bodies with Dundurs' constants from 0 to 1/2, friction 0.1 to 0.6, in mode I (a
force of nine tenths of sliding, and a cycle), II (pressing) and III (a torque of nine tenths of sliding). The same grid
and increments with and without a term, so that the difference is the term's alone. Errors are relative to the value
with all terms, those of the stick radius to the contact radius, at the first peak of the load.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from helpers import data_file, parser_of, report, write_csv

import fretsolve
from fretsolve.errors import NoSolutionError
from fretsolve.problem.model.materials import Compliances
from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.tangential import gross_slip_torque
from fretsolve.result.state import Summary
from fretsolve.simulation.problem_setup import set_up

CASES = Path(__file__).resolve().parent.parent / "cases"

PAIRS = {
    "equal": ("{young_modulus: 210 GPa, poisson_ratio: 0.3}",) * 2,
    "two steels": ("{young_modulus: 206 GPa, poisson_ratio: 0.3}", "{young_modulus: 210 GPa, poisson_ratio: 0.3}"),
    "titanium on steel": (
        "{young_modulus: 115 GPa, poisson_ratio: 0.33}",
        "{young_modulus: 210 GPa, poisson_ratio: 0.3}",
    ),
    "aluminium on steel": (
        "{young_modulus: 70 GPa, poisson_ratio: 0.34}",
        "{young_modulus: 210 GPa, poisson_ratio: 0.3}",
    ),
    "0.06 on 0.42": ("{young_modulus: 200 GPa, poisson_ratio: 0.06}", "{young_modulus: 200 GPa, poisson_ratio: 0.42}"),
    "0.3 on rigid": ("{young_modulus: 210 GPa, poisson_ratio: 0.3}", "rigid"),
    "0.1 on rigid": ("{young_modulus: 210 GPa, poisson_ratio: 0.1}", "rigid"),
    "0 on rigid": ("{young_modulus: 210 GPa, poisson_ratio: 0}", "rigid"),
}
"""By name; figures are Poisson's ratios."""

FRICTIONS = (0.1, 0.3, 0.6)
MODES = {
    "I": ("max_pressure", "delta_x", "stick_radius", "work_total"),
    "II": ("delta_z", "contact_radius", "max_pressure", "stick_radius", "work_total"),
    "III": ("max_pressure", "phi_z", "stick_radius", "work_total"),
}
"""The quantities compared under a force, under pressing alone and under a torque. A force or a torque after pressing
makes the errors of `delta_z` and `contact_radius` smaller."""

MOTION = {"I": "delta_x", "III": "phi_z"}
COUPLINGS = ("none", "tangential", "full")
RADIUS, LOAD, PEAK, INCREMENTS = 10.0, 400.0, 0.9, 10
SIZE = 2.8
"""Sides of the grid in contact radii: shear shifts the contact of strongly dissimilar bodies."""

POINTS = 64
RATIOS_OF_POISSON = (0.1, 0.2, 0.3, 0.4, 0.5)
LEAST = 1e-5
"""Errors below this are none: the tolerance makes a tenth of it."""


@dataclass(frozen=True)
class Solved:
    """A run: the states at the first peak and at the end, and its cost."""

    material: Compliances
    peak: Summary
    end: Summary
    applications: int
    seconds: float

    def value(self, name: str) -> float:
        """Return a value at the first peak."""
        return float(getattr(self.peak, name))


def path(mode: str, friction: float, torque: float) -> list[str]:
    """Return the stages: pressing, then in mode I a rise and a cycle, in mode III a rise."""
    force, torque = PEAK * friction * LOAD, PEAK * torque
    rest = {
        "I": [f"{{Qx: {force} N}}", f"{{Qx: {-force} N}}", f"{{Qx: {force} N}}"],
        "II": [],
        "III": [f"{{Mz: {torque} N mm, Qx: 0 N, Qy: 0 N}}"],
    }[mode]
    return [f"{{P: {LOAD} N}}", *rest]


@cache
def solved(
    bodies: tuple[str, str],
    friction: float,
    mode: str,
    coupling: str,
    points: int,
    increments: str = str(INCREMENTS),
    surface: str = f"{{sphere: {{radius: {RADIUS} mm}}}}",
) -> Solved | None:
    """Run a case; None where it has no solution."""
    base = CASES / "mode1_dissimilar.yaml"
    fixed = [f"bodies=[{bodies[0]}, {bodies[1]}]", f"friction={friction}", f"coupling={coupling}", "expect=[]"]
    fixed += [f"surface={surface}", "output.fields=[]"]
    material = set_up(fretsolve.load_case(base, fixed)).model.compliances
    hertz = hertz_sphere(LOAD, RADIUS, material.contact_modulus)
    stages = [
        stage.replace("}", f", increments: {increments}}}")
        for stage in path(mode, friction, gross_slip_torque(hertz, friction))
    ]
    side = SIZE * hertz.contact_radius
    case = fretsolve.load_case(
        base, [*fixed, f"grid={{points: {points}, size: {side} mm}}", f"load_path=[{', '.join(stages)}]"]
    )
    setup, began = set_up(case), time.process_time()
    try:
        summaries = [state.summary for state in fretsolve.run(setup)]
    except NoSolutionError:
        return None
    ends = [summaries[step] for step in setup.load_path.last_steps]
    return Solved(
        material,
        ends[min(1, len(ends) - 1)],
        ends[-1],
        sum(summary.operator_applications for summary in summaries),
        time.process_time() - began,
    )


def measured(less: Solved, full: Solved, name: str) -> float:
    """Return the error of a quantity at the first peak."""
    scale = full.peak.contact_radius if name == "stick_radius" else abs(full.value(name))
    return abs(less.value(name) - full.value(name)) / scale if scale else 0.0


@dataclass(frozen=True)
class Comparison:
    """A pair of runs, with and without the coupling between pressure and shear."""

    pair: str
    friction: float
    mode: str
    less: Solved
    full: Solved

    @property
    def dundurs(self) -> float:
        """Dundurs' constant, positive."""
        return abs(self.full.material.dundurs_constant)

    @property
    def errors(self) -> dict[str, float]:
        """Errors without the coupling, by quantity."""
        return {name: measured(self.less, self.full, name) for name in MODES[self.mode]}


@cache
def comparisons(points: int) -> list[Comparison]:
    """Return all pairs, frictions and modes that have a solution with and without the coupling."""
    found = []
    for mode in MODES:
        for name, bodies in PAIRS.items():
            for friction in FRICTIONS:
                runs = [solved(bodies, friction, mode, coupling, points) for coupling in ("tangential", "full")]
                if runs[0] and runs[1]:
                    found.append(Comparison(name, friction, mode, runs[0], runs[1]))
                else:
                    print(f"\nno solution: {name}, friction {friction}, mode {mode}")
    return found


def percent(share: float) -> str:
    """Return a share in %, rounded."""
    return "0" if share < LEAST else f"{100 * share:.2g}" if share < 0.995 else f"{100 * share:.0f}"


def print_coupling(points: int) -> None:
    """Print the measured errors without the coefficients between pressure and shear, and what these cost."""
    print("| bodies | Dundurs | friction |", " | ".join(COLUMNS), "| applications, times (I, II, III) |")
    print("| --- " * (4 + len(COLUMNS)) + "|")
    found = {(one.pair, one.friction, one.mode): one for one in comparisons(points) if one.dundurs > 0.0}
    for pair, friction in dict.fromkeys(key[:2] for key in found):
        by_mode = {mode: found.get((pair, friction, mode)) for mode in MODES}
        cells = [
            ", ".join(percent(one.errors[name]) if one else "-" for one in map(by_mode.get, modes))
            for name, modes in COLUMNS.values()
        ]
        known = [one for one in by_mode.values() if one]
        costs = ", ".join(f"{one.full.applications / one.less.applications:.1f}" for one in known)
        dundurs = f"{known[0].full.material.dundurs_constant:.3g}"
        print(f"| {pair} | {dundurs} | {friction:g} |", " | ".join(cells), f"| {costs} |")


COLUMNS = {
    "pressure (II)": ("max_pressure", ("II",)),
    "delta_x (I)": ("delta_x", ("I",)),
    "phi_z (III)": ("phi_z", ("III",)),
    "stick radius (I, II, III)": ("stick_radius", ("I", "II", "III")),
    "energy (I, III)": ("work_total", ("I", "III")),
}
"""Columns of the page: a quantity, and the modes in which it is shown."""

QUANTITIES = ("delta_z", "contact_radius", "max_pressure", "delta_x", "phi_z", "stick_radius", "work_total")


def write_coupling(file: Path, points: int) -> None:
    """Write the errors of all quantities in per cent, and what the coupling costs."""
    rows = []
    for one in comparisons(points):
        cells = [percent(one.errors[name]) if name in one.errors else "" for name in QUANTITIES]
        costs = (one.full.applications / one.less.applications, one.full.seconds / one.less.seconds)
        dundurs = f"{one.full.material.dundurs_constant:.3g}"
        rows.append([one.mode, one.pair, dundurs, one.friction, *cells, *(f"{cost:.1f}" for cost in costs)])
    headings = ["mode", "bodies", "dundurs", "friction", *QUANTITIES, "applications_ratio", "seconds_ratio"]
    write_csv(file, headings, rows)


def print_cross(points: int) -> None:
    """Print the errors without ux from qy and uy from qx, between equal bodies."""
    print("| mode | Poisson's ratio | motion | stick_radius | work_total | applications, times | seconds, times |")
    print("| --- " * 7 + "|")
    for mode in ("I", "III"):
        for ratio in RATIOS_OF_POISSON:
            bodies = (f"{{young_modulus: 210 GPa, poisson_ratio: {ratio}}}",) * 2
            none, whole = (solved(bodies, 0.3, mode, coupling, points) for coupling in COUPLINGS[:2])
            assert none and whole, "equal bodies have a solution"
            cells = [percent(measured(none, whole, name)) for name in (MOTION[mode], "stick_radius", "work_total")]
            cost = f"{whole.applications / none.applications:.2f} | {whole.seconds / none.seconds:.2f}"
            print(f"| {mode} | {ratio} |", " | ".join(cells), f"| {cost} |")


def print_automatic(points: int) -> None:
    """Print the cost of the three with the increments that `auto` takes."""
    print("| bodies | mode | coupling | increments | applications | seconds |")
    print("| --- " * 6 + "|")
    for name in ("equal", "0.06 on 0.42"):
        for mode in MODES:
            for coupling in COUPLINGS:
                run = solved(PAIRS[name], 0.3, mode, coupling, points, "auto")
                if run:
                    count = run.end.step + 1
                    print(f"| {name} | {mode} | {coupling} | {count} | {run.applications} | {run.seconds:.2f} |")


ELSEWHERE = {
    "ellipsoid, 7 and 14 mm": "{ellipsoid: {radius_x: 7 mm, radius_y: 14 mm}}",
    "rounded punch": "{punch: {radius: 0.3 mm, edge_radius: 0.1 mm}}",
}


def print_elsewhere(points: int) -> None:
    """Print the errors without the coupling for other surfaces than spheres."""
    print("| surface | friction |", " | ".join(MODES["I"]), "|")
    print("| --- " * 6 + "|")
    for name, surface in ELSEWHERE.items():
        for friction in FRICTIONS:
            bodies = PAIRS["0.06 on 0.42"]
            runs = [
                solved(bodies, friction, "I", coupling, points, surface=surface) for coupling in ("tangential", "full")
            ]
            if not (runs[0] and runs[1]):
                print(f"| {name} | {friction} | no solution |")
                continue
            errors = Comparison(name, friction, "I", runs[0], runs[1]).errors
            print(f"| {name} | {friction:g} |", " | ".join(map(percent, errors.values())), "|")


def draw(points: int, file: Path) -> None:
    """Draw errors over Dundurs' constant by friction, and over the time saved."""
    from fretsolve.post.plots.canvas import canvas, rendered

    marks = {"I": ("o", "#0072B2"), "II": ("s", "#E69F00"), "III": ("^", "#009E73")}
    with canvas(None, 3, (3.7, 3.1)) as drawn:
        first, second, third = drawn.axes
        handles: list[Any] = []
        for mode, (marker, color) in marks.items():
            chosen = [one for one in comparisons(points) if one.mode == mode and one.dundurs > 0.0]
            style = {"linestyle": "", "marker": marker, "color": color, "markerfacecolor": "none"}
            if mode in MOTION:
                ratios = [one.dundurs / one.friction for one in chosen]
                first.plot(ratios, [100 * one.errors[MOTION[mode]] for one in chosen], **style)
            pressures = [100 * one.errors["max_pressure"] for one in chosen]
            handles += second.plot([one.dundurs for one in chosen], pressures, **style, label=f"mode {mode}")
            saved = [100 * (1 - one.less.applications / one.full.applications) for one in chosen]
            third.plot(saved, [100 * max(one.errors.values()) for one in chosen], **style)
        first.set_xlabel("|Dundurs' constant| / friction")
        first.set_title("displacement, rotation")
        second.set_xlabel("|Dundurs' constant|")
        second.set_title("largest pressure")
        third.set_xlabel("applications saved (%)")
        third.set_title("worst of the quantities")
        first.set_ylabel("error without the coupling (%)")
        for axes in (first, second):
            axes.set_xscale("log")
        for axes in drawn.axes:
            axes.set_yscale("log")
            axes.set_ylim(1e-4, 200.0)
        drawn.legend(handles, 3)
        file.write_bytes(rendered(drawn.figure, file.suffix[1:]))


PARTS = {"coupling": print_coupling, "cross": print_cross, "automatic": print_automatic, "elsewhere": print_elsewhere}


def main(words: Sequence[str] | None = None) -> None:
    """Read the arguments, and print the tables or put them into a page."""
    parser = parser_of(__doc__)
    parser.add_argument("--points", type=int, default=POINTS)
    parser.add_argument("--picture", type=Path)
    asked = parser.parse_args(words)
    solved(PAIRS["0.06 on 0.42"], 0.1, "I", "full", asked.points)  # compiles, plans
    solved.cache_clear()
    report({name: partial(part, asked.points) for name, part in PARTS.items()}, asked.into)
    if asked.into:
        write_coupling(data_file(asked.into, "terms"), asked.points)
    if asked.picture:
        draw(asked.points, asked.picture)


if __name__ == "__main__":
    main()
