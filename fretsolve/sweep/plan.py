"""The plan of a sweep: all its cases, checked before anything runs."""

from __future__ import annotations

import sys
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

from fretsolve.case.loading import read_case, validated
from fretsolve.case.source import CaseSource
from fretsolve.errors import CaseError, FileError
from fretsolve.setup.cost_estimate import free_bytes, rounded_bytes
from fretsolve.setup.kernel_choice import compiling_pays, seconds_saved
from fretsolve.sweep.base_case import FILES_BESIDE, BaseCase, placed
from fretsolve.sweep.beginnings import Beginning, beginnings_of, shared
from fretsolve.sweep.manifest import RESULTS_NAME, Manifest, ManifestRow
from fretsolve.sweep.points import Point, Value, all_of, common_values, overrides_of, points_of
from fretsolve.sweep.quantity import CORRECTED_NAMES, key_beside, read_quantity, usual_quantities
from fretsolve.sweep.spec import SweepSpec
from fretsolve.sweep.status import missing


@dataclass(frozen=True)
class SweepPlan:
    """A checked sweep. warnings: those of all its cases, each once."""

    manifest: Manifest
    spec: SweepSpec
    source: CaseSource
    warnings: tuple[str, ...]


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
    rows: list[ManifestRow] = []
    files: dict[str, float] = {}
    saved: dict[str, float] = {}
    beginnings: dict[str, tuple[Beginning, ...]] = {}
    found: dict[str, None] = {}
    usual: tuple[str, ...] = ()
    stages, memory, have_bars = sys.maxsize, 0.0, True
    have = {*FILES_BESIDE, "wear"}
    for index, prepared in enumerate(base.prepare_all(points, folder / RESULTS_NAME)):
        setup = prepared.setup
        rows.append(prepared.row(index))
        files[prepared.id] = prepared.expected.file
        beginnings[prepared.id] = beginnings_of(setup, prepared.header, prepared.expected.seconds)
        saved[prepared.id] = seconds_saved(setup.model, setup.grid, setup.load_path)
        found |= dict.fromkeys(setup.model.warnings)
        have_bars &= setup.case.solver.error_bars
        have &= {*prepared.beside, *(["wear"] if setup.case.wear is not None else [])}
        last = len(setup.load_path.last_steps)
        stages, memory = min(stages, last), max(memory, prepared.expected.memory)
        usual = usual or tuple(one.name if one.stage == last else str(one) for one in usual_quantities(setup))
    _require_quantities(spec, text.source, stages, have_bars=have_bars, have=have)
    found_shared = shared(beginnings)
    manifest = Manifest(
        folder.absolute(),
        path.absolute(),
        spec.title or path.stem,
        case.absolute(),
        base.overrides,
        spec.quantities or usual,
        spec.threads,
        memory,
        tuple(replace(row, shared=found_shared[row.id]) for row in rows),
        compiled=compiling_pays(sum(saved.values())),
    )
    warnings, free = tuple(found), free_bytes(manifest.folder)
    left = sum(files.values()) * len(missing(manifest)) / len(manifest.unique)
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


def _require_quantities(
    spec: SweepSpec, source: CaseSource, stages: int, *, have_bars: bool, have: Collection[str]
) -> None:
    for index, text in enumerate(spec.quantities):
        try:
            quantity = read_quantity(text, stages)
        except CaseError as error:
            raise source.problem(error.message, ("quantities", index)) from None
        if (key := key_beside(quantity.name)) and key.removeprefix("output.") not in have:
            problem = f"{quantity.name} is known from runs with {key} alone; {key} in the case is needed"
            raise source.problem(problem, ("quantities", index))
        if quantity.name in CORRECTED_NAMES and not have_bars:
            problem = f"{quantity.name} is known from runs with error bars alone; error_bars: true is needed"
            raise source.problem(problem, ("quantities", index))
