"""The load path: stages cut into increments, and what is imposed at the end of each increment.

A stage moves the components that it names from where they stand to their new totals, in equal or in graded increments.
The other components stay as they are. A component that changes between force and displacement control starts from the
value that the contact had at the start of the stage.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, pairwise

import numpy as np

from fretsolve.case.history import SHEARING
from fretsolve.case.keys.unrolled_path import CyclePass, Stage, imposed_after
from fretsolve.problem.model.increment_grading import LINE, SPHERE, LoadsAtContact, StageGrading, stage_gradings
from fretsolve.problem.model.load_control import LoadControl, load_controls
from fretsolve.problem.model.required_terms import Model
from fretsolve.result.state import Summary
from fretsolve.system.arrays import DoubleArray, Vector

DRAWN_INCREMENTS = 10
"""Least number of automatic increments under tangential load: a loop needs points to be drawn."""

INCREMENTS_PER_EDGE_MOTION = 25
"""Automatic increments per unit of `StageGrading.edge_motion`, where the slip depends on the path. Displacements are
then within about 0.5 % of what more increments give, the dissipated energy within 1 to 3 % (docs/verification.md)."""


@dataclass(frozen=True)
class Increment:
    """An increment, with the totals imposed at its end (N, mm, N mm, rad). step: from 0 over the whole path.

    bulk: bulk stresses at its end (MPa) by their names; strain_mismatch: by how much they change the mismatch of the
    surfaces in the increment, De_xx, De_yy, De_xy, None without a change; friction: coefficient that a stage has set,
    None without one; coupling: compliance of a rig from tangential loads to normal motions, (3, 3), and transposed the
    other way, None where a rig has none; actuator: its imposed motions (mm, rad) by their names.
    """

    step: int
    stage: Stage
    normal: LoadControl
    tangential: LoadControl
    bulk: dict[str, float] = field(default_factory=dict)
    strain_mismatch: Vector | None = None
    friction: float | None = None
    coupling: DoubleArray | None = None
    actuator: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class _PlannedStage:
    """A stage with its number of increments, and what is imposed before it and at its end.

    index: among all stages, from 0; path_dependent: whether the slip depends on the increments; grading: None for
    equal ones.
    """

    index: int
    stage: Stage
    increments: int
    path_dependent: bool
    before: dict[str, float]
    after: dict[str, float]
    grading: StageGrading | None

    def share(self, done: int) -> float:
        """Return the share of the stage that is done after `done` of its increments, 1 at its end."""
        part = done / self.increments
        return part if self.grading is None else self.grading.share(part)


class LoadPath:
    """The stages of a case, cut into increments.

    refinement: factor on automatic numbers of increments where there is more than one; at_contact: the loads of
    the contact on a rig, by which increments are graded, None for those imposed.

    Attributes, of the whole path: increments: their number; path_dependent: whether the slip of any stage depends on
    them. Of each stage: stages: itself; counts: number of increments; last_steps: the last increment; graded: whether
    the increments are; imposed: load components with their totals at the end (N, mm, N mm, rad).
    """

    def __init__(
        self, stages: Sequence[Stage], model: Model, refinement: float = 1.0, at_contact: LoadsAtContact | None = None
    ):
        self._model, self._at_contact = model, at_contact
        self._planned: list[_PlannedStage] = []
        self._left_out: Collection[int] | None = None
        self._without = 0  # so many of them are left out
        self.path_dependent = False
        self._all_imposed = imposed_along(stages, model)
        moved = set[str]()
        for index, (stage, (before, after)) in enumerate(zip(stages, pairwise(self._all_imposed), strict=True)):
            # A tangential component that returns to 0 still counts: shear stays behind.
            moved |= {name for name, value in stage.targets if name in SHEARING and value}
            path_dependent = _depends_on_path(stage, moved, model)
            self.path_dependent |= path_dependent
            drawn = DRAWN_INCREMENTS if model.has_shear and moved and _moves(stage) else 1
            usual = self._needed(index) if path_dependent else drawn
            count = stage.increments or (1 if usual == 1 else math.ceil(usual * refinement - 1e-9))  # less rounding
            spacing = stage.spacing or ("graded" if path_dependent and not stage.increments else "equal")
            grading = self._gradings[index] if spacing == "graded" else None
            self._planned.append(_PlannedStage(index, stage, count, path_dependent, before, after, grading))
        self._spans = _spans(stages)
        self._place(self._planned)

    @cached_property
    def _gradings(self) -> tuple[StageGrading, ...]:
        """The grading of each stage. Equal increments need none, and a case of a sweep takes 0.5 ms less without."""
        laws = LINE if self._model.line else SPHERE
        if self._at_contact is None:
            return tuple(stage_gradings(self._model.friction, self._all_imposed, laws))
        contact = self._at_contact
        return tuple(stage_gradings(self._model.friction, contact.imposed, laws, contact.course))

    def _needed(self, index: int) -> float:
        """Return the number of increments of a stage whose slip depends on them."""
        return max(DRAWN_INCREMENTS, INCREMENTS_PER_EDGE_MOTION * self._gradings[index].edge_motion)

    def _place(self, planned: list[_PlannedStage]) -> None:
        """Let stages follow each other, and set the attributes of each stage."""
        self._planned = planned
        self.stages = tuple([stage.stage for stage in planned])
        self.counts = tuple([stage.increments for stage in planned])
        *self._firsts, self.increments = accumulate(self.counts, initial=0)
        self.last_steps = tuple([first - 1 for first in (*self._firsts[1:], self.increments)])
        self.imposed = tuple([stage.after for stage in planned])
        self.graded = tuple([stage.grading is not None for stage in planned])

    def after(self, history: Sequence[Summary]) -> LoadPath:
        """Return the path without the repetitions that are left of a cycle which has come to its end with the last
        increment: it is periodic, or all cycles are done that it stands for.

        history: the summaries of all steps so far. It is this path itself unless such a cycle ends there.
        """
        return self._after(history, len(history) - 1)

    def _after(self, history: Sequence[Summary], step: int) -> LoadPath:
        """Return the path as `after` leaves it after `step` of a history."""
        if self._left_out is not None:
            return self.without(self._left_out) if len(self._left_out) > self._without else self
        cycle = self._may_end_at(step)
        if cycle is None:
            return self
        if cycle.jumps is not None:
            if self.cycles_done(history, cycle, step) < cycle.jumps.represents:
                return self
        elif not self._is_periodic(history, cycle, step):
            return self
        left = (stage for stage in self.stages if _is_later(stage.cycle, cycle) or _changes(stage.wears, cycle))
        return self.without({stage.number for stage in left})

    def _may_end_at(self, step: int) -> CyclePass | None:
        """Return the repetition that ends with `step` if its cycle may come to its end there, else None."""
        place = self._place_of(step) if step >= 0 else None
        cycle = None if place is None else self._planned[place].stage.cycle
        if place is None or cycle is None or (cycle.until is None and cycle.jumps is None):
            return None
        is_end = self.last_steps[place] == step == self.steps_of(cycle.cycle, cycle.turn)[1]
        return cycle if is_end and (cycle.turn > 1 or cycle.jumps is not None) else None

    def _is_periodic(self, history: Sequence[Summary], cycle: CyclePass, last: int) -> bool:
        """Return whether `cycle`, which ends with the step `last`, is within its tolerance of the limit of its kind."""
        from fretsolve.result.cycles.loops import CHANGE_COLUMNS, cycles_in, distance_to_limit  # few paths need them

        first, _ = self.steps_of(cycle.cycle, max(1, cycle.turn - 2))
        rows = history[max(0, first - 1) : last + 1]  # from where the first of three repetitions begins
        columns = {name: np.array([getattr(one, name) for one in rows]) for name in CHANGE_COLUMNS}
        turns = self._planned[bisect_right(self._firsts, first) - 1 : bisect_right(self._firsts, last)]
        found = cycles_in([planned.stage for planned in turns], columns["stage"])
        return cycle.until is not None and distance_to_limit(columns, found).largest <= cycle.until

    def cycles_done(self, history: Sequence[Summary], cycle: CyclePass, step: int = -1) -> float:
        """Return how many cycles the repetitions of a cycle stand for up to a step, by default the last one."""
        first, _ = self.steps_of(cycle.cycle, 1)
        return history[step].cycles - (history[first - 1].cycles if first else 0.0)

    def followed(self, history: Sequence[Summary]) -> LoadPath:
        """Return the path as `after` leaves it after each step of `history`."""
        path, place = self, 0
        while place < len(path.last_steps) and (step := path.last_steps[place]) < len(history):
            path, place = path._after(history, step), place + 1
        return path

    def without(self, numbers: Collection[int]) -> LoadPath:
        """Return the path without the stages of these numbers; the others keep theirs."""
        shorter = copy(self)
        shorter._without = len(numbers)
        shorter._place([planned for planned in self._planned if planned.stage.number not in numbers])
        return shorter

    def with_counts(self, counts: Sequence[int], left_out: Collection[int] | None = None) -> LoadPath:
        """Return the same stages with other numbers of increments, one per stage, graded alike.

        left_out: numbers of stages that `after` leaves out, which may grow, instead of what the history shows.
        """
        stages = [
            replace(planned.stage, increments=count, spacing="graded" if planned.grading else "equal")
            for planned, count in zip(self._planned, counts, strict=True)
        ]
        path = LoadPath(stages, self._model, at_contact=self._at_contact)
        path._left_out = left_out
        return path

    def steps_of(self, cycle: int, turn: int) -> tuple[int, int]:
        """Return the first and the last step of a repetition of a cycle, both counted from 1."""
        spanned = self._spans[cycle, turn]
        first, last = (bisect_left(self._planned, number, key=lambda one: one.stage.number) for number in spanned)
        return self._firsts[first], self.last_steps[last]

    def growth(self, step: int) -> float | None:
        """Return the load step at `step` over the load step before it, None where that belongs to another stage."""
        place = self._place_of(step)
        if place is None or step == self._firsts[place]:
            return None
        planned, done = self._planned[place], step - self._firsts[place]
        before, last, now = (planned.share(count) if count else 0.0 for count in (done - 1, done, done + 1))
        return (now - last) / (last - before) if last - before > 0.0 else None

    def _place_of(self, step: int) -> int | None:
        """Return the place of the stage of `step` among the stages, from 0; None after the last one."""
        return bisect_right(self._firsts, step) - 1 if step < self.increments else None

    def ends_stage(self, step: int) -> bool:
        """Return whether a stage ends with a step."""
        place = self._place_of(step)
        return place is not None and self.last_steps[place] == step

    def imposed_at(self, step: int) -> frozenset[str]:
        """Return the names of what is imposed at a step of the path."""
        place = self._place_of(step)
        return frozenset(() if place is None else self._planned[place].after)

    def imposed_in_stages(self) -> Iterator[tuple[dict[str, float], dict[str, float], list[float]]]:
        """Yield for each stage what is imposed before it and at its end, and the share that each increment ends at.

        With the history before it, that is all that a stage depends on.
        """
        for planned in self._planned:
            done = range(1, planned.increments + 1)
            yield planned.before, planned.after, [planned.share(count) for count in done]

    def normal_loads(self) -> tuple[LoadControl, ...]:
        """Return what is imposed of P|delta_z, Mx|phi_x, My|phi_y at the end of each stage."""
        return tuple(load_controls(planned.after, self._model.rig)[0] for planned in self._planned)

    def increment(self, step: int, history: Sequence[Summary]) -> Increment:
        """Return what is imposed at `step`; `history` holds the summaries of all steps before it."""
        planned, values = self._values(step, history)
        normal, tangential, coupling = load_controls(values, self._model.rig)
        response = self._model.bulk
        friction, actuator = values.get("friction"), _named(values, "actuator_")
        found = Increment(
            step, planned.stage, normal, tangential, friction=friction, coupling=coupling, actuator=actuator
        )
        if response is None:
            return found
        bulk = _named(values, "bulk_")
        strains = response.mismatch(bulk) - response.mismatch(self._values(step - 1, history)[1] if step else {})
        bulk = response.with_constraint(bulk)
        return replace(found, bulk=bulk, strain_mismatch=strains if strains.any() else None)

    def _values(self, step: int, history: Sequence[Summary]) -> tuple[_PlannedStage, dict[str, float]]:
        """Return the stage of `step`, and what is imposed at its end by name."""
        place = self._place_of(step)
        assert place is not None
        planned, first = self._planned[place], self._firsts[place]
        start = history[first - 1] if first else None
        part = planned.share(step - first + 1)
        values = {}
        for name, end in planned.after.items():
            if name == "friction":  # at once, since the friction limit is no load
                values[name] = end
                continue
            begin = planned.before[name] if name in planned.before else float(getattr(start, name, 0.0))
            values[name] = end if part == 1.0 else begin + (end - begin) * part
        return planned, values


def imposed_along(stages: Sequence[Stage], model: Model) -> tuple[dict[str, float], ...]:
    """Return what is imposed before the first stage and at the end of each stage, which cycles come back to."""
    found, equal, known = [model.at_start], dict[str, dict[str, float]](), dict[tuple[int, int], dict[str, float]]()
    for stage in stages:
        step = id(found[-1]), id(stage.targets)  # of objects that are kept; as numbers 0 and -0 would be equal
        if step not in known:
            after = imposed_after(found[-1], stage)
            known[step] = equal.setdefault(repr(after), after)
        found.append(known[step])
    return tuple(found)


def _is_later(cycle: CyclePass | None, than: CyclePass) -> bool:
    return cycle is not None and cycle.cycle == than.cycle and cycle.turn > than.turn


def _changes(wears: CyclePass | None, after: CyclePass) -> bool:
    """Return whether the surfaces change at the end of the repetition `after` or of a later one."""
    return wears is not None and wears.cycle == after.cycle and wears.turn >= after.turn


def _spans(stages: Sequence[Stage]) -> dict[tuple[int, int], tuple[int, int]]:
    """Return the numbers of the first and the last stage of each repetition, by cycle and repetition."""
    found: dict[tuple[int, int], tuple[int, int]] = {}
    for stage in stages:
        if (one := stage.cycle) is not None:
            first, _ = found.get((one.cycle, one.turn), (stage.number, 0))
            found[one.cycle, one.turn] = first, stage.number
    return found


def _depends_on_path(stage: Stage, moved: set[str], model: Model) -> bool:
    """Return whether the slip of a stage depends on the way to its end.

    It does where pressure and shear change each other, where the pressure changes under shear, where several
    tangential loads or bulk stresses turn the slip, and where friction depends on the slip.
    moved: names of the loads moved up to the end of the stage.
    """
    if not _moves(stage):
        return False
    presses = any(name not in SHEARING and name != "friction" for name, _ in stage.targets)
    varies = model.friction_evolves and bool(moved)
    return model.has_shear and (model.coupled or varies or len(moved) > 1 or (presses and bool(moved)))


def _moves(stage: Stage) -> bool:
    """Return whether a stage moves any load, rather than change the friction alone."""
    return any(name != "friction" for name, _ in stage.targets)


def _named(values: dict[str, float], prefix: str) -> dict[str, float]:
    return {name: value for name, value in values.items() if name.startswith(prefix)}
