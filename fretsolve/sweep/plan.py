"""The cases of a sweep or study, and the plan of a sweep: all are checked before anything runs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import get_args

from fretsolve.case.expected import lacking_of
from fretsolve.case.keys.map_keys import HeightsSurface
from fretsolve.case.keys.quantity_names import BESIDE_DIMENSIONS
from fretsolve.case.loading import EVERY_STAGE, CaseText, read_case, validated
from fretsolve.case.source import CaseSource, Override
from fretsolve.errors import CaseError, CaseErrors, FileError, KeyPath
from fretsolve.problem.setup.cost_estimate import Estimate, free_bytes, require_memory, rounded_bytes
from fretsolve.problem.setup.problem import ProblemSetup, compiling_pays
from fretsolve.result import RunHeader
from fretsolve.simulation.accuracy.rounds import Round, first_round, most_memory
from fretsolve.simulation.accuracy.saved_rounds import header_of_round
from fretsolve.sweep.beginnings import beginnings_of, shared
from fretsolve.sweep.manifest import RESULTS_NAME, Manifest, ManifestRow, SideOutput, digest
from fretsolve.sweep.quantity import (
    CORRECTED_NAMES,
    ERROR_OF_WEAR,
    NEEDED_KEYS,
    needed_key,
    read_quantity,
    usual_quantities,
)
from fretsolve.sweep.sweep_file import Point, SweepSpec, Value, all_of, common_values, overrides_of, points_of

SIDE_OUTPUTS: tuple[SideOutput, ...] = get_args(SideOutput)


@dataclass(frozen=True)
class PreparedCase:
    """A case that can run. settings: the varied keys and their values; first: the round with which it begins, the only
    one without an accuracy; header_of: returns the header of a round; id: names its result `out`, equal for equal
    cases; expected: its estimated cost.
    """

    settings: Mapping[str, str]
    first: Round
    header_of: Callable[[Round], RunHeader]
    id: str
    out: Path
    expected: Estimate

    @property
    def setup(self) -> ProblemSetup:
        """The problem of the first round."""
        return self.first.setup

    @cached_property
    def header(self) -> RunHeader:
        """The header of the first round."""
        return self.header_of(self.first)

    @property
    def beside(self) -> tuple[SideOutput, ...]:
        """The side outputs that the case asks for."""
        output = self.setup.case.output
        return tuple(name for name in SIDE_OUTPUTS if getattr(output, name) is not None)

    def row(self, index: int) -> ManifestRow:
        """Return the case as number `index` of a sweep or study."""
        return ManifestRow(index, self.id, self.settings, self.expected.seconds, beside=self.beside)


@dataclass(frozen=True)
class BaseCase:
    """The base of all cases: the case file, read once, with the common overrides. stages: the keys of its stages.

    overrides: as `--set` takes them; last: overrides that come after the settings of a case; compiled: whether all
    cases use the compiled kernels, None where each decides.
    """

    text: CaseText
    overrides: tuple[str, ...]
    last: tuple[str, ...]
    stages: tuple[KeyPath, ...]
    threads: int
    compiled: bool | None = False

    @classmethod
    def of(
        cls,
        text: CaseText,
        overrides: Sequence[str],
        threads: int = 1,
        last: Sequence[str] = (),
        compiled: bool | None = None,
    ) -> BaseCase:
        """Return the base case of a case file. Raises CaseError."""
        text = text.overridden(overrides)
        stages = tuple(stage.key for stage in text.case().stages())
        return cls(text, tuple(overrides), tuple(last), stages, threads, compiled)

    def prepare(self, settings: Mapping[str, str], folder: Path) -> PreparedCase:
        """Set up the case at `settings`, whose result goes to `folder`.

        Raises CaseError if it is not valid, does not fit into memory or has an unusable height map; FileError.
        """
        own = [text for item in settings.items() for text in overrides_of(*item, self.stages)] + list(self.last)
        first = first_round(self.text.case(own), self.compiled)
        setup = first.setup
        expected = require_memory(setup)
        if setup.case.output.fatigue is not None:
            from fretsolve.post.fatigue.request import require_fatigue

            require_fatigue(setup)
        if setup.case.output.crack is not None:
            from fretsolve.post.crack.request import require_crack

            require_crack(setup)
        if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
            setup.separation()  # reads the height maps
        header_of = partial(header_of_round, self.threads, (*self.overrides, *own))
        name = digest(header_of(first).attributes("running"))
        return PreparedCase(settings, first, header_of, name, folder / f"{name}.h5", expected)

    def prepare_all(self, points: Iterable[Point], folder: Path) -> Iterator[PreparedCase]:
        """Yield the case at each of `points` as if it were run. At the end, raises CaseError for all that are wrong."""
        problems: dict[str, CaseError] = {}
        checked: set[tuple[str, ...]] = set()
        for point in points:
            values = [(text, value) for value in point for text in overrides_of(value.name, value.text, self.stages)]
            names = tuple(value.name for value in point)
            if names not in checked:
                checked.add(names)
                self._require_different_keys(values)
            try:
                yield self.prepare({value.name: value.text for value in point}, folder)
            except CaseError as error:
                problems |= {str(problem): problem for problem in placed(error, dict(values), self.text)}
        if problems:
            raise all_of(problems.values())

    def _require_different_keys(self, values: Sequence[tuple[str, Value]]) -> None:
        """Raise CaseError if a key has two values; the value of one stage may follow the value of every stage."""
        origin, seen = dict(values), dict[KeyPath, str]()
        overridden = self.text.overridden([text for text, _ in values])
        for override in overridden.source.overrides[len(self.text.source.overrides) :]:
            value = origin[override.text]
            first = seen.get(override.key)
            if first == value.name:
                raise value.problem("the key is varied twice; give all of its values at once")
            if first is not None and not first.startswith(EVERY_STAGE):
                raise value.problem(f"{first} and {value.name} are the same key; keep one of the two")
            seen[override.key] = value.name


def placed(error: CaseError, values: Mapping[str, Value], text: CaseText) -> Iterator[CaseError]:
    """Yield each problem in `error` at the value that causes it, if one does. values: by overrides of `text`."""
    of_origin = {Override((), override).origin: value for override, value in values.items()}
    source = text.overridden(list(values)).source
    keys = {override.origin: source.typed(override.key) for override in source.overrides}
    for problem in error.problems if isinstance(error, CaseErrors) else [error]:
        origin = str(problem.file)
        own = keys.get(origin, problem.key)
        inside = problem.key[len(own) if problem.key[: len(own)] == own else 0 :]
        yield of_origin[origin].problem(problem.message, inside) if origin in of_origin else problem


@dataclass(frozen=True)
class SweepPlan:
    """A checked sweep. warnings: of all its cases, each once."""

    manifest: Manifest
    spec: SweepSpec
    source: CaseSource
    warnings: tuple[str, ...]


@dataclass
class _Survey:
    """The needs of a sweep's cases, gathered one by one, since their setups take too much memory to be kept.

    file_bytes, seconds_saved (by compiling): by the name of the case; warnings: each once; usual: the quantities of the
    first case; stages: the fewest of a case; memory: the largest (bytes); have_bars: whether all have error bars;
    lacking: what some case lacks for a quantity beside its result; beside: what all have beside their
    history, and keys of the case that give quantities.
    """

    rows: list[ManifestRow] = field(default_factory=list)
    file_bytes: dict[str, float] = field(default_factory=dict)
    seconds_saved: dict[str, float] = field(default_factory=dict)
    warnings: dict[str, None] = field(default_factory=dict)
    usual: tuple[str, ...] = ()
    stages: int = sys.maxsize
    memory: float = 0.0
    have_bars: bool = True
    lacking: dict[str, str] = field(default_factory=dict)
    beside: set[str] = field(default_factory=lambda: {*SIDE_OUTPUTS, *NEEDED_KEYS})

    def add(self, prepared: PreparedCase) -> None:
        """Gather what the next case has."""
        setup, expected = prepared.setup, prepared.expected
        beginnings = beginnings_of(setup, prepared.header, expected.seconds)
        self.rows.append(replace(prepared.row(len(self.rows)), shared=beginnings))
        self.file_bytes[prepared.id] = expected.file
        self.seconds_saved[prepared.id] = setup.seconds_saved
        self.warnings |= dict.fromkeys(setup.model.warnings)
        last = len(setup.load_path.last_steps)
        if not self.usual:
            usual = (one.name if one.stage == last else str(one) for one in usual_quantities(setup))
            self.usual = (*usual, *((ERROR_OF_WEAR,) if setup.case.wear is not None else ()))
        self.stages, self.memory = (
            min(self.stages, last),
            max(self.memory, most_memory(prepared.first, expected.memory)),
        )
        self.have_bars &= setup.case.solver.error_bars
        lacking = ((name, lacking_of(name, setup.case.output)) for name in BESIDE_DIMENSIONS)
        self.lacking |= {name: text for name, text in lacking if text is not None}
        self.beside &= {*prepared.beside, *(key for key in NEEDED_KEYS if getattr(setup.case, key) is not None)}


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
    several = shared({row.id: row.shared for row in survey.rows})
    manifest = Manifest(
        folder.absolute(),
        path.absolute(),
        spec.title or path.stem,
        case.absolute(),
        base.overrides,
        spec.quantities or survey.usual,
        spec.threads,
        survey.memory,
        tuple(replace(row, shared=several[row.id]) for row in survey.rows),
        compiled=compiling_pays(sum(survey.seconds_saved.values())),
    )
    warnings, free = tuple(survey.warnings), free_bytes(manifest.folder)
    left = sum(survey.file_bytes.values()) * len(manifest.missing()) / len(manifest.unique)
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
    for index, text in enumerate(spec.quantities):
        try:
            quantity = read_quantity(text, survey.stages)
        except CaseError as error:
            raise source.problem(error.message, ("quantities", index)) from None
        if (key := needed_key(quantity.name)) and key.removeprefix("output.") not in survey.beside:
            problem = f"{quantity.name} is known from runs with {key} alone; {key} in the case is needed"
            raise source.problem(problem, ("quantities", index))
        if quantity.name in survey.lacking:
            raise source.problem(f"{quantity.name} {survey.lacking[quantity.name]}", ("quantities", index))
        if quantity.name in CORRECTED_NAMES and not survey.have_bars:
            problem = f"{quantity.name} is known from runs with error bars alone; error_bars: true is needed"
            raise source.problem(problem, ("quantities", index))
