"""Find every closed form that holds for a case on an area: those of pressing, Cattaneo and Mindlin, Lubkin, Spence.

`validate`, the warnings, studies, the automatic size and the plots all read them from `ClosedForms`. The formulas are
in `fretsolve.reference`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.history import PAIRS
from fretsolve.model.required_terms import Model
from fretsolve.reference.hertz import HertzContact
from fretsolve.reference.tangential import (
    cattaneo_mindlin,
    cattaneo_mindlin_moved,
    gross_slip_torque,
    spence_stick_ratio,
)
from fretsolve.setup.closed_forms.normal_forms import Load, NormalForms, is_tilted

if TYPE_CHECKING:
    from fretsolve.reference.cyclic_loading import CyclicLoading
    from fretsolve.setup.closed_forms.friction_forms import FrictionForms


@dataclass(frozen=True)
class ClosedForm:
    """The exact value of a column of the history at the end of a stage (from 0); source: authors of the solution."""

    quantity: str
    stage: int
    value: float
    source: str


def spence_ratio(model: Model) -> float:
    """Return the stick radius over the contact radius of a sphere under P alone, by Spence; 1 for uncoupled bodies.

    In a line contact it is that of a cylinder, where shear does not act on the pressure.
    """
    if not model.terms.normal_tangential_coupling:
        return 1.0
    if model.line:
        from fretsolve.reference.line import pressed_stick_ratio  # other cases need none of it

        return pressed_stick_ratio(model.friction, model.compliances.dundurs_constant)
    return spence_stick_ratio(model.friction, model.compliances.dundurs_constant)


class ClosedForms(NormalForms):
    """The closed forms of a case along its load path. Stages are counted from 0."""

    def gross_slip(
        self, P: float, hertz: HertzContact | None = None, coefficient: float | None = None
    ) -> tuple[float, float, float | None]:
        """Return force (N), torque (N mm) and displacement (mm) of gross slip under P (N), on Hertz's contact if it is.

        The torque is infinite, and the displacement under the force is None, where no closed form gives them. Where
        friction varies, the force may be infinite too. coefficient: that a stage has set.
        """
        if self.case.friction_varies:
            return self._varied_gross_slip(hertz, coefficient, P)
        friction = self.model.friction
        if hertz is None or not hertz.is_circle:
            return friction * P, math.inf, None
        delta_x = None
        if friction and not self.model.coupled and self.model.bulk is None:
            delta_x = cattaneo_mindlin(hertz, friction, friction * P, self.model.compliances.tangential).delta_x
        return friction * P, gross_slip_torque(hertz, friction), delta_x

    def _varied_gross_slip(
        self, hertz: HertzContact | None, coefficient: float | None, P: float
    ) -> tuple[float, float, float | None]:
        force = None if hertz is None else self._friction_on(hertz, coefficient).gross_slip_force
        if hertz is None or force is None:
            return math.inf, math.inf, None
        bound = self._friction_on(hertz).rim_slip(self.model.compliances.tangential)
        if bound is None or self.model.coupled or self.model.bulk is not None:
            return force, math.inf, None
        return force, bound.gross_slip_torque, bound.under(bound.gross_slip_force).delta_x

    def _friction_on(self, hertz: HertzContact, coefficient: float | None = None) -> FrictionForms:
        from fretsolve.setup.closed_forms.friction_forms import FrictionForms, FrictionOnContact  # few cases need them

        return FrictionForms(FrictionOnContact(self.case, self.case.surface[0].center, coefficient), hertz)

    def tangential(self, stage: int, center: tuple[float, float] | None = None) -> CyclicLoading | None:
        """Return Cattaneo and Mindlin's or Lubkin's solution for a sphere after `stage`; None where there is none.

        There is none where shear acts on the pressure, or where a tangential motion is imposed. Where friction varies,
        it is that of slip from the rim under a force, if it holds. center: of the contact
        (mm), by default the sphere's own.
        """
        loads, circle = self.loads[: stage + 1], self.hertz[stage]
        if circle is None or not circle.is_circle or any(map(is_tilted, loads)) or self.model.bulk is not None:
            return None
        if not self.model.has_shear or self.model.coupled:
            return None
        from fretsolve.reference.cyclic_loading import cyclic_loading  # a run may ask for none of it

        # The path begins unloaded.
        P = np.array([0.0, *(contact.load if contact else 0.0 for contact in self.hertz[: stage + 1])])
        Qx, Qy, Mz = (np.array([0.0, *_path(loads, force)]) for force in ("Qx", "Qy", "Mz"))
        if not np.isfinite([Qx, Qy, Mz]).all():
            return None
        # An imposed Mz is about the origin; a rotation that is held takes no torque about the contact's centre.
        x, y = center or self.case.surface[0].center
        imposed = np.array([False, *("Mz" in load for load in loads)])
        torque = np.where(imposed, Mz - x * Qy + y * Qx, 0.0)
        compliances = self.model.compliances.tangential, self.model.compliances.torsional
        friction, varies = self.model.friction, self.case.friction_varies
        if varies:
            # The coefficient that carries as much: under a shear limit that of the case may be a mere large number.
            carried = self._friction_on(circle).gross_slip_force
            friction = friction if carried is None else carried / circle.load
        found = cyclic_loading(circle, friction, compliances, (P, Qx, Qy, torque), (x, y))
        if found is None or not varies:
            return found
        bound = None if found.direction is None else self._friction_on(circle).rim_slip(compliances[0])
        return None if bound is None else replace(found, bound=bound)

    def values(self) -> Iterator[ClosedForm]:
        """Yield the exact values at the ends of the stages that P alone presses, upright, as the model has them.

        Cattaneo and Mindlin neglect that shear along x moves the surfaces along y, Lubkin does not.
        """
        if self.model.terms.normal_tangential_coupling or self.case.wear is not None:
            return  # wear changes the shape of the surfaces
        for stage, (load, hertz) in enumerate(zip(self.loads, self.hertz, strict=True)):
            if hertz is None or "P" not in load or not load.get("phi_x") == load.get("phi_y") == 0.0:
                continue
            a = hertz.contact_radius
            found = {"delta_z": hertz.delta_z, "max_pressure": hertz.max_pressure}
            found |= {"contact_radius": a, "contact_area": math.pi * a**2}
            yield from (ClosedForm(name, stage, value, "Hertz") for name, value in found.items())
            shear = self.tangential(stage)
            if shear is None or not 0.0 < shear.largest <= shear.limit:
                continue
            under_force = shear.direction is not None
            if self.model.compliances.B == 0.0 or under_force != self.model.terms.in_plane_coupling:
                c = shear.stick_radius
                found = shear.displacements() | {"stick_radius": c, "stick_area": math.pi * c**2}
                if under_force:
                    found["work_total"] = shear.dissipated_energy()
                yield from (ClosedForm(name, stage, value, shear.source) for name, value in found.items())
        directions_interact = self.model.terms.in_plane_coupling and self.model.compliances.B != 0.0
        if self.model.bulk is not None and not directions_interact:
            yield from self._under_bulk or ()

    @cached_property
    def _under_bulk(self) -> tuple[ClosedForm, ...] | None:
        """Values of a sphere under a force and bulk stress where the force is largest, the stick radius first."""
        from fretsolve.setup.closed_forms.bulk_forms import (  # few cases have bulk stress
            NoClosedFormError,
            sphere_under_bulk,
        )

        if self.case.friction_varies:
            return None
        try:
            stage, form = sphere_under_bulk(self.model, self.hertz, self.loads)
        except NoClosedFormError:
            return None
        c = form.stick_radius
        found = {"stick_radius": c, "stick_area": math.pi * c**2, "delta_x": form.delta_x}
        found |= {
            "stick_half_width_x": c,
            "stick_half_width_y": c,
            "stick_center_x": self.case.surface[0].center[0] + form.stick_center,
        }
        return tuple(ClosedForm(name, stage, value, "Cattaneo-Mindlin, shifted") for name, value in found.items())

    @property
    def why_not_mindlin(self) -> str:
        """The reason why Cattaneo and Mindlin are not exact where it is Poisson's ratio alone; else empty."""
        directions_interact = self.model.terms.in_plane_coupling and self.model.compliances.B != 0.0
        sheared = bool({"Qx", "Qy", "delta_x", "delta_y"} & set(self.model.moved))
        if not directions_interact or not sheared or self.model.bulk is not None:
            return ""
        return (
            "with Poisson's ratios other than 0, shear along x also moves the surfaces along y, which Cattaneo and"
            " Mindlin neglect: they are exact only with coupling: none"
        )

    @cached_property
    def smallest_stick(self) -> ClosedForm | None:
        """The smallest stick radius (mm) of the path; None where no closed form gives it.

        By Spence for a sphere under P alone on a dissimilar body. For similar bodies by Cattaneo and Mindlin or Lubkin
        at the largest force, displacement or torque, at constant P.
        """
        if not self.model.has_shear:
            return None
        if self.model.bulk is not None:
            under_bulk = self._under_bulk
            return None if under_bulk is None else under_bulk[0]
        if self.model.moved:
            if {"delta_x", "delta_y"} & set(self.model.moved):
                return self._smallest_stick_moved
            shear = self.tangential(len(self.loads) - 1)
            if shear is None or shear.largest >= shear.limit:
                return None
            stage = [abs(load) for load in shear.path].index(shear.largest) - 1  # the path begins unloaded
            return ClosedForm("stick_radius", stage, shear.on_loading(shear.largest).stick_radius, shear.source)
        if self.case.friction_varies:
            return None
        radii = [(one.contact_radius, stage) for stage, one in enumerate(self.hertz) if one and one.is_circle]
        if not radii or not self.model.coupled:
            return None
        radius, stage = max(radii)
        return ClosedForm("stick_radius", stage, spence_ratio(self.model) * radius, "Spence")

    @property
    def _smallest_stick_moved(self) -> ClosedForm | None:
        """The smallest stick radius where a displacement along one direction is imposed: where it is largest.

        On the way back, half of the displacement from the turning point counts.
        """
        if self.model.coupled or self.case.friction_varies or not self.model.friction:
            return None
        path = np.array([(load.get("delta_x", 0.0), load.get("delta_y", 0.0)) for load in self.loads])
        lengths = np.hypot(*path.T)
        stage, first = int(lengths.argmax()), int(np.flatnonzero(lengths)[0])
        hertz, under = self.hertz[stage], self.hertz[max(first - 1, 0) :]
        if hertz is None or not hertz.is_circle or first == 0 or any(one != hertz for one in under):
            return None
        moved = ("delta_x", "delta_y")[int(abs(path[stage, 1]) > abs(path[stage, 0]))]
        others = any(load.get(name) for load in self.loads for name in ("Qx", "Qy", "Mz", "phi_z"))
        across = path[:, 0] * path[stage, 1] - path[:, 1] * path[stage, 0]
        if others or any(moved not in load for load in self.loads[first:]) or np.abs(across).max() > 0.0:
            return None
        shear = cattaneo_mindlin_moved(hertz, self.model.friction, lengths[stage], self.model.compliances.tangential)
        if shear is None:
            return None
        return ClosedForm("stick_radius", stage, shear.stick_radius, "Cattaneo-Mindlin")


def _path(loads: Sequence[Load], force: str) -> list[float]:
    """Return a tangential force at the end of each stage; infinite where its motion is imposed, 0 while it is held."""
    motion, path = dict(PAIRS)[force], list[float]()
    for load in loads:
        held = load.get(motion) == 0.0 and not any(path)
        path.append(load.get(force, 0.0 if held else math.inf))
    return path
