"""Follow the shear along the load path, for least errors of the dissipated energy and of the stick zone."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fretsolve.case.history import PAIRS, Summary
from fretsolve.simulation.error_bars.shear_memory import NO_SHEAR, ShearMemory

Shares = tuple[float, float, float]

SHEARING_PAIRS = PAIRS[3:]
"""Tangential loads and motions."""

LEAST_LEFT = 0.01
"""Part of the friction limit that counts as left, at least."""

AT_LARGEST = 0.999
"""Part of the largest share of the shear from which on it counts as there."""

PRESSED_ORDER = 8.0 / 3.0
"""Power of P with which slip within a rounding dissipates: K^2 d, where d goes with K^(2/3) and K with P."""

TORQUE_ARM = 1.5
"""Under a torque the shear traction at the edge of a round punch is so many times that of a force over the radius."""

TURNS_SEEN = 2
"""Number of increments by which a stage that turns the shear converges later than with the first order."""

UNSHEARED = 1e-3
"""Part of the friction limit below which a load is one of pressing alone."""

HELD = 1e-4
"""Part of the friction limit by which an increment moves the shear at most that holds it."""


@dataclass(frozen=True)
class StickEdges:
    """Where earlier loads have left edges of the stick zone: radii (mm), infinite where there is none.

    smallest: the smallest stick radius under shear; turned: that at the last turn by more than a right angle.
    """

    smallest: float = math.inf
    turned: float = math.inf

    def apart(self, radius: float) -> float:
        """Return how far (mm) the nearest of them is from a stick radius."""
        return min(abs(radius - self.smallest), abs(radius - self.turned))


@dataclass(frozen=True)
class ShearPath:
    """The path of the shear so far, as a part of what friction carries: forces, torque over the radius.

    at: where it is, (3,); farthest: how far from 0 it has been; largest: the same with what pressing adds, at most 1;
    way: in the last increment, (3,); length: of all ways; coarsest: the longest way of an increment over what is left
    of the friction limit at its end; last_at_edge, at_edge: least error (mJ) of what the last increment and all
    dissipated, by the width of their slip annuli in cells, and as they shear at once what they press.
    A shear that slips within a rounding dissipates what it does up to gross slip times `largest` squared times
    `length`: it goes with the third power of the way from a reversal, halved. last_pressed, pressed: ways of the last
    increment and of all, each times P^(8/3), the larger one of its ends: what such slip dissipates goes with that of P.
    turning, turned_before: ways across the direction of the shear, over TURNS_SEEN more than the increments of their
    stage: their sum in this stage, and the largest one of earlier stages.
    edges: earlier edges of the stick zone; memory, at_once: how far the shear slips as it changes with the load, and as
    the run's increments take it. now: the summary of the last increment; before: that of the largest P of those before
    it; None where there is none. strained: part of the work of the shear in the last increment that strains the bodies.
    By Cattaneo and Mindlin it is the stick radius over the contact radius, and where all slides it is nothing.
    """

    at: Shares = (0.0, 0.0, 0.0)
    farthest: float = 0.0
    largest: float = 0.0
    way: Shares = (0.0, 0.0, 0.0)
    length: float = 0.0
    last_pressed: float = 0.0
    pressed: float = 0.0
    coarsest: float = 0.0
    last_at_edge: float = 0.0
    at_edge: float = 0.0
    turning: float = 0.0
    turned_before: float = 0.0
    edges: StickEdges = StickEdges()
    memory: ShearMemory = NO_SHEAR
    at_once: ShearMemory = NO_SHEAR
    now: Summary | None = None
    before: Summary | None = None
    strained: float = 1.0

    @property
    def last(self) -> float:
        """The length of the way in the last increment."""
        return math.hypot(*self.way)

    @property
    def ways_under_load(self) -> tuple[float, float]:
        """The ways of the last increment and of all, counted by what they dissipate within a rounding under the present
        P, 0 without one."""
        present = self.now.P**PRESSED_ORDER if self.now is not None else 0.0
        return (self.last_pressed / present, self.pressed / present) if present else (0.0, 0.0)

    @property
    def to_limit(self) -> float:
        """The part of the friction limit that is left, 0 where the bodies slide."""
        return _left(self.at, 0.0)

    @property
    def left(self) -> float:
        """The same, LEAST_LEFT at least."""
        return _left(self.at)

    @property
    def turned(self) -> float:
        """The larger of `turning` and `turned_before`."""
        return max(self.turning, self.turned_before)

    @property
    def moves_on(self) -> bool:
        """True if the last increment moved the shear farther from 0, and did not just hold it."""
        return self.last > HELD and _product(self.at, self.way) > 0.0

    @property
    def is_below_largest(self) -> bool:
        """True unless the shear is at its largest share."""
        return math.hypot(*self.at) < AT_LARGEST * self.largest

    def after(
        self, summary: Summary, carried: float, pressed: float, at_edge: float, count: int = 1, known: float = 1.0
    ) -> ShearPath:
        """Return the path after one more increment.

        carried: the force (N) that friction carries; pressed: the share of it to which pressing unlike bodies shears;
        at_edge: least error (mJ) of what the increment dissipates, by the width of its slip annulus; count: number of
        increments of its stage; known: factor on what is known exactly, as of `quantity_estimates.room`.
        """
        if carried <= 0.0:
            return replace(
                self,
                way=(0.0, 0.0, 0.0),
                last_pressed=0.0,
                last_at_edge=0.0,
                memory=NO_SHEAR,
                at_once=NO_SHEAR,
                now=summary,
                before=self._most_pressed,
            )
        at = shares_of_limit(summary, carried)
        way = at[0] - self.at[0], at[1] - self.at[1], at[2] - self.at[2]
        last = math.hypot(*way)
        begins = self.now is None or self.now.stage != summary.stage
        turns = _product(way, self.way) < 0.0
        turned = self.now.stick_radius if turns and self.now else self.edges.turned
        force = summary.Qx, summary.Qy, at[2] * carried
        memory = self.memory.after(summary.P, force, carried / summary.P)
        at_once = self.at_once.after_at_once(summary.P, force, carried / summary.P)
        largest_load = max(summary.P, self.now.P if self.now is not None else 0.0)
        last_pressed = last * largest_load**PRESSED_ORDER
        at_edge += known * _part_of_energy(memory.slipping, at_once.slipping) * summary.work
        return ShearPath(
            at=at,
            farthest=max(self.farthest, math.hypot(*at)),
            largest=max(self.largest, min(math.hypot(*at) + pressed, 1.0)),
            way=way,
            length=self.length + last,
            last_pressed=last_pressed,
            pressed=self.pressed + last_pressed,
            coarsest=max(self.coarsest, last / _left(at)),
            last_at_edge=at_edge,
            at_edge=self.at_edge + at_edge,
            turning=(0.0 if begins else self.turning) + _across(way, self.at) / (count + TURNS_SEEN),
            turned_before=self.turned if begins else self.turned_before,
            edges=StickEdges(min(self.edges.smallest, summary.stick_radius), turned),
            memory=memory,
            at_once=at_once,
            now=summary,
            before=self._most_pressed,
            strained=_strained(self.now, summary),
        )

    @property
    def _most_pressed(self) -> Summary | None:
        """The summary of the largest P so far."""
        if self.before is None or (self.now is not None and self.now.P >= self.before.P):
            return self.now
        return self.before


def shares_of_limit(summary: Summary, carried: float) -> Shares:
    """Return forces, and the torque over the radius, as parts of what friction carries (N), which is above 0."""
    arm = summary.contact_radius / TORQUE_ARM
    return summary.Qx / carried, summary.Qy / carried, summary.Mz / arm / carried if arm else 0.0


def share_of_limit(summary: Summary, carried: float) -> float:
    """Return how far a shear is from 0, over what friction carries (N); 0 where it carries nothing."""
    return math.hypot(*shares_of_limit(summary, carried)) if carried > 0.0 else 0.0


def _strained(before: Summary | None, now: Summary) -> float:
    """Return the part of the work of the shear in an increment that strains the bodies, 1 where it is not known."""
    worked = 0.0
    for load, motion in SHEARING_PAIRS:
        mean, moved = getattr(now, load), getattr(now, motion)
        if before is not None:
            mean, moved = 0.5 * (mean + getattr(before, load)), moved - getattr(before, motion)
        worked += mean * moved
    return min(abs(1.0 - now.work / worked), 1.0) if worked > 0.0 else 1.0


def _part_of_energy(slipping: float, at_once: float) -> float:
    """Return the part of what an increment dissipates that it would not if the shear changed with the load.

    The energy goes with the third power of what slips.
    """
    largest = max(slipping, at_once)
    return 1.0 - (min(slipping, at_once) / largest) ** 3 if largest > 0.0 else 0.0


def _across(way: Shares, at: Shares) -> float:
    """Return the length of the part of a way that is perpendicular to where it begins, 0 from the origin."""
    if not any(at):
        return 0.0
    along = _product(way, at) / math.hypot(*at)
    return math.sqrt(max(_product(way, way) - along**2, 0.0))


def _product(one: Shares, other: Shares) -> float:
    """Return the scalar product."""
    return sum(a * b for a, b in zip(one, other, strict=True))


def _left(at: Shares, least: float = LEAST_LEFT) -> float:
    return max(1.0 - math.hypot(*at), least)
