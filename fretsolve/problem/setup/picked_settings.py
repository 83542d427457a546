"""Pick the settings that a case leaves out: the size of its area, and what its accuracy asks for.

Where closed forms do not give the size, `simulation.problem_setup` searches for it on a coarse grid. The laws of
accuracy are measured (docs/howto/grid_and_increments.md); the error bars give the case's own errors, and
`result.verdict` judges by them.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.case.dimensions import cell_counts
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.setup.closed_forms import ClosedForms
from fretsolve.problem.setup.wear_forms import worn_radius
from fretsolve.result.verdict import POINTS_DIVISOR

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


FIRST_CELLS, FEWEST_POINTS = 24, 24
"""Cells across the contact in the first round of an accuracy, and the fewest points of a side."""

FIRST_REFINEMENT = 0.4
"""Factor on automatic numbers of increments in the first round of an accuracy."""


@dataclass(frozen=True)
class Picks:
    """The picks of a round of an accuracy. points: along x and y; refinement: factor on automatic increments."""

    points: tuple[int, int]
    refinement: float


def first_points(forms: ClosedForms, size: Size, automatic_size: Callable[[], Size]) -> tuple[int, int]:
    """Return the points along x and y of the first round of an accuracy, on an area of `size` (mm).

    automatic_size: as of `ProblemSetup`; where the contact's size is unknown it counts as the whole area.
    """
    contact = size
    if forms.case.grid.size is not None:
        with contextlib.suppress(CaseError):
            contact = automatic_size()
    cell = min(side / AREA_MARGIN for side in contact) / FIRST_CELLS
    waves = [surface.cutoff / 2.0 for surface in forms.case.surface if surface.kind == "roughness"]
    cell = min(cell, *(side / FEWEST_POINTS for side in size), *waves)
    return points_of_cells(forms, size, cell)


def points_of_cells(forms: ClosedForms, size: Size, cell: float) -> tuple[int, int]:
    """Return the points along x and y with which cells on `size` (mm) are about `cell` long, none longer."""
    nx, ny = (POINTS_DIVISOR * math.ceil(side / cell / POINTS_DIVISOR - 1e-9) for side in size)
    return nx, (1 if forms.model.line else ny)


def tolerance_needed(accuracy: float) -> float:
    """Return the tolerance to one digit that adds no error, and resolves the slip of small increments."""
    return float(f"{min(max(1e-4 * accuracy, 1e-8), 1e-5):.0e}")


def settled(case: Case, picks: Picks | None) -> Case:
    """Return the case with the tolerance, to one digit, the factor on increments and the error bars of its accuracy,
    unless they are given.

    picks: of a round, None for the first one. With wear there are no error bars.
    """
    solver = case.solver
    if solver.accuracy is None:
        return case
    picked = {
        "tolerance": tolerance_needed(solver.accuracy.target),
        "refinement": FIRST_REFINEMENT if picks is None else picks.refinement,
        "error_bars": case.wear is None,
    }
    missing = {name: value for name, value in picked.items() if name not in solver.model_fields_set}
    return case.model_copy(update={"solver": solver.model_copy(update=missing)})


def in_words(asked: Case, case: Case, points: tuple[int, int], load_path: LoadPath) -> tuple[str, ...]:
    """Return in words the settings of `case` that its accuracy has picked. asked: the case as it was read."""
    if asked.solver.accuracy is None:
        return ()
    stages, given = zip(asked.stages(), load_path.counts, strict=True), asked.solver.model_fields_set
    counts = sorted({count for stage, count in stages if stage.increments is None and count > 1})
    span = " to ".join(str(count) for count in dict.fromkeys(counts[:1] + counts[-1:]))
    texts = {
        f"{cell_counts(points)} points": asked.grid.points is None,
        f"{span} increments per stage": counts and "refinement" not in given,
        f"tolerance {case.solver.tolerance:g}": "tolerance" not in given,
        "error bars": "error_bars" not in given and asked.wear is None,
    }
    return tuple(text for text, is_picked in texts.items() if is_picked)
