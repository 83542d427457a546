"""What a sweep is going to run, settled and checked before anything runs."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.case import CaseErrors, read_case
from fretsolve.case.loading import validated
from fretsolve.case.source import Override
from fretsolve.errors import CaseError, FileError
from fretsolve.setup.cost_estimate import free_bytes, require_memory, rounded_bytes
from fretsolve.study.quantity import read_observable, usual_observables
from fretsolve.sweep.base import Base, identity, read_height_maps
from fretsolve.sweep.manifest import Manifest, Row
from fretsolve.sweep.points import Point, Value, common_values, points_of
from fretsolve.sweep.spec import SweepSpec
from fretsolve.sweep.state import missing

if TYPE_CHECKING:
    from fretsolve.case import CaseSource
    from fretsolve.setup.problem_setup import ProblemSetup

MOST_SHOWN = 10
"""Problems that are reported one by one."""


@dataclass(frozen=True)
class Plan:
    """A checked sweep. warnings: what a person should hear of its cases, each once."""

    manifest: Manifest
    spec: SweepSpec
    source: CaseSource
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class Findings:
    """What the check of all cases finds. stages: how many every case has; usual: what is collected by default.

    memory, files: estimated bytes, of the largest case and of all results.
    """

    rows: tuple[Row, ...]
    warnings: tuple[str, ...]
    stages: int
    usual: tuple[str, ...]
    memory: float
    files: float


def make_plan(path: Path, folder: Path) -> Plan:
    """Read the sweep file and check every case. Raises CaseError, FileError."""
    text = read_case(path)
    text.require_mapping(("case", "axes"))
    spec = validated(SweepSpec, text.data, text.source, text.problems)
    common, points = common_values(spec, text.source), points_of(spec, text.source)
    case = path.parent / spec.case
    base = _base(case, spec, common, text.source)
    found = _check(base, points)
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
            f" {folder}, which may be too little; empty cells compress, the sweep goes on",
        )
    return Plan(manifest, spec, text.source, warnings)


def _base(case: Path, spec: SweepSpec, common: Point, source: CaseSource) -> Base:
    extra = ["solver.error_bars=true"] if spec.error_bars else []
    texts: list[tuple[str, Value]] = []
    try:
        for of_every_stage in (False, True):  # which the others may change
            values = [value for value in common if ("*" in value.setting.key) == of_every_stage]
            stages = Base.read(case, [text for text, _ in texts], spec.threads).stages if of_every_stage else ()
            texts += [(text, value) for value in values for text in value.setting.overrides(stages)]
        return Base.read(case, [*(text for text, _ in texts), *extra], spec.threads)
    except FileError as error:
        raise source.problem(str(error), ("case",)) from None
    except CaseError as error:
        raise _all_of(list(_placed(error, texts))) from None


def _check(base: Base, points: Sequence[Point]) -> Findings:
    """Every case, made ready as if it were run. Raises CaseError for all that are none."""
    rows: list[Row] = []
    files: dict[str, float] = {}
    problems: dict[str, CaseError] = {}
    warnings: dict[str, None] = {}
    usual: tuple[str, ...] = ()
    stages, memory = sys.maxsize, 0.0
    for index, point in enumerate(points):
        settings = tuple(value.setting for value in point)
        try:
            setup = base.setup(settings)
            expected = require_memory(setup)
            read_height_maps(setup)
        except CaseError as error:
            texts = [(text, value) for value in point for text in value.setting.overrides(base.stages)]
            problems |= {str(problem): problem for problem in _placed(error, texts)}
            continue
        rows.append(Row(index, identity(base.header(setup, settings)), settings, expected.seconds))
        files[rows[-1].id] = expected.file
        warnings |= dict.fromkeys(setup.model.warnings)
        stages, memory = min(stages, len(setup.load_path.last_steps)), max(memory, expected.memory)
        usual = usual or _usual(setup)
    if problems:
        raise _all_of(list(problems.values()))
    return Findings(tuple(rows), tuple(warnings), stages, usual, memory, sum(files.values()))


def _placed(error: CaseError, texts: Sequence[tuple[str, Value]]) -> Iterator[CaseError]:
    """The problems in `error`, each at the value of the sweep that causes it, else where it arose."""
    origins = {Override((), text).origin: value for text, value in texts}
    for problem in error.problems if isinstance(error, CaseErrors) else [error]:
        value = origins.get(str(problem.file))
        if value is None:
            yield problem
        else:
            depth = value.setting.key.count(".") + 1
            yield value.problem(problem.message, problem.key[depth:])


def _all_of(problems: Sequence[CaseError]) -> CaseError:
    if len(problems) == 1:
        return problems[0]
    if len(problems) > MOST_SHOWN:
        more = CaseError(f"and {len(problems) - MOST_SHOWN} more problems", (), problems[-1].file)
        problems = [*problems[:MOST_SHOWN], more]
    return CaseErrors(problems)


def _usual(setup: ProblemSetup) -> tuple[str, ...]:
    last = len(setup.load_path.last_steps)
    return tuple(one.name if one.stage == last else str(one) for one in usual_observables(setup))


def _quantities(spec: SweepSpec, source: CaseSource, found: Findings) -> tuple[str, ...]:
    for index, text in enumerate(spec.quantities):
        try:
            read_observable(text, found.stages)
        except CaseError as error:
            raise source.problem(error.message, ("quantities", index)) from None
    return spec.quantities or found.usual
