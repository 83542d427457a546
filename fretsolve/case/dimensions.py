"""Physical dimensions with their units, and the quantities of the history. It loads no pydantic."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Dimension:
    """A physical dimension.

    noun: its name in messages; unit: the internal one, as a case file has it; stored: the same in a result file;
    example: a value in a case file.
    """

    noun: str
    unit: str
    stored: str
    example: str

    @property
    def wanted(self) -> str:
        """The noun with an example, as in ``a force such as '400 N'``."""
        return f"{self.noun} such as {self.example!r}"

    def shown(self, value: float) -> str:
        """Return a value in internal units as users read it."""
        if self is ANGLE:
            return f"{math.degrees(value):g} deg"
        return f"{value:g} {self.unit}".rstrip()


LENGTH = Dimension("a length", "mm", "mm", "10 mm")
AREA = Dimension("an area", "mm^2", "mm^2", "0.28 mm^2")
FORCE = Dimension("a force", "N", "N", "400 N")
MOMENT = Dimension("a moment", "N*mm", "N mm", "5 N*mm")
ENERGY = Dimension("an energy", "N*mm", "mJ", "0.014 N*mm")
PRESSURE = Dimension("a pressure", "MPa", "MPa", "200 GPa")
ANGLE = Dimension("an angle", "rad", "rad", "0.1 deg")
TIME = Dimension("a time", "s", "s", "2 s")
NUMBER = Dimension("a number", "", "1", "0.1")

DIMENSIONS = (LENGTH, AREA, FORCE, MOMENT, PRESSURE, ANGLE, TIME, NUMBER)
"""Those that the unit of a value can tell apart."""


@dataclass(frozen=True)
class HistoryQuantity:
    """A number of each increment, which a case can expect. units: in a result file, if not those of the dimension."""

    name: str
    dimension: Dimension
    meaning: str
    dtype: str = "float64"
    units: str | None = None


HISTORY_QUANTITIES = (
    HistoryQuantity("P", FORCE, "normal force"),
    HistoryQuantity("Mx", MOMENT, "moment of the pressure about the x axis, sum of y p dA"),
    HistoryQuantity("My", MOMENT, "moment of the pressure about the y axis, sum of x p dA"),
    HistoryQuantity("Qx", FORCE, "tangential force along x"),
    HistoryQuantity("Qy", FORCE, "tangential force along y"),
    HistoryQuantity("Mz", MOMENT, "torsional moment"),
    HistoryQuantity("delta_z", LENGTH, "normal approach"),
    HistoryQuantity("delta_x", LENGTH, "rigid displacement along x"),
    HistoryQuantity("delta_y", LENGTH, "rigid displacement along y"),
    HistoryQuantity("phi_x", ANGLE, "rotation about the x axis"),
    HistoryQuantity("phi_y", ANGLE, "rotation about the y axis"),
    HistoryQuantity("phi_z", ANGLE, "rotation about the z axis"),
    HistoryQuantity("contact_area", AREA, "area of contact"),
    HistoryQuantity("stick_area", AREA, "area of the stick zone"),
    HistoryQuantity("contact_radius", LENGTH, "radius of the circle of the area of contact"),
    HistoryQuantity("stick_radius", LENGTH, "radius of the circle of the area of the stick zone"),
    HistoryQuantity("contact_cells", NUMBER, "cells in contact", "int64"),
    HistoryQuantity("stick_cells", NUMBER, "cells of the stick zone", "int64"),
    HistoryQuantity("max_pressure", PRESSURE, "largest pressure"),
    HistoryQuantity("max_shear", PRESSURE, "largest shear traction"),
    HistoryQuantity("work", ENERGY, "energy dissipated in the increment"),
    HistoryQuantity("work_total", ENERGY, "energy dissipated since the start"),
    HistoryQuantity("iterations_normal", NUMBER, "iterations of the normal problem", "int64"),
    HistoryQuantity("iterations_tangential", NUMBER, "iterations of the tangential problem", "int64"),
    HistoryQuantity("alternations", NUMBER, "staggered iterations of the normal and the tangential problem", "int64"),
    HistoryQuantity("operator_applications", NUMBER, "applications of an influence operator", "int64"),
    HistoryQuantity("wall_time", TIME, "wall-clock time of the increment"),
    HistoryQuantity(
        "residual_gap", NUMBER, "largest gap in contact or penetration outside, over the largest normal displacement"
    ),
    HistoryQuantity(
        "residual_stick",
        NUMBER,
        "largest slip increment in the stick zone, over the largest rigid displacement increment",
    ),
    HistoryQuantity(
        "residual_slip",
        NUMBER,
        "largest angle between shear traction and slip increment, weighted by slip",
        units="rad",
    ),
    HistoryQuantity(
        "residual_bound", NUMBER, "largest excess of the shear traction over the friction limit, over its maximum"
    ),
    HistoryQuantity("residual_load", NUMBER, "worst error of an imposed load component, over its scale"),
)
"""In the order of the result file."""

HISTORY_DIMENSIONS = {quantity.name: quantity.dimension for quantity in HISTORY_QUANTITIES}
