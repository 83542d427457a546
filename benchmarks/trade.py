"""Speed against accuracy of modes I.2, I.3, II and III: grids, increments, tolerances and precisions.

    python benchmarks/trade.py                       # tables, some forty minutes on one core
    python benchmarks/trade.py --modes I.3 II --studies tolerance        # of some modes, some of them
    python benchmarks/trade.py --points 32 64 128 256 512     # finer grids with all increments (half an hour more)
    python benchmarks/trade.py --into docs/howto/grid_and_increments.md --pictures docs/pictures
    python benchmarks/trade.py --studies --pictures docs/pictures        # no runs, pictures from the written data

The tables show the worst errors of a run, of the dissipated energy and of all other quantities; ``--into`` writes the
errors of all quantities at the end of each stage to ``data/trade_*.csv``.

The runs are those of ``fretsolve study``, kept in a folder (``--runs``) and not made again. The reference is the finest
run of each study, which has an error of its own; corrected values and those as run are compared with the finest
corrected run. Cost: operator applications times cells, in millions, which no machine changes, and seconds of the
processor, of one thread, with numba unless FRETSOLVE_NUMBA says otherwise. Runs that are compared as run and corrected
are timed again, in turns and with the same kernels: those compiled by numba, and NumPy's.
"""

from __future__ import annotations

import csv
import math
import os
import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from tempfile import gettempdir

import numpy as np
from helpers import data_file, parser_of, report, write_csv
from numba.core import event

from fretsolve import open_result, run_with_error_bars
from fretsolve.case.dimensions import percent
from fretsolve.elastic.kernels import readying_seconds
from fretsolve.simulation import simulation
from fretsolve.sweep.case_run import run_serially
from fretsolve.sweep.outcome import CaseOutcome, read_outcome
from fretsolve.sweep.quantity import ENERGIES, StageQuantity
from fretsolve.sweep.study.assessment import AssessedRun, Assessment, assess, front
from fretsolve.sweep.study.plan import StudyPlan, StudyRequest, make_study_plan
from fretsolve.sweep.study.report import key_names, two_digits
from fretsolve.system.signals import StopRequest

ROOT = Path(__file__).resolve().parent.parent
CASES, PAGE = ROOT / "cases", ROOT / "docs" / "howto" / "grid_and_increments.md"

DPI = 200
"""Dots per inch of the pictures."""

PRESS, PULL, TWIST = "{P: 400 N}", "{Qx: 36 N}", "{Mz: 5 N mm, Qx: 0 N, Qy: 0 N}"
MODES = {
    "I.2": ("mode1_similar", f"load_path=[{PRESS}, {PULL}]"),
    "I.3": ("mode1_dissimilar", f"load_path=[{PRESS}, {PULL}]"),
    "II": ("mode2_dissimilar", f"load_path=[{PRESS}]"),
    "III": ("mode3_dissimilar", f"load_path=[{PRESS}, {TWIST}]"),
}
"""The shipped case of each mode, up to the first peak of its load."""

POINTS = (32, 64, 128, 256)
INCREMENTS = (1, 2, 5, 10, 20, 40, 80)
TOLERANCES = ("1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9")
TOLERANCE_POINTS, TOLERANCE_INCREMENTS = 64, 10
FINER_POINTS = (32, 64, 128, 256, 512, 1024)
FINER_INCREMENTS = {"I.2": 1, "I.3": 10, "II": 10, "III": 10}
"""Per stage, of finer grids."""

SINGLE_TOLERANCES = ("1e-2", "1e-3", "1e-4", "1e-5")
"""As far as single precision goes; the finest run, which comes last, is in double precision."""

CORRECTED = "corrected values"
CORRECTED_MODES = ("I.3", "II", "III")
CORRECTED_POINTS, CORRECTED_INCREMENTS = (32, 48, 64, 96, 128, 256), (2, 3, 5, 10, 20, 40)
"""Of runs with corrected values, in graded increments; the finest is the reference."""

TURNS = 3
"""Times that runs which are compared are timed."""

GOALS = (0.01, 0.001)
"""Errors whose least cost is compared."""

