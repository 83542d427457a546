"""The cycles of a load path over which stresses are looked at, and for how many cycles of a service each one stands.

A cycle is a row of the table of cycles that `fretsolve show` prints. Without a `cycle` in the load path the whole path
counts as one. Miner's rule adds the damage of the chosen cycles, each as often as it occurs.
"""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.source import read_text
from fretsolve.errors import CaseError
from fretsolve.result import Result
from fretsolve.result.cycles.loops import cycles_in
from fretsolve.result.state import stage_ends
from fretsolve.system.arrays import DoubleArray

if TYPE_CHECKING:
    from fretsolve.case.keys.unrolled_path import Stage

CycleChoice = Literal["last", "all"] | int | Mapping[int, float]
"""The last cycle, each cycle (with wear as often as it stands for), one by its number from 1, or a block: numbers with
how often each cycle occurs."""


@dataclass(frozen=True)
class LoadCycle:
    """A cycle in a history of states.

    number: from 1, 0 for a whole path without cycles; states: of the history, the state with which the cycle begins and
    the states of its increments; ends: states in which loads may turn; times: how often the cycle occurs in a block.
    from_rest: whether it begins unloaded, which no state of the history is; ended: False if the history ends before it.
    """

    number: int
    states: tuple[int, ...]
    ends: tuple[int, ...]
    times: float = 1.0
    from_rest: bool = False
    ended: bool = True

    @property
    def title(self) -> str:
        """The cycle in words."""
        return f"cycle {self.number}" if self.number else "the whole load path"

    def with_rest(self, values: DoubleArray, axis: int = 0) -> DoubleArray:
        """Return values over the states along `axis`, with 0 before the first one if the cycle begins unloaded."""
        return np.insert(values, 0, 0.0, axis) if self.from_rest else values

    def of(self, values: DoubleArray, axis: int = 0) -> DoubleArray:
        """Return values of a history, whose states lie along `axis`, in the states of the cycle, with 0 at rest."""
        return self.with_rest(np.take(values, self.states, axis), axis)


def load_cycles(stages: Sequence[Stage], column: NDArray[Any], *, ended: bool = True) -> list[LoadCycle]:
    """Return the cycles that a history holds whole, or its whole path as the only cycle if the path has no cycle.

    stages: of the load path; column: the stage of each state of the history; ended: whether its last stage has ended.

    A cycle begins with the state before it, at the start of the path unloaded. It begins with its own end where wear
    has changed the surfaces before it: cells that have come into contact by this carry no shear before they have
    slipped once, but do whenever the cycle begins again.
    """
    if all(stage.cycle is None for stage in stages):
        states = tuple(range(len(column)))
        return [LoadCycle(0, states, tuple(stage_ends(column).tolist()), from_rest=True, ended=ended)]
    stage_end = stage_ends(column)
    found = []
    for one in cycles_in(stages, column, ended=ended):
        inside = range(one.first + 1, one.last + 1)
        before = int(column[inside[0]]) - 2  # the stage before the cycle, in `stages`
        begin = one.last if before >= 0 and stages[before].wears is not None else one.first
        turns = tuple(stage_end[slice(*np.searchsorted(stage_end, (inside.start, inside.stop)))].tolist())
        states = (*([begin] if begin >= 0 else []), *inside)
        ends = (*([one.first] if 0 <= begin < one.last else []), *turns)
        found.append(LoadCycle(one.number, states, ends, from_rest=begin < 0))
    return found


def cycles_of(result: Result) -> list[LoadCycle]:
    """Return the cycles that a result holds whole, or its whole path as the only cycle."""
    case = result.case
    if not result.increments:
        raise CaseError(result.why_empty, (), result.path)
    stages = () if case is None else case.stages()
    found = load_cycles(stages, result.history["stage"], ended=result.status == "complete")
    if not found:
        raise CaseError("the result holds no whole cycle of its load path", (), result.path)
    if "cycles" not in result.history:
        return found
    # With wear a solved cycle stands for those up to the next one.
    firsts = [min(cycle.states[1:] if len(cycle.states) > len(set(cycle.states)) else cycle.states) for cycle in found]
    counts = np.diff(result.history["cycles"][[*(max(first - 1, 0) for first in firsts), -1]])
    return [replace(cycle, times=max(float(count), 1.0)) for cycle, count in zip(found, counts, strict=True)]


def chosen(cycles: Sequence[LoadCycle], choice: CycleChoice) -> tuple[LoadCycle, ...]:
    """Return the cycles of a choice. Raises CaseError if there is none, or not all that are chosen."""
    if not cycles:
        raise CaseError("no cycle is there whole")
    if choice == "last":
        return (cycles[-1],)
    if choice == "all":
        return tuple(cycles)
    wanted = choice if isinstance(choice, Mapping) else {choice: 1.0}
    known = {one.number or 1: one for one in cycles}
    if missing := [number for number in wanted if number not in known]:
        there = "there is one" if len(cycles) == 1 else f"there are 1 to {len(cycles)}"
        raise CaseError(f"there is no cycle {missing[0]}; {there}")
    return tuple(replace(known[number], times=times) for number, times in wanted.items())


