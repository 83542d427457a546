"""Whether an accuracy that is asked for is met: by the run's own error bars, and by the true error; and what it costs.

    python benchmarks/accuracy.py --processes 2 # all cases, an hour and a half on one core
    python benchmarks/accuracy.py 14- closed    # those whose names begin so: the unseen ones
    python benchmarks/accuracy.py --into docs/howto/grid_and_increments.md    # writes docs/data/*accuracy*.csv

The cases are those of the error bars (`calibration_cases`, and unseen ones that `random_cases` draws), and unseen ones
with closed forms (`random_closed_forms`), without their points and increments, which the accuracy picks. Errors are
those of the corrected values where there are any. True ones are against closed forms where these are exact, and else
against a finer run: twice the points per side of `standard` and four times the automatic increments, or twice those of
`standard`, corrected for what is left of their error. Cases that would take more than 512 x 512 cells have no truth,
and are named. Such a run is not exact enough for the accuracies `reference` and 0.1 %. They are measured on the closed
forms, and `reference`, by its own error bars alone, on a few other cases. Left out is the largest pressure where its
bar has no bound, as that of a cone. The cost is cells times increments, with the coarse runs, relative to settings by
hand: 128 x 128 cells with 10 increments per stage, 40 where the slip depends on the path.
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from calibration_cases import CASES, SIMILAR, SPHERE, CalibrationCase, corrected_run, knows_peak, random_closed_forms
from helpers import data_file, kept, outcomes, parser_of, report, write_csv
from random_cases import random_cases

from fretsolve.case.dimensions import percent
from fretsolve.case.models import Case
from fretsolve.errors import NoSolutionError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import State
from fretsolve.result.verdict import JUDGED_QUANTITIES, Verdict, best_column, scales, verdict
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars
from fretsolve.simulation.problem_setup import set_up

KNOWN, UNSEEN, CLOSED_FORMS = "known", "unseen", "unseen closed forms"
LEVELS = ("draft", "standard", "reference", "0.1 %")
FINE_LEVELS = LEVELS[2:]
JUDGED_BY_RUNS = "standard"
"""The finest of the levels whose truth is a finer run."""

FINER_POINTS, MOST_CELLS, FINER_INCREMENTS = 2, 512**2, 4
HAND_POINTS, HAND_INCREMENTS, HAND_PATH_INCREMENTS = 128, 10, 40
COARSE_RUNS = 1.33
"""Cost of a run with its coarse runs."""

LEFT_OUT = ("Hertz, 45", "Hertz, 96", "Hertz, 52", "I.3, 10", "I.3, 20", "I.3, 8", "punch, rounded")
"""Cases that differ from others by points or increments alone, and one whose edge needs hundreds of points."""

REFERENCE_TOO = ("I.2, cycle", "I.3, 5 increments", "III.3", "x, then y")
"""Cases without a closed form that are run to `reference` all the same, as far as their own error bars."""


@dataclass(frozen=True)
class Row:
    """A case run with an accuracy.

    error: the worst true one in parts of its scale, NaN where it is not known; cost: against settings by hand.
    """

    group: str
    case: str
    level: str
    points: tuple[int, int]
    increments: int
    verdict: Verdict
    error: float
    worst: str
    cost: float

    @property
    def true(self) -> bool:
        """Whether the accuracy is met by the true error, as far as that is known."""
        return self.error <= self.verdict.accuracy

    @property
    def false(self) -> bool:
        """Whether it is known not to be."""
        return self.error > self.verdict.accuracy

    @property
    def judged(self) -> bool:
        """Whether a truth is known."""
        return self.true or self.false

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the CSV file; what is not known is left empty."""
        nx, ny = self.points
        bar = (_number(self.verdict.worst), self.verdict.quantity, "yes" if self.verdict.met else "no")
        error = (_number(self.error), self.worst, "yes" if self.true else "no")
        truth = ("", "", "") if math.isnan(self.error) else error
        return (
            self.group,
            self.case,
            self.level,
            f"{nx} x {ny}",
            str(self.increments),
            *bar,
            *truth,
            f"{self.cost:.2g}",
        )

    def line(self) -> str:
        """Return the row of the page's table."""
        bar, error = f"{percent(self.verdict.worst)} ({self.verdict.quantity})", f"{percent(self.error)} ({self.worst})"
        return f"| {self.case} | {self.level} | {bar} | {error} |"


