"""How far to trust the error bars: estimated errors against true ones, over two groups of cases.

    python benchmarks/calibrate_error_bars.py --processes 2         # everything, half an hour on two cores
    python benchmarks/calibrate_error_bars.py Hertz II              # the cases whose names begin so
    python benchmarks/calibrate_error_bars.py --into docs/error_bars.md

Prints Markdown, or puts it between the marks ``<!-- figures: calibration -->`` and ``<!-- end of figures -->`` of a
file and writes all comparisons at the end of a stage to ``data/error_bars.csv`` beside it. Compared are the values that
the load path does not impose and that are more than round-off, as run and corrected, at the ends of stages and, where
there is a fine run, at all increments; where an increment leaves a value as it is, as one of shear leaves the pressure,
it is compared once. The fine run is corrected for its own increments, too.
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from calibration_cases import CASES, CalibrationCase, corrected_run, knows_peak
from helpers import data_file, kept, outcomes, parser_of, report, write_csv
from random_scenes import scene_of, unseen_cases

from fretsolve.case.history import HISTORY_DIMENSIONS, LINE_DIMENSIONS
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import CORRECTED, CORRECTED_SUFFIX, Summary, SummaryErrors
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up

QUANTITIES = {
    **dict.fromkeys(("P", "Qx", "Qy"), "N"),
    **dict.fromkeys(("Mx", "My", "Mz"), "N mm"),
    **dict.fromkeys(("delta_z", "delta_x", "delta_y"), "mm"),
    **dict.fromkeys(("phi_x", "phi_y", "phi_z"), "rad"),
    **dict.fromkeys(("contact_radius", "stick_radius"), "mm"),
    "max_pressure": "MPa",
    "work_total": "mJ",
}
PER_LENGTH = {name for name in QUANTITIES if LINE_DIMENSIONS[name] != HISTORY_DIMENSIONS[name]}
"""Quantities that a line contact has per mm of its length."""


@dataclass(frozen=True)
class Row:
    """One comparison; errors in the quantity's units.

    end: whether it is made at the end of its stage; quantity: with the ending ``_corrected`` for corrected values;
    in_plane: whether the case is one of line contact.
    """

    case: str
    stage: int
    end: bool
    quantity: str
    value: float
    error: float
    bar: float
    in_plane: bool = False

    @property
    def corrected(self) -> bool:
        return self.quantity.endswith(CORRECTED_SUFFIX)

    @property
    def units(self) -> str:
        name = self.quantity.removesuffix(CORRECTED_SUFFIX)
        return f"{QUANTITIES[name]}/mm" if self.in_plane and name in PER_LENGTH else QUANTITIES[name]

    @property
    def inside(self) -> bool:
        return self.error <= self.bar

    @property
    def ratio(self) -> float:
        """Bar over true error."""
        return self.bar / self.error if self.error else math.inf

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the CSV file, without its group."""
        numbers = (f"{self.value:.5g}", f"{self.error:.1e}", f"{self.bar:.1e}", f"{self.ratio:.2g}")
        return (self.case, str(self.stage), self.quantity, self.units, *numbers)


@dataclass(frozen=True)
class Cost:
    """Share of the coarse runs in a case's seconds, and in its operator applications."""

    case: str
    time: float
    applications: float


def share(rows: Sequence[bool]) -> str:
    """Return how many of them, in per cent."""
    return f"{sum(rows)} of {len(rows)} ({100.0 * sum(rows) / len(rows):.0f} %)"


def report_lines(rows: Mapping[str, Sequence[Row]], costs: Sequence[Cost], unsolved: Sequence[str]) -> Iterator[str]:
    """Yield the lines of the page: shares by group, and by scene of the last one."""
    yield "| | " + " | ".join(rows) + " |"
    yield "| --- " * (1 + len(rows)) + "|"
    ends = {group: [row for row in part if row.end] for group, part in rows.items()}
    for kind in (False, True):
        for label, value in SHARES.items():
            of_kind = [[row for row in part if row.corrected == kind] for part in ends.values()]
            yield f"| {label}{', corrected values' if kind else ''} | " + " | ".join(map(value, of_kind)) + " |"
    for what, spent in spent_on(costs).items():
        yield from ("", f"Share of the coarse runs in all {what}: {spent}.")
    if unsolved:
        print(*unsolved, sep="\n", file=sys.stderr)
    *_, last = ends.values()
    yield from (
        "",
        "Cases with every value inside and median of bar over error, as run and corrected:",
        "",
        *by_scene(last),
    )


def percent(part: float) -> str:
    """Return a share in whole per cent."""
    return f"{100.0 * part:.0f} %"


def whole_cases(rows: Sequence[Row]) -> str:
    """Return how many cases have every value inside its bar."""
    names = dict.fromkeys(row.case for row in rows)
    return share([all(row.inside for row in rows if row.case == name) for name in names])


