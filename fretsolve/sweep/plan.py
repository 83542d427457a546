"""The plan of a sweep: all its cases, checked before anything runs."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.case.loading import read_case, validated
from fretsolve.case.problems import CaseErrors
from fretsolve.case.source import CaseSource
from fretsolve.errors import CaseError, FileError
from fretsolve.setup.cost_estimate import free_bytes, rounded_bytes
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.sweep.base_case import BaseCase, with_origins
from fretsolve.sweep.manifest import RESULTS_NAME, Manifest, ManifestRow
from fretsolve.sweep.points import Point, Value, common_values, points_of
from fretsolve.sweep.quantity import read_quantity, usual_quantities
from fretsolve.sweep.spec import SweepSpec
from fretsolve.sweep.status import missing

MOST_SHOWN = 10
"""Problems that are reported one by one."""


@dataclass(frozen=True)
class SweepPlan:
    """A checked sweep. warnings: those of all its cases, each once."""

    manifest: Manifest
    spec: SweepSpec
    source: CaseSource
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Findings:
    """What the check of all cases finds. stages: how many every case has; usual: quantities collected by default.

    memory, files: estimated bytes, of the largest case and of all results.
    """

    rows: tuple[ManifestRow, ...]
    warnings: tuple[str, ...]
    stages: int
    usual: tuple[str, ...]
    memory: float
    files: float


def make_plan(path: Path, folder: Path) -> SweepPlan:
    """Read the sweep file and check every case. Raises CaseError, FileError."""
    text = read_case(path)
    text.require_mapping(("case", "axes"))
    spec = validated(SweepSpec, text.data, text.source, text.problems)
    common, points = common_values(spec, text.source), points_of(spec, text.source)
    case = path.parent / spec.case
    base = _base(case, spec, common, text.source)
    found = _check(base, points, folder)
    manifest = Manifest(
        folder.absolute(),
        path.absolute(),
        spec.title or path.stem,
        case.absolute(),
        base.overrides,
        _quantities(spec, text.source, found),
        spec.threads,
        found.memory,
        found.rows,
    )
    warnings, free = found.warnings, free_bytes(manifest.folder)
    left = found.files * len(missing(manifest)) / len(manifest.unique)
    if free is not None and left > free:
        warnings += (
            f"results of about {rounded_bytes(left)} are missing, {rounded_bytes(free)} are free on the disk of"
            f" {folder}, which may be too little; empty cells take less, so the sweep goes on",
        )
    return SweepPlan(manifest, spec, text.source, warnings)


def _base(case: Path, spec: SweepSpec, common: Point, source: CaseSource) -> BaseCase:
    extra = ["solver.error_bars=true"] if spec.error_bars else []
    texts: list[tuple[str, Value]] = []
    try:
        for of_every_stage in (False, True):  # the other keys may change how many stages there are
            values = [value for value in common if ("*" in value.setting.key) == of_every_stage]
            stages = BaseCase.read(case, [text for text, _ in texts]).stages if of_every_stage else ()
            texts += [(text, value) for value in values for text in value.setting.overrides(stages)]
        return BaseCase.read(case, [*(text for text, _ in texts), *extra], spec.threads)
    except FileError as error:
        raise source.problem(str(error), ("case",)) from None
    except CaseError as error:
        raise _all_of(_placed(error, dict(texts))) from None


def _check(base: BaseCase, points: Sequence[Point], folder: Path) -> _Findings:
    """Prepare every case as if it were run. Raises CaseError for all that are not valid."""
    rows: list[ManifestRow] = []
    files: dict[str, float] = {}
    problems: dict[str, CaseError] = {}
    warnings: dict[str, None] = {}
    usual: tuple[str, ...] = ()
    stages, memory = sys.maxsize, 0.0
    for index, point in enumerate(points):
        settings = tuple(value.setting for value in point)
        try:
            case = base.prepare(settings, folder / RESULTS_NAME)
        except CaseError as error:
            texts = {text: value for value in point for text in value.setting.overrides(base.stages)}
            problems |= {str(problem): problem for problem in _placed(error, texts)}
            continue
        rows.append(ManifestRow(index, case.id, settings, case.expected.seconds))
        files[case.id] = case.expected.file
        warnings |= dict.fromkeys(case.setup.model.warnings)
        stages = min(stages, len(case.setup.load_path.last_steps))
        memory = max(memory, case.expected.memory)
        usual = usual or _usual(case.setup)
    if problems:
        raise _all_of(problems.values())
    return _Findings(tuple(rows), tuple(warnings), stages, usual, memory, sum(files.values()))


def _placed(error: CaseError, texts: Mapping[str, Value]) -> Iterator[CaseError]:
    """Yield the problems in `error`, each at the value of the sweep file that causes it, if one does."""
    for problem, value in with_origins(error, texts):
        depth = value.setting.key.count(".") + 1 if value else 0
        yield value.problem(problem.message, problem.key[depth:]) if value else problem


def _all_of(found: Iterable[CaseError]) -> CaseError:
    problems = list(found)
    if len(problems) == 1:
        return problems[0]
    if len(problems) > MOST_SHOWN:
        more = CaseError(f"and {len(problems) - MOST_SHOWN} more problems", (), problems[-1].file)
        problems = [*problems[:MOST_SHOWN], more]
    return CaseErrors(problems)


def _usual(setup: ProblemSetup) -> tuple[str, ...]:
    last = len(setup.load_path.last_steps)
    return tuple(one.name if one.stage == last else str(one) for one in usual_quantities(setup))


def _quantities(spec: SweepSpec, source: CaseSource, found: _Findings) -> tuple[str, ...]:
    for index, text in enumerate(spec.quantities):
        try:
            read_quantity(text, found.stages)
        except CaseError as error:
            raise source.problem(error.message, ("quantities", index)) from None
    return spec.quantities or found.usual