def _number(part: float) -> str:
    """Return an error in per cent, without the sign."""
    return percent(part).removesuffix(" %")


def case_of(case: CalibrationCase, **parts: Any) -> Case:
    """Return the case without its points and increments."""
    whole = {"bodies": SIMILAR, "surface": SPHERE, "friction": 0.1, **case.parts}
    grid = {name: value for name, value in whole["grid"].items() if name != "points"} | parts.pop("grid", {})
    path = [without_increments(stage) for stage in whole["load_path"]]
    return Case.model_validate({**whole, "grid": grid, "load_path": path, **parts})


def without_increments(stage: Mapping[str, Any]) -> dict[str, Any]:
    """Return a stage or a cycle of stages without numbers of increments."""
    if "cycle" in stage:
        cycle = stage["cycle"]
        return {"cycle": {**cycle, "stages": [without_increments(part) for part in cycle["stages"]]}}
    return {name: value for name, value in stage.items() if name not in ("increments", "spacing")}


Ends = list[Mapping[str, float]]


def true_ends(case: CalibrationCase) -> Ends:
    """Return the values at the ends of the stages; none where they would take too many cells."""
    finest = set_up(case_of(case, solver={"accuracy": JUDGED_BY_RUNS}))
    if case.exact is not None:
        known = case.exact(finest.model.compliances)
        return [known.get(stage, {}) for stage in range(1, len(finest.load_path.counts) + 1)]
    points = [FINER_POINTS * count for count in finest.grid.shape]
    if math.prod(points) > MOST_CELLS:
        return []
    fine = set_up(case_of(case, grid={"points": points}))
    if fine.load_path.path_dependent:
        pairs = zip(fine.load_path.counts, finest.load_path.counts, strict=True)
        counts = [max(FINER_INCREMENTS * count, 2 * judged) for count, judged in pairs]
        fine = replace(fine, load_path=fine.load_path.with_counts(counts))
    rows = corrected_run(fine)
    names = [name for name in JUDGED_QUANTITIES if name != "max_pressure" or knows_peak(fine)]
    return [{name: float(rows[step][name]) for name in names} for step in fine.load_path.last_steps]


def measured(group: str, case: CalibrationCase, level: str, truth: Ends) -> Row:
    """Run a case with an accuracy and compare with the reference, if there is one."""
    setup = set_up(case_of(case, solver={"accuracy": level}))
    rows = list(run_with_error_bars(setup))
    history = history_of(rows)
    reached = verdict(vars(setup.case.solver), history)
    assert reached is not None
    ends = np.array(setup.load_path.last_steps)
    error, worst = 0.0 if truth else math.nan, "-"
    for name, scale in scales(history, ends).items():
        if scale == 0.0 or name in reached.unbounded:
            continue
        for end, exact in zip(ends, truth, strict=bool(truth)):
            found = history[best_column(name, history)][end]
            if name in exact and abs(found - exact[name]) > error * scale:
                error, worst = abs(found - exact[name]) / scale, name
    return Row(
        group, case.name, level, setup.grid.shape, setup.load_path.increments, reached, float(error), worst, cost(setup)
    )


def history_of(rows: Sequence[State]) -> dict[str, Any]:
    """Return the columns of a run."""
    columns = [vars(state.summary) | vars(state.errors) for state in rows]
    return {name: np.array([column[name] for column in columns]) for name in columns[0]}


def cost(setup: ProblemSetup) -> float:
    """Return cells times increments, over those of the settings that a careful user would take."""
    usual = HAND_PATH_INCREMENTS if setup.load_path.path_dependent else HAND_INCREMENTS
    hand = [1 if count == 1 else usual for count in setup.load_path.counts]
    return COARSE_RUNS * math.prod(setup.grid.shape) * setup.load_path.increments / (HAND_POINTS**2 * sum(hand))


def cases_of(
    names: Sequence[str], unseen: Iterable[CalibrationCase], closed_forms: Iterable[CalibrationCase]
) -> Iterator[tuple[str, CalibrationCase]]:
    """Yield group and case of all cases whose names begin so."""
    for group, cases in {KNOWN: CASES, UNSEEN: unseen, CLOSED_FORMS: closed_forms}.items():
        for case in cases:
            if not case.name.startswith(LEFT_OUT) and (not names or case.name.startswith(tuple(names))):
                yield group, case


