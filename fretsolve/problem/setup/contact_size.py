"""Margins and size of the potential contact area, as far as closed forms give it; else a search gives it."""

from __future__ import annotations

import math

import numpy as np

from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.problem.setup.closed_forms import ClosedForms

Size = tuple[float, float]

AREA_MARGIN = 1.2
"""Sides of the area over the frictionless contact's extent about the centre."""

COUPLED_MARGIN, COUPLED_LINE_MARGIN = 1.1, 1.5
"""Half a side over the reach of a contact that shear moves, tried with friction from 0.3 to 30 on dissimilar bodies;
and the side over the width of such a line contact."""

FEWEST_COARSE_POINTS, COARSENED, FREE_COARSE_CELLS = 8, 3, 1.0
"""Points per side of the coarsest run for error bars, at least, since with fewer a contact has no inside; by what they
are fewer than those of the run; and cells of that grid to leave free on each side of the contact. With 0.67 of them,
which AREA_MARGIN leaves, a coarse run found no solution in 28 of 140 contacts on 16 points (twelve surfaces, similar
and dissimilar bodies, pressed alone and sheared to 0.9 of mu P), with 1 in none of them."""


def size_by_closed_form(forms: ClosedForms) -> Size | None:
    """Return the sides (mm) that hold the contact on the load path of a sphere or a line; None for other surfaces.

    Raises CaseError for a concave sphere.
    """
    if (concave := concave_sphere(forms.case)) is not None:
        raise concave
    surface, hertz = forms.case.surface[0], forms.largest
    if surface.center != forms.case.grid.center:
        return None
    if hertz is not None and surface.kind == "sphere":
        reach = max(hertz.contact_radius, worn_reach(forms))
        side = 2.0 * max(AREA_MARGIN * reach, COUPLED_MARGIN * _sheared_reach(forms))
        return side, side
    if forms.model.line and (width := forms.contact_width(0.0)):
        side = (COUPLED_LINE_MARGIN if forms.model.coupled and forms.model.moved else AREA_MARGIN) * width
        return side, side
    return None


def coarse_points(points: int, factor: int) -> int:
    """Return the points of a side on which a coarse run has a `factor`-th of `points`, at least.

    An even number becomes an even one, so that mirror images stay solved on one half of the grid.
    """
    found = max(min(points, FEWEST_COARSE_POINTS), math.ceil(points / factor))
    return found + found % 2 * (points % 2 == 0)


def room_for_coarse_runs(points: int) -> float:
    """Return the factor on an automatic side of `points` that lets the coarse runs of error bars hold the contact.

    It is 1 from 33 points on.
    """
    return room_for_cells(coarse_points(points, COARSENED))


def room_for_cells(points: int) -> float:
    """Return the factor on a side with AREA_MARGIN that leaves cells free on each side of a contact.

    points: of the side, at least 3. It is 1 from 12 points on.
    """
    return max(1.0, points / (points - 2.0 * FREE_COARSE_CELLS) / AREA_MARGIN)


def worn_reach(forms: ClosedForms) -> float:
    """Return how far from the grid's middle (mm) the worn contact reaches at most, 0 where none is known."""
    if forms.case.wear is None:
        return 0.0
    from fretsolve.problem.setup.wear_forms import worn_radius  # few cases have wear

    radius = worn_radius(forms)
    return radius + max(map(abs, np.subtract(forms.case.surface[0].center, forms.case.grid.center))) if radius else 0.0


def _sheared_reach(forms: ClosedForms) -> float:
    """Return how far from the centre (mm) a sphere's contact reaches on the load path, moved by the coupling to shear.

    A tangential force Q within the radius a has uz of about beta Q / (pi E* a) at the edge, by the field of a point
    force (Cerruti), up on one side and down on the other. A sphere of radius R tilted so touches R beta Q / (pi E* a^2)
    beside its centre. Q is at most mu P, and 2 E* a times a displacement.
    """
    sphere, model = forms.case.surface[0], forms.model
    modulus, coupling = model.compliances.contact_modulus, abs(model.compliances.dundurs_constant)
    if sphere.kind != "sphere" or not model.terms.normal_tangential_coupling:
        return 0.0
    reach = 0.0
    for load, hertz in zip(forms.loads, forms.hertz, strict=True):
        if hertz is not None:
            radius = hertz.contact_radius
            stiffness = 2.0 * modulus * radius
            forces = [load.get(f"Q{axis}", stiffness * load.get(f"delta_{axis}", 0.0)) for axis in "xy"]
            force = min(model.friction * hertz.load, math.hypot(*forces))
            reach = max(reach, radius + sphere.radius * coupling * force / (math.pi * modulus * radius**2))
    return reach


def concave_sphere(case: Case) -> CaseError | None:
    """Return the error of a case whose only surface is a concave sphere; None for any other."""
    sphere = case.surface[0]
    if len(case.surface) > 1 or sphere.kind != "sphere" or sphere.radius > 0.0:
        return None
    return case.source.problem(
        f"{sphere.radius:g} mm is concave, so the bodies would touch only at the grid's edge; a convex sphere has a"
        " positive radius, a ball in a socket takes both spheres",
        ("surface", 0, "sphere", "radius"),
    )
