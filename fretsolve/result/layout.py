"""The datasets of a result file: names, units and meaning, and how they are stored.

gzip makes nine fields of mode I.3 on 256 x 256 points take 1.8 MB instead of 4.3 MB. Levels above 1 gain nothing, and
only h5py reads lzf.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from fretsolve.case.history import LINE_MEANINGS, OF_RIG, OF_WEAR, PER_LENGTH, SPOTS
from fretsolve.result.state import CORRECTED, CORRECTED_SUFFIX, ERROR_SUFFIX, ESTIMATED, ZONE_NAMES, Summary

FORMAT_VERSION = 1
"""Raise it whenever an older fretsolve could misread a newer file."""

FIELD_FILTERS: dict[str, Any] = {"shuffle": True, "compression": "gzip", "compression_opts": 1}
"""zlib compares a checksum on reading. HDF5's own checksum besides would take 1 % of an increment."""


def described(units: str, long_name: str) -> dict[str, Any]:
    """Return the attributes that every dataset has; units in UDUNITS spelling."""
    return {"units": units, "long_name": long_name}


@dataclass(frozen=True)
class Quantity:
    """One dataset: `name`, `units` (UDUNITS spelling), `long_name` and numpy `dtype`."""

    name: str
    units: str
    long_name: str
    dtype: str = "float64"

    @property
    def attributes(self) -> dict[str, Any]:
        """The attributes of the dataset."""
        flags = {"flag_values": np.arange(len(ZONE_NAMES), dtype=np.uint8), "flag_meanings": " ".join(ZONE_NAMES)}
        return described(self.units, self.long_name) | (flags if self.name == "zone" else {})


@dataclass(frozen=True)
class FieldQuantity(Quantity):
    """A dataset of one value per cell: component `component` (None: all) of the state's array `array`."""

    array: str = ""
    component: int | None = None


X = Quantity("x", "mm", "x of the cell centres")
Y = Quantity("y", "mm", "y of the cell centres")

STEP, *_COLUMNS = (
    Quantity(one.name, one.metadata["units"], one.metadata["meaning"], "int64" if one.type == "int" else "float64")
    for one in fields(Summary)
)

BULK_HISTORY = tuple(one for one in _COLUMNS if one.name.startswith("bulk_"))
"""Bulk stresses; only in results of cases that have one."""

SPOT_HISTORY = tuple(one for one in _COLUMNS if one.name in SPOTS)
"""Numbers of spots; only in results of cases that may have several."""

WEAR_HISTORY = tuple(one for one in _COLUMNS if one.name in OF_WEAR)
"""Wear; only in results of cases that have it."""

RIG_HISTORY = tuple(one for one in _COLUMNS if one.name in OF_RIG)
"""Motions of the actuator; only in results of cases with a rig."""

_OPTIONAL = (BULK_HISTORY, SPOT_HISTORY, WEAR_HISTORY, RIG_HISTORY)

HISTORY = tuple(one for one in _COLUMNS if not any(one in columns for columns in _OPTIONAL))
"""Columns of every result, besides the step."""


def _error_of(one: Quantity) -> Quantity:
    """Return the column with the error bars of a column."""
    return Quantity(one.name + ERROR_SUFFIX, one.units, f"estimated error of {one.long_name}")


def _errors_of(estimated: Iterable[Quantity], corrected: Iterable[Quantity]) -> tuple[Quantity, ...]:
    """Return the columns of error bars, of corrected values, and of their error bars."""
    values = [
        Quantity(one.name + CORRECTED_SUFFIX, one.units, f"{one.long_name}, corrected for the number of increments")
        for one in corrected
    ]
    return (*map(_error_of, estimated), *values, *map(_error_of, values))


ERRORS = (
    *_errors_of(*([one for one in HISTORY if one.name in names] for names in (ESTIMATED, CORRECTED))),
    Quantity("coarse_runs_applications", "1", "operator applications of the error bars, over those on the run's grid"),
    Quantity("coarse_runs_wall_time", "s", "wall-clock time of the error bars"),
)
"""Error bars and corrected values, as `HISTORY`; only in results of cases with `solver.error_bars`."""

RIG_ERRORS = _errors_of(RIG_HISTORY, RIG_HISTORY)
"""Those of `RIG_HISTORY`; only in results of cases with a rig as well."""

FIELDS = (
    FieldQuantity("pressure", "MPa", "pressure", array="pressure"),
    FieldQuantity("shear_x", "MPa", "shear traction on body 2 along x", array="shear", component=0),
    FieldQuantity("shear_y", "MPa", "shear traction on body 2 along y", array="shear", component=1),
    FieldQuantity(
        "slip_x", "mm", "slip of body 1 relative to body 2 along x since the start", array="slip", component=0
    ),
    FieldQuantity(
        "slip_y", "mm", "slip of body 1 relative to body 2 along y since the start", array="slip", component=1
    ),
    FieldQuantity("slip_path", "mm", "length of the path of slip since the start", array="slip_path"),
    FieldQuantity("work_density", "mJ/mm^2", "energy dissipated per area since the start", array="work_density"),
    FieldQuantity("zone", "1", "state of the cell: 0 open, 1 stick, 2 slip", "uint8", array="zone"),
    FieldQuantity("gap", "mm", "gap between the surfaces", array="gap"),
)

DERIVED_FIELDS = (
    FieldQuantity("friction", "1", "coefficient of friction", array="friction"),
    FieldQuantity("shear_bound", "MPa", "friction limit of the shear traction", array="shear_bound"),
    FieldQuantity("wear_depth", "mm", "worn depth of both bodies together", array="wear_depth"),
    FieldQuantity("wear_depth_1", "mm", "worn depth of body 1", array="wear_depth_1"),
    FieldQuantity("wear_depth_2", "mm", "worn depth of body 2", array="wear_depth_2"),
)
"""Fields that are stored if a case asks for them, and from which nothing goes on."""