STUDIES = ("grids and increments", CORRECTED, "finer grids", "tolerance", "precision")
OTHERS, ENERGY = "worst error of all other quantities, %", "of the energy, %"
"""Headings."""

FRONT_ALONE = STUDIES[0]
"""The study of which the table shows the best runs alone."""

QUANTITIES = ("delta_z", "delta_x", "phi_z", "contact_radius", "stick_radius", "max_pressure", "work_total")
COLUMNS = tuple(f"{name}@{stage}" for name in QUANTITIES for stage in (1, 2))
"""Of the written tables."""


@dataclass(frozen=True)
class Asked:
    """What the command line asks for."""

    points: tuple[int, ...]
    increments: tuple[int, ...]
    runs: Path


def variations(mode: str, study: str, asked: Asked) -> list[str]:
    """Return what ``fretsolve study --vary`` takes."""
    if study == CORRECTED:
        return [
            f"grid.points={','.join(map(str, CORRECTED_POINTS))}",
            f"load_path.*.increments={','.join(map(str, CORRECTED_INCREMENTS))}",
        ]
    if study == "finer grids":
        return [f"grid.points={','.join(map(str, FINER_POINTS))}"]
    if study == "tolerance":
        return [f"solver.tolerance={','.join(TOLERANCES)}"]
    if study == "precision":
        return [f"solver.tolerance={','.join(SINGLE_TOLERANCES)}", "solver.precision=single,double"]
    return [
        f"grid.points={','.join(map(str, asked.points))}",
        f"load_path.*.increments={','.join(map(str, asked.increments))}",
    ]


def studied(mode: str, study: str, asked: Asked) -> Assessment:
    """Make the runs that are missing, and compare."""
    plan = planned(mode, study, asked)
    for _ in run_serially(plan.cases, StopRequest()):
        pass
    corrected = study == CORRECTED
    return assess(
        plan,
        [read_outcome(case.out, plan.quantities, case.setup.load_path, corrected=corrected) for case in plan.cases],
    )


def planned(mode: str, study: str, asked: Asked) -> StudyPlan:
    """Return the plan of a study."""
    case, path = MODES[mode]
    fixed = [path, "expect=[]"]
    stages = range(path.count("{"))
    if study == "finer grids":
        fixed += [f"load_path.{stage}.increments={FINER_INCREMENTS[mode]}" for stage in stages]
    if study in ("tolerance", "precision"):
        fixed += [f"grid.points={TOLERANCE_POINTS}"]
        fixed += [f"load_path.{stage}.increments={TOLERANCE_INCREMENTS}" for stage in stages]
    if study == CORRECTED:
        fixed += [f"load_path.{stage}.spacing=graded" for stage in stages]
    corrected = study == CORRECTED
    folder = asked.runs / f"{mode}{'_corrected' * corrected}"
    folder.mkdir(parents=True, exist_ok=True)
    axes = variations(mode, study, asked)
    request = StudyRequest(CASES / f"{case}.yaml", fixed, axes, (), "finest", corrected)
    return make_study_plan(request, folder)


def recorded(mode: str, study: str, asked: Asked) -> Assessment:
    """Return the study as it was written to its table, with two digits of each error and no values."""
    plan = planned(mode, study, asked)
    with data_file(PAGE, data_name(study)).open(encoding="utf-8") as file:
        table = [row for row in csv.DictReader(file) if row["mode"] == mode]
    found = {tuple(row[key] for key in key_names(plan.variations)): row for row in table}
    kept = tuple(one for one in plan.quantities if any(row.get(str(one)) for row in table))
    nothing = np.full(len(kept), np.nan)
    rows = []
    for case in plan.cases:
        row = found[tuple(case.settings.values())]
        errors = np.array([0.01 * float(row[str(one)] or "nan") for one in kept])
        outcome = CaseOutcome(nothing, nothing, 0, float(row["seconds"]))
        rows.append(AssessedRun(case, outcome, nothing, errors, case is plan.cases[0], row["best"] == "yes"))
    return Assessment(plan, kept, (), nothing, nothing, tuple(rows))


def data_name(study: str) -> str:
    """Return the name of a study's table."""
    return f"trade_{study.replace(' ', '_')}"


def work(row: AssessedRun) -> float:
    """Return millions of applications times cells."""
    nx, ny = row.case.setup.grid.shape
    return 1e-6 * row.outcome.applications * nx * ny


