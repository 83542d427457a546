"""Look whether a body may shake down elastically over cycles, by Melan's theorem.

It shakes down if residual stresses in equilibrium keep the stress at each place and time within yield. A residual
stress shifts the path of the deviator as a whole. So no place may have a path that is wider than the yield surface:
the radius of the smallest ball around the path, as vectors of length sqrt(J2), is at most k, the yield stress over
sqrt(3). One residual stress has to serve all cycles that occur, so that their paths count as one. This is necessary.
It is not sufficient, since the shifts of all places together must be in equilibrium.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.post.fatigue.criteria import deviator_vectors
from fretsolve.post.fatigue.planes import smallest_ball
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, StressCycles, elastic_body
from fretsolve.post.stress.yielding import at_place
from fretsolve.system.arrays import DoubleArray, IndexArray


@dataclass(frozen=True)
class WidestPath:
    """The widest path of the deviator in a body.

    radius: of its ball, as sqrt(J2) in MPa, with its error, infinite at a sharp edge; limit: the yield stress (MPa);
    place: x, y (None in a line contact), depth (mm); averaged: stresses are averages over a length; cycles: whose path
    it is.
    """

    body: int
    radius: float
    error: float
    limit: float
    place: tuple[float, float | None, float]
    averaged: bool
    cycles: int = 1

    @property
    def ratio(self) -> float:
        """The radius over k; elastic shakedown is impossible above 1."""
        return math.sqrt(3.0) * self.radius / self.limit

    @property
    def certain(self) -> bool:
        """True if the radius is above k by more than its error."""
        return math.sqrt(3.0) * (self.radius - self.error) > self.limit

    @property
    def possible(self) -> bool:
        """True if the radius is below k by more than its error."""
        return math.sqrt(3.0) * (self.radius + self.error) <= self.limit

    def __str__(self) -> str:
        if math.isinf(self.error):
            why = "since stress has no bound at a sharp edge or tip"
            verdict = f"whether elastic shakedown is possible cannot be said, {why}"
            error, on_cells = "", " on these cells"
        else:
            one = "is not ruled out" if self.possible else "is impossible" if self.certain else "may be impossible"
            verdict = f"elastic shakedown {one}"
            error, on_cells = f" ± {math.sqrt(3.0) * self.error / self.limit:.1g}", ""
        x, y, depth = self.place
        mean = ", of averaged stresses" if self.averaged else ""
        of = f" over {self.cycles} cycles together" if self.cycles > 1 else ""
        more = "; necessary, not sufficient, as residual stresses must be in equilibrium" if self.possible else ""
        return (
            f"body {self.body}: {verdict}: the widest path of the deviator{of}{at_place(x, y)}, depth {depth:.4g} mm"
            f"{mean}, needs {self.ratio:.3g}{error} times k = {self.limit / math.sqrt(3.0):.4g} MPa{on_cells}"
            f" (Melan; yield stress {self.limit:g} MPa){more}"
        )


Paths = Callable[[IndexArray], Sequence[DoubleArray]]


class ShakedownSearch:
    """Keeps the widest path of each body with a yield stress, of all layers. limits: yield stresses."""

    def __init__(self, limits: Mapping[int, float]):
        self.limits = limits
        self._widest: dict[int, WidestPath] = {}

    def add(self, body: int, stresses: StressCycles, depth: int, extent: Extent) -> None:
        """Look at a layer, the number `depth`, of a body with a yield stress.

        extent: of the paths of all cycles, whose stresses are read again where one of them may be the widest.
        """
        before = self._widest.get(body)
        found = widest_path(
            extent, lambda points: stresses.paths(depth, points), 0.0 if before is None else before.radius
        )
        if found is not None:
            radius, point = found
            i, j = divmod(point, stresses.shape[1])
            y = float(stresses.body.y[j]) if stresses.shape[1] > 1 else None
            place = float(stresses.body.x[i]), y, float(stresses.depths[depth])
            error = float(stresses.body.columns["max_mises_error"][list(stresses.states)].max()) / math.sqrt(3.0)
            limit, averaged = self.limits[body], stresses.average is not None
            self._widest[body] = WidestPath(body, radius, error, limit, place, averaged, len(stresses.cycles))

    def __iter__(self) -> Iterator[WidestPath]:
        return iter(self._widest.values())


class Extent:
    """The box around paths in the six components, (6, points), which grows path by path."""

    def __init__(self) -> None:
        self.high, self.low = np.full((1, 1), -np.inf), np.full((1, 1), np.inf)

    def add(self, path: DoubleArray) -> None:
        """Take in a path (steps, 6, points)."""
        self.high, self.low = np.maximum(self.high, path.max(axis=0)), np.minimum(self.low, path.min(axis=0))


def widest_path(extent: Extent, paths: Paths, above: float = 0.0) -> tuple[float, int] | None:
    """Return the radius (sqrt(J2), MPa) of the largest ball around the paths of a point, if above `above`, and where.

    extent: of all paths; paths: (steps, 6, chosen) of each cycle at chosen points, in one ball. None if none exceeds.
    A box around paths is no narrower than the paths, and leaves out most points.
    """
    half = 0.5 * (extent.high - extent.low)
    bounds = np.sqrt(np.array([0.5, 0.5, 0.5, 1.0, 1.0, 1.0]) @ np.square(half))
    found = None
    for points in (np.array([bounds.argmax()]), None):
        chosen = np.flatnonzero(bounds > above) if points is None else points
        if not len(chosen) or bounds[chosen].max() <= above:
            break
        radii, _ = smallest_ball(deviator_vectors(np.concatenate(paths(chosen))))
        best = int(radii.argmax())
        if radii[best] > above:
            above = float(radii[best])
            found = above, int(chosen[best])
    return found


def shakedown_limits(cycles: FatigueCycles) -> dict[int, float]:
    """Return the yield stress (MPa) of each body, else of its material, where one is known."""
    given = {
        number: elastic_body(cycles.attributes, number).get("yield_stress", cycles.materials[number].yield_stress)
        for number in cycles.of_body
    }
    return {number: limit for number, limit in given.items() if limit is not None}
