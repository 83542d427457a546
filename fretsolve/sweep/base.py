"""What the cases of a sweep share: the case file, read once, and the overrides of all of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.case import CaseText, HeightsSurface, read_case
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.run_to_file import run_header
from fretsolve.study.trial import digest

if TYPE_CHECKING:
    from fretsolve.errors import KeyPath
    from fretsolve.result import RunHeader
    from fretsolve.study.variation import Setting


@dataclass(frozen=True)
class Base:
    """text: the case file with what every case overrides; stages: the keys of all stages of the case with it.

    overrides: of every case, as `--set` takes them.
    """

    text: CaseText
    overrides: tuple[str, ...]
    stages: tuple[KeyPath, ...]
    threads: int

    @classmethod
    def read(cls, path: Path, overrides: Sequence[str], threads: int) -> Base:
        """Raises CaseError, FileError."""
        text = read_case(path).overridden(overrides)
        stages = tuple(stage.key for stage in text.case().stages())
        return cls(text, tuple(overrides), stages, threads)

    def texts(self, settings: Iterable[Setting]) -> tuple[str, ...]:
        """All overrides of the case at `settings`."""
        return (*self.overrides, *self._own(settings))

    def _own(self, settings: Iterable[Setting]) -> list[str]:
        return [text for setting in settings for text in setting.overrides(self.stages)]

    def setup(self, settings: Iterable[Setting]) -> ProblemSetup:
        """The case at `settings`, made ready. Raises CaseError, FileError."""
        return set_up(self.text.case(self._own(settings)))

    def header(self, setup: ProblemSetup, settings: Iterable[Setting]) -> RunHeader:
        """What the result of `scene` says about its run. Raises FileError."""
        return run_header(setup, self.threads, self.texts(settings))


def identity(header: RunHeader) -> str:
    """The name of a case's result: the same for the same case, whatever sweep it is in."""
    return digest(header)


def read_height_maps(setup: ProblemSetup) -> None:
    """Raise CaseError or FileError where a height map of the case cannot be used."""
    if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
        setup.separation()
