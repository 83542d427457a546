"""Factors on the error of the increments that coarse runs show: how much of it the error bars hold.

One of first order would take a factor of 1 as run, and next to nothing is left of it in corrected values. Where the
increments are too long to show the first order, the factors are larger.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.result.state import Summary
from fretsolve.simulation.error_bars.coarse_runs import CORRECTABLE
from fretsolve.simulation.error_bars.quantity_estimates import (
    DELTA_X,
    DELTA_Y,
    LINKED,
    MX,
    MY,
    SAFETY,
    STICK,
    TOTAL,
    WORK,
)
from fretsolve.simulation.error_bars.shear_path import LEAST_LEFT, UNSHEARED, ShearPath
from fretsolve.system.arrays import BoolArray, DoubleArray

CORRECTED_SAFETY = 1.0
"""Factor on the first-order error of the increments in the corrected values, where it has been taken out."""

CORRECTED_LINKED = 0.5
"""Part of the least errors by the correction of the energy (`linked`) that corrected values keep."""

ALONE, CORRECTED_ALONE = 3.25, 2.0
"""These factors for tangential values, as run and corrected, where a stage has one increment: two of them may turn the
slip otherwise."""

ALONE_AT_ONCE, CORRECTED_AT_ONCE = 4.9, 3.9
"""The same, and those of the dissipated energy, where one increment has pressed unlike bodies and another one sheared
them; where only the former has, they have the factors above."""

LONG_STEP, LONG, CORRECTED_LONG = 0.5, 4.0, 1.8
"""Way of an increment over what it leaves of the friction limit, from which on tangential values and energies have
these factors, as run and corrected. What slips grows with a power of what is left of the limit, and longer increments
do not show the first order yet: near gross slip the corrections made up for a quarter to a third of the errors."""

SIDEWAYS, ASKEW, CORRECTED_ASKEW, CORRECTED_ASKEW_ENERGY = 1e-5, 4.0, 2.9, 2.0
LONG_ASKEW, CORRECTED_LONG_ASKEW = 6.0, 3.0
"""Way sideways over delta_z by which pressing alone moves unlike bodies whose contact is not symmetric, and the factors
of tangential values and energies from then on, as run and corrected, and of tangential values after a long step. What
slips on one side makes up for most of what slips on the other. The little that is left changes by more with each
doubling of few increments, as on a rough map whose `delta_x` after pressing was 8, 18, 30, 38 and 42 nm with 8 to 128
increments. Corrected energies, all of whose parts are positive, have a smaller factor."""

NEAR_SLIDING, HIDDEN_ENERGY, HIDDEN_MOTION, HIDDEN_TURNED = 0.15, 0.045, 0.009, 0.02
"""Part of the friction limit that is left, up to which increments of unlike bodies hide errors from twice and half of
them; and least relative errors of the energy and of tangential values, over the way of such an increment over what it
leaves, 1 at most. Pressure and slip act on each other so much there that the energy may hardly change with twice and
four times the increments, and by some per cent with more."""

ENDED = 0.7
"""Factor on all of these where a body ends, whose contact hardly grows from increment to increment."""

TANGENTIAL: BoolArray = (LINKED > 0.0) & CORRECTABLE
"""Which of the values are tangential loads and displacements."""

SHIFTED: BoolArray = TANGENTIAL.copy()
"""The same, the energy since the start and the moments of the pressure, to all of which slip adds in each increment."""
SHIFTED[[TOTAL, MX, MY]] = True

ENERGIES: BoolArray = np.zeros_like(TANGENTIAL)
"""The energies."""
ENERGIES[[WORK, TOTAL]] = True

BY_SLIP: BoolArray = TANGENTIAL | ENERGIES
"""Tangential loads and displacements, and energies."""


@dataclass(frozen=True)
class Steps:
    """The reasons why increments so far may be too long to show the first order.

    alone: whether the stage has one increment; pressed_at_once: whether one has pressed unlike bodies, and
    sheared_at_once: whether another one has sheared these; coarsest: the longest way of an increment over what it left
    of the friction limit; askew: whether pressing has moved unlike bodies sideways; ends: whether a body ends.
    """

    alone: bool = False
    pressed_at_once: bool = False
    sheared_at_once: bool = False
    coarsest: float = 0.0
    askew: bool = False
    ends: bool = False

    def factors(self) -> tuple[DoubleArray, DoubleArray]:
        """Return the factors on the errors of values as run and corrected.

        Moments gain nothing by the correction, and keep all of it.
        """
        safety, corrected = SAFETY.copy(), np.full(len(SAFETY), CORRECTED_SAFETY)
        corrected[[MX, MY]] = SAFETY[[MX, MY]]
        long = self.coarsest > 1.001 * LONG_STEP  # not by rounding, where it is just that
        widened: list[tuple[BoolArray, float, float]] = []
        if self.alone:
            widened.append((TANGENTIAL, ALONE, CORRECTED_ALONE))
        if long:
            widened.append((BY_SLIP, LONG, CORRECTED_LONG))
        if self.askew:
            widened += [(TANGENTIAL, ASKEW, CORRECTED_ASKEW), (ENERGIES, ASKEW, CORRECTED_ASKEW_ENERGY)]
            if long:
                widened.append((TANGENTIAL, LONG_ASKEW, CORRECTED_LONG_ASKEW))
        if self.pressed_at_once:
            both = self.sheared_at_once
            widened.append((BY_SLIP, *((ALONE_AT_ONCE, CORRECTED_AT_ONCE) if both else (ALONE, CORRECTED_ALONE))))
            safety[STICK] = ALONE  # two increments do not show how the stick zone grows with the contact
        for which, least, least_corrected in widened:
            safety[which] = np.maximum(safety[which], least)
            corrected[which] = np.maximum(corrected[which], least_corrected)
        return (safety * ENDED, corrected * ENDED) if self.ends else (safety, corrected)


def moved_sideways(summary: Summary, carried: float) -> bool:
    """Return whether bodies that are pressed alone move sideways, or are held against it.

    carried: the force (N) that friction carries.
    """
    way, force = math.hypot(summary.delta_x, summary.delta_y), math.hypot(summary.Qx, summary.Qy)
    return summary.contact_radius > 0.0 and (way > SIDEWAYS * abs(summary.delta_z) or force > UNSHEARED * carried)


@dataclass(frozen=True)
class HiddenNearSliding:
    """The errors that increments near gross slip hide from twice and half of them: of unlike bodies, or after a turn.

    way: the longest one of an increment there, over what it left of the friction limit, 1 at most; energy, last: least
    errors (mJ) of what was dissipated up to there, and in the last increment; slides: whether that slides; turned:
    whether the shear has turned.
    """

    way: float = 0.0
    energy: float = 0.0
    last: float = 0.0
    slides: bool = False
    turned: bool = False

    def after(self, path: ShearPath, summary: Summary) -> HiddenNearSliding:
        """Return this after one more increment, with the path of the shear up to its end."""
        slides, turned = path.left <= LEAST_LEFT, path.turned > UNSHEARED
        if slides or path.left > NEAR_SLIDING:
            return replace(self, last=0.0, slides=slides, turned=turned)
        way = min(path.last / path.left, 1.0)
        energy = max(self.energy, HIDDEN_ENERGY * way * summary.work_total)
        return HiddenNearSliding(max(self.way, way), energy, HIDDEN_ENERGY * way * summary.work, turned=turned)

    def least(self, largest: DoubleArray) -> DoubleArray:
        """Return the least errors of all values; largest: their largest absolute values so far.

        Loads that slide are known.
        """
        motion = np.where(TANGENTIAL, 0.0 if self.slides else HIDDEN_MOTION * self.way, 0.0)
        found: DoubleArray = motion * largest
        if self.turned and not self.slides:
            moved = [DELTA_X, DELTA_Y]
            found[moved] = HIDDEN_TURNED * self.way * math.hypot(*largest[moved])
        found[[WORK, TOTAL]] = self.last, self.energy
        return found
