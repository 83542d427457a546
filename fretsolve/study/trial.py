"""The runs of a study before they are made: each a valid case with the name of its result."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fretsolve.case import CaseErrors, HeightsSurface, load_case
from fretsolve.errors import CaseError, KeyPath
from fretsolve.setup.cost_estimate import estimate, require_memory
from fretsolve.setup.problem_setup import ProblemSetup, set_up
from fretsolve.simulation.run_to_file import run_header
from fretsolve.study.variation import Combination

if TYPE_CHECKING:
    from fretsolve.result import RunHeader

WITHOUT_EXTRAS = ("output.fields=[]", "solver.error_bars=false")
"""A study compares scalars; without fields a result takes some tens of kilobytes. It finds errors itself."""

IRRELEVANT = ("title", "expect")
"""Keys of a case that change nothing of a run, not even whether it fails."""

DIGITS = 16
"""Hexadecimal digits in the name of a result."""


@dataclass(frozen=True)
class Trial:
    """One run of a study. out: its result file, named by what the run is."""

    combination: Combination
    setup: ProblemSetup
    header: RunHeader
    out: Path

    @property
    def seconds(self) -> float:
        """Estimated, for the order of the runs and for progress."""
        return estimate(self.setup).seconds


def prepare_trials(
    path: Path, overrides: Sequence[str], combinations: Sequence[Combination], folder: Path
) -> list[Trial]:
    """All runs, in the order of `combinations`. Raises CaseError or FileError for the first that is no valid case."""
    stages = [stage.key for stage in load_case(path, overrides).stages()]
    trials = []
    for combination in combinations:
        varied = [text for setting in combination.settings for text in setting.overrides(stages)]
        texts = (*overrides, *varied, *WITHOUT_EXTRAS)
        try:
            setup = set_up(load_case(path, texts))
            require_memory(setup)
            if any(isinstance(surface, HeightsSurface) for surface in setup.case.surface):
                setup.separation()  # reads the maps
        except CaseError as error:
            raise _at_its_setting(error, combination, stages) from None
        header = run_header(setup, 1, texts)
        trials.append(Trial(combination, setup, header, folder / f"{digest(header)}.h5"))
    return trials


def digest(header: RunHeader) -> str:
    """Of all that a run's outcome depends on, failures included."""
    case = {name: value for name, value in json.loads(header.effective_case).items() if name not in IRRELEVANT}
    identity = json.dumps([case, header.inputs, header.version, header.format_version], sort_keys=True)
    return hashlib.sha256(identity.encode()).hexdigest()[:DIGITS]


def finest(trials: Sequence[Trial]) -> Trial:
    """The trial with the most points, then increments, then terms of the model, then the least tolerance."""

    def rank(trial: Trial) -> tuple[float, ...]:
        nx, ny = trial.setup.grid.shape
        terms = trial.setup.model.terms
        kept = sum((terms.tangential, terms.in_plane_coupling, terms.normal_tangential_coupling))
        return nx * ny, trial.setup.load_path.increments, kept, -trial.setup.case.solver.tolerance

    return max(reversed(trials), key=rank)


def stage_count(trials: Sequence[Trial]) -> int:
    """Stages that every trial has."""
    return min(len(trial.setup.load_path.last_steps) for trial in trials)


def _at_its_setting(error: CaseError, combination: Combination, stages: Sequence[KeyPath]) -> CaseError:
    """One line that names the `--vary` at fault; the error itself where none is."""
    first = error.problems[0] if isinstance(error, CaseErrors) else error
    for setting in combination.settings:
        if str(first.file) in {f"--set {text}" for text in setting.overrides(stages)}:
            return CaseError(first.message, first.key, setting.origin)
    return error