SHARES: dict[str, Callable[[Sequence[Row]], str]] = {
    "true error inside the bar": lambda rows: share([row.inside for row in rows]),
    "cases with every value inside its bar": whole_cases,
    "largest true error over its bar": lambda rows: f"{max(1.0 / row.ratio for row in rows):.2g}",
    "median of bar over true error": lambda rows: f"{statistics.median(row.ratio for row in rows):.2g}",
}


def spent_on(costs: Sequence[Cost]) -> dict[str, str]:
    """Return the shares of the coarse runs in operator applications and time."""
    kinds = {"operator applications": [one.applications for one in costs], "time": [one.time for one in costs]}
    return {
        what: f"{percent(statistics.median(spent))} in the median case, {percent(max(spent))} at most"
        for what, spent in kinds.items()
    }


def by_scene(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line per kind of scene."""
    for scene in sorted({scene_of(row.case) for row in rows}):
        kinds = [
            [row for row in rows if scene_of(row.case) == scene and row.corrected == kind] for kind in (False, True)
        ]
        if all(kinds):
            cases, ratios = (" and ".join(map(SHARES[label], kinds)) for label in BY_SCENE)
            yield f"- {scene}: {cases}, median {ratios}"


BY_SCENE = ("cases with every value inside its bar", "median of bar over true error")
"""Shares of each scene, as run and corrected."""


FREE_IN_PLANE = ("delta_x", "delta_y", "delta_z")
"""Displacements of a line contact, which have a free constant and are not compared."""

UNCHANGED = 1e-6
"""A value that changes with its error by less than this much of it is not compared again."""


def compare(case: CalibrationCase, truths: Path | None) -> tuple[list[Row], Cost]:
    """Run a case with error bars and without end, and compare where both are known; truths: folder that keeps these."""
    setup = set_up(case.case())
    rows = [(state.summary, state.errors) for state in run_with_error_bars(setup) if state.errors is not None]
    found = kept(truths, case.name, lambda: list(true_values(case, setup).items()))
    truth, nothing = dict(found), scales([summary for summary, _ in rows], setup)
    compared: list[Row] = []
    latest: dict[str, Row] = {}
    left_out = FREE_IN_PLANE if setup.model.line else ()
    for step in sorted(truth):
        exact = {name: value for name, value in truth[step].items() if name not in left_out}
        for found_row in step_rows(case.name, step in setup.load_path.last_steps, rows[step], exact, nothing):
            row = replace(found_row, in_plane=setup.model.line)
            if row.quantity not in latest or not same(latest[row.quantity], row):
                compared.append(row)
            latest[row.quantity] = row
    return compared, cost(case.name, rows)


def true_values(case: CalibrationCase, setup: ProblemSetup) -> dict[int, Mapping[str, float]]:
    """Return by increment the closed forms at the ends of stages, or the values of the fine run where it has them."""
    ends = setup.load_path.last_steps
    if case.exact is not None:
        return {ends[stage - 1]: values for stage, values in case.exact(setup.model.compliances).items()}
    fine = set_up(case.fine_case())
    path = corrected_run(fine)
    names = [name for name in QUANTITIES if name != "max_pressure" or knows_peak(fine)]
    values = {}
    for end, count, fine_end, fine_count in zip(
        ends, setup.load_path.counts, fine.load_path.last_steps, fine.load_path.counts, strict=True
    ):
        for back in range(count):
            row = path[fine_end - back * fine_count // count]
            values[end - back] = {name: float(row[name]) for name in names}
    return values


def scales(summaries: Sequence[Summary], setup: ProblemSetup) -> dict[str, float]:
    """Return what counts as 0: a thousandth of the load, displacement or moment that goes with a value.

    Of energies that is one of the largest, and 1e-9 of P delta_z. A line contact has no approach; p a/E* stands for it.
    """
    largest = {name: max(abs(float(getattr(row, name))) for row in summaries) for name in QUANTITIES}
    if math.isnan(largest["delta_z"]):
        modulus = setup.model.compliances.contact_modulus
        largest["delta_z"] = largest["max_pressure"] * largest["contact_radius"] / modulus
    force, moment = largest["P"], largest["P"] * largest["contact_radius"]
    turn = largest["delta_z"] / largest["contact_radius"]
    own = {"Qx": force, "Qy": force, "Mx": moment, "My": moment, "Mz": moment}
    own |= dict.fromkeys(("delta_x", "delta_y"), largest["delta_z"])
    own |= dict.fromkeys(("phi_x", "phi_y", "phi_z"), turn)
    own["work_total"] = max(largest["work_total"], 1e-6 * force * largest["delta_z"])
    return {name: 1e-3 * own.get(name, largest[name]) for name in QUANTITIES}


def step_rows(
    case: str, end: bool, row: tuple[Summary, SummaryErrors], truth: Mapping[str, float], nothing: Mapping[str, float]
) -> Iterator[Row]:
    """Return the comparisons after an increment."""
    summary, errors = row
    for name, exact in truth.items():
        value, bar = float(getattr(summary, name)), float(getattr(errors, f"{name}_error"))
        imposed = name in QUANTITIES and abs(value - exact) < 1e-5 * abs(exact) and bar < 1e-5 * abs(exact)
        if math.isinf(bar) or imposed or max(abs(value), abs(exact)) <= nothing[name]:
            continue
        yield Row(case, summary.stage, end, name, value, abs(value - exact), bar)
        if name in CORRECTED:
            name += CORRECTED_SUFFIX
            value, bar = float(getattr(errors, name)), float(getattr(errors, f"{name}_error"))
            yield Row(case, summary.stage, end, name, value, abs(value - exact), bar)


def same(one: Row, other: Row) -> bool:
    """Return whether a value was left as it was."""
    least = UNCHANGED * abs(one.value)
    return abs(one.error - other.error) < least and abs(one.value - other.value) < least


def cost(case: str, rows: Iterable[tuple[Summary, SummaryErrors]]) -> Cost:
    """Return what the coarse runs took of the whole."""
    own = [(summary.wall_time, summary.operator_applications) for summary, _ in rows]
    theirs = [(errors.coarse_runs_wall_time, errors.coarse_runs_applications) for _, errors in rows]
    time, work = (sum(column) for column in zip(*own, strict=True))
    their_time, their_work = (sum(column) for column in zip(*theirs, strict=True))
    return Cost(case, their_time / (time + their_time), their_work / (work + their_work))


def outcome(truths: Path | None, case: CalibrationCase) -> tuple[list[Row], Cost] | str:
    """Return the comparisons of a case and its costs, or why there are none."""
    try:
        found, spent = compare(case, truths)
    except NoSolutionError as error:
        return f"{case.name}: {error.message}"
    if any(math.isnan(row.bar) for row in found):
        return f"{case.name}: a coarse run has no solution"
    print(f"{case.name}: {sum(row.inside for row in found)} of {len(found)} inside", file=sys.stderr, flush=True)
    return found, spent


def measured(
    groups: Mapping[str, Iterable[CalibrationCase]], processes: int, truths: Path | None
) -> tuple[dict[str, list[Row]], list[Cost], list[str]]:
    """Compare the cases of each group. Return the comparisons, the costs, and the cases without a solution."""
    named = [(group, case) for group, cases in groups.items() for case in cases]
    rows: dict[str, list[Row]] = {group: [] for group in groups}
    costs: list[Cost] = []
    unsolved: list[str] = []
    all_found = outcomes(partial(outcome, truths), [case for _, case in named], processes)
    for (group, _), found in zip(named, all_found, strict=True):
        if isinstance(found, str):
            unsolved.append(found)
        else:
            rows[group].extend(found[0])
            costs.append(found[1])
    return rows, costs, unsolved


def write_comparisons(file: Path, rows: Mapping[str, Sequence[Row]]) -> None:
    """Write every comparison at the end of a stage."""
    headings = ("group", "case", "stage", "quantity", "unit", "found", "true_error", "bar", "bar_over_error")
    write_csv(file, headings, ((group, *row.cells) for group, part in rows.items() for row in part if row.end))


def main() -> None:
    """Read the arguments and print the report, or put it into a page."""
    parser = parser_of(__doc__)
    parser.add_argument("names", nargs="*", help="beginnings of the names of cases")
    parser.add_argument("--processes", type=int, default=1, help="number of cases that run at a time")
    parser.add_argument("--seed", type=int, nargs="+", default=[81, 82, 83], help="seeds of the unseen cases")
    parser.add_argument("--count", type=int, default=70, help="number of the cases of a seed")
    parser.add_argument("--truths", type=Path, metavar="FOLDER", help="keeps true values, to go on after a stop")
    asked = parser.parse_args()
    chosen = tuple(asked.names) or ("",)
    with TemporaryDirectory() as maps:
        groups = {
            "chosen by hand": [case for case in CASES if case.name.startswith(chosen)],
            "random": (
                case
                for seed in asked.seed
                for case in unseen_cases(seed, asked.count, Path(maps))
                if case.name.startswith(chosen)
            ),
        }
        rows, costs, unsolved = measured(groups, asked.processes, asked.truths)
    rows = {group: part for group, part in rows.items() if part}
    report({"calibration": lambda: print("\n".join(report_lines(rows, costs, unsolved)))}, asked.into)
    if asked.into:
        write_comparisons(data_file(asked.into, "error_bars"), rows)


if __name__ == "__main__":
    main()
