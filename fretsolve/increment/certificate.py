"""Proof of an increment: the contact conditions checked from tractions and displacements alone.

The displacements come from one application of the elastic operator to the final tractions, not from the
iteration's own recurrences. What is measured is listed with `fretsolve.result.state.Certificate`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.rounding import LEAST_MOTION, LEAST_SLIP, TINY, circle_width, least_slip, named_rounding
from fretsolve.model.load_control import LoadControl
from fretsolve.result.state import Certificate, Zone, nothing
from fretsolve.solvers.rigid_modes import NormalModes, TangentialModes
from fretsolve.system.arrays import BoolArray, FloatArray, Vector


@dataclass(frozen=True)
class Solution:
    """A candidate for the end of an increment.

    pressure, uz: (nx, ny); shear, displacement: (2, nx, ny); rigid: delta_z, phi_x, phi_y, delta_x, delta_y, phi_z;
    motion: the same over the increment; previous_displacement: tangential, at the increment's start.
    """

    pressure: FloatArray
    shear: FloatArray
    uz: FloatArray
    displacement: FloatArray
    rigid: Vector
    motion: Vector
    previous_displacement: FloatArray


@dataclass(frozen=True)
class Evidence:
    """What follows from a `Solution`: gap and slip increment in mm, zone, and the residuals."""

    gap: FloatArray
    slip: FloatArray
    zone: NDArray[np.uint8]
    certificate: Certificate


class Examiner:
    """Examines solutions on one grid: `separation` (nx, ny) of the undeformed surfaces, friction coefficient; to a
    tolerance, which tells what is lost in rounding (`least_slip`). slides: whether anything can slip at all;
    precision: of operator and tractions."""

    def __init__(
        self,
        separation: FloatArray,
        friction: float,
        normal: NormalModes,
        tangential: TangentialModes,
        tolerance: float,
        slides: bool = True,
        precision: type[np.floating] = np.float64,
    ):
        self.separation = separation
        self.may_slip = slides
        self.friction = friction
        self.tolerance, self.precision = tolerance, precision
        self.normal = normal
        self.tangential = tangential
        self.reach = max(float(np.ptp(normal.x)), float(np.ptp(normal.y))) / 2.0

    def examine(self, solution: Solution, normal: LoadControl, tangential: LoadControl) -> Evidence:
        """Gap, slip and certificate; `normal` and `tangential` tell what was imposed."""
        contact = solution.pressure > 0.0
        bound = self.friction * solution.pressure
        length, slip = nothing(contact.shape), nothing((2, *contact.shape))
        if self.may_slip:
            length, slip = np.hypot(solution.shear[0], solution.shear[1]), self._slip(solution, contact)
        gap = np.empty_like(self.separation)
        errors = self.normal.gap(self.separation, solution.uz, solution.rigid[:3], contact, gap)
        tension = -float(min(solution.pressure.min(), 0.0)) / max(float(solution.pressure.max()), TINY)
        sticking = contact & (length < bound * (1.0 - circle_width(self.precision)))
        if self.friction and not slip.any():
            sticking = contact
        zone = np.full(contact.shape, Zone.OPEN, dtype=np.uint8)
        zone[contact] = Zone.SLIP
        zone[sticking] = Zone.STICK
        stick, across = self._slip_residuals(solution, slip, sticking) if self.may_slip else (0.0, 0.0)
        certificate = Certificate(
            gap=float(np.maximum(errors.residual, tension)) + 0.0,  # -0.0 is 0
            stick=stick,
            slip=across,
            bound=self._bound_residual(length, bound) if self.may_slip else 0.0,
            load=self._load_residual(solution, bound, normal, tangential),
        )
        return Evidence(gap, slip, zone, certificate)

    def lost_in_rounding(self, solution: Solution, evidence: Evidence) -> str:
        """What keeps gap or slip from being any better, in words; empty where it is not rounding."""
        certificate = evidence.certificate
        farthest = self._farthest
        if certificate.gap > self.tolerance:
            contact = solution.pressure > 0.0
            error = certificate.gap * self.normal.approach(solution.uz, contact, solution.rigid[:3])
            lengths = {
                "heights": float(np.max(np.abs(self.separation), where=contact, initial=0.0)),
                "delta_z": abs(float(solution.rigid[0])),
                "tilted heights": float(np.abs(solution.rigid[1:3]).max()) * farthest,
            }
            elastic = {"elastic displacements": float(np.abs(solution.uz).max())}
            return named_rounding(error, elastic, self.precision) or named_rounding(error, lengths)
        if max(certificate.stick, certificate.slip) > self.tolerance:
            motion = self.motion_scale(solution)
            largest = float(np.hypot(evidence.slip[0], evidence.slip[1]).max())
            error = max(certificate.stick * motion, certificate.slip * self._slip_scale(solution, largest, motion))
            lengths = {
                "delta_x and delta_y": float(np.abs(solution.rigid[3:5]).max()),
                "rotated coordinates": abs(float(solution.rigid[5])) * farthest,
                "elastic displacements": float(np.abs(solution.displacement).max()),
            }
            moved = solution.displacement - solution.previous_displacement
            changed = {"changes of the elastic displacements": float(np.abs(moved).max())}
            return named_rounding(error, lengths) or named_rounding(error, changed, self.precision)
        return ""

    def motion_scale(self, solution: Solution) -> float:
        """Largest rigid displacement increment (mm; rotations times the grid's half side)."""
        dz, tilt_x, tilt_y, dx, dy, turn = np.abs(solution.motion)
        turned = max(tilt_x, tilt_y, turn) * self.reach
        least = max(LEAST_MOTION * _elastic(solution), self._least_slip(solution), TINY)
        return float(max(dz, dx, dy, turned, least))

    def _least_slip(self, solution: Solution) -> float:
        return least_slip(_elastic(solution), solution.rigid, self._farthest, self.tolerance)

    @property
    def _farthest(self) -> float:
        """Largest coordinate of a cell (mm)."""
        return max(float(np.abs(self.normal.x).max()), float(np.abs(self.normal.y).max()))

    def _slip_scale(self, solution: Solution, largest: float, motion: float) -> float:
        """Slip (mm) that the directions of slips are weighted by; largest: of all slips."""
        return max(largest, LEAST_SLIP * motion, self._least_slip(solution))

    def _slip(self, solution: Solution, contact: BoolArray) -> FloatArray:
        """Slip increment of the cells in contact, 0 elsewhere [2.1]."""
        slip = np.empty_like(solution.shear)
        self.tangential.displacement(solution.motion[3:], slip)
        slip += solution.previous_displacement
        slip -= solution.displacement
        slip *= contact
        return slip

    def _slip_residuals(
        self, solution: Solution, slip: FloatArray, sticking: BoolArray
    ) -> tuple[float, float]:
        motion = self.motion_scale(solution)
        distance = np.hypot(slip[0], slip[1])
        if not np.isfinite(distance).all():
            return np.inf, np.inf
        stick = float(np.max(distance, where=sticking, initial=0.0)) / motion
        if not self.friction:
            return stick, 0.0
        sliding = np.nonzero((distance > 0.0) & ~sticking)
        if not sliding[0].size:
            return stick, 0.0
        q_x, q_y, s_x, s_y = (part[sliding] for field in (solution.shear, slip) for part in field)
        weighted = np.arctan2(np.abs(q_x * s_y - q_y * s_x), q_x * s_x + q_y * s_y) * distance[sliding]
        return stick, float(np.max(weighted)) / self._slip_scale(solution, float(distance.max()), motion)

    def _bound_residual(self, length: FloatArray, bound: FloatArray) -> float:
        excess = float(np.max(length - bound))
        return float(np.maximum(excess, 0.0)) / max(float(bound.max()), TINY)

    def _load_residual(
        self, solution: Solution, bound: FloatArray, normal: LoadControl, tangential: LoadControl
    ) -> float:
        """Worst imposed load's error over P or what friction can carry (moments: times the contact's reach), and
        worst imposed displacement's over the largest rigid displacement (rotations: likewise)."""
        found = self.normal.resultants(solution.pressure)
        load, reach = float(found[0]), max(self.reach, TINY)
        carried = float(bound.sum(dtype=np.float64)) * self.normal.cell_area
        sheared = self.tangential.resultants(solution.shear)
        farthest = float(np.abs(solution.rigid * np.array([1.0, reach, reach, 1.0, 1.0, reach])).max())
        errors = []
        for control, resultant, rigid, scale, arms in (
            (normal, found, solution.rigid[:3], load, (1.0, reach, reach)),
            (tangential, sheared, solution.rigid[3:], carried, (1.0, 1.0, reach)),
        ):
            for mode, (forced, value) in enumerate(zip(control.forced, control.values, strict=True)):
                error = abs(float(resultant[mode] if forced else rigid[mode]) - value)
                unit = scale * arms[mode] if forced else farthest / arms[mode]
                errors.append(error / max(unit, TINY) if error else 0.0)
        return float(np.max(errors))


def _elastic(solution: Solution) -> float:
    """Largest elastic displacement (mm)."""
    return max(float(max(field.max(), -field.min())) for field in (solution.uz, solution.displacement))
