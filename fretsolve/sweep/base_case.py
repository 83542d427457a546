"""The base case of a sweep or study, and its cases at the varied points."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from fretsolve.case.loading import CaseText, read_case
from fretsolve.case.problems import CaseErrors
from fretsolve.case.source import Override
from fretsolve.case.surface_specs import HeightsSurface
from fretsolve.errors import CaseError, KeyPath
from fretsolve.result import RunHeader
from fretsolve.setup.cost_estimate import Estimate, require_memory
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.run_to_file import run_header
from fretsolve.sweep.points import Setting

IRRELEVANT = ("title", "expect")
"""Keys of a case that change nothing in its run."""

DIGITS = 16
"""Hexadecimal digits in the name of a result."""

Origin = TypeVar("Origin")


@dataclass(frozen=True)
class PreparedCase:
    """A case that can run. id: names its result `out`, the same for equal cases; expected: its estimated cost."""

    settings: tuple[Setting, ...]
    setup: ProblemSetup
    header: RunHeader
    id: str
    out: Path
    expected: Estimate


@dataclass(frozen=True)
class BaseCase:
    """What all cases share: the case file, read once, with the common overrides. stages: the keys of its stages.

    overrides: as `--set` takes them; last: overrides that come after the settings of a case.
    """

    text: CaseText
    overrides: tuple[str, ...]
    last: tuple[str, ...]
    stages: tuple[KeyPath, ...]
    threads: int

    @classmethod
    def read(cls, path: Path, overrides: Sequence[str], threads: int = 1, last: Sequence[str] = ()) -> BaseCase:
        """Read the case file. Raises CaseError, FileError."""
        text = read_case(path).overridden(overrides)
        stages = tuple(stage.key for stage in text.case().stages())
        return cls(text, tuple(overrides), tuple(last), stages, threads)

    def prepare(self, settings: Iterable[Setting], folder: Path) -> PreparedCase:
        """Set up the case at `settings`, whose result goes to `folder`.

        Raises CaseError if it is not valid, does not fit into memory or has an unusable height map; FileError.
        """
        settings = tuple(settings)
        own = [text for setting in settings for text in setting.overrides(self.stages)] + list(self.last)
        setup = set_up(self.text.case(own))
        expected = require_memory(setup)
        if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
            setup.separation()  # reads the height maps
        header = run_header(setup, self.threads, (*self.overrides, *own))
        name = digest(header)
        return PreparedCase(settings, setup, header, name, folder / f"{name}.h5", expected)


def digest(header: RunHeader) -> str:
    """Return a digest of all that the outcome of a run depends on."""
    case = {name: value for name, value in json.loads(header.effective_case).items() if name not in IRRELEVANT}
    identity = json.dumps([case, header.inputs, header.version, header.format_version], sort_keys=True)
    return hashlib.sha256(identity.encode()).hexdigest()[:DIGITS]


def with_origins(error: CaseError, texts: Mapping[str, Origin]) -> Iterator[tuple[CaseError, Origin | None]]:
    """Yield each problem in `error` with the origin of the override at fault, None if no override is.

    texts: overrides and where they come from.
    """
    origins = {Override((), text).origin: origin for text, origin in texts.items()}
    for problem in error.problems if isinstance(error, CaseErrors) else [error]:
        yield problem, origins.get(str(problem.file))
