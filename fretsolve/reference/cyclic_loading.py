"""Cattaneo, Mindlin and Lubkin under a cyclic load at a constant normal force; Mindlin & Deresiewicz (1953)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from fretsolve.reference.hertz import HertzContact
from fretsolve.reference.tangential import CattaneoMindlin, LubkinContact, cattaneo_mindlin, gross_slip_torque, lubkin
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.reference.slip_from_rim import RimFrictionLimit, RimSlip

Branch = TypeVar("Branch")

SAME = 1e-6
"""Loads that differ by no more than this, relative to the load they go with, are equal."""


class MasingPath(ABC, Generic[Branch]):
    """The tractions and motions that a path of loads, all at one normal load, leaves in a contact that begins unloaded.

    By Masing's rule each branch after the first is twice the first loading by half of its length.
    """

    path: tuple[float, ...]

    @abstractmethod
    def on_loading(self, load: float) -> Branch:
        """Return the solution on first loading by `load`."""

    @property
    @abstractmethod
    def least(self) -> float:
        """Load up to which a change does not count."""

    @cached_property
    def branches(self) -> list[tuple[float, Branch]]:
        """The solutions on first loading that add up to the branches, with a factor each."""
        points, _ = turning_points(self.path, self.least)
        lengths = [after - before for before, after in pairwise(points)]
        first = [(1.0, self.on_loading(length)) for length in lengths[:1]]
        return first + [(2.0, self.on_loading(0.5 * length)) for length in lengths[1:]]

    @cached_property
    def last(self) -> Branch | None:
        """The solution on first loading whose stick zone is the one at the end of the path; None where all sticks."""
        load = last_branch(self.path, self.least)
        return self.on_loading(load) if load else None


@dataclass(frozen=True)
class CyclicLoading(MasingPath["CattaneoMindlin | LubkinContact | RimSlip"]):
    """A Hertz contact about `center` (mm) under a force along `direction`, or (None) under a torque.

    compliance: tangential or torsional (1/MPa); path: the successive forces along the direction, or torques;
    friction_limit: where it is not `friction` times pressure, for forces alone.
    """

    hertz: HertzContact
    center: tuple[float, float]
    friction: float
    compliance: float
    direction: tuple[float, float] | None
    path: tuple[float, ...]
    friction_limit: RimFrictionLimit | None = None

    @property
    def source(self) -> str:
        """The authors of the solution."""
        if self.friction_limit is not None:
            return "slip from the rim"
        return "Lubkin" if self.direction is None else "Cattaneo-Mindlin"

    @property
    def component(self) -> str:
        """The load component that acts, the larger one of Qx and Qy."""
        if self.direction is None:
            return "Mz"
        return "Qx" if abs(self.direction[0]) >= abs(self.direction[1]) else "Qy"

    @property
    def largest(self) -> float:
        """The largest magnitude on the path."""
        return max(map(abs, self.path))

    @property
    def limit(self) -> float:
        """The force mu P, or a torque just below gross slip."""
        if self.direction is None:
            return gross_slip_torque(self.hertz, self.friction) * (1.0 - SAME)
        if self.friction_limit is not None:
            return self.friction_limit.gross_slip_force
        return self.friction * self.hertz.load

    @property
    def least(self) -> float:
        arm = 1.0 if self.direction is not None else self.hertz.contact_radius
        return SAME * self.friction * self.hertz.load * arm

    def on_loading(self, load: float) -> CattaneoMindlin | LubkinContact | RimSlip:
        """Return the solution on first loading by `load`, or by the limit beyond it."""
        within = max(-self.limit, min(self.limit, load))
        if self.direction is None:
            return lubkin(self.hertz, self.friction, within, self.compliance)
        return self._under_force(within)

    def _under_force(self, load: float) -> CattaneoMindlin | RimSlip:
        if self.friction_limit is not None:
            return self.friction_limit.under(load)
        return cattaneo_mindlin(self.hertz, self.friction, load, self.compliance)

    def dissipated_energy(self) -> float:
        """Return the energy (N mm) that a force dissipates on its path."""
        return dissipated(self.path, lambda load: self._under_force(load).work_per_cycle)

    @property
    def stick_radius(self) -> float:
        """Radius c, decided by the branch after the last turning point."""
        return self.hertz.contact_radius if self.last is None else self.last.stick_radius

    def displacements(self) -> dict[str, float]:
        """Return the rotation phi_z, or the rigid displacements delta_x and delta_y that are not 0."""
        name = "phi_z" if self.direction is None else "delta_x"
        total: float = sum(factor * getattr(branch, name) for factor, branch in self.branches)
        if self.direction is None:
            return {name: total}
        return {name: total * part for name, part in zip(("delta_x", "delta_y"), self.direction, strict=True) if part}

    def shear(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Return the shear traction (2, n) at points (n,)."""
        along_x, along_y = x - self.center[0], y - self.center[1]
        r = np.hypot(along_x, along_y)
        total = sum((factor * branch.shear(r) for factor, branch in self.branches), np.zeros_like(r))
        if self.direction is None:
            return np.stack([-total * along_y, total * along_x]) / np.maximum(r, np.finfo(float).tiny)
        return np.stack([total * self.direction[0], total * self.direction[1]])


