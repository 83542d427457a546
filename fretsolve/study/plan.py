"""The plan of a study: its runs, quantities and reference, checked before anything runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.errors import CaseError
from fretsolve.study.reference import NOUNS, ReferenceKind, compared_quantities, known_values
from fretsolve.study.variation import Variation, crossed, is_first_problem, read_variations, words
from fretsolve.sweep.base_case import BaseCase, PreparedCase, with_origins
from fretsolve.sweep.points import Setting
from fretsolve.sweep.quantity import StageQuantity, usual_quantities

WITHOUT_EXTRAS = ("output.fields=[]", "solver.error_bars=false")
"""A study compares scalars and finds errors itself; without fields a result takes some tens of kilobytes."""


@dataclass(frozen=True)
class StudyPlan:
    """The runs of a study: first the finest run of the first problem, then the others by their estimated cost.

    known: the reference if it is known before any run, None for the finest run. unknown: usual quantities for which the
    reference has no value, for the reason why_unknown, empty if that is clear.
    """

    variations: tuple[Variation, ...]
    trials: tuple[PreparedCase, ...]
    quantities: tuple[StageQuantity, ...]
    unknown: tuple[StageQuantity, ...]
    why_unknown: str
    kind: ReferenceKind
    known: Mapping[StageQuantity, float] | None

    @property
    def finest(self) -> PreparedCase:
        """The finest run of the first problem."""
        return self.trials[0]

    @property
    def problem_keys(self) -> tuple[str, ...]:
        """The varied keys that change the problem itself, so that differences are not errors."""
        return tuple(one.key for one in self.variations if one.changes_the_problem)

    @property
    def reference_words(self) -> str:
        """What the runs are compared with."""
        if self.known is not None:
            return f"the {NOUNS[self.kind]}s"
        return f"the {'run with' if self.problem_keys else 'finest run,'} {words(self.finest.settings)}"


def make_plan(
    case: Path,
    overrides: Sequence[str],
    varied: Sequence[str],
    quantities: Sequence[str],
    kind: ReferenceKind,
    folder: Path,
) -> StudyPlan:
    """Read what the command line gives as text, and check every run. Raises CaseError, FileError."""
    variations = read_variations(varied)
    changing = next((one for one in variations if one.changes_the_problem), None)
    if changing is not None and kind != "finest":
        message = (
            f"changes the problem itself, and --truth {kind} holds for one problem only; vary the grid, increments or"
            " settings of the solver, or leave --truth out"
        )
        raise CaseError(message, (), f"--vary {changing.key}")
    base = BaseCase.read(case, overrides, last=WITHOUT_EXTRAS)
    trials = [_prepared(base, settings, folder) for settings in crossed(variations)]
    costliest = finest([trial for trial in trials if is_first_problem(trial.settings, variations)])
    known = known_values(kind, costliest.setup)
    stages = min(len(trial.setup.load_path.last_steps) for trial in trials)
    compared = compared_quantities(quantities, stages, costliest.setup, kind, known)
    if not compared:
        raise CaseError("nothing to compare; name it with --quantity, such as --quantity delta_z", (), case)
    others = sorted((trial for trial in trials if trial is not costliest), key=lambda trial: trial.expected.seconds)
    usual = usual_quantities(costliest.setup) if kind == "closed-form" and not quantities else ()
    unknown = tuple(one for one in usual if one not in compared)
    why = costliest.setup.closed_forms.why_not_mindlin if unknown else ""
    return StudyPlan(variations, (costliest, *others), compared, unknown, why, kind, known)


def finest(trials: Sequence[PreparedCase]) -> PreparedCase:
    """Return the run with the most points, then increments, then terms of the model, then the least tolerance."""

    def rank(trial: PreparedCase) -> tuple[float, ...]:
        nx, ny = trial.setup.grid.shape
        terms = trial.setup.model.terms
        kept = sum((terms.tangential, terms.in_plane_coupling, terms.normal_tangential_coupling))
        return nx * ny, trial.setup.load_path.increments, kept, -trial.setup.case.solver.tolerance

    return max(reversed(trials), key=rank)


def _prepared(base: BaseCase, settings: Sequence[Setting], folder: Path) -> PreparedCase:
    """Prepare a run. Raises CaseError that names the `--vary` at fault, if one is."""
    try:
        return base.prepare(settings, folder)
    except CaseError as error:
        texts = {text: f"--vary {one.key}={one.value}" for one in settings for text in one.overrides(base.stages)}
        problem, origin = next(with_origins(error, texts))
        raise CaseError(problem.message, problem.key, origin) if origin else error from None
