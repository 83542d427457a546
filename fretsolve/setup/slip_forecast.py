"""Forecast from closed forms where everything slides and how small the stick zone becomes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretsolve.case.load_components import TANGENTIAL
from fretsolve.reference.tangential import cattaneo_mindlin, full_slip_torque, spence_stick_ratio
from fretsolve.setup.closed_forms import ClosedForms


@dataclass(frozen=True)
class Slide:
    """A tangential load beyond what friction carries, at the end of `stage` (from 0): both in N or N mm.

    component: of the case file, the larger one of Qx and Qy; limit: what friction carries, as a formula.
    """

    stage: int
    component: str
    load: float
    carried: float
    limit: str


@dataclass(frozen=True)
class Stick:
    """The smallest stick radius (mm) of the path, at the end of `stage` (from 0), and the authors of the solution."""

    stage: int
    radius: float
    source: str

    def cells_across(self, cell: float) -> float:
        """Return the cells of side `cell` (mm) along the diameter."""
        return 2.0 * self.radius / cell


def first_slide(forms: ClosedForms) -> Slide | None:
    """Return the first stage at whose end a tangential force or a torque alone exceeds what friction carries."""
    friction = forms.model.friction
    for stage, (load, hertz) in enumerate(zip(forms.loads, forms.hertz, strict=True)):
        pressed = load.get("P", hertz.contact.load if hertz is not None else None)
        force, torque = math.hypot(load.get("Qx", 0.0), load.get("Qy", 0.0)), abs(load.get("Mz", 0.0))
        if pressed is not None and force > 0.0 and force >= friction * pressed:
            component = max(("Qx", "Qy"), key=lambda name: abs(load.get(name, 0.0)))
            return Slide(stage, component, force, friction * pressed, "mu P")
        if hertz is not None and hertz.circle is not None:
            carried = full_slip_torque(hertz.circle, friction)
            if torque > carried:
                return Slide(stage, "Mz", torque, carried, "3 pi mu P a/16")
    return None


def sliding_displacement(forms: ClosedForms) -> float | None:
    """Return the rigid displacement (mm) at which the largest contact begins to slide, by Cattaneo and Mindlin.

    None for other shapes than a sphere, without friction, and where shear changes the pressure.
    """
    model, circle = forms.model, forms.largest.circle if forms.largest is not None else None
    if circle is None or not model.friction or model.coupled:
        return None
    return cattaneo_mindlin(circle, model.friction, model.friction * circle.load, model.compliances.tangential).delta_x


def smallest_stick(forms: ClosedForms) -> Stick | None:
    """Return the smallest stick zone of the path; None where no closed form gives it.

    Spence: a sphere pressed on a dissimilar body, without tangential load. Cattaneo and Mindlin, or Lubkin: a sphere
    under a tangential force or a torque at constant P, similar bodies; unloading leaves no smaller stick zone.
    """
    model, last = forms.model, len(forms.loads) - 1
    if not model.has_shear:
        return None
    if not any(load.get(name) for load in forms.loads for name in TANGENTIAL):
        radii = [(form.circle.contact_radius, stage) for stage, form in enumerate(forms.hertz) if form and form.circle]
        if not radii or not model.coupled:
            return None
        radius, stage = max(radii)
        return Stick(stage, spence_stick_ratio(model.friction, model.compliances.dundurs_constant) * radius, "Spence")
    shear = forms.shear(last)
    if shear is None or shear.largest > shear.limit:
        return None
    radius = shear.on_loading(shear.largest).stick_radius
    stage = [abs(load) for load in shear.path].index(shear.largest) - 1  # the path begins with the unloaded state
    return Stick(stage, radius, shear.source) if radius else None
