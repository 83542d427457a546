"""Carry out ``fretsolve check``: solve cases in memory and compare with the values that they expect."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

from fretsolve.case.cycle_quantities import CYCLE_DIMENSIONS
from fretsolve.case.dimensions import smaller_unit
from fretsolve.case.history import DISPLACEMENTS, HISTORY_DIMENSIONS
from fretsolve.case.keys.quantity_names import OF_WHOLE_RUN
from fretsolve.case.keys.settings_spec import Expectation
from fretsolve.case.loading import CaseText, read_case
from fretsolve.case.models import Case
from fretsolve.errors import CaseError, FileError, FretsolveError, NoSolutionError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.setup.cost_estimate import require_memory
from fretsolve.problem.setup.warnings import case_warnings
from fretsolve.result import HistoryWriter
from fretsolve.result.history import History
from fretsolve.result.verdict import Verdict
from fretsolve.simulation.accuracy.rounds import Round, first_round
from fretsolve.simulation.accuracy.saved_rounds import solve_rounds
from fretsolve.simulation.run_to_file import solve_missing
from fretsolve.simulation.simulation import run
from fretsolve.system import atomic_files
from fretsolve.system.files import reported, require_ending, require_own, writing
from fretsolve.system.signals import StopRequest

EXIT_MISSED = 1

SEVERITY = (0, EXIT_MISSED, NoSolutionError.exit_code, CaseError.exit_code, FileError.exit_code)
"""Exit codes from the best outcome to the worst."""

JUNIT_MARK = b'<testsuites name="fretsolve check"'
"""In every report as JUnit XML."""

ENDINGS = (".yaml", ".yml")

HEADINGS = ("stage", "quantity", "expected", "found", "deviation", "allowed", "ok")


@dataclass(frozen=True)
class Comparison:
    """An expected value, and the value found; stage: of the history (from 1). None if the run ended before."""

    expected: Expectation
    stage: int
    found: float | None

    @property
    def allowed(self) -> float:
        """Largest deviation, in the quantity's units."""
        if self.expected.rel is not None:
            return self.expected.rel * abs(self.expected.value)
        return self.expected.abs or 0.0

    @property
    def deviation(self) -> float:
        """The value found less the expected one, 0 if both are infinite; NaN without a value."""
        if self.found is None:
            return math.nan
        return 0.0 if self.found == self.expected.value else self.found - self.expected.value

    @property
    def ok(self) -> bool:
        """True if the value was found within the tolerance."""
        return abs(self.deviation) <= self.allowed

    @property
    def place(self) -> str:
        """The stage at whose end, or the cycle in which, the value was found; of the whole run, run."""
        name, cycle = self.expected.quantity, self.expected.cycle
        if name in CYCLE_DIMENSIONS:
            return "last cycle" if cycle is None else f"cycle {cycle}"
        return "run" if name in OF_WHOLE_RUN else str(self.stage)

    @property
    def where(self) -> str:
        """The place in a sentence."""
        return f"at stage {self.place}" if self.place.isdecimal() else f"of {self.place}"

    def cells(self) -> tuple[str, ...]:
        """Return the row under `HEADINGS`. Deviations have the form of the tolerance: in per cent or with a unit."""
        value, unit = self.expected.value, self.expected.dimensions[self.expected.quantity].unit
        small = self.expected.quantity in (*DISPLACEMENTS, *CYCLE_DIMENSIONS)
        unit, scale = smaller_unit(unit, abs(value)) if small else (unit, 1.0)
        factor, of = (scale, unit) if self.expected.rel is None else (100.0 / abs(value), "%")
        found, deviation = "not reached", "-"
        if self.found is not None:
            found, deviation = f"{scale * self.found:.7g} {unit}", f"{factor * self.deviation:+.3g} {of}"
        allowed = f"{factor * self.allowed:.3g} {of}"
        row = (f"{scale * value:.7g} {unit}", found, deviation, allowed, "yes" if self.ok else "NO")
        return self.place, self.expected.quantity, *map(str.rstrip, row)


@dataclass(frozen=True)
class CheckedCase:
    """The outcome of a check of one case. error: what stopped it; seconds: time of solving; warnings: of the case."""

    case: Path
    comparisons: tuple[Comparison, ...]
    error: FretsolveError | None
    seconds: float
    warnings: tuple[str, ...] = ()

    @property
    def exit_code(self) -> int:
        """The exit code of the error, else 1 if a value is outside its tolerance."""
        if self.error is not None:
            return self.error.exit_code
        return 0 if all(comparison.ok for comparison in self.comparisons) else EXIT_MISSED