QUANTITIES: dict[str, Quantity] = {
    one.name: one
    for one in (
        *(STEP, *HISTORY, *BULK_HISTORY, *SPOT_HISTORY, *WEAR_HISTORY, *RIG_HISTORY, *ERRORS, *RIG_ERRORS),
        *(X, Y, *FIELDS, *DERIVED_FIELDS),
    )
}
"""All columns, axes and fields by their names, which are unique."""

_PER_LENGTH = {known.stored: other.stored for known, other in PER_LENGTH.items()}


def _of_a_line(one: Quantity) -> Quantity:
    """Return a dataset as it is in a line contact, whose loads and energies are per mm of its length."""
    units = _PER_LENGTH.get(one.units, one.units)
    return replace(one, units=units, long_name=LINE_MEANINGS.get(one.name, one.long_name))


LINE_QUANTITIES = QUANTITIES | {
    one.name: _of_a_line(one) for one in (STEP, *HISTORY, *WEAR_HISTORY, *RIG_HISTORY, *ERRORS, *RIG_ERRORS)
}
"""The datasets of a line contact."""


def quantities_of(effective_case: Mapping[str, Any]) -> Mapping[str, Quantity]:
    """Return the datasets by their names, with the units that they have in the result of a case."""
    return LINE_QUANTITIES if effective_case.get("plane") == "strain" else QUANTITIES


def is_single(effective_case: Mapping[str, Any]) -> bool:
    """Return whether a case asks for fields in single precision."""
    return bool(effective_case.get("solver", {}).get("precision") == "single")


def optional_columns(effective_case: Mapping[str, Any]) -> tuple[Quantity, ...]:
    """Return the columns of the history of a case that not every result has, besides columns of error bars."""
    of_keys = ("wear" in effective_case, "rig" in effective_case)
    there = (has_bulk_stress(effective_case), may_have_spots(effective_case), *of_keys)
    return tuple(one for columns, has in zip(_OPTIONAL, there, strict=True) if has for one in columns)


def optional_among(names: Collection[str]) -> tuple[Quantity, ...]:
    """Return which `optional_columns` are among the columns of a history."""
    return tuple(one for columns in _OPTIONAL if columns[0].name in names for one in columns)


def row_type(errors: bool, optional: Iterable[Quantity]) -> np.dtype[Any]:
    """Return the type of a record of the history, the step first; optional: see `optional_columns`."""
    columns = [STEP, *HISTORY, *optional]
    if errors:
        columns += [*ERRORS, *(RIG_ERRORS if RIG_HISTORY[0] in columns else ())]
    return np.dtype([(quantity.name, quantity.dtype) for quantity in columns])


def may_have_spots(effective_case: Mapping[str, Any]) -> bool:
    """Return whether a contact may have several spots: on an area, a rough or several surfaces."""
    surfaces = effective_case.get("surface", [])
    several = len(surfaces) > 1 or any("heights" in one or "roughness" in one for one in surfaces)
    return several and effective_case.get("plane") != "strain"


def has_cycles(effective_case: Mapping[str, Any]) -> bool:
    """Return whether the load path repeats stages, so that a result may have a table of cycles."""
    return any("cycle" in step for step in effective_case.get("load_path", ()))


def has_bulk_stress(effective_case: Mapping[str, Any]) -> bool:
    """Return whether a case has a bulk stress."""
    steps = list(effective_case.get("load_path", ()))
    while steps:
        step = steps.pop()
        if "bulk_1" in step or "bulk_2" in step:
            return True
        if "cycle" in step:
            steps += step["cycle"].get("stages", [step["cycle"].get("amplitude", {})])
    return False


def stored_fields(selected: Iterable[str], single: bool = False) -> tuple[FieldQuantity, ...]:
    """Return the datasets of a case's `output.fields` in the order of the file; single: in single precision."""
    names = set(selected)
    if unknown := names - {quantity.array for quantity in FIELDS + DERIVED_FIELDS}:
        raise ValueError(f"no such field: {', '.join(sorted(unknown))}")
    kept = (quantity for quantity in FIELDS + DERIVED_FIELDS if quantity.array in names)
    return tuple(replace(each, dtype="float32") if single and each.dtype == "float64" else each for each in kept)


def chunk_shape(nx: int, ny: int) -> tuple[int, int]:
    """Return the cells of one chunk of a field of ``(nx, ny)`` cells: whole rows, of about a megabyte."""
    chunks = -(-nx // max(1, 2**20 // (8 * ny)))
    return -(-nx // chunks), ny


def create_field(group: Any, quantity: FieldQuantity, steps: int, shape: tuple[int, int]) -> Any:
    """Create a dataset ``(steps, nx, ny)`` of `quantity` in the HDF5 `group`, no chunk across two increments."""
    stored = {"chunks": (1, *chunk_shape(*shape)), **FIELD_FILTERS} if steps else {}
    return group.create_dataset(quantity.name, (steps, *shape), quantity.dtype, **stored)


def create_column(group: Any, quantity: Quantity, values: Any, scale: Any = None) -> Any:
    """Store a column of numbers with units, meaning and the `scale` of its axis; without one it is itself a scale."""
    data = np.asarray(values, quantity.dtype)
    # Of a short column a block and its index would take more space than compression saves.
    stored = {"chunks": data.shape, **FIELD_FILTERS} if data.nbytes > 4096 else {}
    column = group.create_dataset(quantity.name, data=data, **stored)
    column.attrs.update(quantity.attributes)
    if scale is None:
        column.make_scale(quantity.name)
    else:
        column.dims[0].attach_scale(scale)
    return column
