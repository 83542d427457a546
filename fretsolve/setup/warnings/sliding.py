"""Warn of friction that is missing, and of loads that it cannot carry."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fretsolve.case.history import PAIRS
from fretsolve.errors import dotted
from fretsolve.model.required_terms import UNCOUPLED_BELOW
from fretsolve.setup.closed_forms.normal_forms import Load
from fretsolve.setup.problem_setup import ProblemSetup


def about_friction(setup: ProblemSetup) -> Iterator[str]:
    """Warn of friction that is not given although something shears the contact."""
    if "friction" in setup.case.model_fields_set:
        return
    moved, beta = ", ".join(setup.model.moved), setup.model.compliances.dundurs_constant
    if moved or abs(beta) > UNCOUPLED_BELOW:
        differ = f"the bodies differ (Dundurs' constant {beta:.4g}), so that pressing alone would shear them"
        although = f"the load path moves {moved}" if moved else differ
        yield f"friction: not given, so it is 0, although {although}; write friction: 0 if that is meant"


def about_sliding(setup: ProblemSetup) -> Iterator[str]:
    """Warn of the first stage that ends with a tangential force or a torque alone that friction cannot carry."""
    forms, stages, motion = setup.closed_forms, setup.case.stages(), dict(PAIRS)
    if "friction" not in setup.case.model_fields_set:  # then the missing friction is the warning
        return
    varies = setup.case.friction_varies
    limit, of_torque = (
        ("sum of the friction limit", "sum of the friction limit times r") if varies else ("mu P", "3 pi mu P a/16")
    )
    seen = set[object]()
    for stage, load, hertz in zip(stages, forms.loads, forms.hertz, strict=True):
        if (same := tuple(sorted(load.items()))) in seen:  # repeated cycles come back to the same ones
            continue
        seen.add(same)
        pressed = load.get("P", hertz.load if hertz else math.inf)
        most_force, most_torque, _ = forms.gross_slip(pressed, hertz, load.get("friction"))
        if varies:
            most_force = min(most_force, pressed * _largest_share(setup, load))
        Qx, Qy, Mz = (abs(load.get(name, 0.0)) for name in ("Qx", "Qy", "Mz"))
        if 0.0 < (force := math.hypot(Qx, Qy)) >= most_force:
            name = "Qx" if Qx >= Qy else "Qy"
            unit = setup.case.dimensions[name].unit
            if most_force == 0.0:
                limit = "P is 0" if pressed == 0.0 else "friction is 0"
            loads = f"{force:.6g} {unit} is not below the {most_force:.6g} {unit} ({limit})"
        elif Mz > most_torque:
            name, loads = "Mz", f"{Mz:.6g} N mm is not below the {most_torque:.6g} N mm ({of_torque})"
        else:
            continue
        place = dotted(setup.case.source.typed(stage.place(name)))
        advice = "lower it" if setup.model.line else f"impose {motion[name]} to follow it"
        yield f"{place}: {loads} that friction carries: gross slip ends the run; {advice}"
        return


def _largest_share(setup: ProblemSetup, load: Load) -> float:
    from fretsolve.friction.warnings import largest_share  # few cases need it

    return largest_share(setup.case.friction, load.get("Qx", 0.0), load.get("Qy", 0.0))


def about_varied_friction(setup: ProblemSetup) -> Iterator[str]:
    """Warn of friction that falls too fast, and of cycles that count as periodic before it has run in."""
    if not setup.case.friction_varies or not setup.model.has_shear:
        return
    from fretsolve.friction.warnings import friction_warnings  # few cases need them

    compliance = setup.model.compliances.tangential
    yield from friction_warnings(setup.case.friction, setup.load_path.stages, setup.closed_forms.largest, compliance)
