"""Describe in lines of text what closed forms know of a contact on its rig, or of a line's motion, for ``validate``."""

from __future__ import annotations

from collections.abc import Iterator

from fretsolve.case.dimensions import ANGLE, LENGTH, STIFFNESS, TURNING_STIFFNESS, in_small_unit, percent
from fretsolve.case.history import COMPONENTS, DIMENSIONS_BY_NAME
from fretsolve.problem.model.rig import Rig
from fretsolve.problem.setup.driven_contact import DrivenContact
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.problem.setup.rig_forms import RigForms

MOST_STATES_LISTED = 20

Names = tuple[str, str, str]


def rig_lines(setup: ProblemSetup) -> Iterator[str]:
    """Yield the stiffnesses of rig and contact, the onset of gross slip at the actuator, and loads and motions."""
    forms = setup.on_rig
    if forms is None:
        return
    known = [*_stiffness_lines(forms), *_pressed_lines(forms), *_sheared_lines(forms)]
    if setup.model.rig is not None:
        yield "\n# rig in series with the contact"
        if setup.case.rig is not None and (file := setup.case.rig.compliance) is not None:
            yield f"{file.name}: stiffness of each motion alone: {', '.join(_stiffnesses(setup.model.rig))}"
        yield from known or ["no closed form tells how contact and rig share the actuator's motion"]
    elif known:
        yield f"\n# motion of points {setup.case.reference_depth:g} mm deep in both bodies"
        yield from known


def _stiffnesses(rig: Rig) -> Iterator[str]:
    """Yield the stiffness of each motion of a rig under its own load alone, in which a wrong unit shows."""
    for (_, motion, _), compliance in zip(COMPONENTS, rig.compliance.diagonal().tolist(), strict=True):
        unit = STIFFNESS if DIMENSIONS_BY_NAME[motion] is LENGTH else TURNING_STIFFNESS
        if compliance:
            yield f"{motion} {1.0 / compliance:.4g} {unit.unit}"


def _stiffness_lines(forms: RigForms) -> Iterator[str]:
    if (found := forms.reversal) is None:
        return
    (force, motion, actuator), given, sticking = found
    unit = "N mm/rad" if force == "Mz" else "N/mm^2" if forms.model.line else "N/mm"
    both = given + sticking
    of_both, of_contact = (f"{1.0 / one:.7g}" for one in (both, sticking))
    if forms.model.coupled:  # shear moves the surfaces along the normal too, which changes some parts in a hundred
        of_both, of_contact = (f"about {float(f'{1.0 / one:.3g}'):g}" for one in (both, sticking))
    if forms.model.rig is None:
        yield f"just after a reversal {force} changes by {of_contact} {unit} over {motion}"
    else:
        yield (
            f"just after a reversal {force} changes by {of_both} {unit} over {actuator}, by {of_contact} {unit} over"
            f" {motion}; the rig takes {percent(given / both, 3)} of {actuator}"
        )
    if (slip := forms.gross_slip) is not None:
        at_actuator = "" if forms.model.rig is None else f"{_motion(actuator, slip[1])}, "
        yield f"gross slip begins at {at_actuator}{_motion(motion, slip[0])}"


def _pressed_lines(forms: RigForms) -> Iterator[str]:
    """Yield the normal load and both approaches under each load once, where the rig gives along the normal."""
    seen = set[float]()
    for stage, contact in enumerate(forms.pressed):
        if contact is not None and contact.force not in seen and len(seen) < MOST_STATES_LISTED:
            seen.add(contact.force)
            yield _state(forms, stage, ("P", "delta_z", "actuator_z"), contact)


def _sheared_lines(forms: RigForms) -> Iterator[str]:
    if forms.driven is None:
        return
    names, states = forms.driven
    seen = set[DrivenContact]()
    for stage, state in states.items():
        if not state.force or state in seen:
            continue
        if len(seen) == MOST_STATES_LISTED:
            yield "... and more loads in later stages"
            return
        seen.add(state)
        yield _state(forms, stage, names, state)


def _state(forms: RigForms, stage: int, names: Names, state: DrivenContact) -> str:
    force, motion, actuator = names
    slides = ", gross slip" if state.slides else ""
    load = f"{state.force:.7g} {({**DIMENSIONS_BY_NAME, **forms.case.dimensions})[force].unit}"
    motions = _motion(motion, state.motion)
    motions += "" if forms.model.rig is None else f", {_motion(actuator, state.actuator)}"
    return f"stage {stage + 1} ends at {force} = {load}, {motions}{slides}"


def _motion(name: str, value: float) -> str:
    if DIMENSIONS_BY_NAME[name] is LENGTH:
        return f"{name} = {in_small_unit(value, 7)}"
    return f"{name} = {value:.7g} {ANGLE.unit}"
