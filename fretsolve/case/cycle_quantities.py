"""The quantities of a cycle: their dimensions and meaning. Loads neither NumPy nor pydantic."""

from __future__ import annotations

from fretsolve.case.dimensions import ENERGY, FORCE, LENGTH, LINE_STIFFNESS, NUMBER, STIFFNESS, Dimension
from fretsolve.case.history import PER_LENGTH

CYCLE_QUANTITIES: dict[str, tuple[Dimension, str]] = {
    "dissipated_energy": (ENERGY, "energy dissipated in the cycle"),
    "energy_ratio": (NUMBER, "area of the loop over force range times displacement range"),
    "sliding_ratio": (NUMBER, "width of the loop at its mean force over the displacement range"),
    "sliding_amplitude": (LENGTH, "half of the width of the loop at its mean force"),
    "slip_amplitude": (LENGTH, "largest local slip amplitude, half of the slip between the ends of the loop"),
    "reversal_stiffness": (STIFFNESS, "slope of the loop just after a reversal, the mean of its reversals"),
    "force_range": (FORCE, "largest less smallest force"),
    "displacement_range": (LENGTH, "largest less smallest displacement"),
    "force_drift": (FORCE, "force at the end less that at the beginning"),
    "displacement_drift": (LENGTH, "displacement at the end less that at the beginning"),
}
"""Quantities of a loop of force over displacement, each with its dimension and meaning."""

ACTUATOR = "actuator_"
"""Beginning of the name of a column that is measured over the motion of the actuator."""

OF_MOTION = (
    *("energy_ratio", "sliding_ratio", "sliding_amplitude"),
    *("reversal_stiffness", "displacement_range", "displacement_drift"),
)
"""Columns that a rig in series changes, so that there is one at the contact and one at the actuator."""

CYCLE_DIMENSIONS: dict[str, Dimension] = {name: dimension for name, (dimension, _) in CYCLE_QUANTITIES.items()}
CYCLE_DIMENSIONS |= {ACTUATOR + name: CYCLE_DIMENSIONS[name] for name in CYCLE_DIMENSIONS if name in OF_MOTION}
"""Dimensions of what is measured of a cycle, with a rig also at the actuator, where loads are forces."""

LINE_CYCLE_DIMENSIONS = {
    name: PER_LENGTH.get(dimension, LINE_STIFFNESS if dimension is STIFFNESS else dimension)
    for name, dimension in CYCLE_DIMENSIONS.items()
}
"""The same in a line contact."""

CYCLES_WITH_BARS = tuple(name for name in CYCLE_DIMENSIONS if name != "slip_amplitude" and not name.endswith("_drift"))
"""Quantities of cycles that have error bars where the history has."""
