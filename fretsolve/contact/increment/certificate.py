"""The certificate of an increment: the contact conditions checked from tractions and displacements alone.

The displacements come from one application of the elastic operator to the final tractions, not from the recurrences of
the iterations. `fretsolve.result.state.Certificate` lists the residuals. docs/theory.md describes the steps C2 to C6.

A cell in contact slips where its shear has reached the friction limit and it moves. Under cyclic loads with a mean
value, parts of a contact come to the limit in each cycle and do not move: these stick. Without friction all cells slip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretsolve.contact.kernels import ON_ANY_GRID, GridKernels
from fretsolve.contact.solvers.rigid_modes import GapErrors, NormalModes, TangentialModes
from fretsolve.elastic.rounding import LEAST_MOTION, LEAST_SLIP, circle_width, least_slip, named_rounding, slips
from fretsolve.problem.friction.limit import FrictionLimit
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.load_control import LoadControl
from fretsolve.result.state import Certificate, Zone, broadcast_zeros
from fretsolve.system.arrays import TINY, BoolArray, FloatArray, Vector, vector_lengths

LARGE_SLIP = 1e-3
"""Above this ratio of slip to motion, the motion itself is the scale."""

LEFT_OVER, LARGEST_LEFT_OVER = 10.0, 1e-5
"""Largest slip that may be an error of the iterations: over what the stick residual allows, and over the motion. Errors
of larger increments before the present one stay in the shear traction."""


@dataclass(frozen=True)
class Solution:
    """A candidate for the end of an increment.

    pressure, uz: (nx, ny); shear, displacement: (2, nx, ny); rigid: delta_z, phi_x, phi_y, delta_x, delta_y, phi_z;
    motion: `rigid` over the increment; previous_displacement: tangential, at the increment's start, less the mismatch
    of the surfaces by bulk stress; friction: its limit in the increment; mismatch: the largest one in the contact (mm).
    """

    pressure: FloatArray
    shear: FloatArray
    uz: FloatArray
    displacement: FloatArray
    rigid: Vector
    motion: Vector
    previous_displacement: FloatArray
    friction: FrictionLimit
    mismatch: float

    @property
    def friction_limit(self) -> FloatArray:
        """The friction limit (nx, ny) in MPa."""
        return self.friction.limit(self.pressure)


@dataclass(frozen=True)
class Verification:
    """Results that follow from a `Solution`.

    gap: (nx, ny), mm; gap_scale: length that it is measured against (mm); slip: increment, (2, nx, ny), mm; zone:
    (nx, ny), as `Zone`; resultants: P, Mx, My, Qx, Qy, Mz (N, N mm).
    """

    gap: FloatArray
    gap_scale: float
    slip: FloatArray
    zone: NDArray[np.uint8]
    resultants: Vector
    certificate: Certificate


class Verifier:
    """Checks solutions on one grid.

    separation: (nx, ny), undeformed; friction: the largest coefficient; tolerance: of the case, which limits what
    counts as rounding (`least_slip`); may_slip: whether anything can slip at all; precision: of operator and tractions.
    """

    def __init__(
        self,
        separation: FloatArray,
        friction: float,
        grid: Grid,
        tolerance: float,
        may_slip: bool = True,
        precision: type[np.floating] = np.float64,
        kernels: GridKernels = ON_ANY_GRID,
    ):
        self._kernels = kernels
        self.separation, self.friction, self.may_slip = separation, friction, may_slip
        self.tolerance, self.precision = tolerance, precision
        self.normal, self.tangential, self.grid = NormalModes(grid, kernels), TangentialModes(grid, kernels), grid
        # Arms of the residuals of moments and rotations: to the outermost cell's centre along the longer side.
        reach = max(grid.size[0] - grid.dx, grid.size[1] - grid.dy, TINY) / 2.0
        self._arms = np.array([1.0, reach, reach, 1.0, 1.0, reach])

    def verify(
        self, solution: Solution, normal: LoadControl, tangential: LoadControl, coupling: FloatArray | None = None
    ) -> Verification:
        """Return gap, slip, zones and certificate.

        normal, tangential: what was imposed; coupling: as in `Increment`.
        """
        contact = solution.pressure > 0.0
        friction_limit = solution.friction_limit
        # C2: gap (T1)
        gap = np.empty_like(self.separation)
        errors = self.gap_errors(solution, gap)
        # C3, C4: zones; tension
        slip, zone, stick, across = self._stick_and_slip(solution, contact, friction_limit)
        tension = -float(min(solution.pressure.min(), 0.0)) / max(float(solution.pressure.max()), TINY)
        excess = 0.0
        if self.may_slip:
            # C6: shear beyond the friction limit, and loads (T3)
            excess = float(np.maximum(self._kernels.friction.excess(solution.shear, friction_limit), 0.0))
            excess /= max(float(friction_limit.max()), TINY)
        of_pressure, of_shear = self.normal.resultants(solution.pressure), self.tangential.resultants(solution.shear)
        resultants = np.concatenate([of_pressure, of_shear])
        carried = float(friction_limit.sum(dtype=np.float64)) * self.grid.cell_area
        given_way = np.concatenate([normal.given_way(of_pressure), tangential.given_way(of_shear)])
        if coupling is not None:
            given_way += np.concatenate([coupling @ of_shear, coupling.T @ of_pressure])
        certificate = Certificate(
            gap=float(np.maximum(errors.residual, tension)) + 0.0,  # -0.0 is 0
            stick=stick,
            slip=across,
            bound=excess,
            load=self._load_residual(solution.rigid + given_way, resultants, carried, normal, tangential),
        )
        return Verification(gap, errors.gap_scale, slip, zone, resultants, certificate)

    def gap_errors(self, solution: Solution, gap: FloatArray) -> GapErrors:
        """Write the gap (nx, ny) of a solution and return its errors with their scale."""
        contact = solution.pressure > 0.0
        return self.normal.gap(self.separation, solution.uz, solution.rigid[:3], contact, gap)

    def lost_in_rounding(self, solution: Solution, found: Verification) -> str:
        """Describe the rounding that keeps gap or slip above the tolerance; return "" if it is not rounding."""
        certificate = found.certificate
        farthest = self.grid.farthest
        if certificate.gap > self.tolerance:
            error = certificate.gap * found.gap_scale
            lengths = {
                "heights": float(np.max(np.abs(self.separation), where=solution.pressure > 0.0, initial=0.0)),
                "delta_z": abs(float(solution.rigid[0])),
                "tilted heights": float(np.abs(solution.rigid[1:3]).max()) * farthest,
            }
            elastic = {"elastic displacements": float(np.abs(solution.uz).max())}
            return named_rounding(error, elastic, self.precision) or named_rounding(error, lengths)
        if max(certificate.stick, certificate.slip) > self.tolerance:
            motion, slip = self.slip_scales(solution, float(vector_lengths(found.slip).max()))
            error = max(certificate.stick * motion, certificate.slip * slip)
            lengths = {
                "delta_x and delta_y": float(np.abs(solution.rigid[3:5]).max()),
                "rotated coordinates": abs(float(solution.rigid[5])) * farthest,
                "elastic displacements": float(np.abs(solution.displacement).max()),
            }
            moved = solution.displacement - solution.previous_displacement
            changed = {"changes of the elastic displacements": float(np.abs(moved).max())}
            return named_rounding(error, lengths) or named_rounding(error, changed, self.precision)
        return ""

    def slip_scales(self, solution: Solution, largest: float) -> tuple[float, float]:
        """Return the lengths (mm) that the slip of sticking cells and the direction of slips are measured against.

        They are the largest rigid displacement increment (rotations: times their arms) or mismatch by bulk stress, and
        the `largest` slip, but not below least values.
        """
        elastic = max(map(self._kernels.cg.largest, (solution.uz[None], solution.displacement)))
        least = least_slip(elastic, solution.rigid, self.grid.farthest, self.tolerance)
        motion = float(max(*self.moved(solution), solution.mismatch, LEAST_MOTION * elastic, least, TINY))
        return motion, max(largest, LEAST_SLIP * motion, least)

    def moved(self, solution: Solution) -> Vector:
        """Return how far the surfaces move past each other rigidly in the increment (mm), by each mode."""
        moved: Vector = np.abs(solution.motion) * self._arms
        return moved

    def _slip(self, solution: Solution, contact: BoolArray) -> FloatArray:
        """Return the slip increment of the cells in contact, 0 elsewhere (T2)."""
        slip = np.empty_like(solution.shear)
        self.tangential.displacement(solution.motion[3:], slip)
        slip += solution.previous_displacement
        slip -= solution.displacement
        slip *= contact
        return slip

    def _moved(self, solution: Solution, motion: float, slip: float) -> float:
        """Return how far the surfaces move in the increment (mm), at most `motion`; slip: the largest one.

        `motion` may be a least value that refers to the normal displacement, which is far more than friction can cause
        under a small coefficient.
        """
        if slip > LARGE_SLIP * motion:
            return motion
        change = self._kernels.cg.largest(solution.displacement - solution.previous_displacement)
        return float(min(motion, max(slip, change, LEAST_MOTION * self._kernels.cg.largest(solution.displacement))))

    def _stick_and_slip(
        self, solution: Solution, contact: BoolArray, friction_limit: FloatArray
    ) -> tuple[FloatArray, NDArray[np.uint8], float, float]:
        if not self.may_slip:
            return broadcast_zeros(solution.shear.shape), zones(contact, contact & (not self.friction)), 0.0, 0.0
        # C2: slip increment (T2)
        if not (solution.displacement.any() or solution.previous_displacement.any() or solution.motion[3:].any()):
            # nothing moves along, as under a normal load alone: a first contact on 256 x 256 points takes 3 % less time
            return np.zeros_like(solution.shear), zones(contact, contact & (not self.friction)), 0.0, 0.0
        slip = self._slip(solution, contact)
        distance = vector_lengths(slip)
        farthest = float(distance.max())
        motion, largest = self.slip_scales(solution, farthest)
        # C3: a cell at the friction limit slips if it moves
        reached = contact & slips(solution.shear, friction_limit, circle_width(self.precision))
        still = max(self.tolerance, min(LEFT_OVER * self.tolerance, LARGEST_LEFT_OVER))
        moved = distance > still * self._moved(solution, motion, farthest)
        zone = zones(contact, reached & moved if self.friction else contact)
        # C5: slip of cells below the limit, direction of the others'
        if not math.isfinite(farthest):
            return slip, zone, np.inf, np.inf
        stick = float(distance[contact & ~reached].max(initial=0.0)) / motion
        slipped = (distance > 0.0) & reached
        if not self.friction or not slipped.any():
            return slip, zone, stick, 0.0
        # one component after another: NumPy takes four times as long for both at once
        q_x, q_y, s_x, s_y = (component[slipped] for component in (*solution.shear, *slip))
        # + 0.0, since -0.0 in cells without friction would count as slip against the shear
        weighted = np.arctan2(np.abs(q_x * s_y - q_y * s_x), q_x * s_x + q_y * s_y + 0.0) * distance[slipped]
        return slip, zone, stick, float(np.max(weighted)) / largest

    def _load_residual(
        self, motions: Vector, resultants: Vector, carried: float, normal: LoadControl, tangential: LoadControl
    ) -> float:
        """Return the largest error of an imposed load over P, or over what friction can carry (`carried`, N), or of an
        imposed displacement over the largest displacement; a moment or rotation: times its arm.

        motions: rigid displacements, of the actuator where there is a rig.
        """
        arms, loads = self._arms.tolist(), resultants.tolist()
        moved = motions.tolist()
        farthest = max(abs(value) * arm for value, arm in zip(moved, arms, strict=True))
        capacities = [loads[0]] * 3 + [carried] * 3
        errors = []
        for mode, (forced, imposed) in enumerate(
            zip((*normal.forced, *tangential.forced), (*normal.values, *tangential.values), strict=True)
        ):
            found = loads[mode] if forced else moved[mode]
            scale = capacities[mode] * arms[mode] if forced else farthest / arms[mode]
            errors.append(abs(found - imposed) / max(scale, TINY))
        return float(np.max(errors))  # keeps a NaN


def zones(contact: BoolArray, slipping: BoolArray) -> NDArray[np.uint8]:
    """Return the zone of each cell as `Zone`; both: cells, (nx, ny)."""
    zone = np.full(contact.shape, Zone.OPEN, dtype=np.uint8)
    zone[contact] = Zone.STICK
    zone[contact & slipping] = Zone.SLIP
    return zone
