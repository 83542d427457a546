"""Find the cycles of a load path in a history, and estimate how far the last one is from the limit of all.

A cycle is one repetition of an innermost `cycle` of the load path.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.history import PAIRS
from fretsolve.result.layout import has_cycles
from fretsolve.result.verdict import LEAST_MOTION_SCALE

if TYPE_CHECKING:  # pydantic, which the case needs, takes long to load
    from fretsolve.case.keys.unrolled_path import Stage

History = Mapping[str, NDArray[Any]]

CHANGE_COLUMNS = ("stage", "contact_radius", "work_total", *(name for pair in PAIRS for name in pair))
"""Columns that `distance_to_limit` needs."""

ENERGY = "dissipated energy"
"""The name of the energy among the changes."""

MOST_CHANGES = 100.0
"""Largest distance to the limit over the last change. It holds where one change alone is known, and where two are the
noise of the solver, whose ratio says nothing."""


@dataclass(frozen=True)
class CycleSteps:
    """A cycle in a history: from the increment `first` (-1: the start) to `last`.

    number: of the cycles in the history, from 1; run: which `cycle` of the load path, from 1; turn: which repetition of
    it; until: the tolerance of one that runs until it is periodic, and most: its most repetitions. moved: components
    that its stages name; key: where it stands in the case.
    """

    number: int
    first: int
    last: int
    run: int
    turn: int
    until: float | None
    moved: frozenset[str]
    key: str
    most: int


@dataclass(frozen=True)
class LimitDistance:
    """The estimated distance of a cycle from the limit of its repetitions.

    energy: distance of the dissipated energy, over itself; value: distance of the value at the end that is farthest,
    `name`, over the range of its kind in the cycle.
    """

    energy: float
    value: float
    name: str

    @property
    def largest(self) -> float:
        """The larger one of both."""
        return max(self.energy, self.value)


def stages_of(effective_case: Mapping[str, Any]) -> tuple[Stage, ...]:
    """Return the stages of a case, none if it has no cycle or is not understood."""
    if not has_cycles(effective_case):
        return ()
    from fretsolve.case.loading import stored_case

    case = stored_case(effective_case)
    return () if case is None else case.stages()


def cycles_in(stages: Sequence[Stage], stage_column: NDArray[Any], *, ended: bool = True) -> list[CycleSteps]:
    """Return the cycles that a history holds whole. ended: whether its last stage has ended."""
    ends = np.flatnonzero(np.append(np.diff(stage_column) != 0, ended))[: len(stage_column)]
    last_of = dict(zip(stage_column[ends].tolist(), ends.tolist(), strict=True))
    first_of = dict(zip(*np.unique(stage_column, return_index=True), strict=True)) if len(stage_column) else {}
    members: dict[tuple[int, int], list[Stage]] = {}
    most: dict[int, int] = {}
    for stage in stages:
        if stage.cycle is not None:
            members.setdefault((stage.cycle.cycle, stage.cycle.turn), []).append(stage)
            most[stage.cycle.cycle] = stage.cycle.turn
    found: list[CycleSteps] = []
    for (run, turn), inside in members.items():
        if all(stage.number in last_of for stage in inside):
            one = inside[0].cycle
            assert one is not None  # see above
            moved = frozenset(name for stage in inside for name, _ in stage.targets if name != "friction")
            first, last = int(first_of[inside[0].number]) - 1, last_of[inside[-1].number]
            key = ".".join(map(str, one.key))
            found.append(CycleSteps(len(found) + 1, first, last, run, turn, one.until, moved, key, most[run]))
    return found


def distance_to_limit(history: History, cycles: Sequence[CycleSteps]) -> LimitDistance:
    """Return how far the last of `cycles`, two or three in a row, is from the limit of all repetitions.

    The changes d from cycle to cycle are taken to die out as a power of the number k of cycles, or faster. With the
    ratio r of the last two, what all later cycles change is then at most d/(1 - r - 1/k) (Raabe's test of a series).
    history: has `CHANGE_COLUMNS`.
    """
    scales = _scales(history, cycles[-1])
    changes = [_changes(history, before, now, scales) for before, now in pairwise(cycles)]
    left = {name: _left([one[name] for one in changes], cycles[-1].turn) for name in changes[-1]}
    energy = left.pop(ENERGY)
    worst = max(left, key=left.__getitem__, default="P")
    return LimitDistance(energy, left.get(worst, 0.0), worst)


def _left(changes: Sequence[float], turn: int) -> float:
    """Return what is left to the limit after the last of one or two changes, that to the repetition `turn`.

    The larger change counts: the last one may be small because a value turns there.
    """
    if len(changes) < 2 or changes[0] == 0.0:
        return MOST_CHANGES * changes[-1]
    falling = 1.0 - changes[1] / changes[0] - 1.0 / turn
    return max(changes) * (min(MOST_CHANGES, 1.0 / falling) if falling > 0.0 else MOST_CHANGES)


def _changes(history: History, before: CycleSteps, now: CycleSteps, scales: Mapping[str, float]) -> dict[str, float]:
    """Return the changes from one cycle to the next: of the energy over itself, of values at the end over `scales`."""
    energies = [change_within(history["work_total"], one) for one in (before, now)]
    largest = max(map(abs, energies))
    found = {ENERGY: abs(energies[1] - energies[0]) / largest if largest else 0.0}
    for name, scale in scales.items():
        found[name] = float(np.nan_to_num(abs(history[name][now.last] - history[name][before.last]))) / scale
    return found


def _scales(history: History, cycle: CycleSteps) -> dict[str, float]:
    """Return the ranges in a cycle over which loads and displacements at its end are measured, those above 0."""
    rows = slice(max(cycle.first, 0), cycle.last + 1)

    def span(*names: str) -> float:
        return max(float(np.nan_to_num(np.ptp(history[name][rows]))) for name in names)

    radius, force, approach = (
        float(np.nan_to_num(abs(history[n][rows]).max())) for n in ("contact_radius", "P", "delta_z")
    )
    shear = max(span("Qx", "Qy"), span("Mz") / radius if radius else 0.0, LEAST_MOTION_SCALE * force)
    motion = max(span("delta_x", "delta_y"), span("phi_z") * radius, LEAST_MOTION_SCALE * approach)
    scales = {"P": force, "Mx": force * radius, "My": force * radius, "Qx": shear, "Qy": shear, "Mz": shear * radius}
    scales |= dict.fromkeys(("delta_z", "delta_x", "delta_y"), motion)
    scales |= dict.fromkeys(("phi_x", "phi_y", "phi_z"), motion / radius if radius else 0.0)
    return {name: scale for name, scale in scales.items() if scale > 0.0}


def change_within(column: NDArray[Any], cycle: CycleSteps) -> float:
    """Return the value of a column at the end of a cycle less that at its beginning."""
    return float(column[cycle.last]) - (float(column[cycle.first]) if cycle.first >= 0 else 0.0)
