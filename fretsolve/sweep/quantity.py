"""Quantities that sweeps collect and studies compare: a column of the history at the end of a stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from fretsolve.case.dimensions import NUMBER, TIME
from fretsolve.case.history import HISTORY_DIMENSIONS, PAIRS, TANGENTIAL
from fretsolve.case.problems import nearest
from fretsolve.errors import CaseError
from fretsolve.result.layout import HISTORY
from fretsolve.setup.problem_setup import ProblemSetup

NAMES = tuple(
    column.name
    for column in HISTORY
    if HISTORY_DIMENSIONS.get(column.name, NUMBER) not in (NUMBER, TIME) and column.name != "work"
)
"""Columns that can be collected; the dissipated energy of one increment depends on how many there are."""

_UNITS = {column.name: column.units for column in HISTORY}

MOST_STAGES = 999_999_999
"""Number of stages where it is not known."""


@dataclass(frozen=True)
class StageQuantity:
    """A column of the history, by name, at the end of a stage (1-based, cycles unrolled)."""

    name: str
    stage: int

    @property
    def units(self) -> str:
        """The unit of its values."""
        return _UNITS[self.name]

    def __str__(self) -> str:
        return f"{self.name}@{self.stage}"


def read_quantity(text: str, stages: int = MOST_STAGES) -> StageQuantity:
    """Read ``NAME`` or ``NAME@STAGE``; the default is the last of `stages`. Raises CaseError."""
    name, at, stage = (part.strip() for part in text.partition("@"))
    if name not in NAMES:
        raise _refused(f"{name!r} is not a quantity that can be compared; {nearest(name, NAMES)}", text)
    if at and not (stage.isdecimal() and len(stage) < 10 and 1 <= int(stage) <= stages):
        ends = "on" if stages == MOST_STAGES else f"to {stages}"
        raise _refused(f"there is no stage {stage!r}; one from 1 {ends} is needed", text)
    return StageQuantity(name, int(stage) if at else stages)


def usual_quantities(setup: ProblemSetup) -> tuple[StageQuantity, ...]:
    """Return what the load path moves, at its end, and what the case expects, without what is imposed."""
    last = len(setup.load_path.last_steps)
    found = {StageQuantity(name, last) for name in _moved(setup)} | {
        StageQuantity(expected.quantity, expected.stage or last)
        for expected in setup.case.expect
        if expected.quantity in NAMES
    }
    imposed = setup.load_path.imposed
    return in_order([quantity for quantity in found if quantity.name not in imposed[quantity.stage - 1]])


def in_order(quantities: Sequence[StageQuantity]) -> tuple[StageQuantity, ...]:
    """Return each quantity once, in the order of the history and of the stages."""
    return tuple(sorted(set(quantities), key=lambda quantity: (NAMES.index(quantity.name), quantity.stage)))


def _moved(setup: ProblemSetup) -> list[str]:
    """Return both components of each load pair that is moved, and what describes the contact."""
    moved = {name for load in setup.load_path.imposed for name, value in load.items() if value}
    names = [name for pair in PAIRS for name in pair if moved & set(pair)]
    names += ["max_pressure", "contact_radius"]
    if setup.model.has_shear and (moved & TANGENTIAL or setup.model.terms.normal_tangential_coupling):
        names += ["stick_radius", "work_total"]
    return names


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--quantity {text if text.isprintable() else repr(text)}")
