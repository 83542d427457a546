"""The load path: stages cut into increments, and what is imposed at the end of each.

A stage moves the components that it names from where they stand to their new totals, in equal steps or in steps that
`spacing` chooses; the rest stays as it is. A component that changes from force to displacement control, or back,
starts from the value that the contact had at the stage's start.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fretsolve.case.load_components import PAIRS, TANGENTIAL
from fretsolve.model.increment_grading import Course, Courses
from fretsolve.model.load_control import LoadControl

if TYPE_CHECKING:
    from fretsolve.case import Stage
    from fretsolve.model.required_terms import Model
    from fretsolve.result.state import Summary

INITIAL = {"P": 0.0, "phi_x": 0.0, "phi_y": 0.0, "Qx": 0.0, "Qy": 0.0, "phi_z": 0.0}
"""What is imposed until a stage names something else of the pair."""

DRAWN_INCREMENTS = 10
"""Of an automatic stage at least: a loop needs points to be drawn, also where the path between them has no effect."""

INCREMENTS_PER_MOTION = 25
"""Of an automatic stage in which the slip depends on the path, for a contact or stick zone that arises or vanishes
(`spacing.Course.motion`). Then displacements are within about half a per cent of what more increments give, and work
within one to three, as docs/verification.md has them."""

ROUNDING = 1e-9


@dataclass(frozen=True)
class Increment:
    """What is imposed at the end of an increment, as totals (N, mm, N mm, rad).

    step: 0-based over the whole path; key: where the stage stands in the case file.
    """

    step: int
    stage: Stage
    normal: LoadControl
    tangential: LoadControl


@dataclass(frozen=True)
class _PlannedStage:
    """A stage with its first step, its number of increments, and what is imposed before and at its end.

    needed: increments that the slip's course takes; course: by which its steps are chosen, None where they are equal.
    """

    stage: Stage
    first: int
    increments: int
    needed: int
    before: dict[str, float]
    after: dict[str, float]
    course: Course | None

    def share(self, step: int) -> float:
        """The share of the stage that is done after `step`; 1 at its end."""
        part = (step - self.first + 1) / self.increments
        return part if self.course is None else self.course.share(part)


class LoadPath:
    """The stages of a case with the increments of each settled.

    refinement: factor on the number of automatic ones where the slip depends on them; matters: whether it does in any
    stage; slip_width: the largest that Cattaneo and Mindlin let expect, over the contact radius; 0 where they do not.
    """

    def __init__(self, stages: Sequence[Stage], model: Model, refinement: float = 1.0):
        self._model = model
        self._planned: list[_PlannedStage] = []
        courses = Courses(model.friction)
        before, first = dict(INITIAL), 0
        moved: set[str] = set()
        self.path_dependent = False
        self.slip_width = 0.0
        for stage in stages:
            after = _after(before, stage)
            # Shear stays behind where it has once been, so the load that is taken off again does not count.
            moved |= {name for name, value in stage.targets if name in TANGENTIAL and value}
            matters = depends_on_path(stage, moved, model)
            self.path_dependent = self.path_dependent or matters
            course = courses.following(before, after)
            chosen = automatic_increments(matters, bool(moved), model, course.motion * refinement)
            count, needed = stage.increments or chosen, chosen if matters else 1
            if model.has_shear:
                self.slip_width = max(self.slip_width, course.slip_width)
            spacing = stage.spacing or ("graded" if matters and not stage.increments else "equal")
            steps = course if spacing == "graded" else None
            self._planned.append(_PlannedStage(stage, first, count, needed, before, after, steps))
            before, first = after, first + count
        self.increments = first

    @property
    def last_steps(self) -> tuple[int, ...]:
        """The last step of each stage."""
        return tuple(planned.first + planned.increments - 1 for planned in self._planned)

    def with_counts(self, counts: Sequence[int]) -> LoadPath:
        """The same stages with other numbers of increments, one per stage, spaced alike."""
        stages = [
            replace(planned.stage, increments=count, spacing="graded" if planned.course else "equal")
            for planned, count in zip(self._planned, counts, strict=True)
        ]
        return LoadPath(stages, self._model)

    @property
    def counts(self) -> tuple[int, ...]:
        """The number of increments of each stage."""
        return tuple(planned.increments for planned in self._planned)

    @property
    def needed(self) -> tuple[int, ...]:
        """The number of increments that the slip's course takes in each stage; 1 where the path has no effect."""
        return tuple(planned.needed for planned in self._planned)

    @property
    def imposed(self) -> tuple[dict[str, float], ...]:
        """What is imposed at the end of each stage: load components with their totals (N, mm, N mm, rad)."""
        return tuple(dict(planned.after) for planned in self._planned)

    @property
    def graded(self) -> tuple[bool, ...]:
        """Whether the steps of each stage follow the edges of contact and stick zone."""
        return tuple(planned.course is not None for planned in self._planned)

    def normal_loads(self) -> tuple[LoadControl, ...]:
        """What is imposed of P|delta_z, Mx|phi_x, My|phi_y at the end of each stage, as far as the case names it."""
        return tuple(_balance(planned.after, PAIRS[:3]) for planned in self._planned)

    def increment(self, step: int, history: Sequence[Summary]) -> Increment:
        """What is imposed at `step`; `history` holds the summaries of all steps before it."""
        planned = next(p for p in reversed(self._planned) if p.first <= step)
        start = history[planned.first - 1] if planned.first else None
        part = planned.share(step)
        values = {
            name: _between(_start_value(name, planned.before, start), end, part)
            for name, end in planned.after.items()
        }
        return Increment(step, planned.stage, _balance(values, PAIRS[:3]), _balance(values, PAIRS[3:]))


def automatic_increments(matters: bool, moved: bool, model: Model, motion: float) -> int:
    """As many increments as the stage needs; one where one is exact: where nothing can slip.

    matters: whether the slip depends on how the stage's end is reached; moved: whether there has been a tangential
    load; motion: of the edges, times what is asked for beyond the usual.
    """
    if not matters:
        return DRAWN_INCREMENTS if model.has_shear and moved else 1
    return max(DRAWN_INCREMENTS, math.ceil(INCREMENTS_PER_MOTION * motion - ROUNDING))


def depends_on_path(stage: Stage, moved: Collection[str], model: Model) -> bool:
    """Whether the slip of a stage depends on how its end is reached, which increments follow in steps.

    So it does where pressure and shear act on each other, where the pressure changes under shear, and where the slip
    turns: under several tangential loads. moved: the tangential components moved up to the end of the stage.
    """
    if not model.has_shear:
        return False
    presses = any(name not in TANGENTIAL for name, _ in stage.targets)
    return model.coupled or len(moved) > 1 or (presses and bool(moved))


def _after(before: dict[str, float], stage: Stage) -> dict[str, float]:
    after = dict(before)
    for name, value in stage.targets:
        partner = next(b if a == name else a for a, b in PAIRS if name in (a, b))
        after.pop(partner, None)
        after[name] = value
    return after


def _start_value(name: str, before: dict[str, float], start: Summary | None) -> float:
    if name in before:
        return before[name]
    return float(getattr(start, name)) if start is not None else 0.0


def _between(start: float, end: float, part: float) -> float:
    return end if part == 1.0 else start + (end - start) * part


def _balance(values: dict[str, float], pairs: Sequence[tuple[str, str]]) -> LoadControl:
    forced = tuple(force in values for force, _ in pairs)
    imposed = tuple(values[force if force in values else motion] for force, motion in pairs)
    return LoadControl(forced, imposed)  # type: ignore[arg-type]
