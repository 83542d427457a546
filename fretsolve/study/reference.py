"""The reference of a study: the finest run, closed forms, or what the case expects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from fretsolve.errors import CaseError
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.sweep.quantity import NAMES, StageQuantity, in_order, read_quantity, usual_quantities

ReferenceKind = Literal["finest", "closed-form", "expect"]

NOUNS = {"closed-form": "closed form", "expect": "expected value"}

OF_MINDLIN = ("delta_x", "delta_y", "stick_radius", "stick_area", "work_total")
"""Quantities that Cattaneo and Mindlin give under forces."""


def known_values(kind: ReferenceKind, setup: ProblemSetup) -> Mapping[StageQuantity, float] | None:
    """Return what is known of the finest run before it is made; None if that run itself is the reference.

    Raises CaseError if nothing is known.
    """
    if kind == "finest":
        return None
    if kind == "closed-form":
        known = {StageQuantity(form.quantity, form.stage + 1): form.value for form in setup.closed_forms.values()}
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
        StageQuantity(expected.quantity, expected.stage or last): expected.value
        for expected in reversed(setup.case.expect)
        if expected.quantity in NAMES
    }
    if not known:
        raise setup.case.source.problem(
            "the case expects nothing that --truth expect could compare with; give a list such as"
            " [{quantity: delta_z, value: 9 um, rel: 1 %}]",
            ("expect",),
        )
    return known


def compared_quantities(
    texts: Sequence[str],
    stages: int,
    setup: ProblemSetup,
    kind: ReferenceKind,
    known: Mapping[StageQuantity, float] | None,
) -> tuple[StageQuantity, ...]:
    """Return those of ``--quantity``, else the usual ones for which the reference has values. Raises CaseError."""
    if texts:
        asked = in_order([read_quantity(text, stages) for text in texts])
        for quantity in asked:
            if known is not None and quantity not in known:
                same_name = [str(one) for one in in_order(list(known)) if one.name == quantity.name]
                there = ", ".join(same_name or dict.fromkeys(one.name for one in in_order(list(known))))
                of_mindlin = kind == "closed-form" and quantity.name in OF_MINDLIN
                why = setup.closed_forms.why_not_mindlin if of_mindlin else ""
                hint = f"; {why}" if why else ""
                message = f"--truth {kind}: it has no {NOUNS[kind]}; these have: {there}{hint}"
                raise CaseError(message, (), f"--quantity {quantity}")
        return asked
    usual = tuple(quantity for quantity in usual_quantities(setup) if quantity.stage <= stages)
    if known is None:
        return usual
    imposed = setup.load_path.imposed
    stated = in_order([one for one in known if one.stage <= stages and one.name not in imposed[one.stage - 1]])
    return stated if kind == "expect" else tuple(one for one in usual if one in known) or stated
