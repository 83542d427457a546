"""Ruiz's two parameters of fretting on the surface: tension along the slip, shear traction and slip amplitude.

ruiz-1 is the largest tension times the largest shear traction times the slip amplitude of a cycle; ruiz-2 takes the
largest product of tension and traction at one time (Ruiz, Boddington and Chen 1984, Experimental Mechanics 24). They
have neither a limit nor a life.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.case.dimensions import RUIZ
from fretsolve.errors import CaseError
from fretsolve.post.fatigue.criteria import FatigueField
from fretsolve.post.fatigue.planes import smallest_ball
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.layers import Window
from fretsolve.post.stress.tractions import TractionHistory
from fretsolve.system.arrays import DoubleArray

UNITS = RUIZ.stored


@dataclass(frozen=True, eq=False)
class Sliding:
    """Shear and slip on the surface over a cycle.

    shear: size of the shear traction (steps, points) in MPa; amplitude: radius of the smallest circle around the path
    of slip (points,) in mm, half of its range if it is straight; direction: of the slip, (2, points), of length 1.
    """

    shear: DoubleArray
    amplitude: DoubleArray
    direction: DoubleArray

    @classmethod
    def of(cls, slip: DoubleArray, shear: DoubleArray) -> Sliding:
        """Return the sliding from slip (mm) and shear tractions (MPa), both (steps, 2, points)."""
        amplitude, centers = smallest_ball(slip)
        away = slip - centers
        distance = np.hypot(away[:, 0], away[:, 1])
        everywhere = np.arange(slip.shape[2])
        farthest = distance.argmax(axis=0)
        length = distance[farthest, everywhere]
        along_x = np.array([[1.0], [0.0]])
        direction = np.where(length > 0.0, away[farthest, :, everywhere].T / np.where(length > 0.0, length, 1), along_x)
        return cls(np.hypot(shear[:, 0], shear[:, 1]), amplitude, direction)


def ruiz_field(name: str, stress: DoubleArray, sliding: Sliding | None) -> FatigueField:
    """Return a parameter from the stresses (steps, 6, points) in MPa of a layer; sliding: None below the surface."""
    if sliding is None:
        return FatigueField(name, UNITS, np.zeros(stress.shape[2]))
    x, y = sliding.direction
    tension = np.maximum(x * x * stress[:, 0] + y * y * stress[:, 1] + 2.0 * x * y * stress[:, 3], 0.0)
    if name == "ruiz-1":
        product = tension.max(axis=0) * sliding.shear.max(axis=0)
    else:
        product = (tension * sliding.shear).max(axis=0)
    return FatigueField(name, UNITS, product * sliding.amplitude)


def require_slip(tractions: TractionHistory) -> None:
    """Raise CaseError if a result has no slip."""
    result = tractions.result
    if tractions.has_shear and "slip_x" not in result.fields:
        message = "the result does not hold slip, which Ruiz's parameters need; output.fields in the case chooses it"
        raise CaseError(message, (), result.path)


def sliding_in(tractions: TractionHistory, cycle: LoadCycle, window: Window, sides: tuple[int, int]) -> Sliding:
    """Return the sliding of a cycle of increments in the means over blocks of `sides` cells; window: of blocks.

    Outside of the grid it is 0.
    """
    steps = cycle.states
    shape = tuple((one.stop - one.start) * side for one, side in zip(window, sides, strict=True))
    first = tuple(one.start * side for one, side in zip(window, sides, strict=True))
    fields = np.zeros((len(steps), 4, *shape))
    if tractions.has_shear:
        inside = tuple(
            slice(max(begin, 0), min(begin + size, count))
            for begin, size, count in zip(first, shape, tractions.grid.shape, strict=True)
        )
        placed = tuple(
            slice(one.start - at, max(one.stop, one.start) - at) for one, at in zip(inside, first, strict=True)
        )
        for index, step in enumerate(steps):
            for part, name in enumerate(("slip_x", "slip_y", "shear_x", "shear_y")):
                if name in tractions.result.fields:
                    fields[index, part][placed] = tractions.result.field(name, step)[inside]
    blocks = fields.reshape(len(steps), 4, shape[0] // sides[0], sides[0], shape[1] // sides[1], sides[1])
    means = cycle.with_rest(blocks.mean(axis=(3, 5)).reshape(len(steps), 4, -1))
    return Sliding.of(np.ascontiguousarray(means[:, :2]), means[:, 2:])