def by_work(study: Assessment) -> Assessment:
    """Return the study with its runs ordered and judged by their work, which the machine's load does not change."""
    rows = sorted(study.rows, key=work)
    compared = [row for row in rows if row.compared]
    best = front([work(row) for row in compared], [row.worst for row in compared])
    marked = {id(row) for row, is_best in zip(compared, best, strict=True) if is_best}
    return replace(study, rows=tuple(replace(row, best=id(row) in marked) for row in rows))


def print_runs(found: Mapping[str, Assessment], of_finest: Mapping[str, Sequence[str]] | None = None) -> None:
    """Print cost and worst errors of the runs with two columns for each mode, the second one for the energy's error.

    of_finest: errors of the references themselves. Where two keys are varied, only references are printed and runs that
    are best in a mode.
    """
    keys = next(iter(found.values())).plan.variations
    print_row(*key_names(keys), *(f"{mode} | energy" for mode in found))
    print("| --- " * (len(keys) + 2 * len(found)) + "|")
    for settings in product(*keys.values()):
        rows = {mode: _run_with(study, *settings) for mode, study in found.items()}
        if len(keys) > 1 and not any(row.best or row.is_reference for row in rows.values()):
            continue
        cells = []
        for mode, row in rows.items():
            errors = [cell.partition(" (")[0] for cell in _worst(found[mode], row)]
            if row.is_reference and of_finest and mode in of_finest:
                errors = [f"reference ({error})" for error in of_finest[mode]]
            cells += [f"{two_digits(work(row))}: {errors[0]}", errors[1]]
        print_row(*settings, *cells)


def print_grids_and_increments(modes: Sequence[str], asked: Asked) -> None:
    """Print the best runs, and how much the finest ones dissipate where they press.

    The errors of the finest ones themselves are against the finest corrected runs.
    """
    found, of_finest = {mode: by_work(studied(mode, FRONT_ALONE, asked)) for mode in modes}, {}
    for mode in [one for one in modes if one in CORRECTED_MODES]:
        compared = against(found[mode], studied(mode, CORRECTED, asked))
        of_finest[mode] = [cell.partition(" (")[0] for cell in _worst(compared, compared.finest)]
    print_runs(found, of_finest)
    print()
    print_row("mode", "dissipated by pressing, mJ", "of the work of P, %", "of the dissipation of the path, %")
    print("| --- " * 4 + "|")
    for mode in of_finest:
        case = found[mode].finest.case
        with open_result(case.out) as result:
            history, (end, *_) = result.history, case.setup.load_path.last_steps
            P, delta_z = (np.append(0.0, history[name][: end + 1]) for name in ("P", "delta_z"))
            pressing, whole = float(history["work_total"][end]), float(history["work_total"][-1])
        parts = pressing / float(np.trapezoid(P, delta_z)), pressing / whole
        print_row(mode, two_digits(pressing), *(two_digits(100.0 * part) for part in parts))


def print_by_mode(study: str, modes: Sequence[str], asked: Asked) -> None:
    """Print all runs of a study of one key."""
    print_runs({mode: by_work(studied(mode, study, asked)) for mode in modes})


def print_row(*cells: str) -> None:
    """Print a row of a table."""
    print("|", " | ".join(cells), "|", flush=True)


def print_corrected(modes: Sequence[str], asked: Asked) -> None:
    """Print the best runs with corrected values, and what errors cost as run and corrected."""
    found = {mode: by_work(studied(mode, CORRECTED, asked)) for mode in modes if mode in CORRECTED_MODES}
    print_runs(found)
    print()
    print_row("mode", "error", "of", "as run", "corrected", "times less")
    print("| --- " * 6 + "|")
    for mode, study in found.items():
        raw, alone = against(studied(mode, FRONT_ALONE, asked), study), without_coarse_runs(study)
        others = tuple(name for name in study.names if not name.endswith("radius") and name not in ENERGIES)
        compared = (
            (others, study, "the others"),
            (("work_total",), study, "work_total"),
            (("stick_radius",), alone, "stick_radius, graded"),
        )
        for goal in GOALS:
            for names, graded, what in compared:
                one, other = (cheapest(runs, names, goal) for runs in (raw, graded))
                if one is None and other is None:
                    continue
                seconds = least_seconds([row for row in (one, other) if row is not None])
                costs = _cost_text(one, seconds), _cost_text(other, seconds), _saved(one, other, seconds)
                print_row(mode, percent(goal), what, *costs)


