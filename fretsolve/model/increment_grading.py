"""Where the increments of a stage lie: closer where the edges of contact and stick zone move fast.

An increment's error comes from the cells that an edge passes in the middle of it: those that begin to touch, slip or
stick there. So the steps are such that the edges move alike in each. How far they have moved at a share t of the
stage is estimated before anything is solved: the contact's radius grows as P^(1/3), or as delta_z^(1/2) (Hertz), and
the stick radius over it falls as (1 - f)^(1/3), f being the tangential force over that of sliding, after a reversal
half of its change over it (Cattaneo, Mindlin). With P alone the contact so grows by equal parts of its radius, and the
shear that its edge leaves behind between unlike bodies has no waves.

What has not slipped in an increment counts as sticking, so that a stick zone which grows is found where it was at the
increment's start. The last steps of a stage are therefore smaller and smaller.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from fretsolve.case.load_components import TANGENTIAL
from fretsolve.system.arrays import DoubleArray

SAMPLES = 400
"""At which a stage's course is known, dense towards its ends, where edges may start or stop infinitely fast."""

EVEN = 0.05
"""Motion that is added evenly over a stage, so that no step is all of a stage in which no edge moves."""

LEAST_RADIUS = 0.05
"""Contact radius, in parts of the stage's largest, up to which it grows in one step: it is of about a cell's size."""

END, NEAREST = 0.2, 0.003
"""Motion that is added towards a stage's end, as the logarithm of the share that is left, down to NEAREST. With 25
steps of a growing load the last one is 1 % of it instead of 12 %."""

UNKNOWN = 0.8
"""Motion of a stage where nothing tells it, taken to be even."""

STRAIGHT = 1e-6
"""Cosine's distance from 1 or -1 below which a load goes on straight ahead or straight back."""

Loads = dict[str, float]


@dataclass(frozen=True)
class Course:
    """How the edges move through a stage.

    motion: in all, 1 where a contact or a stick zone arises from nothing or vanishes; reached: what the steps are equal
    parts of, up to each of the samples, (SAMPLES,); slip_width: of the slip annulus that a tangential force makes, over
    the contact radius, 0 where it is not known.
    """

    motion: float
    reached: DoubleArray
    slip_width: float

    @classmethod
    def of(cls, moved: DoubleArray, slip_width: float = 0.0) -> Course:
        """From the edges' motion between samples, (SAMPLES - 1,)."""
        shares = _samples()
        motion = np.concatenate([[0.0], np.cumsum(moved)])
        left = (1.0 + NEAREST) / (1.0 - shares + NEAREST)
        end = np.log(left) / np.log((1.0 + NEAREST) / NEAREST)
        return cls(float(motion[-1]), motion + EVEN * shares + END * end, slip_width)

    def share(self, part: float) -> float:
        """The share of the stage at which `part` of the motion is done."""
        if part >= 1.0:
            return 1.0
        return float(np.interp(part * self.reached[-1], self.reached, _samples()))


@dataclass(frozen=True)
class _Branch:
    """A straight tangential load. start: where it began, N; span: change at which all slides, in units of mu P."""

    start: tuple[float, float]
    direction: tuple[float, float]
    span: float


class Courses:
    """The courses of successive stages, of which one goes on where the last has ended."""

    def __init__(self, friction: float):
        self._friction = friction
        self._branch: _Branch | None = None
        self._found: dict[object, Course] = {}

    def following(self, before: Loads, after: Loads) -> Course:
        """The course from `before` to `after`, what is imposed then.

        An even one where there is no telling: where moments or tangential displacements move, or a component comes
        under another control.
        """
        self._branch = _next_branch(self._branch, before, after)
        key = self._branch, tuple(before.items()), tuple(after.items())
        if key not in self._found:
            self._found[key] = self._course(before, after) or Course.of(UNKNOWN * np.diff(_samples()))
        return self._found[key]

    def _course(self, before: Loads, after: Loads) -> Course | None:
        if before.get("P") == 0.0 and "delta_z" in after:
            before = {name: value for name, value in before.items() if name != "P"} | {"delta_z": 0.0}
        if before.keys() != after.keys():
            return None
        moved = {name for name in after if after[name] != before[name]}
        if moved - {"P", "delta_z", "Qx", "Qy"}:
            return None
        pressed = "P" if "P" in after else "delta_z"
        sheared = moved & TANGENTIAL
        if sheared and (pressed == "delta_z" or not {"Qx", "Qy"} <= after.keys() or not self._friction):
            return None
        load = _between(before, after, pressed)
        if load.max() <= 0.0:
            return None
        radius = np.maximum(load / load.max(), 0.0) ** (1.0 / 3.0 if pressed == "P" else 0.5)
        radius = np.maximum(radius, LEAST_RADIUS)
        motion: DoubleArray = np.abs(np.diff(radius))
        if pressed == "delta_z" or self._branch is None:
            return Course.of(motion)
        ratio = self._stick_ratio(self._branch, before, after, load)
        return Course.of(motion + np.abs(np.diff(radius * ratio)), 1.0 - float(ratio.min()))

    def _stick_ratio(
        self, branch: _Branch, before: Loads, after: Loads, load: DoubleArray
    ) -> DoubleArray:
        """Stick radius over contact radius."""
        start_x, start_y = branch.start
        force = np.hypot(_between(before, after, "Qx") - start_x, _between(before, after, "Qy") - start_y)
        limit = branch.span * self._friction * load
        fraction = np.divide(force, limit, out=np.ones_like(force), where=limit > force)
        ratio: DoubleArray = np.cbrt(1.0 - fraction)
        return ratio


def _between(before: Loads, after: Loads, name: str) -> DoubleArray:
    return before[name] + (after[name] - before[name]) * _samples()


def _next_branch(branch: _Branch | None, before: Loads, after: Loads) -> _Branch | None:
    """The tangential load's branch in a stage: the last one, or a new one where it turns."""
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
    """Shares of a stage, from 0 to 1."""
    even = np.linspace(0.0, 1.0, SAMPLES)
    shares: DoubleArray = even**3 / (even**3 + (1.0 - even) ** 3)
    return shares
