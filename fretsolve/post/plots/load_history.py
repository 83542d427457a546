"""Find in a result what its load path moves, where it turns back, and its cycles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.case.history import BULK, COMPONENTS, PAIRS
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
        driven = {stage.number: name for stage in stages for name, _ in stage.targets if name in names}
        if case is None:
            driven = dict.fromkeys(result.history["stage"].tolist(), force)
        if driven and relevant.intersection(names):
            found.append(MovedPair(force, driven, motion, actuator if actuator in relevant else ""))
    return found


def moved_bulk(result: Result) -> list[MovedLoad]:
    """Return the bulk stresses that the load path moves."""
    case, relevant = result.case, relevant_columns(result)
    found = []
    for name in (*BULK[1], *BULK[2]):
        stages = [stage.number for stage in case.stages() if name in dict(stage.targets)] if case is not None else []
        if stages and name in relevant:
            found.append(MovedLoad(name, dict.fromkeys(stages, name)))
    return found


def cycles(result: Result, moved: MovedLoad) -> list[LoadCycle]:
    """Return the first loading and the cycles after it, cut at every second turning point of the load of `moved`."""
    turns = _turning_points(result, moved)
    found = [LoadCycle(0, turns[0], turns[1], closed=False)]
    for number, start in enumerate(range(1, len(turns) - 1, 2), start=1):
        points = turns[start : start + 3]
        loads = result.history[moved.last_driven][points]
        closed = len(points) == 3 and bool(abs(loads[2] - loads[0]) <= 0.01 * abs(loads[0] - loads[1]))
        found.append(LoadCycle(number, points[0], points[-1], closed))
    return found


def chosen_stage_ends(result: Result) -> list[int]:
    """Return the increments with fields at the ends of stages, and the last one; of many the first and last few."""
    require_increments(result)
    ends = [int(step) for step in stage_ends(result.history["stage"]) if int(step) in result.steps]
    if result.steps and result.steps[-1] not in ends:
        ends.append(result.steps[-1])
    # of a long path: pressed, first loaded, and the last cycle
    return list(map(int, first_and_last(np.array(ends, int), most=6, first=2)))


def load_text(result: Result, step: int, *, plain: bool = False) -> str:
    """Return the loads at an increment, such as ``$P$ = 400 N, $Q_x$ = 36 N``; plain: with names for symbols.

    Bulk stresses stand last.
    """
    stage = int(result.history["stage"][step])
    texts = []
    pairs = sorted(moved_pairs(result), key=lambda pair: (pair.force, pair.motion) not in PAIRS[:3])
    for moved in (*pairs, *moved_bulk(result)):
        before = [number for number in moved.driven if number <= stage]
        if before:
            name = moved.driven[max(before)]
            unit = unit_of(result, name)
            column = result.history[name] * unit.factor
            texts.append(
                f"{name if plain else symbol(name)} = {short_number(column[step], np.abs(column).max())} {unit.text}"
            )
    text = ", ".join(texts)
    return text if plain else text.replace("-", "\N{MINUS SIGN}")  # as on the axes


def step_text(result: Result, step: int, *, plain: bool = False) -> str:
    """Return an increment with its stage and its loads; plain: see `load_text`."""
    cycles = f", {result.history['cycles'][step]:.4g} cycles" if "cycles" in result.history else ""
    return f"increment {step} (stage {result.history['stage'][step]}{cycles}): {load_text(result, step, plain=plain)}"


def _turning_points(result: Result, moved: MovedLoad) -> list[int]:
    """Return the first increment, the increments after which the driven component turns back, and the last one."""
    ends = stage_ends(result.history["stage"]).tolist()
    found, sense = [0], 0
    for before, end in zip([None, *ends], ends, strict=False):
        name = moved.driven.get(int(result.history["stage"][end]))
        if name is None:
            continue
        column = result.history[name]
        change = float(column[end] - (column[before] if before is not None else 0.0))
        now = int(np.sign(change)) if abs(change) > 1e-9 * float(np.abs(column).max()) else 0  # not round-off
        if now and sense and now != sense and before is not None:
            found.append(before)
        sense = now or sense
    return [*found, ends[-1]]
