"""Pick the settings that a case leaves out: the size of its area, and what its accuracy asks for.

Where closed forms do not give the size, `simulation.problem_setup` searches for it on a coarse grid. The laws of
accuracy are measured (docs/howto/grid_and_increments.md); the error bars give the case's own errors, and
`result.verdict` judges by them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.dimensions import cell_counts, percent
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.model.required_terms import Model
from fretsolve.problem.setup.closed_forms import ClosedForms, spence_ratio
from fretsolve.problem.setup.wear_forms import worn_radius
from fretsolve.result.verdict import POINTS_DIVISOR

if TYPE_CHECKING:
    from fretsolve.problem.setup.unresolved_heights import HeightMaps


Size = tuple[float, float]

AREA_MARGIN = 1.2
"""Sides of the area over the frictionless contact's extent about the centre."""

COUPLED_MARGIN, COUPLED_LINE_MARGIN = 1.1, 1.5
"""Half a side over the reach of a contact that shear moves, tried with friction from 0.3 to 30 on dissimilar bodies;
and the side over the width of such a line contact."""

FEWEST_COARSE_POINTS, COARSENED = 8, 3
"""Points per side of the coarsest run for error bars, at least, since with fewer a contact has no inside; and by what
factor the run has more."""


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
        margin = COUPLED_LINE_MARGIN if forms.model.coupled and forms.model.moved else AREA_MARGIN
        side = margin * max(width, 2.0 * worn_reach(forms))
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
    """Return the factor on a side with AREA_MARGIN that leaves one cell free on each side of a contact.

    With 0.67 of a cell, which AREA_MARGIN leaves, a coarse run found no solution in 28 of 140 contacts on 16 points
    (twelve surfaces, similar and dissimilar bodies, pressed alone and sheared to 0.9 of mu P), with 1 in none of them.

    points: of the side, at least 3. It is 1 from 12 points on.
    """
    return max(1.0, points / (points - 2.0) / AREA_MARGIN)


def worn_reach(forms: ClosedForms) -> float:
    """Return how far from the grid's middle (mm) the worn contact reaches at most, 0 where none is known."""
    if forms.case.wear is None:
        return 0.0
    radius = worn_radius(forms)
    return radius + max(map(abs, np.subtract(forms.case.surface[0].center, forms.case.grid.center))) if radius else 0.0


