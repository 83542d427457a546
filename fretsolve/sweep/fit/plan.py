"""The plan of a fit: the case, its parameters, the measured loop and the models that follow it, all checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fretsolve.case.loading import CaseText, read_case
from fretsolve.case.models import Case
from fretsolve.errors import CaseError
from fretsolve.problem.setup.problem import compiling_pays
from fretsolve.result.verdict import Verdict
from fretsolve.simulation.problem_setup import set_up
from fretsolve.sweep.fit.loop_file import bare_name, read_loop_file
from fretsolve.sweep.fit.measured_loop import MeasuredLoop, cut
from fretsolve.sweep.fit.model_loop import (
    ACTUATOR,
    COARSE_INCREMENTS,
    COARSE_POINTS,
    FINE_INCREMENTS,
    FORCE,
    MOTION,
    LoopModel,
    area,
    pressing_entries,
)
from fretsolve.sweep.fit.parameters import Parameter, read_parameters

USUAL_LOOPS = 20
"""About how many loops a fit solves."""


DRIVING = 0.02
"""Part of the box about a loop from which noise cannot make the energy of a closed loop negative."""

MOST_FRICTION = 10.0
"""Force over P beyond any friction."""


@dataclass(frozen=True)
class FitRequest:
    """A fit as the command line has it. names: of the parameters; columns: headings of force and motion, None for the
    usual ones; offset: whether offset and drift of both are found, too.
    """

    case: Path
    overrides: Sequence[str]
    loop: Path
    names: Sequence[str]
    columns: tuple[str, str] | None = None
    offset: bool = True


@dataclass(frozen=True, eq=False)
class FitPlan:
    """A checked fit.

    models: in the order in which they are fitted, the last one on the grid of the case; side: of that grid along x
    (mm); reached: the verdict on the case's accuracy, whose rounds have picked the points, if it has one.
    """

    request: FitRequest
    text: CaseText
    case: Case
    parameters: tuple[Parameter, ...]
    loop: MeasuredLoop
    models: tuple[LoopModel, ...]
    side: float
    reached: Verdict | None = None


def make_fit_plan(request: FitRequest) -> FitPlan:
    """Read case and loop. Raises CaseError, FileError."""
    text = read_case(request.case).overridden(request.overrides)
    case = text.case()
    if case.wear is not None:
        raise case.source.problem("a fit follows one settled cycle, without wear; leave it out", ("wear",))
    parameters = read_parameters(request.names, text, case)
    pressing = pressing_entries(text, case)
    usual = MOTION if case.rig is None else ACTUATOR
    columns = request.columns or (FORCE, usual)
    named = bare_name(columns[1])
    motion = named if named in (MOTION, ACTUATOR) else usual
    if motion == ACTUATOR and case.rig is None:
        raise CaseError(
            "is known with a rig alone; add rig: {stiffness_x: 50 kN/mm} to the case", (), "--columns actuator_x"
        )
    force, moved = read_loop_file(request.loop, columns, (case.dimensions[FORCE], case.dimensions[motion]))
    loop = cut(force, moved, request.loop, offset=request.offset)
    _require_plausible(loop, case, request.loop)
    if len(loop.force) <= len(parameters) + 4:  # offset and drift, and two to tell their noise
        raise CaseError(f"{len(loop.force)} points cannot tell {len(parameters)} parameters", (), request.loop)
    ways, coarse_ways = ((loop.way(0, n), loop.way(1, n)) for n in (FINE_INCREMENTS, COARSE_INCREMENTS))
    picked, reached = None, None
    if case.grid.points is None:  # the rounds of an accuracy pick them, once for all values of the parameters
        from fretsolve.simulation.accuracy.in_memory import solved

        last, _, reached = solved(case)
        grid, solver = last.setup.grid, last.setup.case.solver
        picked = list(grid.shape) if case.plane is None else grid.nx
        text = text.overridden([f"solver.tolerance={solver.tolerance:g}"])
    fine = LoopModel(text, pressing, motion, loop.ends[0], ways, parameters, picked)
    setup = set_up(fine.case([one.start for one in parameters]))
    fine = replace(fine, compiled=compiling_pays(USUAL_LOOPS * setup.seconds_saved))
    # a row of cells is solved as fast as a coarse one
    points = case.grid.points
    is_fine = case.plane is None and (points is None or max(points) > COARSE_POINTS)
    coarse = replace(fine, points=COARSE_POINTS if is_fine else None, ways=coarse_ways)
    return FitPlan(request, text, case, parameters, loop, (coarse, fine), setup.grid.size[0], reached)


def _require_plausible(loop: MeasuredLoop, case: Case, path: Path) -> None:
    """Refuse a record that no contact gives: it drives the motion, or has more force than friction could carry."""
    energy, box = area(loop.motion, loop.force), 2.0 * loop.reach * loop.range
    if energy < -DRIVING * box:
        unit = case.dimensions["work_total"].unit
        message = f"force and motion run against each other, so that a cycle gains {-energy:.3g} {unit}"
        raise CaseError(f"{message}; is the sign of one of them wrong, or the order of the rows?", (), path)
    pressed = max((value for stage in case.stages() for name, value in stage.targets if name == "P"), default=math.inf)
    if 0.5 * loop.range > MOST_FRICTION * pressed:
        force = f"{0.5 * loop.range:.3g} {case.dimensions[FORCE].unit}"
        message = f"the force reaches {force}, {0.5 * loop.range / pressed:.3g} times P"
        raise CaseError(f"{message}; is its unit right?", (), path)
