"""What Hertz's theory says of a case, where it applies: a single sphere or ellipsoid that is not tilted."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.closed_forms import HertzContact, full_slip_torque, hertz_elliptic, hertz_sphere

if TYPE_CHECKING:
    from fretsolve.grid import Grid
    from fretsolve.modes import Balance
    from fretsolve.scene import Scene


@dataclass(frozen=True)
class Hertz:
    """The frictionless contact under `load` (N): semi-axes and approach in mm, peak pressure in MPa."""

    load: float
    semi_axes: tuple[float, float]
    max_pressure: float
    delta_z: float

    def torque(self, friction: float) -> float:
        """Torque (N mm) at which a circular contact slips everywhere."""
        circle = HertzContact(self.load, self.semi_axes[0], self.max_pressure, self.delta_z)
        return full_slip_torque(circle, friction)

    def cells_across(self, grid: Grid) -> float:
        """Cells along the shorter diameter."""
        return 2.0 * min(self.semi_axes) / max(grid.dx, grid.dy)


def hertz_contact(scene: Scene) -> Hertz | None:
    """Hertz's contact at the largest normal load of the path; None where his theory does not apply."""
    surface, modulus = scene.case.surface[0], scene.model.compliances.contact_modulus
    loads = scene.load_path.normal_loads()
    if len(scene.case.surface) > 1 or any(load.values[1] or load.values[2] for load in loads):
        return None
    if surface.kind == "sphere":
        radii = (surface.radius, surface.radius)
    elif surface.kind == "ellipsoid" and all(load.forced[0] for load in loads):
        radii = (surface.radius_x, surface.radius_y)
    else:
        return None
    if min(radii) <= 0.0:
        return None
    largest = max(_normal_force(load, radii[0], modulus) for load in loads)
    if largest <= 0.0:
        return None
    if radii[0] == radii[1]:
        circle = hertz_sphere(largest, radii[0], modulus)
        return Hertz(largest, (circle.contact_radius,) * 2, circle.max_pressure, circle.delta_z)
    ellipse = hertz_elliptic(largest, *radii, modulus)
    return Hertz(largest, (ellipse.semi_axis_x, ellipse.semi_axis_y), ellipse.max_pressure, ellipse.delta_z)


def _normal_force(load: Balance, radius: float, modulus: float) -> float:
    """P, or that of a sphere pressed in by delta_z."""
    if load.forced[0]:
        return load.values[0]
    return 4.0 / 3.0 * modulus * math.sqrt(radius * max(load.values[0], 0.0) ** 3)
