"""What each term of the model costs and buys: `coupling: none | tangential | full` beside one another.

    python benchmarks/terms.py                                  # tables, some five minutes on one core
    python benchmarks/terms.py --points 128                     # on a finer grid
    python benchmarks/terms.py --into docs/terms.md --picture docs/pictures/terms.png     # and data/terms.csv

A sphere on a flat between pairs of bodies with Dundurs' constants from 0 to 1/2, friction 0.1 to 0.6, in mode I (a
force of nine tenths of sliding, and a cycle), II (pressing) and III (a torque of nine tenths of sliding). The same grid
and increments with and without a term, so that the difference is the term's alone. Errors are relative to the value
with all terms, those of the stick radius to the contact radius, at the first peak of the load.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from marked import data_file, put_parts_into, write_csv

import fretsolve
from fretsolve.errors import NoSolutionError
from fretsolve.model.materials import Compliances
from fretsolve.model.term_errors import Drive, coupling_errors, cross_errors
from fretsolve.reference.closed_forms import full_slip_torque, hertz_sphere
from fretsolve.result.state import Summary
from fretsolve.setup.problem_setup import set_up

CASES = Path(__file__).resolve().parent.parent / "cases"

PAIRS = {
    "equal": ("{young_modulus: 210 GPa, poisson_ratio: 0.3}",) * 2,
    "two steels": (
        "{young_modulus: 206 GPa, poisson_ratio: 0.3}",
        "{young_modulus: 210 GPa, poisson_ratio: 0.3}",
    ),
    "titanium on steel": (
        "{young_modulus: 115 GPa, poisson_ratio: 0.33}",
        "{young_modulus: 210 GPa, poisson_ratio: 0.3}",
    ),
    "aluminium on steel": (
        "{young_modulus: 70 GPa, poisson_ratio: 0.34}",
        "{young_modulus: 210 GPa, poisson_ratio: 0.3}",
    ),
    "0.06 on 0.42": (
        "{young_modulus: 200 GPa, poisson_ratio: 0.06}",
        "{young_modulus: 200 GPa, poisson_ratio: 0.42}",
    ),
    "0.3 on rigid": ("{young_modulus: 210 GPa, poisson_ratio: 0.3}", "rigid"),
    "0.1 on rigid": ("{young_modulus: 210 GPa, poisson_ratio: 0.1}", "rigid"),
    "0 on rigid": ("{young_modulus: 210 GPa, poisson_ratio: 0}", "rigid"),
}
"""By name; figures are Poisson's ratios."""

FRICTIONS = (0.1, 0.3, 0.6)
MODES = {"I": "force", "II": "pressing", "III": "torque"}
COUPLINGS = ("none", "tangential", "full")
RADIUS, LOAD, PEAK, INCREMENTS = 10.0, 400.0, 0.9, 10
SIZE = 2.8
"""Sides of the grid in contact radii: shear shifts the contact of strongly dissimilar bodies."""

POINTS = 64
RATIOS_OF_POISSON = (0.1, 0.2, 0.3, 0.4, 0.5)
OF_PRESSING = ("delta_z", "contact_radius")
"""Compared in mode II, with which the others begin: a force or a torque after it makes their errors smaller."""

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
        """At the first peak."""
        return float(getattr(self.peak, name))