def check_cases(cases: Sequence[Path], overrides: Sequence[str], junit: Path | None) -> int:
    """Check and print each case, also each case of a folder, and return the worst exit code.

    Raises CaseError for a wrong ending of `junit`, FileError if its folder does not exist, and for a folder without
    cases or that cannot be read.
    """
    if junit is not None:
        require_ending(junit, "a JUnit file", ".xml")
        require_own(junit, JUNIT_MARK, "a report of tests")
        if not junit.parent.is_dir():
            raise FileError(f"cannot be written: there is no folder {junit.parent}", junit)
    found = [cases_at(path) for path in cases]
    skipped = [other for _, others in found for other in others]
    outcomes = []
    for path in (case for inside, _ in found for case in inside):
        outcome = check_case(path, overrides)
        _report(outcome)
        outcomes.append(outcome)
    code = max((outcome.exit_code for outcome in outcomes), key=SEVERITY.index)
    passed = sum(outcome.exit_code == 0 for outcome in outcomes)
    told = f"; skipped, as they are no cases: {', '.join(map(str, skipped))}" if skipped else ""
    left_out = [entry for path in cases if path.is_dir() for entry in sorted(path.iterdir()) if _is_passed_over(entry)]
    told += f"; left out, a folder or a name in capitals: {', '.join(map(str, left_out))}" if left_out else ""
    print(f"{passed} of {len(outcomes)} cases as expected{told}", flush=True)
    if junit is not None:
        write_junit(junit, outcomes)
    return code


def cases_at(path: Path) -> tuple[list[Path], list[Path]]:
    """Return a case, or the cases of a folder and its other YAML files, such as sweeps, in the order of their names.

    A YAML file is a case if it has one of the keys that a case needs, or cannot be read: its check says why. Raises
    FileError if a folder has none, or cannot be read.
    """
    with reported("cannot be read", path):
        if not path.is_dir():
            return [path], []
        files = sorted(file for file in path.iterdir() if file.suffix in ENDINGS and not file.is_dir())
    needed = [key for key, field in Case.model_fields.items() if field.is_required()]
    cases: list[Path] = []
    others: list[Path] = []
    for file in files:
        try:
            data = read_case(file).data
        except FretsolveError:
            data = dict.fromkeys(needed)
        (cases if isinstance(data, dict) and data.keys() & needed else others).append(file)
    if not cases:
        raise FileError(f"no YAML file in this folder is a case, with {', '.join(needed)}", path)
    return cases, others


def _is_passed_over(entry: Path) -> bool:
    """Return whether an entry of a folder may hold cases that `cases_at` does not look for."""
    inner = entry.is_dir() and not entry.name.startswith(".")
    return inner or (entry.suffix not in ENDINGS and entry.suffix.lower() in ENDINGS)


def check_case(path: Path, overrides: Sequence[str] = ()) -> CheckedCase:
    """Solve a case as far as it has a solution, and compare with the values that it expects."""
    expectations: Sequence[Expectation] = ()
    loads: LoadPath | None = None
    histories = [History()]
    found_beside: dict[int, float] = {}
    failure, warnings = None, tuple[str, ...]()
    try:
        text = read_case(path, pipe=True)
        case = text.case(overrides)
        if not case.expect:
            raise case.source.problem(
                "nothing to check; give a list such as [{quantity: delta_z, value: 9 um, rel: 1 %}]", ("expect",)
            )
        first = first_round(case)
        setup = first.setup
        require_memory(setup)
        expectations, loads = case.expect, setup.load_path
        warnings = tuple(case_warnings(setup))
        if case.solver.accuracy is None and all(one.quantity in HISTORY_DIMENSIONS for one in expectations):
            for _ in run(setup, history=histories[-1]):
                pass
        else:
            found_beside, loads, reached = _run_to_file(text, overrides, histories)
            warnings += (str(reached),) if reached is not None and not reached.met else ()
        loads = loads.followed(histories[-1])
    except FretsolveError as error:
        failure = error
    comparisons, summaries = [], histories[-1]
    stages = zip(loads.stages, loads.last_steps, strict=True) if loads is not None else ()
    ends = {stage.number: last for stage, last in stages}
    for index, expected in enumerate(expectations):
        stage = expected.stage or max(ends)
        step, found = ends.get(stage, len(summaries)), found_beside.get(index)
        if expected.quantity in HISTORY_DIMENSIONS and step < len(summaries):
            found = float(getattr(summaries[step], expected.quantity))
        comparisons.append(Comparison(expected, stage, found))
    seconds = sum(summary.wall_time for summary in summaries)
    return CheckedCase(path, tuple(comparisons), failure, seconds, warnings)


