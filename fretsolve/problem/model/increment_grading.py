"""Increment grading: increments of a stage lie closer together where the edges of contact and stick zone move fast.

The error of an increment comes from the cells that an edge passes during it: cells that begin to touch, slip or stick.
So the edges should move by equal parts in each increment. Their motion is estimated before anything is solved. The
contact radius grows like P^(1/3) or delta_z^(1/2) (Hertz). The ratio of stick radius to contact radius falls like
(1 - f)^(1/3) (Cattaneo, Mindlin), with the tangential force over mu P as f; after a reversal f is half of the change of
that force over mu P. In a line contact all these powers are 1/2. Under P alone the contact radius grows by equal parts,
so the shear that the edge leaves behind between dissimilar bodies has no waves.

A cell that has not slipped in an increment counts as sticking, so a growing stick zone is found where it was at the
start of the increment. The last increments of a stage are therefore smaller and smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fretsolve.reference.tangential import mindlin_stick_ratio
from fretsolve.system.arrays import DoubleArray

_EVEN_SHARES = np.linspace(0.0, 1.0, 400)
SHARES: DoubleArray = _EVEN_SHARES**3 / (_EVEN_SHARES**3 + (1.0 - _EVEN_SHARES) ** 3)
"""Shares of a stage, ``(n,)``, at which the edge motion is known; dense near the ends, where it may be infinite."""

EVEN = 0.05
"""Edge motion added evenly over a stage, so that no increment is long where no edge moves."""

LEAST_RADIUS = 0.05
"""Contact radius, over the largest of the stage, up to which it grows in one increment: about the size of a cell."""

NEAREST = 0.003
"""Share that is left of a stage, down to which edge motion is added towards its end, as the logarithm of that share.
With 25 increments of a growing load the last increment is 1 % of the stage instead of 12 %."""

UNKNOWN = 0.8
"""Edge motion of a stage without an estimate, spread evenly."""

_EVENLY = EVEN * SHARES
_TO_THE_END = 0.2 * (np.log((1.0 + NEAREST) / (1.0 - SHARES + NEAREST)) / np.log((1.0 + NEAREST) / NEAREST))
"""Edge motion that every stage is given up to `SHARES`."""

STRAIGHT = 1e-6
"""Distance of a cosine from 1 or -1 up to which a load keeps or reverses its direction."""

Loads = dict[str, float]
Course = Mapping[str, DoubleArray]
"""Loads at `SHARES` of a stage, ``(n,)``, where they do not grow in proportion."""


@dataclass(frozen=True)
class LoadsAtContact:
    """The loads of a contact on a rig, which motions of the actuator amount to.

    imposed: before the first stage and at the end of each stage; course: of a stage, counted from 0.
    """

    imposed: tuple[Loads, ...]
    course: Callable[[int], Course]


@dataclass(frozen=True)
class StageGrading:
    """The motion of the edges in a stage, and the grading that follows from it.

    edge_motion: the whole motion, 1 if a contact or a stick zone grows from nothing or vanishes; progress: a quantity
    that grows by the same amount in each increment, at `SHARES`, ``(n,)``.
    """

    edge_motion: float
    progress: DoubleArray

    @classmethod
    def from_moves(cls, moves: DoubleArray) -> StageGrading:
        """Grade a stage by the edge motion from each of `SHARES` to the next, ``(n - 1,)``."""
        motion = np.concatenate([[0.0], np.cumsum(moves)])
        return cls(float(motion[-1]), motion + _EVENLY + _TO_THE_END)

    def share(self, part: float) -> float:
        """Return the share of the stage that is done after `part` of its increments."""
        return 1.0 if part >= 1.0 else float(np.interp(part * self.progress[-1], self.progress, SHARES))


_EVENLY_GRADED = StageGrading.from_moves(UNKNOWN * np.diff(SHARES))


@dataclass(frozen=True)
class _Branch:
    """A straight piece of the tangential load path.

    start: Qx + i Qy at its beginning (N); direction: of its change, of length 1; span: the change that makes all slip,
    in units of mu P.
    """

    start: complex
    direction: complex
    span: float


@dataclass(frozen=True)
class EdgeLaws:
    """The laws of moving edges: power of P and of delta_z with which the contact grows, stick over contact radius.

    stick_ratio: of the tangential force over mu P, from 0 to 1, both (n,).
    """

    by_force: float
    by_approach: float
    stick_ratio: Callable[[DoubleArray], DoubleArray]


SPHERE = EdgeLaws(1.0 / 3.0, 0.5, mindlin_stick_ratio)
LINE = EdgeLaws(0.5, 0.5, lambda fraction: np.sqrt(1.0 - np.minimum(fraction, 1.0)))  # Cattaneo


def stage_gradings(
    friction: float,
    imposed: Sequence[Loads],
    laws: EdgeLaws = SPHERE,
    course: Callable[[int], Course] = lambda stage: {},
) -> Iterator[StageGrading]:
    """Yield the grading of each stage. imposed: the components before the first stage and at the end of each stage.

    The grading is even where there is no estimate: where moments, tangential displacements or an actuator move, or
    where a component changes between load and displacement control.
    """
    branch: _Branch | None = None
    known: dict[object, StageGrading] = {}
    for stage, (before, after) in enumerate(pairwise(imposed)):
        branch = _next_branch(branch, before, after)
        key = branch, tuple(before.items()), tuple(after.items())
        if key not in known:
            known[key] = _estimated(friction, branch, before, after, laws, course(stage)) or _EVENLY_GRADED
        yield known[key]


def _estimated(
    friction: float, branch: _Branch | None, before: Loads, after: Loads, laws: EdgeLaws, course: Course
) -> StageGrading | None:
    """Return the grading by the estimated motion of the edges, or None where there is no estimate."""
    if before.get("P") == 0.0 and "delta_z" in after:
        before = {name: value for name, value in before.items() if name != "P"} | {"delta_z": 0.0}
    pressed = "P" if "P" in after else "delta_z"
    if pressed not in after:  # an actuator presses in a way that is not known
        return None
    under_forces = pressed == "P" and {"Qx", "Qy"} <= after.keys() and friction > 0.0
    may_move = {pressed, "Qx", "Qy"} if under_forces else {pressed}
    if before.keys() != after.keys() or any(after[name] != before[name] for name in after.keys() - may_move):
        return None
    load = _between(before, after, pressed, course)
    if load.max() <= 0.0:
        return None
    # The edge of the contact.
    radius = np.maximum(load / load.max(), 0.0) ** (laws.by_force if pressed == "P" else laws.by_approach)
    radius = np.maximum(radius, LEAST_RADIUS)
    moves: DoubleArray = np.abs(np.diff(radius))
    if pressed == "delta_z" or branch is None:
        return StageGrading.from_moves(moves)
    # The edge of the stick zone.
    qx, qy = (_between(before, after, name, course) for name in ("Qx", "Qy"))
    force = np.hypot(qx - branch.start.real, qy - branch.start.imag)
    limit = branch.span * friction * load
    ratio = laws.stick_ratio(np.divide(force, limit, out=np.ones_like(force), where=limit > force))
    return StageGrading.from_moves(moves + np.abs(np.diff(radius * ratio)))


def _between(before: Loads, after: Loads, name: str, course: Course) -> DoubleArray:
    return course[name] if name in course else before[name] + (after[name] - before[name]) * SHARES


def _next_branch(branch: _Branch | None, before: Loads, after: Loads) -> _Branch | None:
    """Return the branch that the tangential load follows in a stage: the last one, or a new one if it turns."""
    if not {"Qx", "Qy"} <= before.keys() & after.keys():
        return None
    start, end = (complex(loads["Qx"], loads["Qy"]) for loads in (before, after))
    if start == end:
        return branch
    direction = (end - start) / abs(end - start)
    cosine = 0.0 if branch is None else (direction * branch.direction.conjugate()).real
    if cosine > 1.0 - STRAIGHT:
        return branch
    return _Branch(start, direction, 2.0 if cosine < STRAIGHT - 1.0 else 1.0)