def path(mode: str, friction: float, torque: float) -> list[str]:
    """The stages: pressing, then in mode I a rise and a cycle, in mode III a rise."""
    force, torque = PEAK * friction * LOAD, PEAK * torque
    rest = {
        "I": [f"{{Qx: {force} N}}", f"{{Qx: {-force} N}}", f"{{Qx: {force} N}}"],
        "II": [],
        "III": [f"{{Mz: {torque} N*mm, Qx: 0 N, Qy: 0 N}}"],
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
        for stage in path(mode, friction, full_slip_torque(hertz, friction))
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


def motion_of(mode: str) -> str:
    """Return what the tangential load moves."""
    return {"I": "delta_x", "II": "", "III": "phi_z"}[mode]


def measured(less: Solved, full: Solved, name: str) -> float:
    """Error of a quantity at the first peak."""
    scale = full.peak.contact_radius if name == "stick_radius" else abs(full.value(name))
    return abs(less.value(name) - full.value(name)) / scale if scale else 0.0


@dataclass(frozen=True)
class Comparison:
    """A pair of runs, with and without the coupling: errors measured and expected, by quantity."""

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
    def errors(self) -> dict[str, tuple[float, float]]:
        """Measured and expected."""
        drive: Drive = MODES[self.mode]  # type: ignore[assignment]
        expected = coupling_errors(self.full.material, self.friction, drive, motion_of(self.mode))
        return {
            error.quantity: (measured(self.less, self.full, error.quantity), error.share)
            for error in expected
            if self.mode == "II" or error.quantity not in OF_PRESSING
        }


@cache
def comparisons(points: int) -> list[Comparison]:
    """All pairs, frictions and modes that have a solution with and without the coupling."""
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
    """For people."""
    return "0" if share < LEAST else f"{100 * share:.2g}" if share < 0.995 else f"{100 * share:.0f}"


def print_coupling(points: int) -> None:
    """Print the measured errors without the coefficients between pressure and shear, and what these cost."""
    print("| bodies | Dundurs | friction |", " | ".join(COLUMNS), "| applications (I, II, III) |")
    print("| --- " * (4 + len(COLUMNS)) + "|")
    found = {(one.pair, one.friction, one.mode): one for one in comparisons(points) if one.dundurs > 0.0}
    for pair, friction in dict.fromkeys(key[:2] for key in found):
        by_mode = {mode: found.get((pair, friction, mode)) for mode in MODES}
        cells = [
            ", ".join(percent(one.errors[name][0]) if one else "-" for one in map(by_mode.get, modes))
            for name, modes in COLUMNS.values()
        ]
        known = [one for one in by_mode.values() if one]
        costs = " x, ".join(f"{one.full.applications / one.less.applications:.1f}" for one in known)
        dundurs = f"{known[0].full.material.dundurs_constant:.3g}"
        print(f"| {pair} | {dundurs} | {friction:g} |", " | ".join(cells), f"| {costs} x |")


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
    """Write the errors of all quantities, measured and expected, in per cent; and what the coupling costs."""
    both = [name for quantity in QUANTITIES for name in (quantity, f"{quantity}_expected")]
    rows = []
    for one in comparisons(points):
        errors = [one.errors.get(quantity) for quantity in QUANTITIES]
        cells = [cell for pair in errors for cell in (map(percent, pair) if pair else ("", ""))]
        costs = (one.full.applications / one.less.applications, one.full.seconds / one.less.seconds)
        dundurs = f"{one.full.material.dundurs_constant:.3g}"
        rows.append([one.mode, one.pair, dundurs, one.friction, *cells, *(f"{cost:.1f}" for cost in costs)])
    headings = ["mode", "bodies", "dundurs", "friction", *both, "applications_ratio", "seconds_ratio"]
    write_csv(file, headings, rows)


def print_law(points: int) -> None:
    """Return how far the expected errors hold."""
    print("| quantity | mode | cases | least expected/measured | median | largest | within a factor of two |")
    print("| --- " * 7 + "|")
    for mode in MODES:
        chosen = [one for one in comparisons(points) if one.mode == mode and one.dundurs > 0.0]
        for name in chosen[0].errors:
            pairs = [one.errors[name] for one in chosen]
            ratios = np.array([expected / found for found, expected in pairs if found > 10 * LEAST])
            if not ratios.size:
                continue
            within = np.mean((ratios >= 0.5) & (ratios <= 2.0))
            print(
                f"| {name} | {mode} | {ratios.size} | {ratios.min():.2f} | {np.median(ratios):.2f} | {ratios.max():.2f}"
                f" | {100 * within:.0f} % |"
            )


def print_cross(points: int) -> None:
    """Errors without ux from qy and uy from qx, between equal bodies."""
    print("| mode | Poisson's ratio | motion | stick_radius | work_total | applications | seconds |")
    print("| --- " * 7 + "|")
    for mode in ("I", "III"):
        for ratio in RATIOS_OF_POISSON:
            bodies = (f"{{young_modulus: 210 GPa, poisson_ratio: {ratio}}}",) * 2
            none, whole = (solved(bodies, 0.3, mode, coupling, points) for coupling in COUPLINGS[:2])
            assert none and whole, "equal bodies have a solution"
            drive: Drive = MODES[mode]  # type: ignore[assignment]
            expected = {e.quantity: e.share for e in cross_errors(whole.material, drive, motion_of(mode))}
            cells = []
            for name in (motion_of(mode), "stick_radius", "work_total"):
                known = f" ({percent(expected[name])})" if name in expected else ""
                cells.append(f"{percent(measured(none, whole, name))}{known}")
            cost = f"{whole.applications / none.applications:.2f} x | {whole.seconds / none.seconds:.2f} x"
            print(f"| {mode} | {ratio} |", " | ".join(cells), f"| {cost} |")


def print_automatic(points: int) -> None:
    """Cost of the three with the increments that `auto` takes."""
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
    """Return whether what was fitted to spheres says anything about other surfaces."""
    names = ("max_pressure", "delta_x", "stick_radius", "work_total")
    print("| surface | friction |", " | ".join(names), "|")
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
            cells = [
                f"{percent(errors[key][0])} ({percent(errors[key][1])})"
                for key in names
            ]
            print(f"| {name} | {friction:g} |", " | ".join(cells), "|")


def draw(points: int, file: Path) -> None:
    """Errors over Dundurs' constant by friction with the laws, and errors over the time saved."""
    from fretsolve.plots import canvas, rendered

    marks = {"I": ("o", "#0072B2"), "II": ("s", "#E69F00"), "III": ("^", "#009E73")}
    named = {"force": "I", "pressing": "II", "torque": "III"}
    with canvas(None, 1, 3, (3.7, 3.1)) as drawn:
        first, second, third = drawn.axes
        handles: list[Any] = []
        ratios = np.geomspace(4e-3, 6.0, 120)
        for mode, (marker, color) in marks.items():
            chosen = [one for one in comparisons(points) if one.mode == mode and one.dundurs > 0.0]
            style = {"linestyle": "", "marker": marker, "color": color, "markerfacecolor": "none"}
            x = [one.dundurs / one.friction for one in chosen]
            if mode != "II":
                first.plot(x, [100 * one.errors[motion_of(mode)][0] for one in chosen], **style)
                law = [100 * _law(ratio, named, mode) for ratio in ratios]
                first.plot(ratios, law, color=color, linestyle="-" if mode == "I" else "--")
            handles += second.plot(
                [one.dundurs * min(one.dundurs, 3.2 * one.friction) for one in chosen],
                [100 * one.errors["max_pressure"][0] for one in chosen],
                **style,
                label=f"mode {mode}",
            )
            saved = [100 * (1 - one.less.applications / one.full.applications) for one in chosen]
            worst = [100 * max(found for found, _ in one.errors.values()) for one in chosen]
            third.plot(saved, worst, **style)
        span = np.geomspace(1e-5, 0.3, 2)
        second.plot(span, 100 * span, color="0.3")
        first.set_xlabel("|Dundurs' constant| / friction")
        first.set_title("displacement, rotation")
        second.set_xlabel("m min(m, 3.2 mu), m = |Dundurs' constant|")
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


def _law(ratio: float, named: dict[str, str], mode: str) -> float:
    """The expected error of the motion for weak coupling, where the ratio alone decides."""
    from fretsolve.model.term_errors import MOTION

    drive = next(drive for drive, name in named.items() if name == mode)
    weak = 1e-3
    return MOTION[drive](weak, weak / ratio)


PARTS = {
    "coupling": print_coupling,
    "law": print_law,
    "cross": print_cross,
    "automatic": print_automatic,
    "elsewhere": print_elsewhere,
}


def main(words: Sequence[str] | None = None) -> None:
    """As the top of this file tells."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=POINTS)
    parser.add_argument("--into", type=Path)
    parser.add_argument("--picture", type=Path)
    asked = parser.parse_args(words)
    solved(PAIRS["0.06 on 0.42"], 0.1, "I", "full", asked.points)  # compiles, plans
    solved.cache_clear()
    parts = {name: lambda part=part: part(asked.points) for name, part in PARTS.items()}
    if asked.into:
        put_parts_into(asked.into, parts)
        write_coupling(data_file(asked.into, "terms"), asked.points)
    else:
        for name, part in parts.items():
            print(f"\n### {name}\n")
            part()
    if asked.picture:
        draw(asked.points, asked.picture)


if __name__ == "__main__":
    main()