def least_seconds(rows: Sequence[AssessedRun]) -> dict[int, list[float]]:
    """Return the processor time of each of some runs by its `id`, with numba and without: the least of three each.

    They take turns, so that other load on the machine disturbs them alike.
    """
    found: dict[int, list[float]] = {id(row): [math.inf, math.inf] for row in rows}
    for turn in range(1 + TURNS):  # the first one also compiles kernels and plans transforms
        for kernels, compiled in enumerate((True, False)):
            for row in rows:
                setup = replace(row.case.setup, compiled=compiled)
                began = time.process_time()
                deque((run_with_error_bars if setup.case.solver.error_bars else simulation.run)(setup), maxlen=0)
                if turn:
                    least = found[id(row)]
                    least[kernels] = min(least[kernels], time.process_time() - began)
    return found


def without_coarse_runs(study: Assessment) -> Assessment:
    """Return the study as if its cases ran without error bars, which change no value as run."""
    rows = []
    for row in study.rows:
        with open_result(row.case.out) as result:
            own = float(result.history["operator_applications"].sum())
        case = row.case.setup.case
        solver = case.solver.model_copy(update={"error_bars": False})
        setup = replace(row.case.setup, case=case.model_copy(update={"solver": solver}))
        outcome = replace(row.outcome, applications=round(own))
        rows.append(replace(row, case=replace(row.case, setup=setup), outcome=outcome))
    return replace(study, rows=tuple(rows))


def against(study: Assessment, reference: Assessment) -> Assessment:
    """Return a study compared with the reference of another one."""
    place = [study.quantities.index(one) for one in reference.quantities]
    rows = []
    for row in study.rows:
        errors = np.abs(row.values[place] - reference.reference) / reference.scales
        rows.append(replace(row, errors=errors, is_reference=False))
    return replace(study, quantities=reference.quantities, scales=reference.scales, rows=tuple(rows))


def cheapest(study: Assessment, names: Sequence[str], goal: float) -> AssessedRun | None:
    """Return the run with the least work among those that have all errors of `names` within `goal`, if any has."""
    good = [row for row in study.rows if row.compared and max(study.error_of(row, name) for name in names) <= goal]
    return min(good, key=work, default=None)


def _saved(raw: AssessedRun | None, corrected: AssessedRun | None, seconds: dict[int, list[float]]) -> str:
    """Return how many times more applications and seconds a run takes than a corrected one."""
    if raw is None or corrected is None:
        return "-"
    times = [one / other for one, other in zip(seconds[id(raw)], seconds[id(corrected)], strict=True)]
    return f"{two_digits(work(raw) / work(corrected))}; {', '.join(map(two_digits, times))}"


def _cost_text(row: AssessedRun | None, seconds: dict[int, list[float]]) -> str:
    if row is None:
        return "no run"
    points, increments, millions, _ = _costs(row)
    times = ", ".join(map(two_digits, seconds[id(row)]))
    return f"{points}x{increments}: {millions}; {times}"


def print_precisions(modes: Sequence[str], asked: Asked) -> None:
    """Print the same for double and single precision side by side, with a row for each mode and tolerance."""
    print_row("mode", "tolerance", "million applications x cells: double, single", "seconds", OTHERS, ENERGY)
    print("| --- " * 6 + "|")
    for mode in modes:
        found = by_work(studied(mode, "precision", asked))
        for tolerance in SINGLE_TOLERANCES:
            pair = [_run_with(found, tolerance, precision) for precision in ("double", "single")]
            columns = ([work(row) for row in pair], [row.outcome.seconds for row in pair])
            costs = [", ".join(map(two_digits, column)) for column in columns]
            errors = zip(*(_worst(found, row) for row in pair), strict=True)
            print_row(mode, tolerance, *costs, *map(", ".join, errors))