def _sheared_reach(forms: ClosedForms) -> float:
    """Return how far from the centre (mm) a sphere's contact reaches on the load path, moved by the coupling to shear.

    A tangential force Q within the radius a has uz of about beta Q / (pi E* a) at the edge, by the field of a point
    force (Cerruti), up on one side and down on the other. A sphere of radius R tilted so touches R beta Q / (pi E* a^2)
    beside its centre. Q is at most mu P, and 2 E* a times a displacement, of which a rig takes a part.
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
            motions = (load.get(f"delta_{axis}", load.get(f"actuator_{axis}", 0.0)) for axis in "xy")
            forces = [load.get(f"Q{axis}", stiffness * m) for axis, m in zip("xy", motions, strict=True)]
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


Law = tuple[float, float]
"""An error bar, and the order with which it falls with the number of what it depends on."""

CELLS, CELLS_LAW = 30.0, (0.035, 1.4)
"""Cells across the contact, and the law by which the error bar of the stick radius falls with these cells. It is the
largest bar that cells cause (docs/error_bars.md)."""

SHEARED_LAW, PRESSED_LAW = (0.9, 2.4), (1.5, 1.57)
"""Laws of the error bar of the dissipated energy, from a slip annulus of one cell on: for similar bodies under shear,
and for dissimilar bodies pressed together."""

INCREMENTS_LAW = (0.015, 1.15)
"""Law of the error bar of the corrected dissipated energy and rotation, from automatic increments without an accuracy
on."""

MOST_FOR_SLIP = 4.0
"""Largest factor on cells or increments for a narrow annulus, which dissipates next to nothing."""

NARROW_LAW = (0.5, 2.5)
"""Width of the slip annulus, over the contact radius, of dissimilar bodies pressed together, below which more
increments are taken, and the order with which it falls with their number."""


def _refined(law: Law, accuracy: float) -> float:
    """Return the factor on the number that a law depends on with which its error bar is the accuracy."""
    error, order = law
    return math.pow(error / accuracy, 1.0 / order)


def points_needed(
    forms: ClosedForms,
    load_path: LoadPath,
    size: Size,
    heights: Callable[[], HeightMaps],
    automatic_size: Callable[[], Size],
) -> tuple[int, int]:
    """Return the points along x and y that the case's accuracy needs on an area of `size` (mm).

    They follow from the contact's share of the area, the whole area where the contact's size is unknown, and from
    `heights` that are finer than such cells. heights, automatic_size: as of `ProblemSetup`. Raises FileError or
    CaseError where a map cannot be read or is too fine.
    """
    accuracy, holds_contact = forms.case.solver.accuracy, size
    assert accuracy is not None
    if forms.case.grid.size is not None:
        with contextlib.suppress(CaseError):
            holds_contact = automatic_size()
    usual = cells = CELLS * _refined(CELLS_LAW, accuracy)
    sheared_width = 0.0 if forms.model.coupled else load_path.slip_width
    for width, law in ((sheared_width, SHEARED_LAW), (_pressed_width(forms.model), PRESSED_LAW)):
        if width > 0.0:
            cells = max(cells, min(2.0 * _refined(law, accuracy) / width, MOST_FOR_SLIP * usual))
    extents = (side / AREA_MARGIN for side in holds_contact)
    nx, ny = (
        math.ceil(max(36, cells * side / extent) - 1e-9)  # less the rounding error
        for side, extent in zip(size, extents, strict=True)
    )
    if forms.model.line:
        nx, ny = max(nx, ny), 1
    without_maps = nx, ny
    nx, ny = heights().resolving_points(size, without_maps)
    if max(nx, ny) > 2048 and (nx, ny) != without_maps:
        maps = any(surface.kind == "heights" for surface in forms.case.surface)
        resolve = "the height map; smooth the map" if maps else "the roughness; give it a longer cutoff"
        raise forms.case.source.problem(
            f"accuracy {percent(accuracy)} would take {cell_counts((nx, ny))} points to resolve {resolve}, or give"
            " grid.points",
            ("surface",),
        )
    nx, ny = (POINTS_DIVISOR * math.ceil(count / POINTS_DIVISOR) for count in (nx, ny))
    return nx, (1 if forms.model.line else ny)


def refinement(accuracy: float | None, model: Model) -> float:
    """Return the factor on automatic numbers of increments where the slip depends on the path; 1 without accuracy."""
    if accuracy is None:
        return 1.0
    factor = max(0.25, _refined(INCREMENTS_LAW, accuracy))  # fewer do not follow the path
    width = _pressed_width(model)
    return factor * min(max(1.0, _refined(NARROW_LAW, width)), MOST_FOR_SLIP) if width > 0.0 else factor


def _pressed_width(model: Model) -> float:
    """Return the width of the slip annulus under P alone over the contact radius, 0 if tangential loads dissipate."""
    return 0.0 if model.moved else 1.0 - spence_ratio(model)


def tolerance_needed(accuracy: float) -> float:
    """Return the tolerance to one digit that adds no error, and resolves the slip of small increments."""
    return float(f"{min(max(1e-4 * accuracy, 1e-8), 1e-5):.0e}")


def settled(case: Case) -> Case:
    """Return the case with the tolerance, to one digit, and the error bars of its accuracy, unless they are given.

    With wear there are no error bars.
    """
    solver = case.solver
    if solver.accuracy is None:
        return case
    picked = {"tolerance": tolerance_needed(solver.accuracy), "error_bars": case.wear is None}
    missing = {name: value for name, value in picked.items() if name not in solver.model_fields_set}
    return case.model_copy(update={"solver": solver.model_copy(update=missing)})


def picks(asked: Case, case: Case, points: tuple[int, int], load_path: LoadPath) -> tuple[str, ...]:
    """Return in words the settings of `case` that its accuracy has picked. asked: the case as it was read."""
    if asked.solver.accuracy is None:
        return ()
    stages, given = zip(asked.stages(), load_path.counts, strict=True), asked.solver.model_fields_set
    counts = sorted({count for stage, count in stages if stage.increments is None})
    span = " to ".join(str(count) for count in dict.fromkeys(counts[:1] + counts[-1:]))
    texts = {
        f"{cell_counts(points)} points": asked.grid.points is None,
        f"{span} increments per stage": counts and load_path.path_dependent,
        f"tolerance {case.solver.tolerance:g}": "tolerance" not in given,
        "error bars": "error_bars" not in given and asked.wear is None,
    }
    return tuple(text for text, is_picked in texts.items() if is_picked)
