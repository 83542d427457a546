"""Choose what of a result to show: increments with fields, ends of stages, columns above round-off, and their units."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fretsolve.case.dimensions import smaller_unit
from fretsolve.case.history import (
    ACTUATORS,
    BULK,
    CORRECTED_SUFFIX,
    DISPLACEMENTS,
    ERROR_SUFFIX,
    EXTENTS,
    FEWEST_SPOT_CELLS,
    MOTIONS_OF_ACTUATORS,
)
from fretsolve.result import Result
from fretsolve.result.state import cost_of
from fretsolve.system.arrays import DoubleArray, IndexArray

NOT_ROUND = 0.1
"""Least difference of half-width and radius, or of middle and origin, over the contact radius, that is shown."""


ROUND_OFF = 1e-8
"""Size of a value that counts as 0, over the scale of its column."""

LINE_SLOPE = 1e-3
"""Stands for the approach over the contact radius in a line contact, where it has a free constant."""

ACTUATORS_IN_TABLES = tuple(ACTUATORS[name] for name in ("delta_z", "delta_x", "delta_y", "phi_x", "phi_y", "phi_z"))
"""Motions of the actuator in the order of the motions of the contact."""

RESIDUALS = {
    "residual_gap": "gap",
    "residual_stick": "stick",
    "residual_slip": "slip",
    "residual_bound": "friction limit",
    "residual_load": "load",
}
"""Columns of the certificate's residuals, and what each is about."""


def total_cost(result: Result) -> tuple[float, int]:
    """Return wall-clock time and operator applications of a run, with coarse runs of error bars, and rounds before."""
    seconds, applications = cost_of(result.history)
    for one in result.rounds_before:
        seconds, applications = seconds + one["seconds"], applications + one["applications"]
    return seconds, round(applications)


def stored_names(result: Result) -> list[str]:
    """Return the stored fields by their names in the case file, of vectors without the component."""
    return list(dict.fromkeys(name.removesuffix("_x").removesuffix("_y") for name in result.fields))


def stored_step(result: Result, step: int) -> int:
    """Return increment `step`, a negative one counted from the end. Raises ValueError if its fields are not stored."""
    found = step + result.increments if step < 0 else step
    if not 0 <= found < result.increments:
        raise ValueError(f"there is no increment {step}; there are 0 to {result.increments - 1}")
    if found not in result.steps:
        nearest = min(result.steps, key=lambda stored: abs(stored - found))
        raise ValueError(
            f"the fields of increment {found} are not stored (output.every); the nearest ones are those of {nearest}"
        )
    return found


def first_and_last(rows: IndexArray, most: int, first: int) -> IndexArray:
    """Return all of at most `most` rows, of more the `first` ones and the last ones."""
    return rows if len(rows) <= most else np.concatenate([rows[:first], rows[first - most :]])


def rows_of_stick_zones(history: Mapping[str, DoubleArray]) -> IndexArray:
    """Return for each increment the one whose stick zone to show: itself, or that before a change by wear.

    Cells that such a change has just brought into contact stick in its increment, whatever the load.
    """
    rows = np.arange(len(history["step"]))
    return rows - (history["jump"] > 0.0) if "jump" in history else rows


def relevant_columns(result: Result) -> list[str]:
    """Return the names of the columns above round-off; `P` and `delta_z` always, unless unknown.

    Widths of a zone that is a circle are left out, as its radius tells them, and so are middles at the origin, and
    motions of the actuator where the rig does not give.
    """
    names = (
        *("P", "Mx", "My", "Qx", "Qy", "Mz", *BULK[1], *BULK[2]),
        *("delta_z", "delta_x", "delta_y", "phi_x", "phi_y", "phi_z", *ACTUATORS_IN_TABLES),
        *("contact_radius", "stick_radius", *EXTENTS, "max_pressure", "max_shear", "work_total", "spring_energy"),
        "spots",
        *("cycles", "jump", "wear_volume", "wear_error", "wear_depth_max"),
    )
    scales = _scales(result)
    return [name for name in names if name in result.history and _is_relevant(result, name, scales)]