def states_of(cycles: Sequence[LoadCycle], stored: Container[int]) -> tuple[int, ...]:
    """Return the states of cycles with fields, each once and in the order of the history."""
    return tuple(sorted({state for one in cycles for state in one.states if state in stored}))


def whole_path_note(cycles: Sequence[LoadCycle]) -> str | None:
    """Return the line that the whole path counts as one cycle, None if it has cycles."""
    if cycles[0].number:
        return None
    if not cycles[0].ended:
        return "the load path has no `cycle`: the part of it that is there counts as one, not the whole path"
    return "the load path has no `cycle`: the whole path counts as one"


def require_states(cycle: LoadCycle, stored: Container[int]) -> None:
    """Raise CaseError if a cycle has too few states with fields, or fields are missing where loads turn.

    stored: states of the history that have fields.
    """
    count = sum(state in stored for state in cycle.states)
    if count < 3:
        which = "the cycle" if cycle.number else cycle.title
        noun = "state" if count == 1 else "states"
        every = "" if len(cycle.states) < 3 else ": output.every leaves out the others, 1 stores all"
        raise CaseError(f"{which} has {count} stored {noun}; 3 or more are needed{every}")
    missing = [str(state) for state in cycle.ends if state not in stored]
    if missing:
        noun = f"increment{'s' if len(missing) > 1 else ''} {', '.join(missing)}"
        where = "a stage of the cycle begins or ends" if cycle.number else "a stage ends"
        raise CaseError(f"output.every leaves out {noun}, where {where}; 1 is needed")


def within(cycles: Sequence[LoadCycle], steps: Sequence[int], stored: Container[int] | None = None) -> list[LoadCycle]:
    """Return the cycles that chosen `steps` of a history hold, with their states as places among these.

    stored: of which the steps are chosen, by default the steps themselves.

    Of a whole path without cycles the chosen steps count as one cycle. It begins unloaded if they begin with the first
    stored step, or are the ends of all stages; else they are a part of the path that begins loaded.
    """
    place = {step: index for index, step in enumerate(steps)}
    found = []
    for one in cycles:
        if one.number == 0 or all(end in place for end in one.ends):
            states, ends = (tuple(place[state] for state in of if state in place) for of in (one.states, one.ends))
            first = next((state for state in one.states if state in (place if stored is None else stored)), None)
            whole = one.number > 0 or first in place or place.keys() == set(one.ends)
            from_rest = one.from_rest and whole
            ended = one.ended and all(end in place for end in one.ends)
            found.append(replace(one, states=states, ends=ends, from_rest=from_rest, ended=ended))
    return found


def cycles_as_text(cycles: Sequence[LoadCycle]) -> str:
    """Return cycles as an attribute of a file, which `cycles_from_text` reads."""
    return json.dumps([[one.number, one.states, one.ends, one.from_rest, one.ended, one.times] for one in cycles])


def cycles_from_text(text: str) -> list[LoadCycle]:
    """Return the cycles in an attribute of a file."""
    return [
        LoadCycle(number, tuple(states), tuple(ends), times, from_rest, ended)
        for number, states, ends, from_rest, ended, times in json.loads(text)
    ]


def read_blocks(path: Path) -> dict[int, float]:
    """Return the block of cycles in a CSV file with the heading ``cycle,times``. Raises CaseError, FileError."""
    lines = csv.reader(read_text(path).splitlines())
    numbered = [(number, [cell.strip() for cell in line]) for number, line in enumerate(lines, start=1) if any(line)]
    if not numbered or numbered[0][1] != ["cycle", "times"]:
        raise CaseError("the heading cycle,times is needed, then a line such as 1,1000 for each cycle", (), path, 1)
    found: dict[int, float] = {}
    for number, cells in numbered[1:]:
        try:
            cycle, times = cells
            found_before = int(cycle) in found
            value = float(times)
        except ValueError:
            message = f"{','.join(cells)!r} is not a cycle and how often it occurs; a line such as 1,1000 is needed"
            raise CaseError(message, (), path, number) from None
        if int(cycle) < 1 or not 0.0 < value < math.inf:
            message = f"{','.join(cells)!r} is out of range; a cycle from 1 on and a number above 0 are needed"
            raise CaseError(message, (), path, number)
        if found_before:
            raise CaseError(f"cycle {cycle} stands in the block twice; once is enough", (), path, number)
        found[int(cycle)] = value
    if not found:
        raise CaseError("no cycle is named; a line such as 1,1000 is needed", (), path)
    return found
