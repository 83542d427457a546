"""The rig in series with the contact: its compliance, and the motions of the actuator.

The actuator moves by D = delta + C F, with the motion delta of the contact, its resultants F and the symmetric
compliance C of all that gives between the two. Vectors and matrices follow the order of `PAIRS`: P, Mx, My, Qx, Qy, Mz.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import ACTUATORS, PAIRS
from fretsolve.case.keys.rig_spec import STIFFNESSES, RigSpec
from fretsolve.system.arrays import DoubleArray, Vector

RESULTANTS, MOTIONS = zip(*PAIRS, strict=True)


@dataclass(frozen=True, eq=False)
class Rig:
    """compliance: C, (6, 6) (mm/N, rad/N, rad/(N mm)), or per mm of a line contact."""

    compliance: DoubleArray

    def actuator(self, motions: Vector, resultants: Vector) -> dict[str, float]:
        """Return the motions of the actuator by their names; motions: of the contact, (6,), as the resultants."""
        found = motions + self.compliance @ resultants
        return dict(zip(ACTUATORS.values(), found.tolist(), strict=True))

    def energy(self, resultants: Vector) -> float:
        """Return the energy in the rig (mJ)."""
        return float(0.5 * resultants @ self.compliance @ resultants)

    def errors(self, resultants: Vector, of_motions: Vector, of_resultants: Vector) -> dict[str, float]:
        """Return the largest errors of the motions of the actuator, and of the energy, by their names.

        of_motions, of_resultants: errors of the contact's motions and of the resultants, each ``(6,)``.
        """
        size = np.abs(self.compliance)
        found = of_motions + size @ of_resultants
        energy = np.abs(self.compliance @ resultants) @ of_resultants + 0.5 * of_resultants @ size @ of_resultants
        return dict(zip(ACTUATORS.values(), found.tolist(), strict=True)) | {"spring_energy": float(energy)}


def rig_of(spec: RigSpec | None) -> Rig | None:
    """Return the rig of a case; None without one."""
    if spec is None:
        return None
    if spec.compliance is not None:
        raise NotImplementedError
    stiffness = {motion: getattr(spec, key, None) or math.inf for key, motion in STIFFNESSES.items()}
    return Rig(np.diag([1.0 / stiffness[motion] for motion in MOTIONS]))
