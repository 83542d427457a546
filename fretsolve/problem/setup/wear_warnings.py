"""Warnings of a case with wear, before a run and after it, and the error of the worn volume by cells."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import percent
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.errors import dotted
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.setup.cost_estimate import too_many_cycles
from fretsolve.problem.setup.picked_settings import AREA_MARGIN, worn_reach
from fretsolve.problem.setup.problem import ProblemSetup, closed_forms_of, model_of_forms
from fretsolve.problem.setup.wear_forms import AnyWornCycle, worn_cycles
from fretsolve.reference.worn_contact import WornLimit
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.result import Result


INSET, SPREAD = 0.11, 0.04
"""Radius of the area of the cells that stick, less the radius of the zone that they stand for, over a cell's side, and
by how much that is known: worn limits and volumes on 75 grids of 32 to 128 points a side give 0.10 to 0.12."""

SCATTER = 0.2
"""Expected error of a stick radius over a cell's side, times the root of the cells in it; half as large where the
contact's middle lies on no corner of cells and in the middle of none, so that no eight cells change at once."""


def error_by_stick_cells(limit: WornLimit, volume: float, cells: int, side: float, *, load_kept: bool) -> float | None:
    """Return the estimated error of a worn volume (mm^3), by `cells` of `side` (mm) that stick; None where too few do.

    Nothing wears where cells stick, so that wear follows the stick zone of the grid, which consists of whole cells.
    limit: the worn limit that the wear leads to, with P or else the approach held.
    """
    zone = math.sqrt(cells / math.pi) * side - INSET * side
    farther = zone + math.copysign(SPREAD * side, zone - limit.stick_radius)
    return _change(limit, volume, farther, load_kept) if farther > 0.0 else None


def expected_error(limit: WornLimit, volume: float, side: float, *, centred: bool, load_kept: bool) -> float:
    """Return the error of a worn volume (mm^3) to expect from cells of `side` (mm), as a root mean square.

    centred: whether the contact's middle lies on a corner of cells, or in the middle of one.
    """
    c = limit.stick_radius
    scatter = (SCATTER if centred else 0.5 * SCATTER) * side * math.sqrt(side / c)
    return _change(limit, volume, max(c - scatter, 0.1 * c), load_kept)


def _change(limit: WornLimit, volume: float, zone: float, load_kept: bool) -> float:
    """Return how much another stick radius, `zone`, changes a worn volume: by its part of the limit less than there."""
    change = limit.with_stick_radius(zone, load_kept=load_kept).volume - limit.volume
    return abs(change) * min(1.0, volume / limit.volume) ** 2


def only_worn_cycle(result: Result) -> AnyWornCycle | None:
    """Return what closed forms say of the only cycle that stands for others; None without one."""
    case = result.case
    if case is None or case.wear is None:
        return None
    model = model_of_forms(case)
    found = worn_cycles(closed_forms_of(case, model, LoadPath(case.stages(), model).imposed))
    wearing = {stage.wears.key for stage in case.stages() if stage.wears is not None}
    return found[0] if len(found) == len(wearing) == 1 else None


def error_by_grid(result: Result) -> float | None:
    """Return the estimated error of the worn volume (mm^3) by cells that stick or slip as a whole.

    None where no closed form gives the worn limit, too few cells stick, or nothing is worn yet.
    """
    changes, cycle = np.flatnonzero(result.history["jump"] > 0.0), only_worn_cycle(result)
    if not len(changes) or cycle is None or cycle.limit is None:
        return None
    volume, cells = float(result.history["wear_volume"][-1]), int(result.history["stick_cells"][changes[-1] - 1])
    side = float(np.sqrt((result.x[1] - result.x[0]) * (result.y[1] - result.y[0])))
    return error_by_stick_cells(cycle.limit, volume, cells, side, load_kept=cycle.load_kept)


def warning_of_the_grid(result: Result, jumps: Collection[WearJumps]) -> str | None:
    """Return a warning if the error by the cells that stick is larger than the tolerance, None otherwise.

    jumps: of the cycles of the case that stand for others.
    """
    if not result.increments or not jumps or (error := error_by_grid(result)) is None:
        return None
    volume, tolerance = float(result.history["wear_volume"][-1]), max(one.tolerance for one in jumps)
    if error <= tolerance * volume:
        return None
    return (
        f"wear: cells stick or slip as a whole, which may have changed wear_volume by {percent(error / volume, 2)};"
        " finer cells change it less, and so may a grid.center that is a part of a cell aside"
    )


ASIDE = (0.31, 0.17)
"""Place of a grid's middle in cells, with which no cells change from stick to slip by symmetry at once."""

LARGEST_MOTION = 0.1
"""Motion, or slip of half a cycle, over the contact radius up to which both surfaces may keep their places. The
pressure follows one of them, so that results err by about that part."""


