"""Find every closed form that holds for a case on an area: pressing, Cattaneo and Mindlin, Lubkin, Spence, bulk stress.

`validate`, the warnings, studies, the automatic size and the plots all read them from `ClosedForms`. The formulas are
in `fretsolve.reference`; line contacts are in `line_forms`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.history import ACTUATORS, COMPONENTS, PAIRS
from fretsolve.case.keys.body_specs import Surface
from fretsolve.case.models import Case
from fretsolve.problem.model.required_terms import Model
from fretsolve.reference.cyclic_loading import CyclicLoading, cyclic_loading
from fretsolve.reference.hertz import (
    FlatPunch,
    HertzContact,
    HertzLine,
    LineContact,
    RoundContact,
    boussinesq_punch,
    hertz_elliptic,
    hertz_sphere,
    hertz_sphere_at,
    love_cone,
    love_cone_at,
    pressed_stick_ratio,
)
from fretsolve.reference.layered import layered_stick_compliance, onset_compliance
from fretsolve.reference.tangential import (
    SphereUnderBulk,
    cattaneo_mindlin,
    cattaneo_mindlin_moved,
    gross_slip_torque,
    spence_stick_ratio,
)
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.problem.friction.law import FrictionOnContact

Load = Mapping[str, float]
"""The imposed load components with their totals (N, mm, N mm, rad)."""

WITH_LAYER = "a layer between the bodies shears, which Cattaneo and Mindlin do not have"

ALIKE = 1e-3
"""Part by which P, the proportion of the loads, and the mismatch along y may differ from what bulk stress needs."""


TILTED_BY_RIG = frozenset((ACTUATORS["phi_x"], ACTUATORS["phi_y"]))

SHEARED = frozenset(name for names in COMPONENTS[3:5] for name in names)
"""Loads and motions that shear the contact along x and y."""


@dataclass(frozen=True)
class ClosedForm:
    """The exact value of a column of the history at the end of a stage (from 0); source: authors of the solution."""

    quantity: str
    stage: int
    value: float
    source: str


def spence_ratio(model: Model) -> float:
    """Return the stick radius over the contact radius of a sphere under P alone, by Spence; 1 for uncoupled bodies.

    In a line contact it is the ratio of a cylinder, where shear does not act on the pressure.
    """
    if not model.terms.normal_tangential_coupling:
        return 1.0
    ratio = pressed_stick_ratio if model.line else spence_stick_ratio
    return ratio(model.friction, model.compliances.dundurs_constant)


def pressing(load: Load) -> tuple[str, float]:
    """Return name and value of the imposed normal load: P, or else delta_z, or else actuator_z."""
    return next((name, load[name]) for name in COMPONENTS[0] if name in load)


def is_tilted(load: Load) -> bool:
    """Return whether moments or rotations other than 0 are imposed, or rotations through a rig that may give."""
    return any(load.get(name) for name in ("Mx", "My", "phi_x", "phi_y")) or bool(TILTED_BY_RIG & load.keys())


def round_contact(surface: Surface, modulus: float, name: str, value: float) -> HertzContact | RoundContact | None:
    """Return the contact of a cone by Love, or of a curved surface by Hertz, under P or delta_z; modulus: E* (MPa).

    A motion of the actuator counts as the approach, which it is at most.
    Any curved surface counts as the sphere with its curvature along x. None without contact, and for punches
    and rough surfaces.
    """
    if surface.kind == "punch" or surface.kind == "heights" or surface.kind == "roughness" or value <= 0.0:
        return None
    if surface.kind == "cone":
        return (love_cone if name == "P" else love_cone_at)(value, surface.angle, modulus)
    radius = abs(surface.radius_x if surface.kind == "ellipsoid" else surface.radius)
    return (hertz_sphere if name == "P" else hertz_sphere_at)(value, radius, modulus)


@dataclass(frozen=True)
class ClosedForms:
    """The closed forms of a case along its load path. Stages are counted from 0.

    loads: the imposed load components at the end of each stage; on a rig those of the contact, where they are known.
    """

    case: Case
    model: Model
    loads: tuple[Load, ...]

    @cached_property
    def friction_varies(self) -> bool:
        """As of the case, which looks through its load path."""
        return self.case.friction_varies

    # Pressing alone: Hertz, Boussinesq, Love.

    @cached_property
    def hertz(self) -> tuple[HertzContact | None, ...]:
        """Hertz's contact at the end of each stage; None where it is tilted, without contact, or of another shape."""
        find = cache(self.hertz_under)
        return tuple(None if is_tilted(load) else find(*pressing(load)) for load in self.loads)

    @property
    def contacts(self) -> tuple[HertzContact | LineContact | None, ...]:
        """Hertz's contact at the end of each stage, or a line's; None where no closed form gives it."""
        return self.hertz

    def hertz_under(self, name: str, value: float) -> HertzContact | None:
        """Return Hertz's contact, upright, under P or a sphere's under delta_z; None without one."""
        surface, angle = self._only_surface, 0.0
        if surface is not None and surface.kind == "sphere":
            Rx = Ry = surface.radius
        elif surface is not None and surface.kind == "ellipsoid":
            Rx, Ry, angle = surface.radius_x, surface.radius_y, surface.angle
        elif surface is not None and surface.kind == "cylinder" and surface.crown_radius is not None:
            Rx, Ry, angle = surface.crown_radius, surface.radius, surface.axis
        else:
            return None
        if min(value, Rx, Ry) <= 0.0 or (name != "P" and Rx != Ry) or name == "actuator_z":
            return None
        if Rx == Ry:
            contact = (hertz_sphere if name == "P" else hertz_sphere_at)(value, Rx, self._modulus)
        else:
            contact = replace(hertz_elliptic(value, Rx, Ry, self._modulus), angle=angle)
        if surface.kind == "cylinder" and surface.length is not None:  # a crowned one, which has to go on beyond it
            return contact if contact.semi_axes[0] < 0.5 * surface.length - (surface.end_radius or 0.0) else None
        return contact

    @cached_property
    def largest(self) -> HertzContact | None:
        """Hertz's contact at the largest normal load; None where the contact is ever tilted."""
        if any(map(is_tilted, self.loads)):
            return None
        return max(filter(None, self.hertz), key=lambda contact: contact.load, default=None)

    @cached_property
    def punch(self) -> FlatPunch | None:
        """Boussinesq's flat round punch where it is pressed hardest, sharp and never tilted."""
        surface = self._only_surface
        if surface is None or surface.kind != "punch" or surface.radius is None or surface.edge_radius:
            return None
        solve = partial(boussinesq_punch, radius=surface.radius, contact_modulus=self._modulus)
        stiffness = 1.0 / solve(1.0).delta_z
        pressed = max(load.get("P", stiffness * load.get("delta_z", 0.0)) for load in self.loads)
        return solve(pressed) if pressed > 0.0 and not any(map(is_tilted, self.loads)) else None

    @cached_property
    def widest(self) -> LineContact | None:
        """The contact of a line at the largest load, None on an area."""
        return None

    @property
    def largest_force(self) -> float:
        """The largest imposed P, 0 where none is."""
        return max(load.get("P", 0.0) for load in self.loads)

    def cylinder(self, endless: float | None) -> HertzLine | None:
        """Return Hertz's line contact of a straight cylinder at the largest load, as away from its ends; else None.

        endless: the length (mm) that counts of a cylinder without ends.
        """
        surface, load = self._only_surface, self.largest_force
        if surface is None or surface.kind != "cylinder" or surface.crown_radius is not None:
            return None
        length = surface.straight_length or endless
        if length is None or surface.radius <= 0.0 or load <= 0.0:
            return None
        return HertzLine(load / length, surface.radius, self._modulus)

    def contact_width(self, endless: float) -> float | None:
        """Return the shorter side (mm) of the largest contact, by Hertz or Love; of a punch its whole face.

        endless: the length (mm) that counts of a cylinder without ends.
        """
        if self.largest is not None:
            return 2.0 * min(self.largest.semi_axes)
        surface, load = self._only_surface, self.largest_force
        if surface is not None and surface.kind == "punch":
            return 2.0 * (surface.radius or surface.half_width or 0.0)
        if surface is not None and surface.kind == "cone" and load > 0.0:
            return 2.0 * love_cone(load, surface.angle, self._modulus).contact_radius
        line = self.cylinder(endless)
        return None if line is None else 2.0 * line.half_width

    @property
    def _modulus(self) -> float:
        return self.model.compliances.contact_modulus

    @property
    def _only_surface(self) -> Surface | None:
        """The surface if it is the only one, and no layer is compressed, which no closed form of pressing has."""
        alone = len(self.case.surface) == 1 and not self.model.compliances.layer_normal
        return self.case.surface[0] if alone else None

    # Tangential loads: Cattaneo and Mindlin, Lubkin, slip from the rim, bulk stress, Spence.

    def gross_slip(
        self, P: float, hertz: HertzContact | None = None, coefficient: float | None = None
    ) -> tuple[float, float, float | None]:
        """Return force (N), torque (N mm) and displacement (mm) of gross slip under P (N), on Hertz's contact if it is.

        The torque is infinite, and the displacement under the force is None, where no closed form gives them. Where
        friction varies, the force may be infinite too. coefficient: that a stage has set.
        """
        if self.friction_varies:
            return self._varied_gross_slip(hertz, coefficient, P)
        friction = self.model.friction
        if hertz is None or not hertz.is_circle:
            return friction * P, math.inf, None
        delta_x = None
        if friction and not self.model.coupled and self.model.bulk is None:
            pair = self.model.compliances
            compliance = onset_compliance(hertz.contact_radius, pair.tangential, pair.layer_shear)
            delta_x = cattaneo_mindlin(hertz, friction, friction * P, compliance).delta_x
        return friction * P, gross_slip_torque(hertz, friction), delta_x

    def _varied_gross_slip(
        self, hertz: HertzContact | None, coefficient: float | None, P: float
    ) -> tuple[float, float, float | None]:
        force = None if hertz is None else self._friction_on_contact(coefficient).gross_slip_force(hertz)
        if hertz is None or force is None:
            return math.inf, math.inf, None
        limit = self._friction_on_contact().rim_slip(hertz, self.model.compliances.tangential)
        if self.model.compliances.layer_shear:  # where another point than the middle may stick last
            limit = None
        if limit is None or self.model.coupled or self.model.bulk is not None:
            return force, math.inf, None
        return force, limit.gross_slip_torque, limit.under(limit.gross_slip_force).delta_x

    def full_stick(self, hertz: HertzContact | None) -> float | None:
        """Return delta_x per Qx (mm/N) of a circle without slip, as just after a load turns back; None if unknown."""
        if hertz is None or not hertz.is_circle or not self.model.has_shear or self.model.coupled:
            return None
        pair = self.model.compliances
        return layered_stick_compliance(hertz.contact_radius, pair.tangential, pair.layer_shear)

    def _friction_on_contact(self, coefficient: float | None = None) -> FrictionOnContact:
        from fretsolve.problem.friction.law import FrictionOnContact  # few cases have such friction

        return FrictionOnContact(self.case, self.case.surface[0].center, coefficient)

    def tangential(self, stage: int, center: tuple[float, float] | None = None) -> CyclicLoading | None:
        """Return Cattaneo and Mindlin's or Lubkin's solution for a sphere after `stage`; None where there is none.

        There is none where shear acts on the pressure, or where a tangential motion is imposed. Where friction varies,
        it is slip from the rim under a force, if that holds. center: of the contact (mm), by default the sphere's own.
        """
        if self.model.compliances.layer_shear:
            return None
        circle = self.hertz[stage]
        if circle is None or not circle.is_circle or self.model.bulk is not None:
            return None
        if not self.model.has_shear or self.model.coupled:
            return None
        P, Qx, Qy, Mz, imposed, tilted = self._shear_path[:, : stage + 2]
        if tilted.any() or not np.isfinite([Qx, Qy, Mz]).all():
            return None
        # An imposed Mz is about the origin; a rotation that is held takes no torque about the contact's centre.
        x, y = center or self.case.surface[0].center
        torque = np.where(imposed > 0.0, Mz - x * Qy + y * Qx, 0.0)
        compliances = self.model.compliances.tangential, self.model.compliances.torsional
        friction, varies = self.model.friction, self.friction_varies
        if varies:
            # The coefficient that carries as much: under a shear limit the case's own may be a mere large number.
            carried = self._friction_on_contact().gross_slip_force(circle)
            friction = friction if carried is None else carried / circle.load
        found = cyclic_loading(circle, friction, compliances, (P, Qx, Qy, torque), (x, y))
        if found is None or not varies:
            return found
        limit = None if found.direction is None else self._friction_on_contact().rim_slip(circle, compliances[0])
        return None if limit is None else replace(found, friction_limit=limit)

    @cached_property
    def _shear_path(self) -> DoubleArray:
        """P, Qx, Qy, Mz, whether Mz is imposed, and whether the contact is tilted: unloaded, and at the end of each
        stage, (6, stages + 1)."""
        pressed = [contact.load if contact else 0.0 for contact in self.hertz]
        forces = (_path(self.loads, force) for force in ("Qx", "Qy", "Mz"))
        flags = (["Mz" in load for load in self.loads], list(map(is_tilted, self.loads)))
        return np.pad(np.array([pressed, *forces, *flags], np.float64), ((0, 0), (1, 0)))

    def values(self, wanted: Collection[int] | None = None) -> Iterator[ClosedForm]:
        """Yield the exact values at the ends of the stages that P alone presses, upright, as the model has them.

        wanted: stages (from 0), None for all; each takes as long as the path before it. Cattaneo and Mindlin neglect
        that shear along x moves the surfaces along y, Lubkin does not.
        """
        if self.model.terms.normal_tangential_coupling or self.case.wear is not None:
            return  # wear changes the shape of the surfaces
        for stage, (load, hertz) in enumerate(zip(self.loads, self.hertz, strict=True)):
            if wanted is not None and stage not in wanted:
                continue
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
        if not self._directions_interact and isinstance(self.under_bulk, tuple):
            stage, form = self.under_bulk
            c = form.stick_radius
            found = {"stick_radius": c, "stick_area": math.pi * c**2, "delta_x": form.delta_x}
            found |= {"stick_half_width_x": c, "stick_half_width_y": c}
            found |= {"stick_center_x": self.case.surface[0].center[0] + form.stick_center}
            yield from (ClosedForm(name, stage, value, form.source) for name, value in found.items())

    @property
    def _directions_interact(self) -> bool:
        return self.model.terms.in_plane_coupling and self.model.compliances.B != 0.0

    @cached_property
    def under_bulk(self) -> tuple[int, SphereUnderBulk] | str:
        """The stage with the largest force, and the sphere under it and bulk stress; or why there is no form."""
        bulk, material = self.model.bulk, self.model.compliances
        circles = [one for one in self.hertz if one is not None]
        if bulk is None or not circles or not circles[-1].is_circle or self.model.coupled:
            return "it needs a sphere on a body of its own material"
        if self.model.compliances.layer_shear:
            return "it needs bodies without a layer between them"
        if self.friction_varies:
            return "it needs one coefficient of friction"
        P, force, across = (np.array([load.get(name, np.nan) for load in self.loads]) for name in ("P", "Qx", "Qy"))
        xx, yy, xy = np.array([bulk.mismatch(load) for load in self.loads]).T
        stage = int(np.abs(np.nan_to_num(force)).argmax())
        if not np.nanmax(np.abs(force), initial=0.0) or np.nan_to_num(across, nan=1.0).any() or xy.any():
            return "it needs a force Qx and no other, and no shear stress"
        moved = int(np.flatnonzero((force != 0.0) | (xx != 0.0))[0])
        if np.ptp(P[max(moved - 1, 0) :]) > ALIKE * P[stage]:
            return "P changes under shear"
        if np.abs(force * xx[stage] - force[stage] * xx).max() > ALIKE * abs(force[stage] * xx[stage]):
            return "force and bulk stress are not in proportion"
        hertz = self.hertz[stage]
        assert hertz is not None
        try:
            compliances, loads = (material.A, material.B), (float(force[stage]), float(xx[stage]))
            found = SphereUnderBulk(hertz, self.model.friction, compliances, *loads)
        except ValueError:
            return "the stick zone reaches the edge of the contact"
        wanted = found.mismatch_across if self.model.terms.in_plane_coupling else 0.0
        if abs(yy[stage] - wanted) > ALIKE * abs(xx[stage]):
            needed, given = wanted / xx[stage], yy[stage] / xx[stage]
            return f"it needs a mismatch along y of {needed:.4g} times that along x, not {given:.4g}"
        return stage, found

    @property
    def why_not_mindlin(self) -> str:
        """The reason why Cattaneo and Mindlin are not exact where it is a layer or Poisson's ratio; else empty."""
        if self.model.compliances.layer_shear:
            return WITH_LAYER
        sheared = bool(SHEARED & set(self.model.moved))
        if not self._directions_interact or not sheared or self.model.bulk is not None:
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
        if not self.model.has_shear or self.model.compliances.layer_shear:
            return None
        if self.model.bulk is not None:
            if isinstance(self.under_bulk, str):
                return None
            stage, form = self.under_bulk
            return ClosedForm("stick_radius", stage, form.stick_radius, form.source)
        if self.model.moved:
            if {"delta_x", "delta_y"} & {name for load in self.loads for name, value in load.items() if value}:
                return self._smallest_stick_moved
            shear = self.tangential(len(self.loads) - 1)
            if shear is None or shear.largest >= shear.limit:
                return None
            stage = [abs(load) for load in shear.path].index(shear.largest) - 1  # the path begins unloaded
            return ClosedForm("stick_radius", stage, shear.on_loading(shear.largest).stick_radius, shear.source)
        radii = [(one.contact_radius, stage) for stage, one in enumerate(self.hertz) if one and one.is_circle]
        if not radii or not self.model.coupled or self.friction_varies:
            return None
        radius, stage = max(radii)
        return ClosedForm("stick_radius", stage, spence_ratio(self.model) * radius, "Spence")

    @property
    def _smallest_stick_moved(self) -> ClosedForm | None:
        """The smallest stick radius where a displacement along one direction is imposed: where it is largest.

        On the way back, half of the displacement from the turning point counts.
        """
        if self.model.coupled or self.friction_varies or not self.model.friction:
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
        return None if shear is None else ClosedForm("stick_radius", stage, shear.stick_radius, "Cattaneo-Mindlin")


def _path(loads: tuple[Load, ...], force: str) -> list[float]:
    """Return a tangential force at the end of each stage; infinite where its motion is imposed, 0 while it is held."""
    motion, path, moved = dict(PAIRS)[force], list[float](), False
    for load in loads:
        held = load.get(motion) == 0.0 and not moved
        path.append(load.get(force, 0.0 if held else math.inf))
        moved = moved or path[-1] != 0.0
    return path
