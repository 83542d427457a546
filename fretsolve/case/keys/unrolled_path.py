"""The load path unrolled: its stages one after another, a cycle's stages as often as the cycle is run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import count, islice
from typing import Any, Literal, NamedTuple

from fretsolve.case.base import refused_at
from fretsolve.case.history import ACTUATORS, COMPONENTS
from fretsolve.case.keys.load_path_spec import MOST_CYCLES, AmplitudeCycle, Cycle, CycleSpec, StageSpec, WearJumps
from fretsolve.case.keys.rig_spec import RigSpec
from fretsolve.case.quantities import refused, shown
from fretsolve.errors import KeyPath

LARGEST_STAGE_COUNT = 100_000

MOST_SOLVED_CYCLES, CYCLES_TO_SETTLE = 1000, 20
"""Most solved cycles that stand for others where they choose their jumps, and how many more there may be where their
jump is given, as the first ones must become periodic."""

MANY_CYCLES = "each cycle is solved, but with wear a few can stand for many: represents in place of times"
"""Advice on a cycle that is repeated very often."""

INITIAL = dict.fromkeys(("P", "phi_x", "phi_y", "Qx", "Qy", "phi_z"), 0.0)
"""The components imposed until a stage names another one of the same mode."""


def imposed_at_start(rig: RigSpec | None) -> dict[str, float]:
    """Return the components imposed before the first stage: what is held is held at the actuator of a rig."""
    gives: frozenset[str] = frozenset() if rig is None else rig.gives
    return {ACTUATORS[name] if name in gives else name: value for name, value in INITIAL.items()}


@dataclass(frozen=True, slots=True)
class CyclePass:
    """One repetition of a cycle that holds no other cycle.

    cycle: which one, counted from 1 along the path; turn: which repetition of the cycle, from 1; until: the tolerance
    with which it is repeated until it is periodic, None if it has a number of repetitions. key: where it stands in the
    file; jumps: how it stands for others under wear, if it does; is_last: whether it is the last one that there may be.
    """

    cycle: int
    turn: int
    until: float | None
    key: KeyPath
    jumps: WearJumps | None = None
    is_last: bool = False


@dataclass(frozen=True, slots=True)
class Stage:
    """A stage of the unrolled load path, numbered from 1.

    key: where it stands in the case file; targets: components with their new totals (mm, N, N mm, rad, MPa);
    increments: None for as many as the case needs; spacing: None for the default. part: within `key`, where
    the components stand; cycle: the repetition of a cycle that it belongs to, if any; outer: which repetition of
    an outermost cycle, counted from 1 along the path, 0 for none. wears: the repetition of a cycle that has ended, for
    whose wear the surfaces change in this stage; it moves no load.
    """

    number: int
    key: KeyPath
    targets: tuple[tuple[str, float], ...]
    increments: int | None
    spacing: Literal["equal", "graded"] | None = None
    part: KeyPath = ()
    cycle: CyclePass | None = None
    outer: int = 0
    wears: CyclePass | None = None

    def place(self, name: str | None) -> KeyPath:
        """Return where a component stands in the case file; the stage itself, if it does not name the component."""
        return (*self.key, *self.part, name) if name is not None and name in dict(self.targets) else self.key


class _Leg(NamedTuple):
    """The way to an end of a cycle that is given by its amplitude: mean + sign * amplitude."""

    cycle: AmplitudeCycle
    sign: float
    parts: int


class _Jump(NamedTuple):
    """The change of the surfaces by wear at the end of a repetition."""

    of: CyclePass | None


class _Repeated(NamedTuple):
    """A cycle, validated or as written. stages: of one repetition; times: the most repetitions.

    until, jumps: see `CyclePass`; legs: of a cycle with an amplitude, the way to its first end, and the two of a
    repetition; wears: whether the surfaces change at the end of a repetition.
    """

    stages: Any
    times: int
    until: float | None
    legs: tuple[Any, Any, Any] | None = None
    wears: bool = False
    jumps: WearJumps | None = None


class _Step(NamedTuple):
    key: KeyPath
    stage: Any
    cycle: CyclePass | None
    outer: int = 0


@lru_cache(maxsize=2)
def unrolled(load_path: tuple[StageSpec | CycleSpec, ...]) -> tuple[Stage, ...]:
    """Return the stages in the order in which they are run.

    They are kept, since cycles that stand for others may have many thousands, which are asked for again and again.
    """
    known, keys, found = dict[int, tuple[Any, tuple[Any, ...]]](), dict[KeyPath, KeyPath](), list[Stage]()
    for number, (key, spec, cycle, outer) in enumerate(_walk(load_path, ("load_path",)), start=1):
        place = keys.setdefault(key, key)  # repetitions share what they have in common
        if id(spec) not in known:
            known[id(spec)] = spec, _moved(spec)  # the spec is kept, so that no other one takes its id
        wears, (targets, increments, spacing, part) = getattr(spec, "of", None), known[id(spec)][1]
        found.append(Stage(number, place, targets, increments, spacing, part, cycle, outer, wears))
    return tuple(found)


def _moved(spec: Any) -> tuple[Any, ...]:
    """Return targets, increments, spacing and part of a stage."""
    if isinstance(spec, _Jump):
        return (), 1, "equal", ()
    if isinstance(spec, _Leg):
        return spec.cycle.targets(spec.sign), spec.cycle.count(spec.parts), spec.cycle.spacing, ("amplitude",)
    return spec.targets, spec.increments, spec.spacing, ()


def last_repetitions(stages: Iterable[Stage]) -> dict[tuple[object, ...], int]:
    """Return the numbers of the stages by their place in the case file; a repeated stage counts by its last repetition.

    Changes of the surfaces by wear are no stages. Both ends of a cycle with an amplitude stand at one place.
    """
    found: dict[tuple[object, ...], int] = {}
    for stage in stages:
        if stage.wears is None:
            loads = tuple(target for target in stage.targets if target[0] != "friction")  # which cycles may change
            found[stage.key, loads, stage.cycle is None] = stage.number
    return found


def imposed_after(before: dict[str, float], stage: Stage) -> dict[str, float]:
    """Return what is imposed at the end of a stage."""
    named = dict(stage.targets)
    replaced = {name for names in COMPONENTS if named.keys() & set(names) for name in names}
    return {name: value for name, value in before.items() if name not in replaced} | named


def stage_friction(load_path: Sequence[StageSpec | CycleSpec]) -> tuple[float, ...]:
    """Return the coefficients of friction that stages of a load path set, each once."""
    found: list[float] = []
    for step in load_path:
        if isinstance(step, StageSpec):
            found += [] if step.friction is None else [step.friction]
        elif isinstance(step.cycle, Cycle):
            found += stage_friction(step.cycle.stages)
    return tuple(dict.fromkeys(found))


def with_cycle_friction(stages: Sequence[Stage], coefficient: Callable[[int], float]) -> Iterator[Stage]:
    """Yield the stages with the coefficient of friction of their cycles among the targets.

    Cycles are counted over the path from 1; a stage outside of cycles belongs to the cycle before, else to the first.
    """
    number = 1
    for stage in stages:
        number = stage.outer or number
        yield replace(stage, targets=(*stage.targets, ("friction", coefficient(number))))


def bulk_keys(load_path: Sequence[StageSpec | CycleSpec]) -> tuple[KeyPath, ...]:
    """Return where bulk stresses stand in a load path, as (0, "bulk_2")."""
    found = []
    for key, stage, *_ in _walk(load_path, ()):
        if isinstance(stage, _Jump):
            continue
        of_amplitude = isinstance(stage, _Leg)
        holder, part = (stage.cycle.amplitude, ("amplitude",)) if of_amplitude else (stage, ())
        found += [(*key, *part, name) for name in ("bulk_1", "bulk_2") if getattr(holder, name) is not None]
    return tuple(dict.fromkeys(found))


def stage_count(load_path: Any) -> int:
    """Return the number of stages of a load path, validated or as written in the file."""
    return _count(load_path, _reserve(load_path))


def _count(steps: Any, reserve: int) -> int:
    found = 0
    for step in steps if isinstance(steps, list | tuple) else ():
        if (cycle := _repeated(step, reserve)) is None:
            found += 1
            continue
        of_one = (2 if cycle.legs else _count(cycle.stages, reserve)) + cycle.wears
        found += (1 if cycle.legs else 0) + of_one * cycle.times
    return found


def _reserve(load_path: Any) -> int:
    """Return the most solved cycles of each cycle that stands for others and chooses its jumps.

    Where a path has many such cycles, or repeats them in blocks: 4000 in all together, at least 100 in each.
    """
    return min(MOST_SOLVED_CYCLES, max(100, 4_000 // max(1, _wearing(load_path))))


def _wearing(steps: Any) -> int:
    """Return how often a path comes to a cycle that stands for others."""
    cycles = [_repeated(step) for step in (steps if isinstance(steps, list | tuple) else ())]
    return sum(1 if one.wears else one.times * _wearing(one.stages) for one in cycles if one is not None)


def stage_key(load_path: Any, number: str | int) -> KeyPath:
    """Return where stage `number` (from 1, cycles unrolled) stands in a load path as written. Raises LookupError."""
    count = stage_count(load_path)
    if not isinstance(number, int) or not 1 <= number <= min(count, LARGEST_STAGE_COUNT):
        raise LookupError(f"the load path has no stage {shown(number)}; its stages are 1 to {count}")
    return next(islice(_walk(load_path, ("load_path",)), number - 1, None)).key


def typed_key(load_path: Any, key: KeyPath) -> KeyPath:
    """Return a key as it is typed: what stands in a stage by the number of its first run, as ``("stage", 3, "Qx")``.

    load_path: as written, in which `stage_key` is the way back. What belongs to no stage, as the number of repetitions
    of a cycle, keeps its key.
    """
    number, steps, rest = 1, load_path, key[1:] if key[:1] == ("load_path",) else ()
    reserve = _reserve(load_path)
    while rest and isinstance(steps, list | tuple):
        index = rest[0]
        if not isinstance(index, int) or index >= len(steps):
            break
        number += _count(steps[:index], reserve)
        cycle = _repeated(steps[index], reserve)
        if number > LARGEST_STAGE_COUNT:
            break
        if cycle is None or (cycle.legs and rest[1:] in (("cycle", "increments"), ("cycle", "spacing"))):
            return ("stage", number, *rest[1 if cycle is None else 2 :])
        if cycle.legs or rest[1:3] != ("cycle", "stages"):
            break
        steps, rest = cycle.stages, rest[3:]
    return key


def stage_keys(load_path: Any) -> tuple[KeyPath, ...]:
    """Return where the stages stand in a load path as written, each place once."""
    if stage_count(load_path) > LARGEST_STAGE_COUNT:
        return ()
    return tuple(dict.fromkeys(step.key for step in _walk(load_path, ("load_path",))))


def _walk(steps: Any, parent: KeyPath, numbers: Iterator[int] | None = None, reserve: int = 0) -> Iterator[_Step]:
    """Yield each stage in turn with its place, from steps that are validated or as written.

    numbers: of the cycles that hold no other cycle; None for the outermost steps; reserve: by `_reserve`, found for the
    outermost steps.
    """
    outermost, passes = numbers is None, 0
    numbers, reserve = numbers or count(1), reserve or _reserve(steps)
    for index, step in enumerate(steps if isinstance(steps, list | tuple) else ()):
        key, cycle = (*parent, index), _repeated(step, reserve)
        if cycle is None:
            yield _Step(key, step, None)
            continue
        inside = (*key, "cycle")
        nested = any(_repeated(one) is not None for one in cycle.stages or ()) if cycle.legs is None else False
        number = 0 if nested else next(numbers)
        if cycle.legs is not None:
            yield _Step(inside, cycle.legs[0], None, passes + 1 if outermost else 0)
        for turn in range(1, (cycle.times if cycle.stages or cycle.legs else 0) + 1):
            last = cycle.wears and turn == cycle.times
            run = None if nested else CyclePass(number, turn, cycle.until, inside, cycle.jumps, last)
            passes += 1
            if cycle.legs is not None:
                steps_of_it = iter([_Step(inside, leg, run) for leg in cycle.legs[1:]])
            else:
                steps_of_it = _walk(cycle.stages, (*inside, "stages"), numbers, reserve)
            for one in steps_of_it:
                yield one._replace(cycle=one.cycle if nested else run, outer=passes if outermost else 0)
            if cycle.wears:
                yield _Step(inside, _Jump(run), None, passes if outermost else 0)


def _repeated(step: Any, reserve: int = MOST_SOLVED_CYCLES) -> _Repeated | None:
    """Return what a cycle repeats; None for a stage. reserve: as for `_walk`."""
    if isinstance(step, CycleSpec):
        jumps, until = step.cycle.jumps, step.cycle.tolerance if step.cycle.until else None
        times = step.cycle.most if jumps is None else _solved_cycles(jumps.represents, jumps.jump, reserve)
        if isinstance(step.cycle, AmplitudeCycle):
            legs = _Leg(step.cycle, 1.0, 4), _Leg(step.cycle, -1.0, 2), _Leg(step.cycle, 1.0, 2)
            return _Repeated((), times, until, legs, jumps is not None, jumps)
        return _Repeated(step.cycle.stages, times, until, None, jumps is not None, jumps)
    cycle = step.get("cycle") if isinstance(step, dict) else None
    if not isinstance(cycle, dict):
        return None
    given = cycle.get("at_most", MOST_CYCLES) if "until" in cycle else cycle.get("times")
    if wears := "represents" in cycle:
        given = _solved_cycles(cycle["represents"], cycle.get("jump", "auto"), reserve)
    times = given if isinstance(given, int) and given > 0 else 1
    stages = cycle.get("stages")
    if "amplitude" in cycle:
        return _Repeated((), times, None, (cycle, cycle, cycle), wears)
    return _Repeated(stages if isinstance(stages, list | tuple) else (), times, None, None, wears)


def _solved_cycles(represents: Any, jump: Any, reserve: int) -> int:
    """Return how many solved cycles there are at most, of a cycle that stands for others, validated or as written."""
    values = [_as_number(represents), _as_number(jump)]
    if values[0] is None:
        return 1
    needed = reserve if values[1] is None else 3.0 * values[0] / values[1] + CYCLES_TO_SETTLE
    return max(1, math.ceil(min(values[0], needed)))


def _as_number(value: Any) -> float | None:
    """Return a number of cycles, None for auto and for what is not one."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return None
    return number if 0.0 < number < math.inf else None


def check_load_path(load_path: tuple[StageSpec | CycleSpec, ...]) -> tuple[StageSpec | CycleSpec, ...]:
    """Refuse a path that is too long to unroll, or whose first stage presses nothing together."""
    if (count := stage_count(load_path)) > LARGEST_STAGE_COUNT:
        jumps = [step.cycle.jumps for step in load_path if isinstance(step, CycleSpec)]
        given, advice = max((one.represents / one.jump for one in jumps if one and one.jump), default=0.0), ""
        if given >= MOST_SOLVED_CYCLES:
            advice = f"; {given:.3g} jumps are too many, give a larger jump, or jump: auto"
        elif any(isinstance(step, CycleSpec) and (step.cycle.times or 0) > MOST_SOLVED_CYCLES for step in load_path):
            advice = f"; {MANY_CYCLES}"
        raise refused(f"the load path unrolls to {count} stages; at most {LARGEST_STAGE_COUNT} are possible{advice}")
    first = next(_walk(load_path, ()))
    if not set(COMPONENTS[0]) & dict(_moved(first.stage)[0]).keys():
        refused_at([(first.key, "the first stage presses nothing together; P or delta_z is needed in it")])
    return load_path
