"""The state of the contact after an increment: scalars for the history, fields, and their certificate.

Units are mm, N, MPa, rad (so N mm for moments, mJ = N mm for dissipated energy). Arrays are ``(nx, ny)``, vector fields
component first, ``(2, nx, ny)``. Signs: pressure >= 0 is compressive; shear is the shear traction that body 1
exerts on body 2; slip is the slip of body 1 relative to body 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.history import CORRECTED_SUFFIX as CORRECTED_SUFFIX
from fretsolve.case.history import ERROR_SUFFIX as ERROR_SUFFIX
from fretsolve.case.history import OF_RIG
from fretsolve.case.history import Summary as Summary  # a part of the state
from fretsolve.system.arrays import DoubleArray, FloatArray, IndexArray


@cache
def broadcast_zeros(shape: tuple[int, ...]) -> FloatArray:
    """Return read-only zeros that take no memory: a field that a case does not need."""
    return np.broadcast_to(np.float64(0.0), shape)


def cost_of(history: Mapping[str, DoubleArray]) -> tuple[float, float]:
    """Return the seconds and the operator applications of a run, with the coarse runs of its error bars."""
    columns = ("wall_time", "coarse_runs_wall_time"), ("operator_applications", "coarse_runs_applications")
    seconds, applications = (sum(float(history[one].sum()) for one in part if one in history) for part in columns)
    return seconds, applications


def stage_ends(stage: DoubleArray | IndexArray) -> IndexArray:
    """Return the last increment of each stage, from the stage of each increment."""
    return np.flatnonzero(np.append(np.diff(stage) != 0, True))[: len(stage)]


class Zone:
    """States of a cell, as stored in the field `zone`: `OPEN` is 0, `STICK` 1, `SLIP` 2."""

    # Plain integers: an interrupt would be lost while NumPy looks for attributes of members of an enumeration.
    OPEN: Final = 0
    STICK: Final = 1
    SLIP: Final = 2


ZONE_NAMES = ("open", "stick", "slip")


@dataclass(frozen=True)
class Certificate:
    """Residuals of the contact conditions, computed from the tractions alone (dimensionless, slip in rad).

    The columns ``residual_gap`` to ``residual_load`` of `Summary` say what they are; gap is also the largest tension
    over the largest pressure. The scales of stick and slip have least values (docs/conventions.md).
    """

    gap: float
    stick: float
    slip: float
    bound: float
    load: float

    @property
    def worst(self) -> float:
        """The largest of the residuals; NaN if one of them is."""
        return float(np.max(list(vars(self).values())))


@dataclass(frozen=True)
class SummaryErrors:
    """Error bars of one row of the history: estimated errors of `Summary`'s values, in their units, all >= 0.

    The certificate is about `Summary`, the values as run. Those ``_corrected`` are what infinitely many increments
    would give, to first order, and have error bars of their own. NaN where they are not known. Attribute names are the
    names of datasets in ``/history``. coarse_runs_applications: applications of the elastic operator in the coarse runs
    since the row before, in units of one on the run's own grid; coarse_runs_wall_time: the seconds that they took.
    What belongs to a rig stands last, and is 0 without one.
    """

    P_error: float
    Mx_error: float
    My_error: float
    Qx_error: float
    Qy_error: float
    Mz_error: float
    delta_z_error: float
    delta_x_error: float
    delta_y_error: float
    phi_x_error: float
    phi_y_error: float
    phi_z_error: float
    contact_radius_error: float
    stick_radius_error: float
    contact_half_width_x_error: float
    contact_half_width_y_error: float
    contact_center_x_error: float
    contact_center_y_error: float
    stick_half_width_x_error: float
    stick_half_width_y_error: float
    stick_center_x_error: float
    stick_center_y_error: float
    max_pressure_error: float
    work_error: float
    work_total_error: float
    P_corrected: float
    Mx_corrected: float
    My_corrected: float
    Qx_corrected: float
    Qy_corrected: float
    Mz_corrected: float
    delta_z_corrected: float
    delta_x_corrected: float
    delta_y_corrected: float
    phi_x_corrected: float
    phi_y_corrected: float
    phi_z_corrected: float
    work_corrected: float
    work_total_corrected: float
    P_corrected_error: float
    Mx_corrected_error: float
    My_corrected_error: float
    Qx_corrected_error: float
    Qy_corrected_error: float
    Mz_corrected_error: float
    delta_z_corrected_error: float
    delta_x_corrected_error: float
    delta_y_corrected_error: float
    phi_x_corrected_error: float
    phi_y_corrected_error: float
    phi_z_corrected_error: float
    work_corrected_error: float
    work_total_corrected_error: float
    coarse_runs_applications: float
    coarse_runs_wall_time: float
    actuator_z_error: float = 0.0
    actuator_x_error: float = 0.0
    actuator_y_error: float = 0.0
    actuator_phi_x_error: float = 0.0
    actuator_phi_y_error: float = 0.0
    actuator_phi_z_error: float = 0.0
    spring_energy_error: float = 0.0
    actuator_z_corrected: float = 0.0
    actuator_x_corrected: float = 0.0
    actuator_y_corrected: float = 0.0
    actuator_phi_x_corrected: float = 0.0
    actuator_phi_y_corrected: float = 0.0
    actuator_phi_z_corrected: float = 0.0
    spring_energy_corrected: float = 0.0
    actuator_z_corrected_error: float = 0.0
    actuator_x_corrected_error: float = 0.0
    actuator_y_corrected_error: float = 0.0
    actuator_phi_x_corrected_error: float = 0.0
    actuator_phi_y_corrected_error: float = 0.0
    actuator_phi_z_corrected_error: float = 0.0
    spring_energy_corrected_error: float = 0.0


_COLUMNS = tuple(name for name in SummaryErrors.__dataclass_fields__ if not name.startswith(OF_RIG))

CORRECTED = tuple(name.removesuffix(CORRECTED_SUFFIX) for name in _COLUMNS if name.endswith(CORRECTED_SUFFIX))
"""The values of a summary that are corrected too, in their order. The values of a rig follow from them."""

ESTIMATED = tuple(
    name.removesuffix(ERROR_SUFFIX)
    for name in _COLUMNS
    if name.endswith(ERROR_SUFFIX) and not name.endswith(CORRECTED_SUFFIX + ERROR_SUFFIX)
)
"""The values of a summary that have error bars, in their order. The values of a rig follow from them."""


@dataclass(frozen=True)
class Fields:
    """Fields at the end of an increment.

    shear, slip: ``(2, nx, ny)``; zone: ``(nx, ny)`` uint8 of `Zone`; the others: ``(nx, ny)``. friction, shear_bound
    and the worn depths are there only if the case stores them; nothing goes on from them.
    """

    pressure: FloatArray
    shear: FloatArray
    slip: FloatArray
    slip_path: FloatArray
    work_density: FloatArray
    zone: NDArray[np.uint8]
    gap: FloatArray
    friction: FloatArray | None = None
    shear_bound: FloatArray | None = None
    wear_depth: FloatArray | None = None
    wear_depth_1: FloatArray | None = None
    wear_depth_2: FloatArray | None = None


@dataclass(frozen=True)
class Before:
    """Pressure ``(nx, ny)``, shear and displacement ``(2, nx, ny)`` at the start of an increment."""

    pressure: FloatArray
    shear: FloatArray
    displacement: FloatArray


@dataclass(frozen=True)
class WearState:
    """The wear so far, each ``(nx, ny)`` in double precision.

    depth: worn depth (mm); profile: that by which the surfaces have changed, which do so at the end of a cycle; mark:
    the worn depth where the present cycle began; path: way of the surfaces past each other in the present cycle (mm),
    also where they do not touch; rate: worn depth per pressure in the cycle before the last change (mm/MPa), and
    used: that with which the surfaces changed.
    """

    depth: DoubleArray
    profile: DoubleArray
    mark: DoubleArray
    path: DoubleArray
    rate: DoubleArray
    used: DoubleArray


@dataclass(frozen=True)
class State:
    """Everything after one certified increment.

    displacement: tangential elastic displacement u2 - u1, ``(2, nx, ny)``. Where nothing can slip, it is read-only
    zeros, and so are shear, slip, slip_path and work_density. errors: error bars of the summary, if it has any; wear:
    where there is any; before: the start of the increment, where the next increment is predicted by the change since
    then.
    """

    summary: Summary
    fields: Fields
    displacement: FloatArray
    errors: SummaryErrors | None = None
    wear: WearState | None = None
    before: Before | None = None


def row_of(state: State) -> dict[str, float]:
    """Return the columns of the history in the increment of a state."""
    return vars(state.summary) | ({} if state.errors is None else vars(state.errors))


def summary_of(row: Any) -> Summary:
    """Return the summary in a record of the history."""
    return Summary(**{name: row[name].item() for name in Summary.__dataclass_fields__ if name in row.dtype.names})


def errors_of(row: Any) -> SummaryErrors | None:
    """Return the error bars in a record of the history, if it has any."""
    if _COLUMNS[0] not in row.dtype.names:
        return None
    names = [name for name in SummaryErrors.__dataclass_fields__ if name in row.dtype.names]
    return SummaryErrors(**{name: row[name].item() for name in names})
