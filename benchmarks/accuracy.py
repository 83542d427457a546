"""Whether an accuracy that is asked for is met, whether that is true, and what it costs.

    python benchmarks/accuracy.py --processes 2 --truths FOLDER         # an hour on two cores
    python benchmarks/accuracy.py 71-03 71-17                           # scenes whose names begin so
    python benchmarks/accuracy.py --into docs/howto/grid_and_increments.md

The scenes are drawn at random (`random_scenes`): spheres, ellipsoids, cones, punches, lines, rough and wavy surfaces,
maps with holes, modes I to III, cycles, turned paths, similar and dissimilar bodies, loads and displacements. They are
run without points and increments, with each of the accuracies; scenes without a solution are left out. Errors are those
of the corrected values where there are any, at the ends of the stages. True values are those of a run with twice the
points per side and twice the increments of the finest of these runs, corrected for the increments; they keep a third to
a half of the finest run's errors. The cost counts operator applications times cells: of all rounds with their coarse
runs, over the cheapest of many fixed settings without error bars whose values as run are as accurate, as only the true
values tell; and of settings by hand (128 x 128 points, or 512 of a line, with ten increments per stage, or 40 where the
slip depends on the path).
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from calibration_cases import CalibrationCase, corrected_run
from helpers import data_file, kept, outcomes, parser_of, report, write_csv
from random_scenes import unseen_cases

import fretsolve
from fretsolve.case.dimensions import percent
from fretsolve.case.history import USUAL
from fretsolve.case.loading import case_model
from fretsolve.case.models import Case
from fretsolve.errors import FretsolveError
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.result.state import cost_of
from fretsolve.result.verdict import Verdict, judged, scales
from fretsolve.simulation.accuracy.in_memory import history_of, rounds_of
from fretsolve.simulation.accuracy.rounds import Round, first_round
from fretsolve.simulation.problem_setup import set_up

TARGETS = (0.05, 0.01, 0.002)
AT_MOST = {"cells": 90_000, "time": "120 s"}
"""Limits of each accuracy, so that there are truths."""

FINER, MOST_CELLS = 2, 400_000
"""Points per side and increments of the truth over those of the finest run; and its most cells."""

LADDER = (16, 24, 32, 48, 64, 96, 128, 192, 256, 384)
REFINEMENTS = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4)
"""Points of the shorter side, and factors on automatic increments, of which the cheapest that suffices is found."""

HAND_POINTS, HAND_LINE_POINTS, HAND_INCREMENTS, HAND_PATH_INCREMENTS = 128, 512, 10, 40


@dataclass(frozen=True)
class Row:
    """A scene run with an accuracy. error: the worst true one over its scale, NaN where no truth is known; costs in
    operator applications times cells: of all rounds, of the cheapest settings, of settings by hand."""

    scene: str
    target: float
    points: tuple[int, int]
    increments: int
    rounds: int
    met: bool
    bar: float
    quantity: str
    error: float
    worst: str
    reason: str
    cost: float
    cheapest: float
    by_hand: float

    @property
    def false(self) -> bool:
        """Whether it claims to be met, and is not."""
        return self.met and self.error > self.target

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the CSV file."""
        costs = (f"{self.cost:.3g}", f"{self.cheapest:.3g}", f"{self.by_hand:.3g}")
        bar = (percent(self.bar), self.quantity, "yes" if self.met else "no")
        error = ("", "") if math.isnan(self.error) else (percent(self.error), self.worst)
        nx, ny = self.points
        size = (f"{nx} x {ny}", str(self.increments), str(self.rounds))
        return (self.scene, percent(self.target), *size, *bar, *error, *costs, self.reason)


def asked(case: CalibrationCase, target: float) -> Case:
    """Return a scene without its points and increments, with an accuracy."""
    grid = {name: value for name, value in case.parts["grid"].items() if name != "points"}
    path = [without_increments(stage) for stage in case.parts["load_path"]]
    accuracy = {"target": target, "at_most": AT_MOST}
    parts = {**case.parts, "grid": grid, "load_path": path, "solver": {"accuracy": accuracy}}
    return case_model(parts).model_validate(parts)


