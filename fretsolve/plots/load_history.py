"""The load path as a result has it: what it moves, where it turns back, and its cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretsolve.case.load_components import PAIRS
from fretsolve.errors import PictureError
from fretsolve.export.text_report import relevant_columns, stage_ends
from fretsolve.plots.quantities import short_number, unit_of
from fretsolve.result.stored_case import stored_case

if TYPE_CHECKING:
    from fretsolve.result import Result

FIRST_ENDS, LAST_ENDS = 2, 4
"""Ends of stages that stand for a long path: pressed, first loaded, and the last cycle."""

CLOSED = 0.01
"""A cycle is closed where it ends this near to its start, in parts of its range."""


@dataclass(frozen=True)
class MovedPair:
    """A force and its displacement, and which of both each stage (1-based) moves; absent where it moves neither."""

    force: str
    motion: str
    driven: dict[int, str]


@dataclass(frozen=True)
class Cycle:
    """Increments `first` to `last` between two turning points in the same sense; number 0 is the first loading.

    closed: it comes back to where it began, so that its loop encloses the work.
    """

    number: int
    first: int
    last: int
    closed: bool

    @property
    def steps(self) -> slice:
        """Its increments in the history, both turning points included."""
        return slice(self.first, self.last + 1)

    @property
    def name(self) -> str:
        """For a legend."""
        return f"cycle {self.number}" if self.number else "first loading"


def require_increments(result: Result) -> None:
    """Raise PictureError where the run has not saved one yet."""
    if not result.increments:
        raise PictureError(result.why_empty)


def moved_pairs(result: Result) -> list[MovedPair]:
    """The pairs that the load path moves by more than round-off, tangential ones first."""
    case = stored_case(result)
    stages = case.stages() if case is not None else ()
    relevant = set(relevant_columns(result))
    found = []
    for force, motion in (*PAIRS[3:], *PAIRS[:3]):
        driven = {
            stage.number: name for stage in stages for name, _ in stage.targets if name in (force, motion)
        }
        if case is None:
            driven = dict.fromkeys(result.history["stage"].tolist(), force)
        if driven and relevant & {force, motion}:
            found.append(MovedPair(force, motion, driven))
    return found


def cycles(result: Result, pair: MovedPair) -> list[Cycle]:
    """The first loading and the cycles after it, cut where the load of `pair` turns back for every second time."""
    turns = _turning_points(result, pair)
    found = [Cycle(0, turns[0], turns[1], closed=False)]
    for number, start in enumerate(range(1, len(turns) - 1, 2), start=1):
        points = turns[start : start + 3]
        found.append(Cycle(number, points[0], points[-1], closed=_is_closed(result, pair, points)))
    return found


def last_driven(pair: MovedPair) -> str:
    """The component of `pair` that the path moves, by its last stage that does."""
    return pair.driven[max(pair.driven)]


def chosen_stage_ends(result: Result) -> list[int]:
    """Increments with fields at the ends of stages, the last one included; of many the first and the last few."""
    require_increments(result)
    ends = [int(step) for step in stage_ends(result.history["stage"]) if int(step) in result.steps]
    if result.steps and result.steps[-1] not in ends:
        ends.append(result.steps[-1])
    return ends if len(ends) <= FIRST_ENDS + LAST_ENDS else ends[:FIRST_ENDS] + ends[-LAST_ENDS:]


def load_text(result: Result, step: int) -> str:
    """The loads at an increment, such as ``P = 400 N, Qx = 36 N``."""
    stage = int(result.history["stage"][step])
    texts = []
    for pair in sorted(moved_pairs(result), key=lambda moved: (moved.force, moved.motion) not in PAIRS[:3]):
        before = [number for number in pair.driven if number <= stage]
        if before:
            name = pair.driven[max(before)]
            unit = unit_of(result, name)
            column = result.history[name] * unit.factor
            texts.append(f"{name} = {short_number(column[step], np.abs(column).max())} {unit.text}")
    return ", ".join(texts)


def step_text(result: Result, step: int) -> str:
    """An increment with its stage and its loads."""
    return f"increment {step} (stage {result.history['stage'][step]}): {load_text(result, step)}"


def _turning_points(result: Result, pair: MovedPair) -> list[int]:
    """The first increment, those where the driven component turns back, and the last one."""
    ends = stage_ends(result.history["stage"]).tolist()
    found, sense = [0], 0
    for before, end in zip([None, *ends], ends, strict=False):
        name = pair.driven.get(int(result.history["stage"][end]))
        if name is None:
            continue
        column = result.history[name]
        change = float(column[end] - (column[before] if before is not None else 0.0))
        now = int(np.sign(change)) if abs(change) > 1e-9 * float(np.abs(column).max()) else 0
        if now and sense and now != sense and before is not None:
            found.append(before)
        sense = now or sense
    return [*found, ends[-1]]


def _is_closed(result: Result, pair: MovedPair, points: list[int]) -> bool:
    if len(points) < 3:
        return False
    column = result.history[last_driven(pair)]
    there, turned, back = (float(column[point]) for point in points)
    return abs(back - there) <= CLOSED * abs(there - turned)
