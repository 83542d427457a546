"""Physical dimensions with their units. It loads no pydantic."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Dimension:
    """A physical dimension.

    noun: its name in messages; unit: the internal one, empty for numbers; example: a value in a case file.
    """

    noun: str
    unit: str
    example: str

    @property
    def stored(self) -> str:
        """The unit in a result file."""
        return self.unit or "1"

    @property
    def wanted(self) -> str:
        """The noun with an example, as in ``a force such as '400 N'``."""
        return f"{self.noun} such as {self.example!r}"

    def shown(self, value: float) -> str:
        """Return a value in internal units as users read it."""
        if self is ANGLE:
            return f"{math.degrees(value):g} deg"
        return f"{value:g} {self.unit}".rstrip()


LENGTH = Dimension("a length", "mm", "10 mm")
AREA = Dimension("an area", "mm^2", "0.28 mm^2")
FORCE = Dimension("a force", "N", "400 N")
MOMENT = Dimension("a moment", "N mm", "5 N mm")
ENERGY = Dimension("an energy", "mJ", "0.014 mJ")
PRESSURE = Dimension("a pressure", "MPa", "200 GPa")
VOLUME = Dimension("a volume", "mm^3", "0.01 mm^3")
STRESS = Dimension("a stress", "MPa", "70 MPa")
STRESS_INTENSITY = Dimension("a stress intensity", "MPa m^0.5", "5 MPa m^0.5")
RUIZ = Dimension("a stress squared times a slip", "MPa^2 mm", "800 MPa^2 mm")
"""Ruiz's parameters."""

ANGLE = Dimension("an angle", "rad", "0.1 deg")
TIME = Dimension("a time", "s", "2 s")
NUMBER = Dimension("a number", "", "0.1")
CYCLE_COUNT = Dimension("a number", "", "1000")

LINE_FORCE = Dimension("a force per length", "N/mm", "100 N/mm")
LINE_MOMENT = Dimension("a moment per length", "N mm/mm", "5 N mm/mm")
LINE_ENERGY = Dimension("an energy per length", "mJ/mm", "0.014 mJ/mm")
LINE_AREA = Dimension("an area per length", "mm^2/mm", "0.2 mm^2/mm")
LINE_VOLUME = Dimension("a volume per length", "mm^3/mm", "0.01 mm^3/mm")
"""In a line contact, per mm of its length."""

ENERGY_PER_AREA = Dimension("an energy per area", "mJ/mm^2", "1 mJ/mm^2")
"""1 mJ/mm^2 is 1 N/mm."""

WEAR_COEFFICIENT = Dimension("a wear coefficient", "mm^3/(N mm)", "1e-4 mm^3/J")
"""1 mm^3/J is 1e-3 mm^3/(N mm)."""

STIFFNESS = Dimension("a stiffness", "N/mm", "50 kN/mm")
TURNING_STIFFNESS = Dimension("a stiffness against rotation", "N mm/rad", "5e6 N mm/rad")
LINE_STIFFNESS = Dimension("a stiffness per length", "N/mm^2", "5 kN/mm^2")
LINE_TURNING_STIFFNESS = Dimension("a stiffness against rotation per length", "N/rad", "5e5 N/rad")
LAYER_COMPLIANCE = Dimension("a displacement per traction", "mm/MPa", "2e-5 mm/MPa")

DIMENSIONS = (
    LENGTH,
    AREA,
    FORCE,
    MOMENT,
    PRESSURE,
    LINE_FORCE,
    ENERGY_PER_AREA,
    WEAR_COEFFICIENT,
    *(STRESS_INTENSITY, ANGLE, TIME, NUMBER),
)
"""Those that the unit of a value can tell apart, except for an energy per area, which counts as a force per length."""


SMALLER_UNITS = {
    "mm": ("mm", "um", "nm"),
    "mJ": ("mJ", "uJ", "nJ"),
    "mJ/mm": ("mJ/mm", "uJ/mm", "nJ/mm"),
    "mJ/mm^2": ("mJ/mm^2", "uJ/mm^2", "nJ/mm^2"),
    "rad": ("rad", "mrad", "urad"),
}
"""Units of a result, each with the units 1000 and 1e6 times smaller."""


def smaller_unit(unit: str, largest: float) -> tuple[str, float]:
    """Return the largest unit in which `largest`, a size in `unit`, is at least 0.1, and the factor into that unit."""
    units = SMALLER_UNITS.get(unit, (unit,))
    chosen = next((k for k in range(len(units)) if largest * 1e3**k >= 0.1), len(units) - 1 if largest else 0)
    return units[chosen], 1e3**chosen


def in_small_unit(value: float, digits: int = 6) -> str:
    """Write a displacement in mm with the unit that suits it, such as ``9.06654 um``."""
    unit, factor = smaller_unit("mm", abs(value))
    return f"{factor * value:.{digits}g} {unit}"


def counted(number: int, noun: str) -> str:
    """Write a number of things, such as ``1 increment`` or ``2 increments``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def cell_counts(shape: tuple[int, int]) -> str:
    """Write the numbers of cells along the sides of a grid, such as ``64 x 48``; of a row of cells, ``64``."""
    nx, ny = shape
    return str(nx) if ny == 1 else f"{nx} x {ny}"


def percent(share: float, digits: int = 2) -> str:
    """Write a share in per cent with so many digits, such as ``2.5 %`` or ``530 %``."""
    return f"{float(f'{100.0 * share:.{digits}g}'):g} %"
