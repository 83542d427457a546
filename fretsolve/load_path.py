"""The load path: stages cut into increments, and what is imposed at the end of each.

A stage moves the components that it names in equal steps from where they stand to their new totals; the rest
stays as it is. A component that changes from force to displacement control, or back, starts from the value
that the contact had at the stage's start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from fretsolve.components import PAIRS, TANGENTIAL
from fretsolve.modes import Balance

if TYPE_CHECKING:
    from fretsolve.case import Stage
    from fretsolve.model import Model
    from fretsolve.state import Summary

INITIAL = {"P": 0.0, "phi_x": 0.0, "phi_y": 0.0, "Qx": 0.0, "Qy": 0.0, "phi_z": 0.0}
"""What is imposed until a stage names something else of the pair."""

TANGENTIAL_INCREMENTS = 10
PRESSURE_INCREMENTS = 40
"""Equal increments of an automatic stage: a loop needs points to be drawn; where the pressure changes under
friction the slip depends on the path, and its error falls with the number of increments."""


@dataclass(frozen=True)
class Increment:
    """What is imposed at the end of an increment, as totals (N, mm, N mm, rad).

    step: 0-based over the whole path; key: where the stage stands in the case file.
    """

    step: int
    stage: Stage
    normal: Balance
    tangential: Balance


@dataclass(frozen=True)
class _PlannedStage:
    """A stage with its first step, its number of increments, and what is imposed before and at its end."""

    stage: Stage
    first: int
    increments: int
    before: dict[str, float]
    after: dict[str, float]


class LoadPath:
    """The stages of a case with the number of increments of each settled."""

    def __init__(self, stages: Sequence[Stage], model: Model):
        self._model = model
        self._planned: list[_PlannedStage] = []
        before, first, at_rest = dict(INITIAL), 0, True
        for stage in stages:
            after = _after(before, stage)
            # Shear stays behind where it has once been, so the load that is taken off again does not count.
            at_rest = at_rest and not any(name in TANGENTIAL and value for name, value in stage.targets)
            count = stage.increments or automatic_increments(stage, at_rest, model)
            self._planned.append(_PlannedStage(stage, first, count, before, after))
            before, first = after, first + count
        self.increments = first

    @property
    def last_steps(self) -> tuple[int, ...]:
        """The last step of each stage."""
        return tuple(planned.first + planned.increments - 1 for planned in self._planned)

    def with_counts(self, counts: Sequence[int]) -> LoadPath:
        """The same stages with other numbers of increments, one per stage."""
        stages = [
            replace(planned.stage, increments=count) for planned, count in zip(self._planned, counts, strict=True)
        ]
        return LoadPath(stages, self._model)

    @property
    def counts(self) -> tuple[int, ...]:
        """The number of increments of each stage."""
        return tuple(planned.increments for planned in self._planned)

    @property
    def imposed(self) -> tuple[dict[str, float], ...]:
        """What is imposed at the end of each stage: load components with their totals (N, mm, N mm, rad)."""
        return tuple(dict(planned.after) for planned in self._planned)

    def normal_loads(self) -> tuple[Balance, ...]:
        """What is imposed of P|delta_z, Mx|phi_x, My|phi_y at the end of each stage, as far as the case names it."""
        return tuple(_balance(planned.after, PAIRS[:3]) for planned in self._planned)

    def increment(self, step: int, history: Sequence[Summary]) -> Increment:
        """What is imposed at `step`; `history` holds the summaries of all steps before it."""
        planned = next(p for p in reversed(self._planned) if p.first <= step)
        start = history[planned.first - 1] if planned.first else None
        part = (step - planned.first + 1) / planned.increments
        values = {
            name: _between(_start_value(name, planned.before, start), end, part)
            for name, end in planned.after.items()
        }
        return Increment(step, planned.stage, _balance(values, PAIRS[:3]), _balance(values, PAIRS[3:]))


def automatic_increments(stage: Stage, at_rest: bool, model: Model) -> int:
    """As many increments as the stage needs; one where one is exact: where nothing can slip.

    at_rest: no tangential component has been moved up to the end of the stage.
    """
    if not model.sheared:
        return 1
    moves_pressure = any(name not in TANGENTIAL for name, _ in stage.targets)
    if moves_pressure and model.interacting:
        return PRESSURE_INCREMENTS
    if at_rest and not model.interacting:
        return 1
    return PRESSURE_INCREMENTS if moves_pressure else TANGENTIAL_INCREMENTS


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


def _balance(values: dict[str, float], pairs: Sequence[tuple[str, str]]) -> Balance:
    forced = tuple(force in values for force, _ in pairs)
    imposed = tuple(values[force if force in values else motion] for force, motion in pairs)
    return Balance(forced, imposed)  # type: ignore[arg-type]
