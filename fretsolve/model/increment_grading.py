"""Increment grading: increments of a stage lie closer together where the edges of contact and stick zone move fast.

The error of an increment comes from the cells that an edge passes during it: cells that begin to touch, slip or stick.
So the edges are to move by equal parts in each increment. How far they have moved at a share t of the stage is
estimated before anything is solved. The contact radius grows like P^(1/3) or delta_z^(1/2) (Hertz). The stick radius
over it falls like (1 - f)^(1/3), where f is the tangential force over that of sliding, or after a reversal half of its
change over that (Cattaneo, Mindlin). With P alone the contact radius grows by equal parts, and the shear that the edge
leaves behind between dissimilar bodies has no waves.

A cell that has not slipped in an increment counts as sticking, so a growing stick zone is found where it was at the
start of the increment. The last increments of a stage are therefore smaller and smaller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from fretsolve.case.load_components import TANGENTIAL
from fretsolve.reference.tangential import mindlin_stick_ratio
from fretsolve.system.arrays import DoubleArray

SAMPLES = 400
"""Shares of a stage at which the edge motion is known, dense towards the ends, where it may be infinitely fast."""

EVEN = 0.05
"""Edge motion that is added evenly over a stage, so that no increment is long where no edge moves."""

LEAST_RADIUS = 0.05
"""Contact radius, over the largest of the stage, up to which it grows in one increment: about the size of a cell."""

END, NEAREST = 0.2, 0.003
"""Edge motion that is added towards the end of a stage, as the logarithm of the share that is left, down to NEAREST.
With 25 increments of a growing load the last one is 1 % of it instead of 12 %."""

UNKNOWN = 0.8
"""Edge motion of a stage for which there is no estimate. It is spread evenly."""

STRAIGHT = 1e-6
"""Largest distance of a cosine from 1 or -1 at which a load goes straight ahead or straight back."""

Loads = dict[str, float]


@dataclass(frozen=True)
class StageGrading:
    """How the edges move through a stage.

    edge_motion: in all, 1 if a contact or a stick zone arises from nothing or vanishes; reached: the quantity that
    grows by equal parts in each increment, at the samples, (SAMPLES,); slip_width: width of the slip annulus that a
    tangential force makes, over the contact radius, 0 if unknown.
    """

    edge_motion: float
    reached: DoubleArray
    slip_width: float

    @classmethod
    def from_moves(cls, moves: DoubleArray, slip_width: float = 0.0) -> StageGrading:
        """Grade a stage by the edge motion between samples, (SAMPLES - 1,)."""
        shares = _samples()
        motion = np.concatenate([[0.0], np.cumsum(moves)])
        left = (1.0 + NEAREST) / (1.0 - shares + NEAREST)
        end = np.log(left) / np.log((1.0 + NEAREST) / NEAREST)
        return cls(float(motion[-1]), motion + EVEN * shares + END * end, slip_width)

    def share(self, part: float) -> float:
        """Return the share of the stage that is done after `part` of its increments."""
        if part >= 1.0:
            return 1.0
        return float(np.interp(part * self.reached[-1], self.reached, _samples()))


@dataclass(frozen=True)
class _Branch:
    """A straight piece of the tangential load path.

    start: (Qx, Qy) at its beginning (N); span: the change at which everything slides, in units of mu P.
    """

    start: tuple[float, float]
    direction: tuple[float, float]
    span: float


class IncrementGrading:
    """Grades successive stages, each of which starts at the loads where the one before has ended."""

    def __init__(self, friction: float):
        self._friction = friction
        self._branch: _Branch | None = None
        self._known: dict[object, StageGrading] = {}

    def next_stage(self, before: Loads, after: Loads) -> StageGrading:
        """Grade the stage that leads from the imposed components `before` to `after`.

        The grading is even where there is no estimate: where moments or tangential displacements move, or where a
        component changes between load and displacement control.
        """
        self._branch = _next_branch(self._branch, before, after)
        key = self._branch, tuple(before.items()), tuple(after.items())
        if key not in self._known:
            even = UNKNOWN * np.diff(_samples())
            self._known[key] = self._estimated(before, after) or StageGrading.from_moves(even)
        return self._known[key]

    def _estimated(self, before: Loads, after: Loads) -> StageGrading | None:
        if before.get("P") == 0.0 and "delta_z" in after:
            before = {name: value for name, value in before.items() if name != "P"} | {"delta_z": 0.0}
        if before.keys() != after.keys():
            return None
        moved = {name for name in after if after[name] != before[name]}
        if moved - {"P", "delta_z", "Qx", "Qy"}:
            return None
        pressed = "P" if "P" in after else "delta_z"
        under_forces = pressed == "P" and {"Qx", "Qy"} <= after.keys() and self._friction
        if moved & TANGENTIAL and not under_forces:
            return None
        load = _between(before, after, pressed)
        if load.max() <= 0.0:
            return None
        # The edge of the contact.
        radius = np.maximum(load / load.max(), 0.0) ** (1.0 / 3.0 if pressed == "P" else 0.5)
        radius = np.maximum(radius, LEAST_RADIUS)
        moves: DoubleArray = np.abs(np.diff(radius))
        if pressed == "delta_z" or self._branch is None:
            return StageGrading.from_moves(moves)
        # The edge of the stick zone.
        ratio = self._stick_ratio(self._branch, before, after, load)
        return StageGrading.from_moves(moves + np.abs(np.diff(radius * ratio)), 1.0 - float(ratio.min()))

    def _stick_ratio(self, branch: _Branch, before: Loads, after: Loads, load: DoubleArray) -> DoubleArray:
        """Return the stick radius over the contact radius."""
        start_x, start_y = branch.start
        force = np.hypot(_between(before, after, "Qx") - start_x, _between(before, after, "Qy") - start_y)
        limit = branch.span * self._friction * load
        fraction = np.divide(force, limit, out=np.ones_like(force), where=limit > force)
        return mindlin_stick_ratio(fraction)


def _between(before: Loads, after: Loads, name: str) -> DoubleArray:
    return before[name] + (after[name] - before[name]) * _samples()


def _next_branch(branch: _Branch | None, before: Loads, after: Loads) -> _Branch | None:
    """Return the branch that the tangential load follows in a stage: the last one, or a new one if it turns."""
    if not {"Qx", "Qy"} <= before.keys() & after.keys():
        return None
    start = before["Qx"], before["Qy"]
    change = after["Qx"] - start[0], after["Qy"] - start[1]
    length = math.hypot(*change)
    if length == 0.0:
        return branch
    direction = change[0] / length, change[1] / length
    if branch is None:
        return _Branch(start, direction, 1.0)
    cosine = direction[0] * branch.direction[0] + direction[1] * branch.direction[1]
    if cosine > 1.0 - STRAIGHT:
        return branch
    return _Branch(start, direction, 2.0 if cosine < STRAIGHT - 1.0 else 1.0)


@cache
def _samples() -> DoubleArray:
    """Return SAMPLES shares of a stage, from 0 to 1."""
    even = np.linspace(0.0, 1.0, SAMPLES)
    shares: DoubleArray = even**3 / (even**3 + (1.0 - even) ** 3)
    return shares
