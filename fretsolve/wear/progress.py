"""The solved cycles of a run so far: what each one dissipates and wears, and the cycles that it stands for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from fretsolve.case.keys.unrolled_path import CYCLES_TO_SETTLE, CyclePass
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import Summary


@dataclass(frozen=True)
class SolvedCycle:
    """A solved cycle in a history.

    energy: that it dissipates (mJ); volume: that it wears itself (mm^3); error: of the volume by the jump before it;
    jump: the cycles that it stands for, and jumped_volume: the volume that these wear, both 0 as long as the surfaces
    have not changed for it.
    """

    energy: float
    volume: float = 0.0
    error: float = 0.0
    jump: float = 0.0
    jumped_volume: float = 0.0


@dataclass(frozen=True)
class Worn:
    """The volume that all repetitions of a cycle have worn so far (mm^3), and its estimated error."""

    volume: float
    error: float


@dataclass(frozen=True)
class Progress:
    """A load path and the history so far."""

    path: LoadPath
    history: Sequence[Summary]

    def solved(self, cycle: CyclePass) -> list[SolvedCycle]:
        """Return the last repetitions of a cycle up to this one, with which or with whose jump the history ends."""
        first = max(1, cycle.turn - CYCLES_TO_SETTLE)
        return [self._one(*self.path.steps_of(cycle.cycle, turn)) for turn in range(first, cycle.turn + 1)]

    def worn(self, cycle: CyclePass) -> Worn:
        """Return what all repetitions of a cycle have worn up to the end of the history."""
        volume, error = self._before(self.path.steps_of(cycle.cycle, 1)[0])
        return Worn(self.history[-1].wear_volume - volume, self.history[-1].wear_error - error)

    def jump_before(self, cycle: CyclePass) -> float:
        """Return the cycles that the repetition before this one stood for."""
        return self.history[self.path.steps_of(cycle.cycle, cycle.turn)[0] - 1].jump

    def _before(self, step: int) -> tuple[float, float]:
        """Return the worn volume and its error before a step."""
        return (self.history[step - 1].wear_volume, self.history[step - 1].wear_error) if step else (0.0, 0.0)

    def _one(self, first: int, last: int) -> SolvedCycle:
        history, (before, error) = self.history, self._before(first)
        energy = math.fsum(one.work for one in history[first : last + 1])
        volume, error = history[last].wear_volume - before, history[last].wear_error - error
        if len(history) <= last + 1:
            return SolvedCycle(energy, volume, error)
        return SolvedCycle(energy, volume, error, history[last + 1].jump, history[last + 1].wear_volume - before)
