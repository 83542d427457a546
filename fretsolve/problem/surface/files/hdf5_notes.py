"""Read what an HDF5 dataset of heights says of itself: in attributes of any string type, and in dimension scales."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np

from fretsolve.case.quantities import shown, split_quantity
from fretsolve.problem.surface.files.raw_map import AGREEMENT
from fretsolve.problem.surface.files.stated_units import decoded, length_unit
from fretsolve.system.hdf5_files import require_own_data

UNEVEN = 0.05
"""Largest distance of a coordinate from the even grid between the outermost ones, in steps."""

NO_COORDINATES = "This is a netCDF dimension but not a netCDF variable"
"""How netCDF names the scale of a dimension that has no coordinates."""


class Attributes:
    """Attributes of a dataset; capitals in their names do not count."""

    def __init__(self, node: Any):
        self._stored, self._names = node.attrs, {name.lower(): name for name in node.attrs}

    def values(self, name: str) -> list[Any]:
        """Return the numbers or texts of an attribute, empty if there is none. Texts may be stored as bytes."""
        if name.lower() not in self._names:
            return []
        value = self._stored[self._names[name.lower()]]
        flat = [] if isinstance(value, h5py.Empty) else np.ravel(value).tolist()
        # h5py gives texts of variable length that are not UTF-8 as str, with their bytes escaped
        stored = [one.encode("utf-8", "surrogateescape") if isinstance(one, str) else one for one in flat]
        texts = [decoded(one) if isinstance(one, bytes) else one for one in stored]
        return [one.strip("\0 ") if isinstance(one, str) else one for one in texts]

    def numbers(self, name: str) -> list[float]:
        """Return the numbers of an attribute, empty if there is none or it holds something else."""
        found = self.values(name)
        return found if all(isinstance(one, int | float) for one in found) else []

    def text(self, name: str) -> str | None:
        """Return an attribute that holds one text, None without such a one."""
        found = self.values(name)
        return found[0] if len(found) == 1 and isinstance(found[0], str) and found[0] else None

    def said(self, name: str) -> str:
        """Return an attribute as a text, whatever it holds; empty without one."""
        return ", ".join(map(str, self.values(name)))

    def unit(self, *names: str) -> tuple[float | None, str, list[str]]:
        """Return the mm of the unit that these attributes state, or None and what they state instead; and remarks.

        Raises ValueError if one contradicts another.
        """
        texts = {name: text for name in names if (text := self.said(name))}
        if not texts:
            return None, "", []
        first, stated = next(iter(texts.items()))
        unit = length_unit(stated)
        for name, text in texts.items():
            other = length_unit(text)
            if (unit is None) != (other is None) or abs((unit or 0.0) - (other or 0.0)) > AGREEMENT * (unit or 0.0):
                raise ValueError(
                    f"its attribute {first} is {shown(stated)}, {name} is {shown(text)}; remove the one that is wrong"
                )
        if unit is not None:
            return unit, "", []
        return None, stated, [f"its unit {shown(stated)} is no unit of length and is not used"]


@dataclass(frozen=True)
class Axis:
    """A dimension of a dataset: its name in small letters, the step of its coordinates, in `unit` (mm) if stated.

    stated: what its coordinates state instead of a unit of length.
    """

    name: str
    step: float | None = None
    unit: float | None = None
    stated: str = ""
    remarks: tuple[str, ...] = ()


def axes_of(node: Any) -> list[Axis]:
    """Return the dimensions of a dataset, from their scales or labels, empty if it has neither.

    It reads the attributes that make up dimension scales, since HDF5's own functions for them crash on damaged files.
    Raises ValueError if coordinates are uneven or of another number.
    """
    notes = Attributes(node)
    scales, labels = notes.values("DIMENSION_LIST"), notes.values("DIMENSION_LABELS")
    if scales:
        sized = zip(scales, node.shape, strict=True)
        return [_axis(node.file[found[0]], size) if len(found) else Axis("") for found, size in sized]
    return [Axis(label.lower()) for label in labels if isinstance(label, str)]


def is_scale(node: Any) -> bool:
    """Return whether a dataset is the scale of a dimension of others."""
    return Attributes(node).text("CLASS") == "DIMENSION_SCALE"


def _axis(scale: Any, size: int) -> Axis:
    """Return the dimension of `size` points of a scale, without a step where netCDF keeps the size alone."""
    name = scale.name.rsplit("/")[-1]
    notes = Attributes(scale)
    if (notes.text("NAME") or "").startswith(NO_COORDINATES):
        return Axis(name.lower())
    require_own_data(scale, name)
    if scale.shape != (size,):
        raise ValueError(f"its scale {name!r} does not hold {size} coordinates")
    unit, stated, remarks = notes.unit("unit", "units")
    told = tuple(f"{name}: {one}" for one in remarks)
    return Axis(name.lower(), _step(np.asarray(scale[()]), name), unit, stated, told)


def _step(coordinates: Any, name: str) -> float | None:
    """Return the step of evenly spaced `coordinates` (n,), below 0 if they descend; None of a single one."""
    if coordinates.dtype.kind not in "iuf" or coordinates.size < 2:
        return None
    places = coordinates.astype(np.float64)
    step: float = float(places[-1] - places[0]) / (places.size - 1)
    even = places[0] + step * np.arange(places.size)
    if step == 0 or not np.abs(places - even).max() <= UNEVEN * abs(step):  # not finite is uneven
        steps = np.abs(np.diff(places))
        raise ValueError(
            f"its coordinates {name!r} are not evenly spaced, with steps from {steps.min():g} to {steps.max():g}; map"
            " the heights to an even grid first"
        )
    return step


def stated_spacing(notes: Attributes) -> tuple[tuple[tuple[float, ...], float | None] | None, list[str]]:
    """Return the spacing that attributes state with its unit (mm), None without one; and remarks.

    `spacing`, or `dx` and `dy`, holds numbers in mm, or in the unit that `spacing_unit` or `xy_unit` names, or texts
    such as "5 um". `pixel_size` counts only with a unit, since programs write it in mm, um, and m.
    """
    names = next((names for names in (("spacing",), ("dx", "dy")) if notes.values(names[0])), ("pixel_size",))
    found = [one for name in names for one in notes.values(name)]
    if not found:
        return None, []
    units = ("spacing_unit", "xy_unit", f"{names[0]}_unit")
    of_all, stated, remarks = notes.unit(*units)
    if stated:
        return None, [f"its spacing is not used: {remark}" for remark in remarks]
    parts = []
    for one in found:
        number, text = split_quantity(one)
        own = length_unit(text)
        if text and own is None:
            raise ValueError(f"its {names[0]} is {shown(one)}, which is no length; one such as '5 um' is needed")
        parts.append((number, own or of_all))
    if names == ("pixel_size",) and any(unit is None for _, unit in parts):
        return None, ["its pixel_size has no unit and is not used"]
    return in_one_unit([(number, unit or 1.0) for number, unit in parts]), []


def in_one_unit(lengths: Sequence[tuple[float, float | None]]) -> tuple[tuple[float, ...], float | None]:
    """Return lengths and the unit of all: the one they have in common, or else mm; None if none has a unit.

    Raises ValueError if some have a unit and others none.
    """
    units = {unit for _, unit in lengths}
    if len(units) > 1 and None in units:
        raise ValueError("it states the unit of one of its directions and not of the other")
    if len(units) == 1:
        return tuple(length for length, _ in lengths), units.pop()
    return tuple(length * (unit or 1.0) for length, unit in lengths), 1.0
