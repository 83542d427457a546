"""The quantities of the history: their units and meaning, and which of them a load path can impose. Loads no NumPy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from itertools import chain
from typing import Any

from fretsolve.case.dimensions import (
    ANGLE,
    AREA,
    ENERGY,
    FORCE,
    LENGTH,
    LINE_AREA,
    LINE_ENERGY,
    LINE_FORCE,
    LINE_MOMENT,
    LINE_VOLUME,
    MOMENT,
    NUMBER,
    PRESSURE,
    TIME,
    VOLUME,
    Dimension,
)

PAIRS = (("P", "delta_z"), ("Mx", "phi_x"), ("My", "phi_y"), ("Qx", "delta_x"), ("Qy", "delta_y"), ("Mz", "phi_z"))
"""The load components: force or moment of each rigid mode, normal modes first, and the displacement or rotation that it
works on. One of each pair is imposed at a time."""

ACTUATORS = {motion: f"actuator_{motion.removeprefix('delta_')}" for _, motion in PAIRS}
"""The motions of the contact, each with the motion of the actuator that a rig in series makes of it."""

MOTIONS_OF_ACTUATORS = {actuator: motion for motion, actuator in ACTUATORS.items()}
"""The motions of the actuator, each with the contact's motion of the same mode."""

COMPONENTS = tuple((force, motion, ACTUATORS[motion]) for force, motion in PAIRS)
"""The force or moment of each rigid mode, and its two motions; one of the three is imposed at a time."""

TANGENTIAL = frozenset(name for names in COMPONENTS[3:] for name in names)

DISPLACEMENTS = ("delta_z", "delta_x", "delta_y", "actuator_z", "actuator_x", "actuator_y")
"""Those that are lengths. Text for people has them in um where they are small; files have mm."""

BULK = {body: tuple(f"bulk_{body}_{part}" for part in ("xx", "yy", "xy")) for body in (1, 2)}
"""The bulk stresses of each body."""

SPOTS = ("spots", "small_spots")
"""The numbers of spots of contact."""

OF_RIG = (*ACTUATORS.values(), "spring_energy")
"""Motions of the actuator, and the energy in the rig."""

OF_WEAR = ("cycles", "jump", "wear_volume", "wear_depth_max", "wear_error")
"""Cycles and wear."""

FEWEST_SPOT_CELLS = 10
"""Cells of a spot below which its area and loads are rough."""

SHEARING = TANGENTIAL.union(*BULK.values())
"""Loads, displacements and stresses of a stage that shear the contact."""


def moment_sign(names: Sequence[str]) -> str:
    """Return what positive values of `names`, Mx or My or both, mean."""
    axes = ("y" if name == "Mx" else "x" for name in names)
    return f"{', '.join(names)} > 0 is more pressure at {', '.join(axes)} > 0"


def _of(dimension: Dimension, meaning: str, units: str | None = None) -> dict[str, Any]:
    """Return what describes a quantity. units: in a result file, if they differ from the dimension's units."""
    return {"dimension": dimension, "meaning": meaning, "units": units or dimension.stored}


