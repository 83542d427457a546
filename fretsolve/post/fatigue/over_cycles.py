"""A parameter over several cycles: its largest value at each point, and the life by Miner's rule."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from fretsolve.post.fatigue.criteria import FatigueField
from fretsolve.post.stress.cycles import LoadCycle
from fretsolve.system.arrays import DoubleArray


def miner_life(lives: Iterable[DoubleArray], cycles: Sequence[LoadCycle]) -> DoubleArray:
    """Return the cycles to a crack, (points,), where each cycle occurs as often as in a block (Miner 1945).

    lives: of each cycle alone, (points,).
    """
    with np.errstate(divide="ignore"):
        damage = sum(cycle.times / life for cycle, life in zip(cycles, lives, strict=True))
        return np.asarray(sum(cycle.times for cycle in cycles) / damage)


class OverCycles:
    """Collects the fields of one criterion, cycle by cycle.

    values, lives: of each cycle, (points,), where the criterion has a life curve.
    """

    def __init__(self) -> None:
        self._largest: FatigueField | None = None
        self.values: list[DoubleArray] = []
        self.lives: list[DoubleArray] = []

    def add(self, field: FatigueField) -> None:
        """Add the next cycle."""
        if field.life is not None:
            self.values.append(field.value)
            self.lives.append(field.life)
        self._largest = field if self._largest is None else _larger(self._largest, field)

    def field(self, cycles: Sequence[LoadCycle]) -> FatigueField:
        """Return the field of all cycles."""
        assert self._largest is not None
        if len(self.lives) < 2:
            return self._largest
        return replace(self._largest, life=miner_life(self.lives, cycles))


def _larger(one: FatigueField, other: FatigueField) -> FatigueField:
    """Return at each point the larger value, with its plane."""
    second = other.value > one.value
    if one.normal is None or one.refined is None or other.normal is None or other.refined is None:
        return replace(one, value=np.maximum(one.value, other.value))
    return replace(
        one,
        value=np.where(second, other.value, one.value),
        normal=np.where(second, other.normal, one.normal),
        refined=np.where(second, other.refined, one.refined),
    )