def cyclic_loading(
    hertz: HertzContact,
    friction: float,
    compliances: tuple[float, float],
    loads: tuple[DoubleArray, DoubleArray, DoubleArray, DoubleArray],
    center: tuple[float, float] = (0.0, 0.0),
) -> CyclicLoading | None:
    """Return the solution after a path of loads; None without friction, or unless a force keeps its direction or a
    torque acts alone, while P is constant.

    loads: P, Qx, Qy and Mz about the centre, each (n,). hertz: the contact under the last P. compliances: tangential
    and torsional (1/MPa).
    """
    P, Qx, Qy, Mz = loads
    nothing = SAME * friction * hertz.load
    force, torque = np.hypot(Qx, Qy), np.abs(Mz) / hertz.contact_radius
    if friction == 0.0 or (force.max() > nothing and torque.max() > nothing):
        return None
    moved = np.flatnonzero(np.maximum(force, torque) > nothing)
    if len(moved) and np.ptp(P[max(moved[0] - 1, 0) :]) > SAME * hertz.load:
        return None
    if torque.max() > nothing:
        return CyclicLoading(hertz, center, friction, compliances[1], None, tuple(Mz.tolist()))
    largest, length = int(force.argmax()), float(force.max()) or 1.0
    direction = (float(Qx[largest]) / length, float(Qy[largest]) / length)
    if np.abs(direction[0] * Qy - direction[1] * Qx).max() > nothing:
        return None
    path = tuple((direction[0] * Qx + direction[1] * Qy).tolist())
    return CyclicLoading(hertz, center, friction, compliances[0], direction, path)


def dissipated(loads: Sequence[float], per_cycle: Callable[[float], float]) -> float:
    """Return the energy dissipated on a path of `loads` from 0.

    per_cycle: the energy of a full cycle between plus and minus a load. First loading takes a quarter of a cycle, a
    later branch half a cycle of half its length, a closed loop a full cycle.
    """
    points, closed = turning_points(loads)
    per_cycle = cache(per_cycle)  # most loops of a long path are alike
    lengths = [abs(after - before) for before, after in pairwise(points)]
    opened = [(0.5, 0.5 * length) if index else (0.25, length) for index, length in enumerate(lengths)]
    return sum(cycles * per_cycle(load) for cycles, load in (*opened, *closed))


def turning_points(loads: Sequence[float], least: float = 0.0) -> tuple[tuple[float, ...], list[tuple[float, float]]]:
    """Return the turning points that the contact remembers, from 0 to the last load, and the closed loops.

    A branch that goes beyond the branch before closes that loop and wipes it out. Each loop is given by its number of
    cycles and their load. Changes up to `least` do not count.
    """
    points, closed = [0.0], list[tuple[float, float]]()
    for load in loads:
        if abs(load - points[-1]) <= least:
            continue
        if len(points) > 1 and (load - points[-1]) * (points[-1] - points[-2]) > 0.0:
            points[-1] = load
        else:
            points.append(load)
        while len(points) > 2:
            on_first_loading = len(points) == 3
            before = abs(points[-2] - points[-3])
            if abs(points[-1] - points[-2]) < before * (2.0 if on_first_loading else 1.0) * (1.0 - SAME):
                break
            # On first loading the branch goes through the mirror image of its start, after half a cycle.
            closed.append((0.5, before) if on_first_loading else (1.0, 0.5 * before))
            del points[-2 if on_first_loading else -3 : -1]
    return tuple(points), closed


def last_branch(loads: Sequence[float], least: float = 0.0) -> float:
    """Return the first loading with the same stick zone as the last branch of a path from 0; 0 without a branch.

    At a load that closes a loop this is still the branch of the loop: the cells inside of its slip zones have come to
    the friction limit, but have not moved.
    """
    path = [0.0, *loads]
    last = next((index for index in range(len(loads), 0, -1) if abs(path[index] - path[index - 1]) > least), 0)
    if not last:
        return 0.0
    end = path[last]
    short = end - math.copysign(4.0 * SAME * max(map(abs, path)), end - path[last - 1])  # the loop is not closed yet
    points, _ = turning_points((*path[1:last], short), least)
    length = end - points[-2]
    return length if len(points) == 2 else 0.5 * length
