"""Say how far the cells that stick or slip as a whole change the worn volume of a result."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from fretsolve.case.dimensions import percent
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.problem.model.load_path import LoadPath
from fretsolve.problem.setup.problem import closed_forms_of, model_of_forms
from fretsolve.problem.setup.wear_forms import WornCycle, worn_cycles
from fretsolve.reference.worn_contact import WornLimit
from fretsolve.result import Result

INSET, SPREAD = 0.11, 0.04
"""Radius of the area of the cells that stick, less the radius of the zone that they stand for, over a cell's side, and
by how much that is known: worn limits and volumes on 75 grids of 32 to 128 points a side give 0.10 to 0.12."""

SCATTER = 0.2
"""Expected error of a stick radius over a cell's side, times the root of the cells in it; half of it where the
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


def only_worn_cycle(result: Result) -> WornCycle | None:
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
