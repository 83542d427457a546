"""Warn of a rig that hides the contact, or on which the contact jumps."""

from __future__ import annotations

import math
from collections.abc import Iterator

from fretsolve.case.dimensions import LINE_STIFFNESS, STIFFNESS, TURNING_STIFFNESS, percent
from fretsolve.case.history import COMPONENTS
from fretsolve.problem.setup.picked_settings import AREA_MARGIN
from fretsolve.problem.setup.problem import ProblemSetup
from fretsolve.reference.tangential import full_stick_compliance

Names = tuple[str, str, str]
"""Force, motion and actuator of a mode."""

LARGEST_SHARE = 0.9
"""Part of the actuator's motion that the rig takes, from which an error of 1 % in the rig's stiffness makes one of more
than 10 % in the contact's motion."""


def about_rig(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a rig that is too soft: for the contact to be seen, and for friction that falls with slip."""
    if (rig := setup.model.rig) is None:
        return
    found = None if setup.on_rig is None else setup.on_rig.reversal
    if found is not None:
        yield from _about_jumps(setup, *found[:2])
    known = {} if found is None else {found[0][2]: found[2]}
    driven = {name for load in setup.load_path.imposed for name, value in load.items() if value}
    for mode, (_, motion, actuator) in enumerate(COMPONENTS):
        given, sticking = float(rig.compliance[mode, mode]), known.get(actuator) or _rough_compliance(setup, mode)
        if actuator in driven and sticking and (share := given / (given + sticking)) > LARGEST_SHARE:
            rough = "nearly all" if share > 0.99 else f"about {percent(share)}"
            part = percent(share, 3) if actuator in known else rough
            dimension = LINE_STIFFNESS if setup.model.line else STIFFNESS if mode in (0, 3, 4) else TURNING_STIFFNESS
            yield (
                f"{_key(setup, actuator)}: with {1.0 / given:g} {dimension.unit} the rig takes {part} of {actuator}"
                " while the contact sticks, so that the loop at the actuator tells little about the contact; check the"
                f" unit, look at the loop over {motion}, or take a stiffer rig"
            )


def _rough_compliance(setup: ProblemSetup, mode: int) -> float | None:
    """Return about how far the surfaces move under a load (mm/N, mm^2/N), as a contact that fills the grid; None for
    rotations, and for lines without a reference depth."""
    material, a = setup.model.compliances, 0.5 * min(setup.grid.size[: len(setup.grid.axes)]) / AREA_MARGIN
    if mode not in (0, 3, 4):
        return None
    layer = material.layer_shear if mode else material.layer_normal
    if setup.model.line:
        depth = setup.case.reference_depth
        return None if depth is None else material.A / math.pi * math.log(2.0 * depth / a) + layer / (2.0 * a)
    bodies = full_stick_compliance(a, material.tangential) if mode else 0.25 * material.A / a
    return bodies + layer / (math.pi * a**2)


def _about_jumps(setup: ProblemSetup, names: Names, given: float) -> Iterator[str]:
    """Warn of friction that falls faster with slip than the rig unloads, where the actuator may make it slide."""
    spec, hertz, (force, motion, actuator) = setup.case.friction, setup.closed_forms.largest, names
    if hertz is None or spec.initial is None or spec.final is None or spec.weakening == "allow" or force == "Mz":
        return
    if spec.exponent is not None or spec.shear_limit is not None:
        return
    farthest = max((abs(load.get(actuator, 0.0)) for load in setup.load_path.imposed), default=0.0)
    # The integral of Hertz's pressure squared is 3/4 P p0.
    weight = 1.0 / spec.slip if spec.slip else 0.75 * spec.initial * hertz.max_pressure / (spec.energy or 1.0)
    growth = given * (spec.initial - spec.final) * hertz.load * weight
    if growth >= 1.0 and farthest > given * spec.initial * hertz.load:
        yield (
            f"{_key(setup, actuator)}: once the contact slides as a whole, friction falls {growth:.3g} times as fast"
            f" with slip as the rig unloads, which ends the run; a stiffer rig, or {motion} imposed on the contact"
            " itself, follows it"
        )


def _key(setup: ProblemSetup, actuator: str) -> str:
    """Return the key by which the rig gives way along a motion of the actuator."""
    of_file = setup.case.rig is not None and setup.case.rig.compliance is not None
    return "rig.compliance" if of_file else f"rig.stiffness_{actuator.removeprefix('actuator_')}"