def without_increments(stage: Mapping[str, Any]) -> dict[str, Any]:
    """Return a stage or a cycle of stages without numbers of increments."""
    if "cycle" in stage:
        cycle = stage["cycle"]
        return {"cycle": {**cycle, "stages": [without_increments(part) for part in cycle["stages"]]}}
    return {name: value for name, value in stage.items() if name not in ("increments", "spacing")}


Ends = list[Mapping[str, float]]


@dataclass(frozen=True)
class Answer:
    """What the rounds of an accuracy have led to."""

    last: Round
    verdict: Verdict
    history: Mapping[str, Any]
    cost: float


def answer(case: CalibrationCase, target: float) -> Answer:
    """Run the rounds of an accuracy. Raises FretsolveError where the first one has no solution."""
    costs, found = {}, None
    for last, rows, known in rounds_of(asked(case, target)):
        assert known.verdict is not None
        found = Answer(last, known.verdict, history_of(rows), 0.0)
        costs[len(last.before)] = cost_of(found.history)[1] * math.prod(last.setup.grid.shape)
    assert found is not None
    return replace(found, cost=sum(costs.values()))


def true_ends(finest: ProblemSetup) -> Ends:
    """Return the values at the ends of the stages of a run that is finer than `finest`; none if it is too large."""
    points = [FINER * count for count in finest.grid.shape[: len(finest.grid.axes)]]
    if math.prod(points) > MOST_CELLS:
        return []
    fine = with_settings(finest, points, [2 * FINER * -(-count // 2) for count in finest.load_path.counts])
    rows = corrected_run(fine)
    return [{name: float(rows[step][name]) for name in USUAL} for step in fine.load_path.last_steps]


def with_settings(setup: ProblemSetup, points: Sequence[int], counts: Sequence[int]) -> ProblemSetup:
    """Return a problem with other points, and other increments where the slip depends on them."""
    finer = replace(setup, grid=setup.grid.cut_into(*(*points, 1)[:2]))
    finer = replace(finer, case=finer.case.model_copy(update={"solver": plain(finer.case)}))
    return replace(finer, load_path=setup.load_path.with_counts(counts)) if setup.load_path.path_dependent else finer


def plain(case: Case) -> Any:
    """Return the solver's settings of a case without error bars."""
    return case.solver.model_copy(update={"error_bars": False, "accuracy": None})


def error_of(history: Mapping[str, Any], truth: Ends, columns: Mapping[str, str]) -> tuple[float, str]:
    """Return the worst true error over its scale, and of what; columns: which hold the quantities."""
    ends = np.flatnonzero(np.append(np.diff(history["stage"]) != 0, True))
    known, worst = scales(history, ends), (0.0, "-")
    for name, column in columns.items():
        for end, exact in zip(ends, truth, strict=True):
            worst = max(worst, (float(abs(history[column][end] - exact[name]) / known[name]), name))
    return worst


def rows_of(truths: Path | None, case: CalibrationCase) -> list[Row]:
    """Return the runs of a scene; none where it has no solution."""
    try:
        answers = {target: answer(case, target) for target in TARGETS}
        setups = [one.last.setup for one in answers.values()]
        finest = max(setups, key=lambda setup: (math.prod(setup.grid.shape), setup.load_path.increments))
        counts = [max(counts) for counts in zip(*(setup.load_path.counts for setup in setups), strict=True)]
        finest = with_settings(finest, finest.grid.shape[: len(finest.grid.axes)], counts)
        truth = kept(truths, case.name, lambda: true_ends(finest))
        rows = []
        for target, one in answers.items():
            verdict = one.verdict
            bars = judged((), one.history, lambda: None)
            columns = {bar.quantity: bar.column for bar in bars if bar.quantity not in verdict.unbounded}
            error, worst = error_of(one.history, truth, columns) if truth else (math.nan, "")
            cheapest = cheapest_cost(case, target, truth, columns) if truth else math.nan
            setup, hand = one.last.setup, by_hand(case)
            size = setup.grid.shape, setup.load_path.increments, 1 + len(one.last.before)
            found = (verdict.met, verdict.worst, verdict.quantity, error, worst, verdict.reason)
            rows.append(Row(case.name, target, *size, *found, one.cost, cheapest, hand))
            print(" | ".join(rows[-1].cells), file=sys.stderr, flush=True)
    except FretsolveError as error:
        print(f"{case.name}: {error}", file=sys.stderr, flush=True)
        return []
    return rows


def cheapest_cost(case: CalibrationCase, target: float, truth: Ends, columns: Mapping[str, str]) -> float:
    """Return the cost of the cheapest fixed settings whose values as run are as accurate; NaN where none are."""
    least = math.inf
    first = first_round(asked(case, target)).setup
    for refinement in REFINEMENTS if first.load_path.path_dependent else REFINEMENTS[:1]:
        for side in LADDER:
            shape = first.grid.shape[: len(first.grid.axes)]
            points = [math.ceil(side * count / min(shape) / 2) * 2 for count in shape]
            if math.prod(points) > MOST_CELLS // FINER**2:
                break
            own = asked(case, target).model_copy(update={"solver": plain(first.case)})
            own = own.model_copy(update={"solver": own.solver.model_copy(update={"refinement": refinement})})
            grid = own.grid.model_copy(update={"points": (*points, 1)[:2], "size": first.grid.size})
            try:
                setup = set_up(own.model_copy(update={"grid": grid}))
                if 10.0 * setup.load_path.increments * math.prod(setup.grid.shape) > least:
                    break  # an increment takes ten applications at the least
                history = history_of(list(fretsolve.run(setup)))
            except FretsolveError:
                continue
            cost = cost_of(history)[1] * math.prod(setup.grid.shape)
            if error_of(history, truth, {name: name for name in columns})[0] <= target:
                least = min(least, cost)
                break
    return least if math.isfinite(least) else math.nan


def by_hand(case: CalibrationCase) -> float:
    """Return the cost of the settings that a careful user would take."""
    setup = first_round(asked(case, TARGETS[0])).setup
    usual = HAND_PATH_INCREMENTS if setup.load_path.path_dependent else HAND_INCREMENTS
    points = [HAND_LINE_POINTS] if setup.model.line else [HAND_POINTS] * 2
    hand = with_settings(setup, points, [1 if count == 1 else usual for count in setup.load_path.counts])
    history = history_of(list(fretsolve.run(hand)))
    return cost_of(history)[1] * math.prod(hand.grid.shape)


def report_lines(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the lines of the page: shares by accuracy, then what is claimed falsely."""
    groups = {target: [row for row in rows if row.target == target] for target in TARGETS}
    yield "| | " + " | ".join(percent(target) for target in groups) + " |"
    yield "| --- " * (1 + len(groups)) + "|"
    for label, value in {
        "scenes": lambda part: str(len(part)),
        "met by the error bars": lambda part: of(sum(row.met for row in part), len(part)),
        "met, and not true": lambda part: of(
            sum(row.false for row in part), sum(row.met and not math.isnan(row.error) for row in part)
        ),
        "not met by the error bars, but by the true error": lambda part: of(
            sum(not row.met and row.error <= row.target for row in part), sum(not row.met for row in part)
        ),
        "median of the worst true error": lambda part: percent(median([row.error for row in part])),
        "cost over the cheapest fixed settings, median": lambda part: f"{median(over_cheapest(part)):.2g}",
        "worst": lambda part: f"{max(over_cheapest(part), default=math.nan):.2g}",
        "cost over settings by hand, median": lambda part: f"{median([row.cost / row.by_hand for row in part]):.2g}",
        "rounds, median and most": lambda part: f"{median([r.rounds for r in part]):g}, {max(r.rounds for r in part)}",
    }.items():
        yield f"| {label} | " + " | ".join(value(part) for part in groups.values()) + " |"
    if false := [row for row in rows if row.false]:
        yield from ("", "Met by the error bars, and not true:", "")
        yield from ("| scene | accuracy | worst error bar | true error |", "| --- | --- | --- | --- |")
        for row in false:
            bar, error = f"{percent(row.bar)} ({row.quantity})", f"{percent(row.error)} ({row.worst})"
            yield f"| {row.scene} | {percent(row.target)} | {bar} | {error} |"


def over_cheapest(rows: Sequence[Row]) -> list[float]:
    """Return the costs of accuracies that are met over the costs of the cheapest settings."""
    return [row.cost / row.cheapest for row in rows if row.met and not math.isnan(row.cheapest)]


def median(values: Sequence[float]) -> float:
    """Return the median of the values that are known."""
    return statistics.median([value for value in values if not math.isnan(value)] or [math.nan])


def of(part: int, whole: int) -> str:
    """Return how many of them."""
    return f"{part} of {whole} ({100.0 * part / whole:.0f} %)" if whole else "none"


def draw(rows: Sequence[Row], file: Path) -> None:
    """Draw the cost over the target, beside the cheapest settings and settings by hand."""
    figure, axes = plt.subplots(figsize=(5.2, 3.4), layout="constrained")
    for scene in dict.fromkeys(row.scene for row in rows):
        part = [row for row in rows if row.scene == scene and row.met]
        axes.plot([100.0 * row.target for row in part], [row.cost for row in part], color="0.8", linewidth=0.6)
    for label, color, cost in (
        ("rounds of an accuracy", "C0", lambda row: row.cost if row.met else math.nan),
        ("cheapest fixed settings", "C2", lambda row: row.cheapest),
        ("settings by hand", "C1", lambda row: row.by_hand),
    ):
        targets = sorted(TARGETS)
        medians = [median([cost(row) for row in rows if row.target == target]) for target in targets]
        axes.plot([100.0 * target for target in targets], medians, "o-", color=color, label=f"{label}, median")
    axes.set(xscale="log", yscale="log", xlabel="accuracy (%)", ylabel="cells times operator applications")
    axes.set_xticks([100.0 * target for target in TARGETS], [f"{100.0 * target:g}" for target in TARGETS])
    axes.minorticks_off()
    axes.legend(frameon=False)
    figure.savefig(file, dpi=200)


def main() -> None:
    """Read the arguments and print the report, or put it into a page."""
    parser = parser_of(__doc__)
    parser.add_argument("names", nargs="*", help="beginnings of the names of scenes")
    parser.add_argument("--processes", type=int, default=1, help="number of scenes that run at a time")
    parser.add_argument("--seed", type=int, default=71, help="seed of the scenes")
    parser.add_argument("--count", type=int, default=40, help="number of the scenes")
    parser.add_argument("--truths", type=Path, metavar="FOLDER", help="keeps true values, to go on after a stop")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="the picture of the costs")
    given = parser.parse_args()
    with TemporaryDirectory() as maps:
        drawn = unseen_cases(given.seed, given.count, Path(maps))
        scenes = [case for case in drawn if not given.names or case.name.startswith(tuple(given.names))]
        rows = [row for some in outcomes(partial(rows_of, given.truths), scenes, given.processes) for row in some]
    report({"accuracy": lambda: print("\n".join(report_lines(rows)))}, given.into)
    if given.picture:
        draw(rows, given.picture)
    if given.into:
        bar, error = ("worst_bar", "bar_quantity", "met"), ("worst_true_error", "error_quantity")
        size, costs = ("points", "increments", "rounds"), ("cost", "cheapest_cost", "cost_by_hand")
        headings = ("scene", "accuracy", *size, *bar, *error, *costs, "why_not_met")
        write_csv(data_file(given.into, "accuracy"), headings, (row.cells for row in rows))


if __name__ == "__main__":
    main()
