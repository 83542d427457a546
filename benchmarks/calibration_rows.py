"""The comparisons of error bars with true errors, one quantity at one increment each, and what the bars cost."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretsolve.case.history import HISTORY_DIMENSIONS, LINE_DIMENSIONS
from fretsolve.result.state import CORRECTED_SUFFIX

QUANTITIES = {
    **dict.fromkeys(("P", "Qx", "Qy"), "N"),
    **dict.fromkeys(("Mx", "My", "Mz"), "N mm"),
    **dict.fromkeys(("delta_z", "delta_x", "delta_y"), "mm"),
    **dict.fromkeys(("phi_x", "phi_y", "phi_z"), "rad"),
    **dict.fromkeys(("contact_radius", "stick_radius"), "mm"),
    "max_pressure": "MPa",
    "work_total": "mJ",
}
PER_LENGTH = {name for name in QUANTITIES if LINE_DIMENSIONS[name] != HISTORY_DIMENSIONS[name]}
"""Quantities that a line contact has per mm of its length."""


@dataclass(frozen=True)
class Row:
    """One comparison; errors in the quantity's units.

    end: whether it is made at the end of its stage; quantity: with the ending ``_corrected`` for corrected values;
    in_plane: whether the case is one of line contact.
    """

    case: str
    stage: int
    end: bool
    quantity: str
    value: float
    error: float
    bar: float
    in_plane: bool = False

    @property
    def corrected(self) -> bool:
        return self.quantity.endswith(CORRECTED_SUFFIX)

    @property
    def units(self) -> str:
        name = self.quantity.removesuffix(CORRECTED_SUFFIX)
        return f"{QUANTITIES[name]}/mm" if self.in_plane and name in PER_LENGTH else QUANTITIES[name]

    @property
    def inside(self) -> bool:
        return self.error <= self.bar

    @property
    def ratio(self) -> float:
        """Bar over true error."""
        return self.bar / self.error if self.error else math.inf

    @property
    def near(self) -> bool:
        """Within a factor of ten."""
        return 0.1 < self.ratio < 10.0

    @property
    def cells(self) -> tuple[str, ...]:
        """The row of the CSV file, without its group."""
        numbers = (f"{self.value:.5g}", f"{self.error:.1e}", f"{self.bar:.1e}", f"{self.ratio:.2g}")
        return (self.case, str(self.stage), self.quantity, self.units, *numbers)

    def line(self) -> str:
        """Return the row of the page's table."""
        return (
            f"| {self.case} | {self.stage} | {self.quantity}, {self.units} | {self.value:.5g} | {self.error:.1e} |"
            f" {self.bar:.1e} |"
        )


@dataclass(frozen=True)
class Cost:
    """Share of the coarse runs in a case's seconds, and in its operator applications."""

    case: str
    time: float
    applications: float