@dataclass(frozen=True)
class Summary:
    """One row of the history: attribute names are the names of the datasets in ``/history``.

    The contact transmits the forces and moments; body 1 moves and turns by the displacements and rotations relative to
    body 2. `work` is the energy dissipated in the increment, `work_total` since the start. Only cases with bulk stress
    have columns for it, only cases with several surfaces or a height map have columns for spots; -1 stands for what was
    not counted. Only cases with wear have columns for wear; `work_total` then counts all the cycles that solved ones
    stand for.
    """

    step: int = field(metadata=_of(NUMBER, "increment, counted from 0"))
    stage: int = field(metadata=_of(NUMBER, "stage of the load path, counted from 1 with cycles unrolled"))
    P: float = field(metadata=_of(FORCE, "normal force"))
    Mx: float = field(metadata=_of(MOMENT, "moment of the pressure about the x axis, sum of y p dA"))
    My: float = field(metadata=_of(MOMENT, "moment of the pressure about the y axis, sum of x p dA"))
    Qx: float = field(metadata=_of(FORCE, "tangential force along x"))
    Qy: float = field(metadata=_of(FORCE, "tangential force along y"))
    Mz: float = field(metadata=_of(MOMENT, "torsional moment"))
    delta_z: float = field(metadata=_of(LENGTH, "normal approach"))
    delta_x: float = field(metadata=_of(LENGTH, "rigid displacement along x"))
    delta_y: float = field(metadata=_of(LENGTH, "rigid displacement along y"))
    phi_x: float = field(metadata=_of(ANGLE, "rotation about the x axis"))
    phi_y: float = field(metadata=_of(ANGLE, "rotation about the y axis"))
    phi_z: float = field(metadata=_of(ANGLE, "rotation about the z axis"))
    contact_area: float = field(metadata=_of(AREA, "area of contact"))
    stick_area: float = field(metadata=_of(AREA, "area of the stick zone"))
    contact_radius: float = field(metadata=_of(LENGTH, "radius of the circle of the area of contact"))
    stick_radius: float = field(metadata=_of(LENGTH, "radius of the circle of the area of the stick zone"))
    contact_half_width_x: float = field(metadata=_of(LENGTH, "half of the width of the contact along x"))
    contact_half_width_y: float = field(metadata=_of(LENGTH, "half of the width of the contact along y"))
    contact_center_x: float = field(metadata=_of(LENGTH, "middle of the width of the contact along x"))
    contact_center_y: float = field(metadata=_of(LENGTH, "middle of the width of the contact along y"))
    stick_half_width_x: float = field(metadata=_of(LENGTH, "half of the width of the stick zone along x"))
    stick_half_width_y: float = field(metadata=_of(LENGTH, "half of the width of the stick zone along y"))
    stick_center_x: float = field(metadata=_of(LENGTH, "middle of the width of the stick zone along x"))
    stick_center_y: float = field(metadata=_of(LENGTH, "middle of the width of the stick zone along y"))
    contact_cells: int = field(metadata=_of(NUMBER, "cells in contact"))
    stick_cells: int = field(metadata=_of(NUMBER, "cells of the stick zone"))
    max_pressure: float = field(metadata=_of(PRESSURE, "largest pressure"))
    max_shear: float = field(metadata=_of(PRESSURE, "largest shear traction"))
    work: float = field(metadata=_of(ENERGY, "energy dissipated in the increment"))
    work_total: float = field(metadata=_of(ENERGY, "energy dissipated since the start"))
    iterations_normal: int = field(metadata=_of(NUMBER, "iterations of the normal problem"))
    iterations_tangential: int = field(metadata=_of(NUMBER, "iterations of the tangential problem"))
    alternations: int = field(metadata=_of(NUMBER, "staggered iterations of the normal and the tangential problem"))
    operator_applications: int = field(
        metadata=_of(NUMBER, "influence applications, in parts of one on the whole grid")
    )
    wall_time: float = field(metadata=_of(TIME, "wall-clock time of the increment"))
    residual_gap: float = field(
        metadata=_of(NUMBER, "largest gap in contact or penetration outside, over the largest normal displacement")
    )
    residual_stick: float = field(
        metadata=_of(
            NUMBER, "largest slip increment below the friction limit, over the largest rigid displacement increment"
        )
    )
    residual_slip: float = field(
        metadata=_of(NUMBER, "largest angle between shear traction and slip increment, weighted by slip", "rad")
    )
    residual_bound: float = field(
        metadata=_of(NUMBER, "largest excess of the shear traction over the friction limit, over its maximum")
    )
    residual_load: float = field(metadata=_of(NUMBER, "worst error of an imposed load component, over its scale"))
    bulk_1_xx: float = field(default=0.0, metadata=_of(PRESSURE, "bulk stress xx in body 1, tensile"))
    bulk_1_yy: float = field(default=0.0, metadata=_of(PRESSURE, "bulk stress yy in body 1, tensile"))
    bulk_1_xy: float = field(default=0.0, metadata=_of(PRESSURE, "bulk stress xy in body 1"))
    bulk_2_xx: float = field(default=0.0, metadata=_of(PRESSURE, "bulk stress xx in body 2, tensile"))
    bulk_2_yy: float = field(default=0.0, metadata=_of(PRESSURE, "bulk stress yy in body 2, tensile"))
    bulk_2_xy: float = field(default=0.0, metadata=_of(PRESSURE, "bulk stress xy in body 2"))
    spots: int = field(default=-1, metadata=_of(NUMBER, "spots of contact, whose cells touch at sides or corners"))
    small_spots: int = field(default=-1, metadata=_of(NUMBER, f"spots of fewer than {FEWEST_SPOT_CELLS} cells"))
    cycles: float = field(default=0.0, metadata=_of(NUMBER, "cycles so far, with those that solved ones stand for"))
    jump: float = field(default=0.0, metadata=_of(NUMBER, "cycles that the last solved one stands for, at its end"))
    wear_volume: float = field(default=0.0, metadata=_of(VOLUME, "worn volume of both bodies"))
    wear_depth_max: float = field(default=0.0, metadata=_of(LENGTH, "largest worn depth of both bodies together"))
    wear_error: float = field(default=0.0, metadata=_of(VOLUME, "estimated error of the worn volume by the jumps"))
    actuator_z: float = field(default=0.0, metadata=_of(LENGTH, "normal approach at the actuator"))
    actuator_x: float = field(default=0.0, metadata=_of(LENGTH, "displacement of the actuator along x"))
    actuator_y: float = field(default=0.0, metadata=_of(LENGTH, "displacement of the actuator along y"))
    actuator_phi_x: float = field(default=0.0, metadata=_of(ANGLE, "rotation of the actuator about the x axis"))
    actuator_phi_y: float = field(default=0.0, metadata=_of(ANGLE, "rotation of the actuator about the y axis"))
    actuator_phi_z: float = field(default=0.0, metadata=_of(ANGLE, "rotation of the actuator about the z axis"))
    spring_energy: float = field(default=0.0, metadata=_of(ENERGY, "energy stored in the rig"))

    @property
    def worst_residual(self) -> float:
        """The largest of the certificate's residuals."""
        return max(float(value) for name, value in vars(self).items() if name.startswith("residual_"))


