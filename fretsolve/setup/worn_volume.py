"""Say how far the cells that stick or slip as a whole change the worn volume of a result."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from fretsolve.case.dimensions import percent
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.model.load_path import LoadPath
from fretsolve.result import Result
from fretsolve.setup.problem import closed_forms_of, model_of_forms
from fretsolve.setup.wear_forms import WornCycle, worn_cycles
from fretsolve.wear.stick_cells import error_by_stick_cells


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
