"""Find in a result what its load path moves, where it turns back, and its cycles."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import COMPONENTS, PAIRS
from fretsolve.post.export.selection import first_and_last, relevant_columns
from fretsolve.post.plots.labels import short_number, symbol, unit_of
from fretsolve.post.plots.snapshot import require_increments
from fretsolve.result import Result
from fretsolve.result.state import stage_ends


@dataclass(frozen=True)
class MovedLoad:
    """A load that the path moves, such as a bulk stress. driven: its column that each stage (1-based) moves."""

    force: str
    driven: dict[int, str]

    @property
    def last_driven(self) -> str:
        """The column that the last of these stages moves."""
        return self.driven[max(self.driven)]


@dataclass(frozen=True)
class MovedPair(MovedLoad):
    """A force and its displacement; a stage may move either or neither of them.

    actuator: the displacement of the actuator where a rig gives, or empty.
    """

    motion: str
    actuator: str = ""


@dataclass(frozen=True)
class LoadCycle:
    """Increments `first` to `last`, from a turning point to the next one in the same sense.

    number: 0 for the first loading. closed: it ends within 1 % of its range from where it began, so that its loop
    encloses the dissipated energy.
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
        """Its name in a legend."""
        return f"cycle {self.number}" if self.number else "first loading"


def moved_pairs(result: Result) -> list[MovedPair]:
    """Return the pairs that the load path moves by more than round-off, tangential ones first."""
    case = result.case
    stages = case.stages() if case is not None else ()
    relevant = set(relevant_columns(result))
    found = []
    for names in (*COMPONENTS[3:], *COMPONENTS[:3]):
        force, motion, actuator = names
        if not relevant.intersection(names):
            continue
        driven = {stage.number: name for stage in stages for name, _ in stage.targets if name in names}
        if case is None:
            driven = dict.fromkeys(result.history["stage"].tolist(), force)
        if driven:
            found.append(MovedPair(force, driven, motion, actuator if actuator in relevant else ""))
    return found


def moved_bulk(result: Result) -> list[MovedLoad]:
    """Return the bulk stresses that the load path moves."""
    stages_of_case = () if result.case is None else result.case.stages()
    found = []
    for name in (one for one in relevant_columns(result) if one.startswith("bulk_")):
        stages = [stage.number for stage in stages_of_case if name in dict(stage.targets)]
        if stages:
            found.append(MovedLoad(name, dict.fromkeys(stages, name)))
    return found


def cycles(result: Result, moved: MovedLoad) -> list[LoadCycle]:
    """Return the first loading and the cycles after it, cut at every second turning point of the load of `moved`."""
    turns = _turning_points(result, moved)
    found, column = [LoadCycle(0, turns[0], turns[1], closed=False)], result.history[moved.last_driven]
    for number, start in enumerate(range(1, len(turns) - 1, 2), start=1):
        points = turns[start : start + 3]
        loads = column[points]
        closed = len(points) == 3 and bool(abs(loads[2] - loads[0]) <= 0.01 * abs(loads[0] - loads[1]))
        found.append(LoadCycle(number, points[0], points[-1], closed))
    return found


def stored_stage_ends(result: Result) -> list[int]:
    """Return the increments with fields at the ends of stages, and the last one."""
    require_increments(result)
    ends = [step for step in stage_ends(result.history["stage"]).tolist() if step in result.steps]
    return ends if not result.steps or result.steps[-1] in ends else [*ends, result.steps[-1]]


def chosen_stage_ends(result: Result) -> list[int]:
    """Return `stored_stage_ends`, of many the first and last few."""
    # of a long path: pressed, first loaded, and the last cycle
    return list(map(int, first_and_last(np.array(stored_stage_ends(result), int), most=6, first=2)))


def load_texts(result: Result, steps: Sequence[int], *, plain: bool = False) -> list[str]:
    """Return the loads at each of some increments, such as ``$P$ = 400 N, $Q_x$ = 36 N``; plain: names for symbols.

    Bulk stresses stand last.
    """
    pairs = sorted(moved_pairs(result), key=lambda pair: (pair.force, pair.motion) not in PAIRS[:3])
    texts: list[list[str]] = [[] for _ in steps]
    for moved in (*pairs, *moved_bulk(result)):
        stages, columns = sorted(moved.driven), {}
        for step, found in zip(steps, texts, strict=True):
            before = bisect_right(stages, int(result.history["stage"][step]))
            if not before:
                continue
            name = moved.driven[stages[before - 1]]
            if name not in columns:
                unit = unit_of(result, name)
                column = result.history[name] * unit.factor
                columns[name] = unit.text, column, np.abs(column).max()
            units, column, largest = columns[name]
            found.append(f"{name if plain else symbol(name)} = {short_number(column[step], largest)} {units}")
    joined = map(", ".join, texts)
    return list(joined) if plain else [text.replace("-", "\N{MINUS SIGN}") for text in joined]  # as on the axes


def step_texts(result: Result, steps: Sequence[int], *, plain: bool = False) -> list[str]:
    """Return each of some increments with its stage and its loads; plain: see `load_texts`."""
    found = []
    for step, loads in zip(steps, load_texts(result, steps, plain=plain), strict=True):
        cycles = f", {result.history['cycles'][step]:.4g} cycles" if "cycles" in result.history else ""
        found.append(f"increment {step} (stage {result.history['stage'][step]}{cycles}): {loads}")
    return found


def _turning_points(result: Result, moved: MovedLoad) -> list[int]:
    """Return the first increment, the increments after which the driven component turns back, and the last one."""
    ends = stage_ends(result.history["stage"])
    stages = result.history["stage"][ends].tolist()
    names = [moved.driven.get(stage) for stage in stages]
    # The change in each stage, for each component that some stage drives.
    changes = {}
    for one in {one for one in names if one is not None}:
        column = result.history[one]
        change = np.diff(column[ends], prepend=0.0)
        changes[one] = np.where(np.abs(change) > 1e-9 * float(np.abs(column).max()), np.sign(change), 0.0).tolist()
    found, sense = [0], 0.0
    for place, name in enumerate(names):
        if name is None:
            continue
        now = changes[name][place]  # 0 for round-off
        if now and sense and now != sense and place:
            found.append(int(ends[place - 1]))
        sense = now or sense
    return [*found, int(ends[-1])]