def _is_relevant(result: Result, name: str, scales: Mapping[str, float]) -> bool:
    if name in EXTENTS:
        return _tells_more(result.history, name)
    if name.startswith("bulk_") and name.endswith("_yy") and result.effective_case.get("plane") == "strain":
        return False  # it follows from xx
    column = result.history[name]
    if name == "spots":
        return bool(column.max(initial=0) > 1)
    if name in ("P", "delta_z"):
        return not np.isnan(column).all()
    if name in MOTIONS_OF_ACTUATORS and np.array_equal(column, result.history[MOTIONS_OF_ACTUATORS[name]]):
        return False
    return _largest(column) > ROUND_OFF * scales.get(name, 0.0)


def is_more_than_round_off(result: Result, name: str) -> bool:
    """Return whether a column of the history is above `round_off` somewhere."""
    return _largest(result.history[name]) > round_off(result, name)


def _largest(column: DoubleArray) -> float:
    return float(np.abs(column).max(initial=0.0))


def _tells_more(history: Mapping[str, DoubleArray], name: str) -> bool:
    """Return whether a column of `EXTENTS` tells more than the radius of its zone; contacts of few cells never do."""
    zone, columns = name.split("_")[0], [history[name]]
    if "_width_" in name:
        columns = [history[f"{zone}_half_width_{axis}"] - history[f"{zone}_radius"] for axis in "xy"]
    if zone == "stick":
        columns = [column[rows_of_stick_zones(history)] for column in columns]
    cells = history["contact_cells"]
    told = np.nan_to_num(np.abs(columns)) > NOT_ROUND * history["contact_radius"]
    return bool((told & (cells >= min(FEWEST_SPOT_CELLS, cells.max(initial=0)))).any())


def round_off(result: Result, name: str) -> float:
    """Return the size below which values of a column count as 0: 1e-8 of its scale in the whole run.

    A tangential displacement below 1e-5 of the other one is within the usual tolerance, so it counts as 0 as well, and
    so does the middle of a zone within 1e-5 of the contact radius from the origin.
    """
    return ROUND_OFF * _scales(result).get(name, 0.0)


def _scales(result: Result) -> dict[str, float]:
    """Return the scales of columns whose values may be round-off."""
    if not result.increments:
        return {}
    force, approach, radius, shift_x, shift_y = (
        float(np.nan_to_num(np.abs(result.history[column]).max()))
        for column in ("P", "delta_z", "contact_radius", "delta_x", "delta_y")
    )
    scales = dict.fromkeys(("Qx", "Qy"), force) | dict.fromkeys(("Mx", "My", "Mz"), force * radius)
    scales |= dict.fromkeys(("delta_x", "delta_y"), max(approach, 1e3 * max(shift_x, shift_y)))
    if "actuator_x" in result.history:
        far = max(float(np.nan_to_num(np.abs(result.history[column]).max())) for column in ("actuator_x", "actuator_y"))
        scales |= dict.fromkeys(("actuator_x", "actuator_y"), max(approach, 1e3 * far))
    scales |= dict.fromkeys((name for name in EXTENTS if "_center_" in name), 1e3 * radius)
    turn = LINE_SLOPE * radius if np.isnan(result.history["delta_z"]).all() else approach
    turns = ("phi_x", "phi_y", "phi_z")
    scales |= dict.fromkeys((*turns, *(ACTUATORS[name] for name in turns)), turn / radius if radius else 0.0)
    return scales


def unit_for_people(result: Result, name: str) -> tuple[str, float]:
    """Return the unit of a column of the history in a table, and the factor to it: small displacements are in um.

    Error bars and corrected values have the unit of their column.
    """
    own = name.removesuffix(ERROR_SUFFIX).removesuffix(CORRECTED_SUFFIX)
    if own not in DISPLACEMENTS:
        return result.units(name), 1.0
    return smaller_unit(result.units(own), float(np.nan_to_num(np.abs(result.history[own])).max(initial=0.0)))