def _run_to_file(
    text: CaseText, overrides: Sequence[str], histories: list[History]
) -> tuple[dict[int, float], LoadPath, Verdict | None]:
    """Run a case into a folder that does not stay, with its side outputs; return what the history does not hold.

    histories: takes up a history per round, also of increments before a failure. The values are by the place in
    `expect`; the load path and the verdict are of the last round.
    """
    from fretsolve.sweep.case_run import write_side_outputs  # few cases expect what the history does not hold
    from fretsolve.sweep.outcome import read_outcome
    from fretsolve.sweep.plan import BaseCase
    from fretsolve.sweep.quantity import quantity_of

    with TemporaryDirectory(prefix="fretsolve-") as folder:
        prepared = BaseCase.of(text, overrides).prepare({}, Path(folder))
        case, stages = prepared.setup.case, len(prepared.setup.load_path.last_steps)
        # now and then, so that the states of a long run are not all in memory
        in_rounds = case.solver.accuracy is not None
        with HistoryWriter.open(prepared.out, prepared.header, pause=2.0, in_rounds=in_rounds) as writer:

            def solve(current: Round) -> bool:
                histories.append(History())
                take = lambda summary, errors: histories[-1].append(summary)  # noqa: E731
                return solve_missing(current.setup, writer, StopRequest(), show=take)

            solved = solve_rounds(writer, prepared.first, prepared.header_of, solve)
            assert solved is not None, "nothing stops it"
            if len(solved[0].before) < len(histories) - 2:  # the last round has no solution
                histories.pop()
            write_side_outputs(prepared, writer)
        load_path = solved[0].setup.load_path
        wanted = {
            index: quantity_of(one, stages)
            for index, one in enumerate(case.expect)
            if one.quantity not in HISTORY_DIMENSIONS
        }
        outcome = read_outcome(prepared.out, list(wanted.values()), load_path)
    for index, one in wanted.items():
        units = outcome.units[one.name]
        if one.name in CYCLE_DIMENSIONS and ("rad" in units or "N mm" in units):
            message = f"{one.name} of a loop of moment and rotation is in {units}, which cannot be compared"
            advice = "dissipated_energy, energy_ratio or sliding_ratio can"
            raise case.source.problem(f"{message}; {advice}", ("expect", index, "quantity"))
    return dict(zip(wanted, map(float, outcome.values), strict=True)), load_path, solved[1]


def _report(outcome: CheckedCase) -> None:
    print(outcome.case)
    if outcome.comparisons:
        rows = [HEADINGS, *(comparison.cells() for comparison in outcome.comparisons)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
            print("  " + "  ".join(cells).rstrip())
    for text in outcome.warnings:
        print(f"  warning: {text}")
    for line in str(outcome.error).splitlines() if outcome.error is not None else ():
        print(f"  {line}")
    sys.stdout.flush()


def write_junit(path: Path, outcomes: Sequence[CheckedCase]) -> None:
    """Write the outcome as JUnit XML, which build servers read: a suite per case, a test per expectation."""
    suites = ElementTree.Element("testsuites", name="fretsolve check")
    for outcome in outcomes:
        name = str(outcome.case)
        suite = ElementTree.SubElement(suites, "testsuite", name=name, time=f"{outcome.seconds:.3f}")
        for comparison in outcome.comparisons or (None,):
            what = f"{comparison.expected.quantity} {comparison.where}" if comparison else "case"
            test = ElementTree.SubElement(suite, "testcase", classname=name, name=what)
            if comparison is None or comparison.found is None:
                kind = type(outcome.error).__name__
                ElementTree.SubElement(test, "error", message=str(outcome.error), type=kind)
            elif not comparison.ok:
                _, _, expected, found, deviation, allowed, _ = comparison.cells()
                message = f"{expected} expected, {found} found: {deviation} off, {allowed} allowed"
                ElementTree.SubElement(test, "failure", message=message, type="deviation")
        counts = {"tests": "testcase", "failures": "*/failure", "errors": "*/error"}
        suite.attrib |= {key: str(len(suite.findall(tag))) for key, tag in counts.items()}
    ElementTree.indent(suites)
    text = ElementTree.tostring(suites, encoding="unicode", xml_declaration=True)
    # XML cannot hold control characters
    printable = "".join(character if character.isprintable() or character == "\n" else "?" for character in text)
    require_own(path, JUNIT_MARK, "a report of tests")
    with writing(path):
        atomic_files.write_text(path, printable + "\n")
