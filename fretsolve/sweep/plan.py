"""The plan of a sweep: all its cases, checked before anything runs."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

from fretsolve.case.loading import read_case, validated
from fretsolve.case.source import CaseSource
from fretsolve.errors import CaseError, FileError
from fretsolve.setup.cost_estimate import free_bytes, rounded_bytes
from fretsolve.setup.problem import compiling_pays
from fretsolve.sweep.base_case import FILES_BESIDE, BaseCase, PreparedCase, placed
from fretsolve.sweep.beginnings import Beginning, beginnings_of, shared
from fretsolve.sweep.manifest import RESULTS_NAME, Manifest, ManifestRow
from fretsolve.sweep.points import Point, Value, all_of, common_values, overrides_of, points_of
from fretsolve.sweep.quantity import CORRECTED_NAMES, ERROR_OF_WEAR, key_beside, read_quantity, usual_quantities
from fretsolve.sweep.spec import SweepSpec
from fretsolve.sweep.status import missing


@dataclass(frozen=True)
class SweepPlan:
    """A checked sweep. warnings: those of all its cases, each once."""

    manifest: Manifest
    spec: SweepSpec
    source: CaseSource
    warnings: tuple[str, ...]


@dataclass
class _Survey:
    """The needs of a sweep's cases, gathered one by one, since their setups take too much memory to be kept.

    file_bytes, seconds_saved (by compiling), beginnings: by the name of the case; warnings: each once; usual: the
    quantities of the first case; stages: the fewest of a case; memory: the largest (bytes); have_bars: whether all have
    error bars; beside: what all have beside their history.
    """

    rows: list[ManifestRow] = field(default_factory=list)
    file_bytes: dict[str, float] = field(default_factory=dict)
    seconds_saved: dict[str, float] = field(default_factory=dict)
    beginnings: dict[str, tuple[Beginning, ...]] = field(default_factory=dict)
    warnings: dict[str, None] = field(default_factory=dict)
    usual: tuple[str, ...] = ()
    stages: int = sys.maxsize
    memory: float = 0.0
    have_bars: bool = True
    beside: set[str] = field(default_factory=lambda: {*FILES_BESIDE, "wear"})

    def add(self, prepared: PreparedCase) -> None:
        """Gather what the next case has."""
        setup, expected = prepared.setup, prepared.expected
        self.rows.append(prepared.row(len(self.rows)))
        self.file_bytes[prepared.id] = expected.file
        self.seconds_saved[prepared.id] = setup.seconds_saved
        self.beginnings[prepared.id] = beginnings_of(setup, prepared.header, expected.seconds)
        self.warnings |= dict.fromkeys(setup.model.warnings)
        last = len(setup.load_path.last_steps)
        if not self.usual:
            usual = (one.name if one.stage == last else str(one) for one in usual_quantities(setup))
            self.usual = (*usual, *((ERROR_OF_WEAR,) if setup.case.wear is not None else ()))
        self.stages, self.memory = min(self.stages, last), max(self.memory, expected.memory)
        self.have_bars &= setup.case.solver.error_bars
        self.beside &= {*prepared.beside, *(["wear"] if setup.case.wear is not None else [])}

    def rows_with_beginnings(self) -> tuple[ManifestRow, ...]:
        """Return the rows with the beginnings that several cases share."""
        found = shared(self.beginnings)
        return tuple(replace(row, shared=found[row.id]) for row in self.rows)


def make_sweep_plan(path: Path, folder: Path) -> SweepPlan:
    """Read the sweep file and check every case. Raises CaseError, FileError."""
    text = read_case(path, pipe=True)
    text.require_mapping(("case", "axes"))
    if isinstance(text.data, dict) and {"bodies", "load_path"} <= text.data.keys():
        raise text.source.problem("this is a case file; `fretsolve run` takes it, a sweep file names it as `case`")
    spec = validated(SweepSpec, text.data, text.source, text.problems)
    common, points = common_values(spec, text.source), points_of(spec, text.source)
    case = path.parent / spec.case
    base = _base(case, spec, common, text.source)
    survey = _Survey()
    for prepared in base.prepare_all(points, folder / RESULTS_NAME):
        survey.add(prepared)
    _require_quantities(spec, text.source, survey)
    manifest = Manifest(
        folder.absolute(),
        path.absolute(),
        spec.title or path.stem,
        case.absolute(),
        base.overrides,
        spec.quantities or survey.usual,
        spec.threads,
        survey.memory,
        survey.rows_with_beginnings(),
        compiled=compiling_pays(sum(survey.seconds_saved.values())),
    )
    warnings, free = tuple(survey.warnings), free_bytes(manifest.folder)
    left = sum(survey.file_bytes.values()) * len(missing(manifest)) / len(manifest.unique)
    if free is not None and left > free:
        warnings += (
            f"results of about {rounded_bytes(left)} are missing, {rounded_bytes(free)} are free on the disk of"
            f" {folder}, which may be too little; empty cells take less, so the sweep goes on",
        )
    return SweepPlan(manifest, spec, text.source, warnings)


def _base(case: Path, spec: SweepSpec, common: Point, source: CaseSource) -> BaseCase:
    extra = ["solver.error_bars=true"] if spec.error_bars else []
    values: dict[str, Value] = {}
    try:
        text = read_case(case)
    except FileError as error:
        raise source.problem(str(error), ("case",)) from None
    try:
        for of_every_stage in (False, True):  # the other keys may change how many stages there are
            stages = BaseCase.of(text, list(values)).stages if of_every_stage else ()
            chosen = [value for value in common if ("*" in value.name) == of_every_stage]
            values |= {one: value for value in chosen for one in overrides_of(value.name, value.text, stages)}
        return BaseCase.of(text, [*values, *extra], spec.threads)
    except CaseError as error:
        raise all_of(placed(error, values, text)) from None


def _require_quantities(spec: SweepSpec, source: CaseSource, survey: _Survey) -> None:
    """Raise CaseError if the cases do not have a quantity that the sweep names."""
    for index, text in enumerate(spec.quantities):
        try:
            quantity = read_quantity(text, survey.stages)
        except CaseError as error:
            raise source.problem(error.message, ("quantities", index)) from None
        if (key := key_beside(quantity.name)) and key.removeprefix("output.") not in survey.beside:
            problem = f"{quantity.name} is known from runs with {key} alone; {key} in the case is needed"
            raise source.problem(problem, ("quantities", index))
        if quantity.name in CORRECTED_NAMES and not survey.have_bars:
            problem = f"{quantity.name} is known from runs with error bars alone; error_bars: true is needed"
            raise source.problem(problem, ("quantities", index))
