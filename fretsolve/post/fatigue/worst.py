"""Compute the parameters of a body layer by layer, and find where they are worst, how wrong they may be, and the life.

The largest value and the shortest life of several cycles may lie at different places. The planes of both are refined.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from fretsolve.case.keys.quantity_names import SLIP_CRITERIA
from fretsolve.post.fatigue.blocks import BlockFields
from fretsolve.post.fatigue.criteria import FatigueField, fatigue_field, lives_of
from fretsolve.post.fatigue.over_cycles import OverCycles, miner_life
from fretsolve.post.fatigue.ruiz import Sliding, ruiz_field, sliding_in
from fretsolve.post.fatigue.shakedown import Extent, ShakedownSearch
from fretsolve.post.fatigue.stress_cycle import FatigueCycles, StressCycles, opening_of
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.post.stress.peaks import between_depths
from fretsolve.post.stress.request import is_outermost
from fretsolve.post.stress.tractions import BODIES
from fretsolve.system.arrays import DoubleArray

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Life:
    """The shortest life to a crack (cycles): where it is (mm), and for the largest and smallest value of the bars."""

    cycles: float
    place: Place
    low: float = math.nan
    high: float = math.nan


@dataclass(frozen=True)
class Worst:
    """The largest value of a criterion: where it is (mm), its error bar, its plane, and what follows from it.

    error: NaN if it is not known, inf at a sharp edge; cycle: in which it is, 0 for a path without cycles. outermost:
    it is in the last cells along x or y, so that it may be larger beyond.
    """

    criterion: str
    units: str
    value: float
    place: Place
    limit: float | None = None
    normal: tuple[float, ...] | None = None
    life: Life | None = None
    outermost: bool = False
    error: float = math.nan
    cycle: int = 0


@dataclass(frozen=True)
class WorstOfBody:
    """The worst places of a body, by criterion: over all cycles, and in each of them."""

    total: Mapping[str, Worst]
    of_cycles: tuple[Mapping[str, Worst], ...]


@dataclass(frozen=True, eq=False)
class _Shortest:
    """The place of the shortest life so far, and the values there in each cycle, (cycles,)."""

    life: float
    place: Place
    values: DoubleArray


class WorstSearch:
    """Computes the layers of a body and notes the worst places.

    widest: how far the most open cycle misses its beginning, over its range. shakedown: gets the stresses, too.
    """

    def __init__(self, cycles: FatigueCycles, body: int, shakedown: ShakedownSearch | None = None):
        self._shakedown = shakedown if shakedown is not None and body in shakedown.limits else None
        self._cycles, self._body = cycles, BODIES[body - 1]
        self._of: StressCycles = cycles.of_body[body]
        self._material = cycles.materials[body]
        self._worst: list[dict[str, Worst]] = [{} for _ in self._of.cycles]
        self._highest: dict[tuple[str, int], list[float]] = {}  # of each layer
        self._layer: dict[str, tuple[int, int, DoubleArray]] = {}  # with the largest value: its cycle, place and values
        self._shortest: dict[str, _Shortest] = {}
        self.widest = 0.0

    def layer(self, depth: int, show: Callable[[], object]) -> list[FatigueField]:
        """Return the fields of all criteria over all cycles at a place of the depths; show: called after each cycle."""
        names = self._cycles.request.criteria
        over = {name: OverCycles() for name in names}
        extent = Extent()
        for index, cycle in enumerate(self._of.cycles):
            stress = self._of.stress(cycle, depth)
            self.widest = max(self.widest, opening_of(stress))
            if self._shakedown is not None:
                extent.add(stress)
            sliding = self._sliding(cycle, depth)
            for name in names:
                over[name].add(self._field(name, index, stress, sliding, depth))
            show()
        if self._shakedown is not None:
            self._shakedown.add(self._body, self._of, depth, extent)
        fields = [over[name].field(self._of.cycles) for name in names]
        return [self._with_shortest_life(one, over[one.criterion], depth) for one in fields]

    def found(self) -> WorstOfBody:
        """Return the worst places, once all layers are computed, with error bars if the tractions are known."""
        tractions, blocks = self._cycles.tractions, None
        if tractions is not None:
            blocks = BlockFields(tractions, self._cycles.request.average, self._body, self._material)
        total = {}
        for name in self._cycles.request.criteria:
            worst = self._worst[self._layer[name][0]][name]
            if blocks is not None:
                worst = replace(worst, error=self._bar(blocks, name))
            total[name] = replace(worst, life=self._life(worst))
        return WorstOfBody(total, tuple(self._worst))

    def _field(self, name: str, index: int, stress: DoubleArray, sliding: Sliding | None, depth: int) -> FatigueField:
        """Return the field of a cycle, and note where it is worst."""
        before = self._worst[index].get(name)
        if name in SLIP_CRITERIA:
            field = ruiz_field(name, stress, sliding)
        else:
            # no plane is refined that is below the worst one of the layers before
            known = {} if before is None or before.normal is None else {"known": before.value}
            field = fatigue_field(name, self._material, stress, **known)
        self._highest.setdefault((name, index), []).append(float(field.value.max()))
        if before is None or field.value.max() > before.value:
            self._worst[index][name] = self._worst_of(field, self._of.cycles[index], depth)
            if all(field.value.max() >= one[name].value for one in self._worst if name in one):
                self._layer[name] = index, depth, field.value.reshape(self._of.shape)
        return field

    def _worst_of(self, field: FatigueField, cycle: LoadCycle, depth: int) -> Worst:
        point = field.worst
        place = self._place(point, depth)
        return Worst(
            field.criterion,
            field.units,
            float(field.value[point]),
            place,
            field.limit,
            None if field.normal is None else tuple(field.normal[:, point].tolist()),
            None if field.life is None else Life(float(field.life[point]), place),
            is_outermost(divmod(point, self._of.shape[1]), self._of.shape),
            cycle=cycle.number,
        )

    def _place(self, point: int, depth: int) -> Place:
        i, j = divmod(point, self._of.shape[1])
        return float(self._of.body.x[i]), float(self._of.body.y[j]), float(self._of.depths[depth])

    def _sliding(self, cycle: LoadCycle, depth: int) -> Sliding | None:
        tractions = self._cycles.tractions
        if tractions is None or not self._cycles.request.slip_criteria or self._of.depths[depth] > 0.0:
            return None
        return sliding_in(tractions.history, self._of.increments(cycle), tractions.stresses.target, (1, 1))

    def _with_shortest_life(self, field: FatigueField, over: OverCycles, depth: int) -> FatigueField:
        """Note the shortest life of a layer, and return the field with it."""
        if field.life is None:
            return field
        several = len(self._of.cycles) > 1 and np.isfinite(field.life).any()
        point = int(field.life.argmin()) if several else field.worst
        before = self._shortest.get(field.criterion)
        values = np.array([value[point] for value in over.values])
        if before is not None and (field.life[point], -values.max()) >= (before.life, -before.values.max()):
            return field
        life = float(field.life[point])
        if len(values) > 1:
            # The planes of this point may be those of a scan, whose values are too small.
            paths = (self._of.stress(cycle, depth)[:, :, point : point + 1] for cycle in self._of.cycles)
            fields = (fatigue_field(field.criterion, self._material, path, refine_all=True) for path in paths)
            values = np.maximum(values, [float(one.value[0]) for one in fields])
            life = self._life_at(field.criterion, values)
            field.life[point] = life
        self._shortest[field.criterion] = _Shortest(life, self._place(point, depth), values)
        return field

    def _life_at(self, name: str, values: DoubleArray) -> float:
        """Return the life at a point with values (cycles,) of a criterion."""
        lives = lives_of(name, self._material, values)
        assert lives is not None
        return float(lives[0] if len(lives) == 1 else miner_life(lives, self._of.cycles))

    def _life(self, worst: Worst) -> Life | None:
        """Return the shortest life; its bounds are lives of values with the share by which the largest may be wrong."""
        shortest = self._shortest.get(worst.criterion)
        if shortest is None:
            return None
        share = worst.error / worst.value if worst.value > 0.0 else worst.error
        if not math.isfinite(share):
            return Life(shortest.life, shortest.place)
        low, high = (
            self._life_at(worst.criterion, shortest.values * max(1.0 + sign * share, 0.0)) for sign in (1.0, -1.0)
        )
        return Life(shortest.life, shortest.place, low, high)

    def _bar(self, blocks: BlockFields, name: str) -> float:
        """Return the error bar of the largest value."""
        index, depth, values = self._layer[name]
        cycle = self._of.increments(self._of.cycles[index])
        depths = self._of.depths.tolist()
        between = 0.0 if name in SLIP_CRITERIA else between_depths(depths, np.array(self._highest[name, index]), depth)
        return blocks.bar(name, cycle, depth, values) + between
