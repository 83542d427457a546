"""The base case of a sweep or study, and its cases at the varied points."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fretsolve.case.keys.surface_specs import HeightsSurface
from fretsolve.case.loading import EVERY_STAGE, CaseText
from fretsolve.case.problems import CaseErrors
from fretsolve.case.source import Override
from fretsolve.errors import CaseError, KeyPath
from fretsolve.result import RunHeader
from fretsolve.setup.cost_estimate import Estimate, require_memory
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.run_to_file import run_header
from fretsolve.sweep.manifest import ManifestRow
from fretsolve.sweep.points import Point, Value, all_of, overrides_of

FILES_BESIDE = ("stress", "fatigue")
"""What a case may ask for beside its result, the file of which is called NAME.stress.h5 or NAME.fatigue.h5."""


@dataclass(frozen=True)
class PreparedCase:
    """A case that can run. settings: the varied keys and their values; id: names its result `out`, the same for equal
    cases; expected: its estimated cost.
    """

    settings: Mapping[str, str]
    setup: ProblemSetup
    header: RunHeader
    id: str
    out: Path
    expected: Estimate

    @property
    def beside(self) -> tuple[str, ...]:
        """The files beside the result that the case asks for, as `Manifest.is_finished` takes them."""
        output = self.setup.case.output
        return tuple(name for name in FILES_BESIDE if getattr(output, name) is not None)

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
        setup = set_up(self.text.case(own), self.compiled)
        expected = require_memory(setup)
        if setup.case.output.fatigue is not None:
            from fretsolve.fatigue.request import require_fatigue

            require_fatigue(setup)
        if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
            setup.separation()  # reads the height maps
        header = run_header(setup, self.threads, (*self.overrides, *own))
        name = digest(header.attributes("running"))
        return PreparedCase(settings, setup, header, name, folder / f"{name}.h5", expected)

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
        """Raise CaseError if two values are of the same key; that of one stage may follow that of every stage."""
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


def digest(attributes: Mapping[str, Any]) -> str:
    """Return a digest of all that the outcome of a run depends on, which title and expected values do not change.

    attributes: of the run's header or result.
    """
    effective = json.loads(attributes["effective_case"])
    case = {name: value for name, value in effective.items() if name not in ("title", "expect")}
    rest = [attributes.get(name) for name in ("inputs", "fretsolve_version", "format_version")]
    identity = json.dumps([case, *rest], sort_keys=True)
    return hashlib.sha256(identity.encode()).hexdigest()[:16]


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