def runs_of(truths: Path | None, grouped: tuple[str, CalibrationCase]) -> list[Row]:
    """Return the runs of a case with each accuracy; none where it has no solution. truths: folder that keeps these."""
    group, case = grouped
    rows = []
    try:
        truth = kept(truths, case.name, lambda: true_ends(case))
        for level in LEVELS:
            has_reference = level not in FINE_LEVELS or case.exact is not None
            if has_reference or (level == "reference" and case.name in REFERENCE_TOO):
                rows.append(measured(group, case, level, truth if has_reference else []))
                print(f"{rows[-1].line()} {rows[-1].points}", file=sys.stderr, flush=True)
    except NoSolutionError as error:
        print(f"{case.name}: {error.message}", file=sys.stderr, flush=True)
        return []
    return rows


def report_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the lines of the page: shares by accuracy, then the runs that missed it."""
    columns = {f"{level}, {group}": (group, level) for group in (KNOWN, UNSEEN, CLOSED_FORMS) for level in LEVELS}
    found = {name: [row for row in rows if (row.group, row.level) == key] for name, key in columns.items()}
    found = {name: part for name, part in found.items() if part}
    yield "| | " + " | ".join(found) + " |"
    yield "| --- " * (1 + len(found)) + "|"
    for label, share in {
        "cases": lambda part: str(len(part)),
        "met by its own error bars": lambda part: of(sum(row.verdict.met for row in part), len(part)),
        "met by the true error": lambda part: of(sum(row.true for row in part), sum(row.judged for row in part)),
        "claimed to be met, and not": lambda part: of(
            sum(row.verdict.met and row.false for row in part), sum(row.verdict.met and row.judged for row in part)
        ),
        "claimed not to be met, but met": lambda part: str(sum(not row.verdict.met and row.true for row in part)),
        "median of the worst error bar": lambda part: percent(statistics.median(row.verdict.worst for row in part)),
        "median of the worst true error": lambda part: percent(
            statistics.median([row.error for row in part if row.judged] or [math.nan])
        ),
        "median of the cost against settings by hand": lambda part: f"{statistics.median(r.cost for r in part):.2g}",
    }.items():
        yield f"| {label} | " + " | ".join(share(part) for part in found.values()) + " |"
    unjudged = dict.fromkeys(row.case for row in rows if row.level == JUDGED_BY_RUNS and math.isnan(row.error))
    if unjudged:
        yield from ("", "Without a truth, which would take too many cells:", "", *(f"- {case}" for case in unjudged))
    yield from ("", "Not met by the true error:", "")
    yield "| case | accuracy | worst error bar | worst true error |"
    yield "| --- | --- | --- | --- |"
    yield from (row.line() for row in rows if row.false)


def write_runs(file: Path, rows: Sequence[Row]) -> None:
    """Write a row per run; errors are in per cent of their scale."""
    bar = ("worst_bar_percent", "bar_quantity", "met_by_bars")
    error = ("worst_true_error_percent", "error_quantity", "met_by_true_error")
    headings = ("group", "case", "accuracy", "points", "increments", *bar, *error, "cost")
    write_csv(file, headings, (row.cells for row in rows))


def of(part: int, whole: int) -> str:
    """Return how many of them."""
    return f"{part} of {whole} ({100.0 * part / whole:.0f} %)" if whole else "none"


def main() -> None:
    """Read the arguments and print the report, or put it into a page."""
    parser = parser_of(__doc__)
    parser.add_argument("names", nargs="*", help="beginnings of the names of cases")
    parser.add_argument("--processes", type=int, default=1, help="number of cases that run at a time")
    parser.add_argument("--seed", type=int, default=14, help="seed of the unseen cases")
    parser.add_argument("--count", type=int, default=24, help="number of the unseen cases")
    parser.add_argument("--closed-forms", type=int, default=20, help="number of unseen cases with a closed form")
    parser.add_argument("--truths", type=Path, metavar="FOLDER", help="keeps true values, to go on after a stop")
    asked = parser.parse_args()
    with TemporaryDirectory() as maps:
        drawn = random_cases(asked.seed, asked.count, Path(maps))
        cases = list(cases_of(asked.names, drawn, random_closed_forms(asked.seed, asked.closed_forms)))
        rows = [row for some in outcomes(partial(runs_of, asked.truths), cases, asked.processes) for row in some]
    report({"accuracy": lambda: print("\n".join(report_lines(rows)))}, asked.into)
    if asked.into:
        write_runs(data_file(asked.into, "accuracy"), rows)


if __name__ == "__main__":
    main()
