"""Find the closed forms that hold for a line contact: Hertz or a rounded punch, and partial slip on them.

The formulas are in `fretsolve.reference.line`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from fretsolve.reference.cyclic_loading import SAME, dissipated, turning_points
from fretsolve.reference.line import HertzLine, LineContact, LinePartialSlip, RoundedPunch, pressed_stick_ratio
from fretsolve.setup.closed_forms import ClosedForm, ClosedForms, Load
from fretsolve.system.arrays import DoubleArray


@dataclass(frozen=True)
class LineShear:
    """Partial slip after a path of tangential forces in one direction, at constant load.

    axis: 0 for Qx, 1 for Qy; path: the forces (N/mm), from the unloaded contact on.
    """

    contact: LineContact
    friction: float
    compliance: float
    axis: int
    path: tuple[float, ...]

    @cached_property
    def branches(self) -> list[tuple[float, LinePartialSlip]]:
        """The branches, with a factor each: a later one is twice the first loading by half of its length (Masing)."""
        points, _ = turning_points(self.path, SAME * self.friction * self.contact.load)
        lengths = [after - before for before, after in pairwise(points)]
        first = [(1.0, self.on_loading(length)) for length in lengths[:1]]
        return first + [(2.0, self.on_loading(0.5 * length)) for length in lengths[1:]]

    def on_loading(self, force: float) -> LinePartialSlip:
        """Return the solution on first loading by `force`."""
        return LinePartialSlip(self.contact, self.friction, force, self.compliance)

    @property
    def stick_half_width(self) -> float:
        """Half-width of the stick zone (mm) at the end of the path."""
        return self.branches[-1][1].stick_half_width if self.branches else self.contact.half_width

    def shear(self, x: DoubleArray) -> DoubleArray:
        """Return the shear traction along its axis at `x` from the middle (MPa)."""
        return sum((factor * branch.shear(x) for factor, branch in self.branches), start=np.zeros_like(x))

    def dissipated_energy(self) -> float | None:
        """Return the energy dissipated on the path (mJ/mm); None where no closed form gives the slip."""
        if not isinstance(self.contact, HertzLine):
            return None
        return dissipated(self.path, lambda force: self.on_loading(force).work_per_cycle)


@dataclass(frozen=True)
class LineClosedForms(ClosedForms):
    """The closed forms of a line contact along its load path. Stages are counted from 0."""

    @cached_property
    def hertz(self) -> tuple[None, ...]:
        """None at the end of each stage: no contact is round or elliptic."""
        return (None,) * len(self.loads)

    @cached_property
    def punch(self) -> None:
        """None: there is no round punch."""
        return None

    @cached_property
    def contacts(self) -> tuple[LineContact | None, ...]:
        """The contact at the end of each stage; None where it is tilted, pressed by delta_z, or of another shape."""
        return tuple(self._contact(load) for load in self.loads)

    @cached_property
    def widest(self) -> LineContact | None:
        """The contact at the largest load; None where one is not known."""
        pressed = [load.get("P") != 0.0 for load in self.loads]
        if any(here and contact is None for here, contact in zip(pressed, self.contacts, strict=True)):
            return None
        return max(filter(None, self.contacts), key=lambda contact: contact.load, default=None)

    @property
    def source(self) -> str:
        """The authors of the contact's solution."""
        return "Hertz" if self.case.surface[0].kind == "cylinder" else "Ciavarella, Hills and Monno"

    def _contact(self, load: Load) -> LineContact | None:
        surface, modulus = self._only_surface, self._modulus
        tilted = any(load.get(name) for name in ("My", "phi_y"))
        if surface is None or tilted or not load.get("P"):
            return None
        # An imposed moment of 0 holds the load in the grid's middle.
        if "My" in load and surface.center[0] != 0.0:
            return None
        if surface.kind == "cylinder" and surface.radius > 0.0:
            return HertzLine(load["P"], surface.radius, modulus)
        if surface.kind == "punch" and surface.edge_radius and surface.half_width:
            return RoundedPunch(load["P"], surface.half_width, surface.edge_radius, modulus)
        return None

    def contact_width(self, endless: float) -> float | None:
        """Return the width (mm) of the largest contact; of a sharp punch its face."""
        surface = self._only_surface
        if self.widest is not None:
            return 2.0 * self.widest.half_width
        if surface is not None and surface.kind == "punch" and not surface.edge_radius:
            return 2.0 * (surface.half_width or 0.0)
        return None

    def partial_slip(self, stage: int) -> LineShear | None:
        """Return the partial slip after `stage`; None where there is none or no closed form.

        There is none where shear acts on the pressure, under Qx and Qy together, or where P changes under shear.
        """
        contact, loads = self.contacts[stage], self.loads[: stage + 1]
        if contact is None or not self.model.has_shear or self.model.coupled:
            return None
        P, Qx, Qy = (np.array([0.0, *(load.get(name, np.nan) for load in loads)]) for name in ("P", "Qx", "Qy"))
        nothing = SAME * self.model.friction * contact.load
        moved = np.flatnonzero(np.maximum(np.abs(Qx), np.abs(Qy)) > nothing)
        if np.abs(Qx).max() > nothing and np.abs(Qy).max() > nothing:
            return None
        if len(moved) and not np.ptp(P[max(moved[0] - 1, 0) :]) <= SAME * contact.load:
            return None
        axis = int(np.abs(Qy).max() > nothing)
        path = (Qx, Qy)[axis]
        if np.abs(path).max() >= self.model.friction * contact.load:
            return None
        material = self.model.compliances
        return LineShear(contact, self.model.friction, material.A + axis * material.B, axis, tuple(path.tolist()))

    def values(self) -> Iterator[ClosedForm]:
        """Yield the exact values at the ends of the stages."""
        if self.model.terms.normal_tangential_coupling:
            return
        for stage, contact in enumerate(self.contacts):
            if contact is None:
                continue
            a = contact.half_width
            found = {"max_pressure": contact.max_pressure, "contact_radius": a, "contact_area": 2.0 * a}
            yield from (ClosedForm(name, stage, value, self.source) for name, value in found.items())
            shear = self.partial_slip(stage)
            if shear is None or not any(shear.path):
                continue
            c, work = shear.stick_half_width, shear.dissipated_energy()
            found = {"stick_radius": c, "stick_area": 2.0 * c}
            found |= {} if work is None else {"work_total": work}
            yield from (ClosedForm(name, stage, value, self.shear_source) for name, value in found.items())

    @property
    def shear_source(self) -> str:
        """The authors of the solution for partial slip."""
        return "Cattaneo-Mindlin" if self.case.surface[0].kind == "cylinder" else "Ciavarella-Jaeger"

    @property
    def why_not_mindlin(self) -> str:
        """Empty: in a line contact shear along x does not move the surfaces along y."""
        return ""

    @cached_property
    def smallest_stick(self) -> ClosedForm | None:
        """The smallest half-width (mm) of the stick zone on the path; None where no closed form gives it."""
        if not self.model.has_shear:
            return None
        if self.model.moved:
            shears = [self.partial_slip(stage) for stage in range(len(self.loads))]
            known = [
                (abs(one.path[-1]), stage, one) for stage, one in enumerate(shears) if one is not None and one.path[-1]
            ]
            if not known or shears[-1] is None:
                return None
            force, stage, shear = max(known, key=lambda item: item[0])
            return ClosedForm("stick_radius", stage, shear.on_loading(force).stick_half_width, self.shear_source)
        if self.widest is None or not self.model.coupled:
            return None
        ratio = pressed_stick_ratio(self.model.friction, self.model.compliances.dundurs_constant)
        if not isinstance(self.widest, HertzLine):
            return None
        stage = self.contacts.index(self.widest)
        return ClosedForm("stick_radius", stage, ratio * self.widest.half_width, "Spence, one-way")
