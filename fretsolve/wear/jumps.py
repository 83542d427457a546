"""The choice of how many cycles a solved one stands for, from the history of the worn volume.

The error of a jump follows from the rates at its two ends (`fretsolve.wear.rates.owed`). Over the volume that the jump
wears it falls with the second power of the jump, so the next one follows from it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.load_path_spec import WearJumps
from fretsolve.case.unrolled_path import CYCLES_TO_SETTLE, CyclePass
from fretsolve.errors import NotConvergedError
from fretsolve.model.load_path import LoadPath
from fretsolve.result.state import Summary

FIRST_DEPTH, MOST_DEPTH = 0.005, 0.1
"""Depth of the first jump, and the largest of any, over the largest elastic displacement."""

SETTLED = 0.01
"""Change of the dissipated energy from one cycle to the next, or drift within a cycle, up to which it is periodic."""

SHAKEN_DOWN = 0.5
"""Change of the dissipated energy over the tolerance of the wear up to which the first cycle may stand for others."""

FIRST_SHARE = 0.1
"""Part of all cycles that the first jump may have."""

MOST_GROWTH, LEAST_GROWTH = 2.0, 0.3
"""Limits of a jump over the one before it."""

SAFETY = 0.5
"""Part of the tolerance that a jump is chosen for, since its error is known only after it."""


@dataclass(frozen=True)
class SolvedCycle:
    """A solved cycle in a history: the energy that it dissipates, its drift, which is the largest change of a load or
    displacement from its start to its end over their ranges, and the error of the jump before it; then the cycles that
    it stands for and the volume that these wear, 0 as long as the surfaces have not changed for it."""

    energy: float
    drift: float
    error: float
    jump: float = 0.0
    jumped_volume: float = 0.0


@dataclass(frozen=True)
class Progress:
    """A load path and the history so far."""

    path: LoadPath
    history: Sequence[Summary]

    def solved(self, cycle: CyclePass) -> list[SolvedCycle]:
        """Return the last repetitions of a cycle up to this one, with which or with whose jump the history ends."""
        first = max(1, cycle.turn - CYCLES_TO_SETTLE)
        return [self._one(*self.path.steps_of(cycle.cycle, turn)) for turn in range(first, cycle.turn + 1)]

    def jump_before(self, cycle: CyclePass) -> float:
        """Return the cycles that the repetition before this one stood for."""
        return self.history[self.path.steps_of(cycle.cycle, cycle.turn)[0] - 1].jump

    def _one(self, first: int, last: int) -> SolvedCycle:
        history = self.history
        volume, error = (history[first - 1].wear_volume, history[first - 1].wear_error) if first else (0.0, 0.0)
        energy, error = math.fsum(one.work for one in history[first : last + 1]), history[last].wear_error - error
        drift = _drift(history[first - 1 : last + 1]) if first else math.inf
        if len(history) <= last + 1:
            return SolvedCycle(energy, drift, error)
        return SolvedCycle(energy, drift, error, history[last + 1].jump, history[last + 1].wear_volume - volume)


def _drift(rows: Sequence[Summary]) -> float:
    """Return the largest change of a load or displacement from the first to the last row, over the largest range of the
    loads or displacements; moments and rotations likewise. Those that are not known count as none."""
    worst = 0.0
    for kind in (("P", "Qx", "Qy"), ("delta_z", "delta_x", "delta_y"), ("Mx", "My", "Mz"), ("phi_x", "phi_y", "phi_z")):
        values = np.nan_to_num([[getattr(row, name) for name in kind] for row in rows])
        largest = float(np.ptp(values, axis=0).max())
        if largest > 0.0:
            worst = max(worst, float(np.abs(values[-1] - values[0]).max()) / largest)
    return worst


def is_settled(cycles: Sequence[SolvedCycle], tolerance: float) -> bool:
    """Return whether the last cycle, which is not the first, may stand for others.

    As long as the surfaces have their first shape, the energy has to settle within a part of the `tolerance`: slip
    between unlike bodies shakes down from cycle to cycle, which a jump would multiply. Later, and after many cycles,
    the cycle has to end where it begins, or dissipate about what the last one did, since wear changes the energy, too.
    """
    if len(cycles) < 2:
        return False
    before, last = cycles[-2].energy, cycles[-1].energy
    change, largest = abs(last - before), max(before, last)
    if all(one.jump <= 1.0 for one in cycles) and len(cycles) <= CYCLES_TO_SETTLE:
        return change <= SHAKEN_DOWN * tolerance * largest
    return cycles[-1].drift <= SETTLED or change <= SETTLED * largest


def require_periodic(cycles: Sequence[SolvedCycle], tolerance: float) -> None:
    """Raise NotConvergedError where the cycles do not become periodic; tolerance: as for `is_settled`."""
    waited = [not is_settled(cycles[: count + 1], tolerance) for count in range(1, len(cycles))]
    if len(waited) >= CYCLES_TO_SETTLE and all(waited):
        before, last = cycles[-2].energy, cycles[-1].energy
        raise NotConvergedError(
            f"the cycle is not periodic after {len(cycles)} repetitions: from the last one but one to the last its"
            f" dissipated energy changes by {100.0 * abs(last - before) / max(before, last):.2g} %, so that it cannot"
            " stand for others; run it with times and without represents until it is"
        )


def next_jump(
    cycles: Sequence[SolvedCycle], jumps: WearJumps, depth: float, scale: float, left: float, most: float = math.inf
) -> float:
    """Return how many cycles the last of `cycles` is to stand for, at least 1.

    depth: largest depth that it wears; scale: largest elastic displacement (mm); left: the cycles that are left,
    without it; most: those over which friction stays nearly the same.
    """
    if left <= 1.0 or not is_settled(cycles, jumps.tolerance):
        return 1.0
    if jumps.jump is not None:
        return min(jumps.jump, left)
    if depth <= 0.0:
        return min(most, left)
    most = min(most, (jumps.max_depth or MOST_DEPTH * scale) / depth)
    last = max((place for place, one in enumerate(cycles[:-1]) if one.jump > 1.0), default=None)
    if last is None:
        most = min(most, FIRST_DEPTH * scale / depth, FIRST_SHARE * left)
    else:
        before = cycles[last]
        error, allowed = cycles[last + 1].error, jumps.tolerance * before.jumped_volume
        growth = math.sqrt(SAFETY * allowed / error) if error > 0.0 else MOST_GROWTH
        most = min(most, before.jump * min(max(growth, LEAST_GROWTH), MOST_GROWTH))
    return min(max(1.0, float(math.floor(most))), left)