def wear_warnings(setup: ProblemSetup) -> Iterator[str]:
    """Warn of wear without cycles that wear, of slip that is long for the contact, and of a scar beyond the grid."""
    if not any(stage.cycle is not None and stage.cycle.jumps is not None for stage in setup.case.stages()):
        yield (
            "wear: no cycle represents others, so that worn depth is counted and the surfaces keep their shape;"
            " represents in place of times changes them"
        )
        return
    for key, expected, most in too_many_cycles(setup):
        ends = f", but there may be {most}, so that the run would end before its last cycle" * (expected > most)
        about = f"about {float(f'{expected:.1g}'):g} cycles would have to be solved"
        yield f"{dotted(key)}: {about}{ends}; a larger {key[-1]} needs fewer"
    cycles, grid = worn_cycles(setup.closed_forms), setup.grid
    if (text := _about_stick_cells(setup, cycles)) is not None:
        yield text
    if (text := _slip_before_the_run(cycles)) is not None:
        yield text
    if setup.case.grid.size is None:
        if not cycles:
            taken = max(grid.size)
            yield (
                f"grid.size: auto takes {taken:.3g} mm, by the unworn contact, since no closed form tells how far wear"
                f" widens it; {1.5 * taken:.3g} mm would leave room for a scar"
            )
        return
    reach = worn_reach(setup.closed_forms)
    if reach and reach > 0.5 * min(grid.size) - 1.5 * max(grid.dx, grid.dy):
        yield (
            f"grid.size: the worn contact may reach {reach:.3g} mm from the grid's middle, to its edge or beyond;"
            f" {2.0 * AREA_MARGIN * reach:.3g} mm would leave room"
        )


def _about_stick_cells(setup: ProblemSetup, cycles: Sequence[AnyWornCycle]) -> str | None:
    """Warn if cells that stick or slip as a whole are likely to change the worn volume by more than the tolerance."""
    grid, case = setup.grid, setup.case
    for cycle in cycles:
        if cycle.limit is None:
            continue
        volume = min(cycle.volume_at_first_rate, cycle.limit.volume)
        centred = _is_centred(setup)
        side = float(np.sqrt(grid.dx * grid.dy))
        error = expected_error(cycle.limit, volume, side, centred=centred, load_kept=cycle.load_kept)
        if error <= cycle.jumps.tolerance * volume:
            continue
        cells = f"c is {cycle.limit.stick_radius / side:.1f} cells, which stick or slip as a whole"
        aside = ""
        if centred:
            x, y = case.grid.center[0] + ASIDE[0] * grid.dx, case.grid.center[1] + ASIDE[1] * grid.dy
            aside = f", and half of that is likely with a center of [{x:.3g} mm, {y:.3g} mm], a part of a cell aside"
        change = f"the worn volume may change by about {percent(error / volume, 1)}"
        return f"grid.points: {cells}: {change}; more of them change it less{aside}"
    return None


def _is_centred(setup: ProblemSetup) -> bool:
    """Return whether the sphere's middle lies on a corner of cells, or in the middle of one."""
    surface = setup.case.surface[0]
    middles = zip(surface.center, (setup.grid.x[0], setup.grid.y[0]), (setup.grid.dx, setup.grid.dy), strict=True)
    halves = [2.0 * (middle - first) / side for middle, first, side in middles]
    return all(abs(half - round(half)) < 0.02 for half in halves)


def warning_of_slip(setup: ProblemSetup, history: Mapping[str, NDArray[Any]]) -> str | None:
    """Warn if solved cycles slip too far for the contact, where no closed form could warn before the run.

    The slip of a stage is the mean over its friction limit: the dissipated energy over the least that friction carries.
    """
    stages = setup.case.stages()
    wearing = [place + 1 for place, one in enumerate(stages) if one.cycle is not None and one.cycle.jumps is not None]
    if not wearing or _slip_before_the_run(worn_cycles(setup.closed_forms)) is not None:
        return None
    stage = history["stage"]
    starts = np.flatnonzero(np.diff(stage, prepend=0))
    carried = np.minimum(setup.model.friction * history["P"], history["max_shear"] * history["contact_area"])
    limit, radius = (np.maximum.reduceat(column, starts) for column in (carried, history["contact_radius"]))
    cycles = np.isin(stage[starts], wearing) & (limit > 0.0)
    slip: DoubleArray = np.add.reduceat(history["work"], starts)[cycles] / limit[cycles]
    if not len(slip):
        return None
    longest = int(np.argmax(slip / radius[cycles]))
    return _long_slip(float(slip[longest]), float(radius[cycles][longest]))


def _slip_before_the_run(cycles: Sequence[AnyWornCycle]) -> str | None:
    """Return the warning of the first of the cycles that slips far for its contact; None if none does."""
    texts = (_long_slip(cycle.sliding_distance, cycle.unworn_radius) for cycle in cycles)
    return next((text for text in texts if text is not None), None)


def _long_slip(slip: float, radius: float) -> str | None:
    """Return the warning of a half cycle's slip (mm) that is long for a contact of some radius; None if it is not."""
    if slip <= LARGEST_MOTION * radius:
        return None
    return (
        f"wear: half a cycle slips {slip:.3g} mm, {percent(slip / radius)} of the contact radius, but worn profiles"
        f" keep their places on the grid; {percent(LARGEST_MOTION)} or less are needed"
    )