def _run_with(study: Assessment, *settings: str) -> AssessedRun:
    """Return the run with these values of what is varied."""
    return next(row for row in study.rows if tuple(_settings(row)) == settings)


def _settings(row: AssessedRun) -> list[str]:
    return list(row.case.settings.values())


def _costs(row: AssessedRun) -> list[str]:
    """Return the settings of a run, its work and its seconds."""
    return [*_settings(row), two_digits(work(row)), two_digits(row.outcome.seconds)]


def _worst(study: Assessment, row: AssessedRun) -> tuple[str, str]:
    """Return the worst error of all but the dissipated energy, and that of the energy, with what they are of."""
    if row.is_reference or row.outcome.failure:
        word = "reference" if row.is_reference else "no solution"
        return word, word
    found = []
    for of_energy in (False, True):
        names = [name for name in study.names if (name in ENERGIES) == of_energy]
        name = max(names, key=lambda name: study.error_of(row, name))
        error, stage = study.worst_of(row, name)
        found.append(f"{two_digits(100.0 * error)} ({StageQuantity(name, stage)})")
    return found[0], found[1]


def write_trade(file: Path, study: str, modes: Sequence[str], asked: Asked) -> None:
    """Write the errors of all quantities of all runs, in per cent; those of the reference are left empty."""
    rows = []
    for mode in modes if study != CORRECTED else [mode for mode in modes if mode in CORRECTED_MODES]:
        found = by_work(studied(mode, study, asked))
        keys, names = key_names(found.plan.variations), list(map(str, found.quantities))
        for row in found.rows:
            errors = {name: two_digits(100.0 * error) for name, error in zip(names, row.errors, strict=True)}
            cells = [errors.get(name, "") if row.compared else "" for name in COLUMNS]
            rows.append([mode, *_costs(row), "yes" if row.best else "no", *cells])
    write_csv(file, ["mode", *keys, "million_applications_cells", "seconds", "best", *COLUMNS], rows)


def draw(modes: Sequence[str], asked: Asked, folder: Path) -> None:
    """Draw the studies of grids and increments from their table, as ``fretsolve study`` does."""
    from fretsolve.post.plots.canvas import rendered
    from fretsolve.sweep.study.plot import trade

    for mode in modes:
        picture = trade(recorded(mode, STUDIES[0], asked), f"Mode {mode}")
        (folder / f"trade_{mode.replace('.', '_')}.png").write_bytes(rendered(picture, "png", DPI))


def processor_seconds() -> float:
    """Return the processor time, in place of the wall clock, which runs on while other programs do."""
    return time.process_time() - readying_seconds()


def main() -> None:
    """Read the arguments, and print the tables or put them into a page."""
    parser = parser_of(__doc__)
    parser.add_argument("--modes", nargs="+", choices=MODES, default=list(MODES))
    parser.add_argument("--studies", nargs="*", choices=STUDIES, default=STUDIES, help="the tables to make")
    parser.add_argument("--points", nargs="+", type=int, default=POINTS)
    parser.add_argument("--increments", nargs="+", type=int, default=INCREMENTS)
    parser.add_argument("--runs", type=Path, default=Path(gettempdir()) / "fretsolve-trade", help="where runs are kept")
    parser.add_argument("--pictures", type=Path)
    words = parser.parse_args()
    simulation._working_seconds = processor_seconds
    event.timer = time.process_time  # of readying the kernels, which `processor_seconds` leaves out
    os.environ.setdefault("FRETSOLVE_NUMBA", "1")  # short runs would choose NumPy, and be compared with long ones
    asked = Asked(tuple(words.points), tuple(words.increments), words.runs)
    parts = {study: partial(print_by_mode, study, words.modes, asked) for study in STUDIES}
    parts[FRONT_ALONE] = partial(print_grids_and_increments, words.modes, asked)
    parts[CORRECTED] = partial(print_corrected, words.modes, asked)
    parts["precision"] = partial(print_precisions, words.modes, asked)
    report({study: parts[study] for study in words.studies}, words.into)
    if words.into:
        for study in words.studies:
            write_trade(data_file(words.into, data_name(study)), study, words.modes, asked)
    if words.pictures:
        draw(words.modes, asked, words.pictures)


if __name__ == "__main__":
    main()
