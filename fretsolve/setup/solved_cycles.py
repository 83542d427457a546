"""Estimate how many of the cycles that stand for others are solved, and so how many increments a run has."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.case.keys.unrolled_path import Stage
from fretsolve.errors import KeyPath
from fretsolve.setup.closed_forms.wear_forms import WornCycle, worn_cycles
from fretsolve.setup.problem_setup import ProblemSetup
from fretsolve.wear.jumps import FIRST_DEPTH, FIRST_SHARE, MOST_GROWTH, SHORTEST_JUMP

DEEPEST = 1.5
"""The deepest place over the mean depth: 1.5 under Hertz's pressure, as in gross slip before it becomes uniform."""

USUAL_CYCLES = 40
"""Solved cycles where no closed form tells of the depth; 13 to 38 measured at a tolerance of 1 %, 125 where
friction runs in."""

TO_SETTLE = 3
"""Solved cycles before the first jump, and one more after it."""

PER_JUMP = 2.0
"""Solved cycles for each jump while jumps grow: one, and one more that looks at it; 1.9 to 2.1 measured in gross slip,
1.8 in partial slip."""

PER_ROOT, PER_ROOT_FROM = 1.5, 10.0
"""Solved cycles times the root of the tolerance, about, and the T of partial slip below which they go with its root: at
T = 0.1, 1 and 10 0.1 to 0.4, 0.3 to 0.6 and 1.5 to 1.7 measured at tolerances of 1e-2 to 3e-5; in gross slip 0.5 to
1.6."""

PER_TOLERANCE = 0.1
"""Solved cycles times the tolerance between unlike bodies, where a jump's error falls with its first power only; 0.09
to 0.16 measured at tolerances of 1e-2 to 1e-3."""

MANY = 300
"""Solved cycles that are most likely not meant."""


@dataclass(frozen=True)
class ManyCycles:
    """A cycle of which very many repetitions are likely to be solved.

    key: of the value that is the cause; expected: about how many; most: how many there may be.
    """

    key: KeyPath
    expected: float
    most: int


def stage_weights(setup: ProblemSetup) -> list[float]:
    """Return for each stage the share of its increments that is likely to be solved, 1 where all are."""
    stages = setup.case.stages()
    most, solved = _repetitions(stages), _solved(setup)
    shares = {key: min(max(counts.values()), float(most[key])) / most[key] for key, counts in solved.items()}
    keys = [None if (one := stage.cycle or stage.wears) is None or one.jumps is None else one.key for stage in stages]
    return [1.0 if key is None else shares[key] for key in keys]


def _repetitions(stages: Iterable[Stage]) -> dict[KeyPath, int]:
    """Return the most repetitions of each cycle that stands for others, by its place in the case file."""
    most: dict[KeyPath, int] = {}
    for stage in stages:
        if stage.wears is not None:
            most[stage.wears.key] = most.get(stage.wears.key, 0) + 1
    return most


def _solved(setup: ProblemSetup) -> dict[KeyPath, dict[str, float]]:
    """Return for each of these cycles about how many repetitions each key that sets the jumps has solved."""
    known = {cycle.key: cycle for cycle in worn_cycles(setup.closed_forms)}
    found: dict[KeyPath, dict[str, float]] = {}
    for stage in setup.case.stages():
        if stage.wears is None or stage.wears.key in found or (jumps := stage.wears.jumps) is None:
            continue
        if jumps.jump is not None:
            found[stage.wears.key] = {"jump": jumps.represents / jumps.jump + TO_SETTLE}
        else:
            counts = _automatic(jumps, known.get(stage.wears.key), setup.model.coupled)
            found[stage.wears.key] = {name: min(count, jumps.represents) for name, count in counts.items()}
    return found


def _automatic(jumps: WearJumps, cycle: WornCycle | None, coupled: bool) -> dict[str, float]:
    """Return about how many cycles are solved where the depth, `tolerance` and `max_depth` set the jumps, by the key.

    cycle: what closed forms say of it, None if they do not; coupled: whether pressure and shear change each other.
    """
    slow = 1.0 if cycle is None or cycle.slides else min(1.0, math.sqrt(cycle.time / PER_ROOT_FROM))
    by_tolerance = PER_TOLERANCE / jumps.tolerance if coupled else slow * PER_ROOT / math.sqrt(jumps.tolerance)
    if cycle is None:
        return {"represents": USUAL_CYCLES, "tolerance": by_tolerance}
    deepest = DEEPEST * cycle.depth_per_cycle
    first = FIRST_DEPTH * cycle.hertz.delta_z / deepest if deepest > 0.0 else math.inf
    first = min(max(first, SHORTEST_JUMP), max(FIRST_SHARE * jumps.represents, 1.0))
    growing = math.log(jumps.represents / first) / math.log(MOST_GROWTH)
    found = {"represents": TO_SETTLE + PER_JUMP * growing, "tolerance": by_tolerance}
    if jumps.max_depth is not None:
        worn = deepest * jumps.represents
        if cycle.limit is not None and cycle.volume_at_first_rate > 0.0:
            worn *= min(1.0, cycle.limit.volume / cycle.volume_at_first_rate)
        found["max_depth"] = found["represents"] + worn / jumps.max_depth
    return found


def many_cycles(setup: ProblemSetup) -> Iterator[ManyCycles]:
    """Yield the cycles of which `tolerance` or `max_depth` have very many solved."""
    most = _repetitions(setup.case.stages())
    for key, counts in _solved(setup).items():
        name = max(counts, key=lambda one: counts[one])
        if counts[name] > MANY and name not in ("jump", "represents"):
            yield ManyCycles((*key, name), counts[name], most[key])
