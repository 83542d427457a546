"""What Hertz's theory says of a case, where it applies: a single sphere or ellipsoid that is not tilted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.reference.closed_forms import HertzContact, full_slip_torque, hertz_elliptic, hertz_sphere

if TYPE_CHECKING:
    from collections.abc import Mapping

    from fretsolve.model.grid import Grid
    from fretsolve.setup.problem_setup import ProblemSetup


@dataclass(frozen=True)
class Hertz:
    """The frictionless contact under `load` (N): semi-axes, the radii of curvature along them and approach in mm.

    max_pressure, modulus: p0 and E* in MPa; angle: from x to the first semi-axis (rad).
    """

    load: float
    semi_axes: tuple[float, float]
    radii: tuple[float, float]
    angle: float
    max_pressure: float
    delta_z: float
    modulus: float

    @property
    def circle(self) -> HertzContact | None:
        """The contact where it is circular."""
        if self.radii[0] != self.radii[1]:
            return None
        return HertzContact(self.load, self.semi_axes[0], self.max_pressure, self.delta_z)

    @property
    def size_over_radius(self) -> float:
        """a/R, the larger one of both directions."""
        return max(axis / radius for axis, radius in zip(self.semi_axes, self.radii, strict=True))

    @property
    def strain(self) -> float:
        """p0/E*, of the order of the strains."""
        return self.max_pressure / self.modulus

    @property
    def half_extent(self) -> tuple[float, float]:
        """How far the contact reaches from its centre along x and along y (mm)."""
        (first, second), cosine, sine = self.semi_axes, math.cos(self.angle), math.sin(self.angle)
        return math.hypot(first * cosine, second * sine), math.hypot(first * sine, second * cosine)

    def torque(self, friction: float) -> float | None:
        """Torque (N mm) at which a circular contact slips everywhere; None for another one."""
        return None if self.circle is None else full_slip_torque(self.circle, friction)

    def cells_across(self, grid: Grid) -> float:
        """Cells along the shorter diameter."""
        return 2.0 * min(self.semi_axes) / max(grid.dx, grid.dy)


def hertz_contact(setup: ProblemSetup) -> Hertz | None:
    """Hertz's contact at the largest normal load of the path; None where his theory does not apply."""
    found = [hertz for hertz in hertz_contacts(setup) if hertz is not None]
    return max(found, key=lambda hertz: hertz.load, default=None)


def hertz_contacts(setup: ProblemSetup) -> list[Hertz | None]:
    """Hertz's contact at the end of each stage; None where his theory does not apply, or nothing presses.

    All are None where the contact is ever tilted.
    """
    loads = setup.load_path.imposed
    if any(load.get(name) for load in loads for name in ("Mx", "My", "phi_x", "phi_y")):
        return [None] * len(loads)
    known: dict[tuple[float | None, float | None], Hertz | None] = {}
    for load in loads:
        key = load.get("P"), load.get("delta_z")
        if key not in known:
            known[key] = _under(setup, load)
    return [known[load.get("P"), load.get("delta_z")] for load in loads]


def _under(setup: ProblemSetup, load: Mapping[str, float]) -> Hertz | None:
    """The contact under P, or with a sphere under delta_z."""
    surface, modulus = setup.case.surface[0], setup.model.compliances.contact_modulus
    angle = 0.0
    if len(setup.case.surface) > 1:
        return None
    if surface.kind == "sphere":
        radii = (surface.radius, surface.radius)
    elif surface.kind == "ellipsoid" and "P" in load:
        radii, angle = (surface.radius_x, surface.radius_y), surface.angle
    else:
        return None
    if min(radii) <= 0.0:
        return None
    pressed = load["P"] if "P" in load else _sphere_force(load["delta_z"], radii[0], modulus)
    if pressed <= 0.0:
        return None
    if radii[0] == radii[1]:
        circle = hertz_sphere(pressed, radii[0], modulus)
        axes = (circle.contact_radius, circle.contact_radius)
        return Hertz(pressed, axes, radii, 0.0, circle.max_pressure, circle.delta_z, modulus)
    ellipse = hertz_elliptic(pressed, *radii, modulus)
    axes = (ellipse.semi_axis_x, ellipse.semi_axis_y)
    return Hertz(pressed, axes, radii, angle, ellipse.max_pressure, ellipse.delta_z, modulus)


def _sphere_force(delta_z: float, radius: float, modulus: float) -> float:
    """The force (N) of a sphere pressed in by `delta_z` (mm)."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius * max(delta_z, 0.0) ** 3)
