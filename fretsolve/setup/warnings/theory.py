"""Warn of contacts that half-spaces, linear elasticity and small motions do not stand for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from fretsolve.errors import dotted
from fretsolve.setup.contact_size import AREA_MARGIN
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.setup.warnings.resolution import cylinder_contact

LARGEST_SIZE = 0.1
"""Contact radius over radius of curvature up to which a half-space and a paraboloid stand for the body. The strains are
about the same at this slope of a cone, and at this approach of a punch over its radius."""

SPHERE_YIELD, LINE_YIELD = 1.6, 1.67
"""Largest Hertz pressure over the yield stress at which a body of Poisson's ratio 0.3 begins to yield under a sphere
and a cylinder; Johnson, Contact Mechanics (1985), section 6.1 (Tresca). An ellipse lies between both."""

HOLD_TO = "half-spaces and linear elasticity hold to about"


def about_shapes(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a cone that is too steep, and of a punch that goes too deep, for the theory."""
    for place, surface in enumerate(setup.case.surface):
        if surface.kind == "cone" and math.tan(surface.angle) > LARGEST_SIZE:
            key = setup.case.source.typed(("surface", place, "cone", "angle"))
            yield (
                f"{dotted(key)}: {math.degrees(surface.angle):.3g} deg between flank and contact plane is steep (mean"
                f" pressure over E* {0.5 * math.tan(surface.angle):.2g}): {HOLD_TO}"
                f" {math.degrees(math.atan(LARGEST_SIZE)):.2g} deg; is the angle to the axis meant?"
            )
    punch, modulus = setup.closed_forms.punch, setup.model.compliances.contact_modulus
    if punch is not None and punch.delta_z > LARGEST_SIZE * punch.contact_radius:
        depth, mean = punch.delta_z / punch.contact_radius, punch.mean_pressure / modulus
        yield (
            f"load_path: the punch goes deep against its radius (delta_z/a = {depth:.2g}, mean pressure over E*"
            f" {mean:.2g}): {HOLD_TO} delta_z/a = {LARGEST_SIZE:g}; are all units right?"
        )


def about_hertz(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a contact by Hertz that is too large for the theory, for the motions or for the grid."""
    hertz, modulus = setup.closed_forms.largest, setup.model.compliances.contact_modulus
    if hertz is None:
        return
    if hertz.size_over_radius > LARGEST_SIZE:
        yield (
            f"load_path: the contact is large against the radius (a/R = {hertz.size_over_radius:.2g}, p0/E* ="
            f" {hertz.max_pressure / modulus:.2g}): {HOLD_TO} a/R = {LARGEST_SIZE:g}; are all units right?"
        )
    radius = min(hertz.half_extent)
    for load, name in product(setup.load_path.imposed, ("delta_x", "delta_y", "phi_z")):
        motion = abs(load.get(name, 0.0)) * (radius if name == "phi_z" else 1.0)
        if motion > radius:
            yield (
                f"load_path: {name} moves the surfaces by {motion / radius:.2g} contact radii, but both keep their"
                " places on the grid: motions must be small against the contact"
            )
    if setup.case.grid.size is None:
        return
    grid, center = setup.grid, setup.case.surface[0].center
    reach = np.abs(np.subtract(center, grid.center)) + hertz.half_extent
    # The edge of the discrete contact may reach into the next 1.5 cells.
    if (reach > 0.5 * np.array(grid.size) - 1.5 * np.array([grid.dx, grid.dy])).any():
        advised = ", ".join(f"{side:.3g} mm" for side in 2.0 * AREA_MARGIN * reach)
        yield f"grid.size: the contact comes near the grid's edge or reaches it; [{advised}] would leave room"


def about_yield(setup: ProblemSetup) -> Iterator[str]:
    """Warn of a Hertz contact that would yield below the surface, where a body gives its yield stress."""
    if not any(getattr(body, "yield_stress", None) for body in setup.case.bodies):
        return
    pressure, factor = 0.0, SPHERE_YIELD
    if setup.closed_forms.largest is not None:
        pressure = setup.closed_forms.largest.max_pressure
    elif (line := cylinder_contact(setup)) is not None:
        pressure, factor = line.max_pressure, LINE_YIELD
    elif setup.model.line:
        from fretsolve.setup.closed_forms.line_forms import LineClosedForms

        forms = setup.closed_forms
        if isinstance(forms, LineClosedForms) and forms.source == "Hertz" and forms.widest is not None:
            pressure, factor = forms.widest.max_pressure, LINE_YIELD
    for number, body in enumerate(setup.case.bodies):
        limit = factor * (getattr(body, "yield_stress", None) or math.inf)
        if pressure > limit:
            yield (
                f"bodies.{number}.yield_stress: p0 = {pressure:.4g} MPa is above {factor:g} times the yield stress,"
                f" {limit:.4g} MPa, from where body {number + 1} yields below the surface: the solution is elastic"
            )


def about_line(setup: ProblemSetup) -> Iterator[str]:
    """Warn of the contact of a cylinder or of a line that is too large for the theory or for the grid."""
    if (line := cylinder_contact(setup)) is not None:
        yield from _about_width(line.half_width / line.radius)
    if not setup.model.line:
        return
    from fretsolve.setup.closed_forms.line_forms import LineClosedForms

    forms, grid, surface = setup.closed_forms, setup.grid, setup.case.surface[0]
    if not isinstance(forms, LineClosedForms) or (contact := forms.widest) is None:
        return
    if surface.kind == "cylinder":
        yield from _about_width(contact.half_width / surface.radius)
    reach = abs(surface.center[0] - grid.x0) + contact.half_width
    if setup.case.grid.size is not None and reach > 0.5 * grid.size[0] - 1.5 * grid.dx:
        advised = f"{2.0 * AREA_MARGIN * reach:.3g} mm"
        yield f"grid.size: the contact comes near the grid's edge or reaches it; {advised} would leave room"


def _about_width(share: float) -> Iterator[str]:
    if share > LARGEST_SIZE:
        yield (
            f"load_path: the contact is large against the radius (a/R = {share:.2g}):"
            f" {HOLD_TO} a/R = {LARGEST_SIZE:g}; are all units right?"
        )
