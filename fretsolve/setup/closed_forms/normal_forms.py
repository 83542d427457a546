"""The closed forms of pressing alone, on an area: Hertz, Boussinesq, Love."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING

from fretsolve.case.keys.surface_specs import Surface
from fretsolve.case.models import Case
from fretsolve.model.required_terms import Model
from fretsolve.reference.hertz import (
    FlatPunch,
    HertzContact,
    RoundContact,
    boussinesq_punch,
    hertz_elliptic,
    hertz_line_half_width,
    hertz_sphere,
    hertz_sphere_at,
    love_cone,
    love_cone_at,
)

if TYPE_CHECKING:
    from fretsolve.reference.line import HertzLine

Load = Mapping[str, float]
"""The imposed load components with their totals (N, mm, N mm, rad)."""


def pressing(load: Load) -> tuple[str, float]:
    """Return name and value of the imposed normal load: P, or else delta_z."""
    return ("P", load["P"]) if "P" in load else ("delta_z", load["delta_z"])


def round_contact(surface: Surface, modulus: float, name: str, value: float) -> HertzContact | RoundContact | None:
    """Return the contact of a cone by Love, or of a curved surface by Hertz, under P or delta_z; modulus: E* (MPa).

    Any curved surface counts as the sphere with its curvature along x. None without contact, for punches and maps.
    """
    if surface.kind == "punch" or surface.kind == "heights" or value <= 0.0:
        return None
    if surface.kind == "cone":
        return (love_cone if name == "P" else love_cone_at)(value, surface.angle, modulus)
    radius = abs(surface.radius_x if surface.kind == "ellipsoid" else surface.radius)
    return (hertz_sphere if name == "P" else hertz_sphere_at)(value, radius, modulus)


@dataclass(frozen=True)
class NormalForms:
    """The closed forms of the normal loads of a case along its load path. Stages are counted from 0.

    loads: the imposed load components at the end of each stage.
    """

    case: Case
    model: Model
    loads: tuple[Load, ...]

    @cached_property
    def hertz(self) -> tuple[HertzContact | None, ...]:
        """Hertz's contact at the end of each stage; None where it is tilted, without contact, or of another shape."""
        find = cache(self.hertz_under)
        return tuple(None if is_tilted(load) else find(*pressing(load)) for load in self.loads)

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
        if min(value, Rx, Ry) <= 0.0 or (name != "P" and Rx != Ry):
            return None
        if Rx == Ry:
            contact = round_contact(surface, self._modulus, name, value)
            return contact if isinstance(contact, HertzContact) and _is_within(surface, contact) else None
        ellipse = replace(hertz_elliptic(value, Rx, Ry, self._modulus), angle=angle)
        return ellipse if _is_within(surface, ellipse) else None

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

    def cylinder(self, endless: float | None) -> HertzLine | None:
        """Return Hertz's line contact of a straight cylinder at the largest load, as away from its ends; else None.

        endless: the length (mm) that counts of a cylinder without ends.
        """
        surface, load = self._only_surface, max(load.get("P", 0.0) for load in self.loads)
        if surface is None or surface.kind != "cylinder" or surface.crown_radius is not None:
            return None
        length = surface.straight_length or endless
        if length is None or surface.radius <= 0.0 or load <= 0.0:
            return None
        from fretsolve.reference.line import HertzLine  # other cases need none of it

        return HertzLine(load / length, surface.radius, self._modulus)

    def contact_width(self, endless: float) -> float | None:
        """Return the shorter side (mm) of the largest contact, by Hertz or Love; of a punch its whole face.

        endless: the length (mm) that counts of a cylinder without ends.
        """
        if self.largest is not None:
            return 2.0 * min(self.largest.semi_axes)
        surface, load = self._only_surface, max(load.get("P", 0.0) for load in self.loads)
        if surface is None or (load <= 0.0 and surface.kind != "punch"):
            return None
        if surface.kind == "punch":
            return 2.0 * (surface.radius or surface.half_width or 0.0)
        if surface.kind == "cone":
            return 2.0 * love_cone(load, surface.angle, self._modulus).contact_radius
        if surface.kind == "cylinder" and surface.crown_radius is None and surface.radius > 0.0:
            per_length = load / (surface.straight_length or endless)
            return 2.0 * hertz_line_half_width(per_length, surface.radius, self._modulus)
        return None

    @property
    def _modulus(self) -> float:
        return self.model.compliances.contact_modulus

    @property
    def _only_surface(self) -> Surface | None:
        return self.case.surface[0] if len(self.case.surface) == 1 else None


def _is_within(surface: Surface, contact: HertzContact) -> bool:
    """Return whether a contact ends before a crowned cylinder does."""
    if surface.kind != "cylinder" or surface.length is None:
        return True
    return contact.semi_axes[0] < 0.5 * surface.length - (surface.end_radius or 0.0)


def is_tilted(load: Load) -> bool:
    """Return whether moments or rotations other than 0 are imposed."""
    return any(load.get(name) for name in ("Mx", "My", "phi_x", "phi_y"))