EXTENTS = tuple(column.name for column in fields(Summary) if "_width_" in column.name or "_center_" in column.name)
"""Widths and middles of the zones. NaN stands for the middle of a zone that does not exist."""

USUAL = (*chain(*COMPONENTS), "contact_radius", "work_total")
"""What an accuracy is about unless it names others: loads, displacements, contact radius, dissipated energy."""

WORN = ("wear_volume", "wear_depth_max")
"""What it is about with wear, besides."""

SCALED = (*USUAL, *EXTENTS, "stick_radius", "max_pressure", "spring_energy", *WORN)
"""What an accuracy may be about, besides quantities of cycles: all with an error bar and a scale for it."""

DIMENSIONS_BY_NAME: dict[str, Dimension] = {column.name: column.metadata["dimension"] for column in fields(Summary)}

PER_LENGTH = {FORCE: LINE_FORCE, MOMENT: LINE_MOMENT, ENERGY: LINE_ENERGY, AREA: LINE_AREA, VOLUME: LINE_VOLUME}
"""Dimensions of the history in a line contact, where they are others."""

LINE_MEANINGS = {
    "contact_area": "area of contact per mm of the line",
    "stick_area": "area of the stick zone per mm of the line",
    "contact_radius": "half-width of the contact, half of its width in all",
    "stick_radius": "half-width of the stick zone, half of its width in all",
    "delta_z": "normal approach relative to the reference depth; NaN without one",
    "delta_x": "rigid displacement along x relative to the reference depth; NaN without one",
    "delta_y": "always NaN: in a line contact it has a free constant",
    "actuator_z": "normal approach at the actuator relative to the reference depth; NaN without one",
    "actuator_x": "displacement of the actuator along x relative to the reference depth; NaN without one",
    "actuator_y": "always NaN: in a line contact it has a free constant",
    **dict.fromkeys((name for name in EXTENTS if name.endswith("_y")), "always NaN: a line contact is endless along y"),
}
"""Meaning of columns of the history in a line contact, where it is another."""

HISTORY_DIMENSIONS: dict[str, Dimension] = {
    name: dimension
    for name, dimension in DIMENSIONS_BY_NAME.items()
    if name not in ("step", "stage", *BULK[1], *BULK[2], *SPOTS)
}
"""Quantities that a case can expect, in the order of the result file."""

LINE_DIMENSIONS = {name: PER_LENGTH.get(dimension, dimension) for name, dimension in HISTORY_DIMENSIONS.items()}
"""The same in a line contact."""

ERROR_SUFFIX, CORRECTED_SUFFIX = "_error", "_corrected"
"""What the names of error bars, and of values corrected for the number of increments, end with."""
