"""What the runs of a study are compared with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal

from fretsolve.errors import CaseError
from fretsolve.study.quantity import (
    NAMES,
    Observable,
    in_order,
    read_observable,
    usual_observables,
)

if TYPE_CHECKING:
    from fretsolve.setup.problem_setup import ProblemSetup

TruthKind = Literal["finest", "closed-form", "expect"]

NOUNS = {"closed-form": "closed form", "expect": "expected value"}

OF_MINDLIN = ("delta_x", "delta_y", "stick_radius", "stick_area", "work_total")
"""What Cattaneo and Mindlin would give under forces."""


def known_values(kind: TruthKind, setup: ProblemSetup) -> Mapping[Observable, float] | None:
    """What is known before any run, of the finest trial's scene; None for the finest run itself.

    Raises CaseError where nothing is known.
    """
    if kind == "finest":
        return None
    if kind == "closed-form":
        known = {Observable(form.quantity, form.stage + 1): form.value for form in setup.closed_forms.values()}
        if not known:
            raise CaseError(
                "--truth closed-form: no closed form is known for this case; those of Hertz, Cattaneo and Mindlin, and"
                " Lubkin are: a single sphere (Hertz: or ellipsoid) under forces, upright, with uncoupled bodies",
                (),
                setup.case.source.path,
            )
        return known
    last = len(setup.load_path.last_steps)
    known = {
        Observable(expected.quantity, expected.stage or last): expected.value
        for expected in reversed(setup.case.expect)
        if expected.quantity in NAMES
    }
    if not known:
        raise setup.case.source.problem(
            "nothing is expected that --truth expect could compare with; give a list such as"
            " [{quantity: delta_z, value: 9 um, rel: 1 %}]",
            ("expect",),
        )
    return known


def chosen_observables(
    texts: Sequence[str], stages: int, setup: ProblemSetup, kind: TruthKind, known: Mapping[Observable, float] | None
) -> tuple[Observable, ...]:
    """Those of ``--quantity``, else the usual ones, as far as the truth has them. Raises CaseError."""
    if texts:
        asked = in_order([read_observable(text, stages) for text in texts])
        for observable in asked:
            if known is not None and observable not in known:
                same_name = [str(one) for one in in_order(list(known)) if one.name == observable.name]
                there = ", ".join(same_name or dict.fromkeys(one.name for one in in_order(list(known))))
                of_mindlin = kind == "closed-form" and observable.name in OF_MINDLIN
                why = setup.closed_forms.why_not_mindlin if of_mindlin else ""
                hint = f"; {why}" if why else ""
                message = f"--truth {kind}: there is no {NOUNS[kind]} of it, but of {there}{hint}"
                raise CaseError(message, (), f"--quantity {observable}")
        return asked
    usual = tuple(observable for observable in usual_observables(setup) if observable.stage <= stages)
    if known is None:
        return usual
    imposed = setup.load_path.imposed
    stated = in_order([one for one in known if one.stage <= stages and one.name not in imposed[one.stage - 1]])
    return stated if kind == "expect" else tuple(one for one in usual if one in known) or stated

