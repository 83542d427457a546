"""Estimate how many of the cycles that stand for others are solved, and so how many increments a run has."""

from __future__ import annotations

import math
from collections.abc import Iterable

from fretsolve.case.keys.unrolled_path import Stage
from fretsolve.setup.closed_forms.wear_forms import WornCycle, worn_cycles
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.wear.jumps import FIRST_DEPTH, MOST_DEPTH, MOST_GROWTH

DEEPEST = 1.5
"""The deepest place over the mean depth."""

USUAL_CYCLES = 40
"""Solved cycles where no closed form tells of the depth."""

TO_SETTLE = 3
"""Solved cycles before the first jump, and one more after it."""


def stage_weights(setup: ProblemSetup) -> list[float]:
    """Return for each stage the share of its increments that is likely to be solved, 1 where all are."""
    stages = setup.case.stages()
    most = _repetitions(stages)
    solved = {key: min(count, float(most[key])) for key, count in _expected(setup, most).items()}
    keys = [None if (one := stage.cycle or stage.wears) is None or one.jumps is None else one.key for stage in stages]
    return [1.0 if key is None else solved[key] / most[key] for key in keys]


def _repetitions(stages: Iterable[Stage]) -> dict[object, int]:
    """Return the most repetitions of each cycle that stands for others, by its place in the case file."""
    most: dict[object, int] = {}
    for stage in stages:
        if stage.wears is not None:
            most[stage.wears.key] = most.get(stage.wears.key, 0) + 1
    return most


def _expected(setup: ProblemSetup, most: dict[object, int]) -> dict[object, float]:
    """Return about how many repetitions of each of these cycles are solved."""
    stages = setup.case.stages()
    known: dict[object, WornCycle] = {cycle.key: cycle for cycle in worn_cycles(setup.closed_forms)}
    found = {}
    for key in most:
        jumps = next(stage.wears.jumps for stage in stages if stage.wears is not None and stage.wears.key == key)
        assert jumps is not None
        if jumps.jump is not None:
            found[key] = jumps.represents / jumps.jump + TO_SETTLE
        elif (cycle := known.get(key)) is not None:
            found[key] = _automatic(cycle)
        else:
            found[key] = USUAL_CYCLES
    return found


def _automatic(cycle: WornCycle) -> float:
    """Return about how many cycles are solved where the tolerance sets the jumps."""
    deepest = DEEPEST * cycle.depth_per_cycle * cycle.jumps.represents
    if (limit := cycle.likely_limit) is not None and cycle.volume_at_first_rate > 0.0:
        deepest *= min(1.0, limit.volume / cycle.volume_at_first_rate)
    largest = cycle.jumps.max_depth or MOST_DEPTH * cycle.hertz.delta_z
    growing = math.log(MOST_DEPTH / FIRST_DEPTH) / math.log(MOST_GROWTH)
    jumps = min(growing, deepest / (FIRST_DEPTH * cycle.hertz.delta_z)) + deepest / largest
    return TO_SETTLE + jumps
