"""The certificate of an increment: the contact conditions checked from tractions and displacements alone.

The displacements come from one application of the elastic operator to the final tractions, not from the recurrences of
the iterations. `fretsolve.result.state.Certificate` lists the residuals. A cell is declared open, sticking or slipping
here, in `Examiner.zones`, and nowhere else. The steps C2 to C6 are those of docs/theory.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.rounding import LEAST_MOTION, LEAST_SLIP, TINY, circle_width, least_slip, named_rounding, slips
from fretsolve.model.grid import Grid
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
    """What follows from a `Solution`: gap (nx, ny) and slip increment (2, nx, ny) in mm, zones (nx, ny) as `Zone`,
    resultants P, Mx, My, Qx, Qy, Mz (N, N mm), and the residuals."""

    gap: FloatArray
    slip: FloatArray
    zone: NDArray[np.uint8]
    resultants: Vector
    certificate: Certificate


class Examiner:
    """Checks solutions on one grid.

    separation: (nx, ny), undeformed; friction: its coefficient; tolerance: of the case, which limits what counts as
    rounding (`least_slip`); may_slip: whether anything can slip at all; precision: of operator and tractions.
    """

    def __init__(
        self,
        separation: FloatArray,
        friction: float,
        grid: Grid,
        tolerance: float,
        may_slip: bool = True,
        precision: type[np.floating] = np.float64,
    ):
        self.separation, self.friction, self.may_slip = separation, friction, may_slip
        self.tolerance, self.precision = tolerance, precision
        self.normal, self.tangential, self.grid = NormalModes(grid), TangentialModes(grid), grid
        self.reach = max(float(np.ptp(grid.x)), float(np.ptp(grid.y))) / 2.0

    def examine(self, solution: Solution, normal: LoadControl, tangential: LoadControl) -> Evidence:
        """Return gap, slip, zones and certificate; normal, tangential: what was imposed."""
        contact = solution.pressure > 0.0
        friction_limit = self.friction * solution.pressure
        # C2: gap and slip increment
        gap = np.empty_like(self.separation)
        errors = self.normal.gap(self.separation, solution.uz, solution.rigid[:3], contact, gap)
        slip = self._slip(solution, contact) if self.may_slip else nothing(solution.shear.shape)
        # C3: zones
        zone = self.zones(solution, slip, contact, friction_limit)
        # C4 to C6: residuals
        tension = -float(min(solution.pressure.min(), 0.0)) / max(float(solution.pressure.max()), TINY)
        of_pressure, of_shear = self.normal.resultants(solution.pressure), self.tangential.resultants(solution.shear)
        resultants = np.concatenate([of_pressure, of_shear])
        stick = across = bound = 0.0
        if self.may_slip:
            stick, across = self._slip_residuals(solution, slip, zone == Zone.STICK)
            excess = float(np.max(np.hypot(solution.shear[0], solution.shear[1]) - friction_limit))
            bound = float(np.maximum(excess, 0.0)) / max(float(friction_limit.max()), TINY)
        certificate = Certificate(
            gap=float(np.maximum(errors.residual, tension)) + 0.0,  # -0.0 is 0
            stick=stick,
            slip=across,
            bound=bound,
            load=self._load_residual(solution, resultants, friction_limit, normal, tangential),
        )
        return Evidence(gap, slip, zone, resultants, certificate)

    def zones(
        self, solution: Solution, slip: FloatArray, contact: BoolArray, friction_limit: FloatArray
    ) -> NDArray[np.uint8]:
        """Return for each cell whether it is open, sticks or slips, as `Zone`, (nx, ny).

        A cell in contact slips where its shear has reached the friction limit; if no cell has slipped, all stick.
        """
        slipping = contact
        if self.friction:
            within = circle_width(self.precision)
            slipping = contact & slips(solution.shear, friction_limit, within) if slip.any() else np.zeros_like(contact)
        zone = np.full(contact.shape, Zone.OPEN, dtype=np.uint8)
        zone[contact] = Zone.STICK
        zone[slipping] = Zone.SLIP
        return zone

    def lost_in_rounding(self, solution: Solution, evidence: Evidence) -> str:
        """Return in words which rounding keeps gap or slip above the tolerance; empty where it is not rounding."""
        certificate = evidence.certificate
        farthest = self.grid.farthest
        if certificate.gap > self.tolerance:
            contact = solution.pressure > 0.0
            gap = np.empty_like(self.separation)
            errors = self.normal.gap(self.separation, solution.uz, solution.rigid[:3], contact, gap)
            error = certificate.gap * errors.gap_scale
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
        """Return the largest rigid displacement increment (mm; rotations times the grid's half side)."""
        dz, tilt_x, tilt_y, dx, dy, turn = np.abs(solution.motion)
        turned = max(tilt_x, tilt_y, turn) * self.reach
        least = max(LEAST_MOTION * _elastic(solution), self._least_slip(solution), TINY)
        return float(max(dz, dx, dy, turned, least))

    def _least_slip(self, solution: Solution) -> float:
        """Return the least length (mm) that slips are measured against."""
        return least_slip(_elastic(solution), solution.rigid, self.grid.farthest, self.tolerance)

    def _slip_scale(self, solution: Solution, largest: float, motion: float) -> float:
        """Return the slip (mm) that weights the directions of slips; largest: of all slips (mm)."""
        return max(largest, LEAST_SLIP * motion, self._least_slip(solution))

    def _slip(self, solution: Solution, contact: BoolArray) -> FloatArray:
        """Return the slip increment of the cells in contact, 0 elsewhere (T2)."""
        slip = np.empty_like(solution.shear)
        self.tangential.displacement(solution.motion[3:], slip)
        slip += solution.previous_displacement
        slip -= solution.displacement
        slip *= contact
        return slip

    def _slip_residuals(self, solution: Solution, slip: FloatArray, sticking: BoolArray) -> tuple[float, float]:
        """Return the residuals `stick` and `slip`."""
        motion = self.motion_scale(solution)
        distance = np.hypot(slip[0], slip[1])
        if not np.isfinite(distance).all():
            return np.inf, np.inf
        stick = float(np.max(distance, where=sticking, initial=0.0)) / motion
        if not self.friction:
            return stick, 0.0
        slipped = np.nonzero((distance > 0.0) & ~sticking)
        if not slipped[0].size:
            return stick, 0.0
        q_x, q_y, s_x, s_y = (part[slipped] for field in (solution.shear, slip) for part in field)
        weighted = np.arctan2(np.abs(q_x * s_y - q_y * s_x), q_x * s_x + q_y * s_y) * distance[slipped]
        return stick, float(np.max(weighted)) / self._slip_scale(solution, float(distance.max()), motion)

    def _load_residual(
        self,
        solution: Solution,
        resultants: Vector,
        friction_limit: FloatArray,
        normal: LoadControl,
        tangential: LoadControl,
    ) -> float:
        """Return the largest error of an imposed load over P or what friction can carry (moments: times half the grid's
        side), or of an imposed displacement over the largest rigid displacement (rotations: likewise)."""
        reach = max(self.reach, TINY)
        arms = np.array([1.0, reach, reach, 1.0, 1.0, reach])
        carried = float(friction_limit.sum(dtype=np.float64)) * self.grid.cell_area
        farthest = float(np.abs(solution.rigid * arms).max())
        forced = np.array([*normal.forced, *tangential.forced])
        error = np.abs(np.where(forced, resultants, solution.rigid) - (*normal.values, *tangential.values))
        scale = np.where(forced, np.repeat([resultants[0], carried], 3) * arms, farthest / arms)
        with np.errstate(over="ignore"):  # infinite where nothing carries a load
            return float(np.max(error / np.maximum(scale, TINY)))


def _elastic(solution: Solution) -> float:
    """Return the largest elastic displacement (mm)."""
    return max(float(max(field.max(), -field.min())) for field in (solution.uz, solution.displacement))
