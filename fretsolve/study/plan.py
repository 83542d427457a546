"""What a study is going to do, settled before anything runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from fretsolve.errors import CaseError
from fretsolve.study.compared_with import NOUNS, TruthKind, chosen_observables, known_values
from fretsolve.study.quantity import Observable, usual_observables
from fretsolve.study.trial import Trial, finest, prepare_trials, stage_count
from fretsolve.study.variation import Variation, crossed, read_variations


@dataclass(frozen=True)
class Plan:
    """The runs of a study in turn, the finest of the first problem first, then by their estimated cost.

    known: the truth where it is known before any run, else None: the finest run. unknown: what would usually be
    compared, but has no such truth, for the reason why_unknown, empty where that goes without saying.
    """

    variations: tuple[Variation, ...]
    trials: tuple[Trial, ...]
    observables: tuple[Observable, ...]
    unknown: tuple[Observable, ...]
    why_unknown: str
    kind: TruthKind
    known: Mapping[Observable, float] | None

    @property
    def finest(self) -> Trial:
        """The finest of the trials of the first problem."""
        return self.trials[0]

    @property
    def problem_keys(self) -> tuple[str, ...]:
        """The varied keys that change the problem itself, so that what differs is no error."""
        return tuple(one.key for one in self.variations if one.changes_the_problem)

    @property
    def truth_words(self) -> str:
        """What the runs are compared with."""
        if self.known is not None:
            return f"the {NOUNS[self.kind]}s"
        return f"the {'run with' if self.problem_keys else 'finest run,'} {self.finest.combination.words}"


def make_plan(
    case: Path,
    overrides: Sequence[str],
    varied: Sequence[str],
    quantities: Sequence[str],
    kind: TruthKind,
    folder: Path,
) -> Plan:
    """Read what the command line gives as text, and check every run. Raises CaseError, FileError."""
    variations = read_variations(varied)
    changing = next((one for one in variations if one.changes_the_problem), None)
    if changing is not None and kind != "finest":
        message = (
            f"changes the problem itself, and --truth {kind} holds for one problem only; vary the grid, increments or"
            " settings of the solver, or leave --truth out"
        )
        raise CaseError(message, (), f"--vary {changing.key}")
    trials = prepare_trials(case, overrides, crossed(variations), folder)
    costliest = finest([trial for trial in trials if trial.combination.is_first_problem(variations)])
    known = known_values(kind, costliest.setup)
    observables = chosen_observables(quantities, stage_count(trials), costliest.setup, kind, known)
    if not observables:
        raise CaseError("nothing to compare; name it with --quantity, such as --quantity delta_z", (), case)
    others = sorted((trial for trial in trials if trial is not costliest), key=lambda trial: trial.seconds)
    usual = usual_observables(costliest.setup) if kind == "closed-form" and not quantities else ()
    unknown = tuple(one for one in usual if one not in observables)
    why = costliest.setup.closed_forms.why_not_mindlin if unknown else ""
    return Plan(variations, (costliest, *others), observables, unknown, why, kind, known)
