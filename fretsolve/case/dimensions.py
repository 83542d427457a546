"""Physical dimensions with their units. It loads no pydantic."""

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
MOMENT = Dimension("a moment", "N mm", "N mm", "5 N mm")
ENERGY = Dimension("an energy", "mJ", "mJ", "0.014 mJ")
PRESSURE = Dimension("a pressure", "MPa", "MPa", "200 GPa")
STRESS = Dimension("a stress", "MPa", "MPa", "70 MPa")
ANGLE = Dimension("an angle", "rad", "rad", "0.1 deg")
TIME = Dimension("a time", "s", "s", "2 s")
NUMBER = Dimension("a number", "", "1", "0.1")

LINE_FORCE = Dimension("a force per length", "N/mm", "N/mm", "100 N/mm")
LINE_MOMENT = Dimension("a moment per length", "N mm/mm", "N mm/mm", "5 N mm/mm")
LINE_ENERGY = Dimension("an energy per length", "mJ/mm", "mJ/mm", "0.014 mJ/mm")
LINE_AREA = Dimension("an area per length", "mm^2/mm", "mm^2/mm", "0.2 mm^2/mm")
"""In a line contact, per mm of its length."""

ENERGY_PER_AREA = Dimension("an energy per area", "mJ/mm^2", "mJ/mm^2", "1 mJ/mm^2")
"""1 mJ/mm^2 is 1 N/mm."""

WEAR_COEFFICIENT = Dimension("a wear coefficient", "mm^3/(N*mm)", "mm^3/(N mm)", "1e-4 mm^3/J")
"""1 mm^3/J is 1e-3 mm^3/(N*mm)."""

DIMENSIONS = (LENGTH, AREA, FORCE, MOMENT, PRESSURE, LINE_FORCE, ENERGY_PER_AREA, WEAR_COEFFICIENT, ANGLE, TIME, NUMBER)
"""Those that the unit of a value can tell apart, except for an energy per area, which counts as a force per length."""


def counted(number: int, noun: str) -> str:
    """Write a number of things, such as ``1 increment`` or ``2 increments``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def percent(share: float, digits: int = 2) -> str:
    """Write a share in per cent, such as ``2.5 %``."""
    return f"{100.0 * share:.{digits}g} %"
