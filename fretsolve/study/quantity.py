"""The scalars that a study compares: a column of the history at the end of a stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fretsolve.case import HISTORY_DIMENSIONS
from fretsolve.case.load_components import PAIRS, TANGENTIAL
from fretsolve.case.problems import nearest
from fretsolve.case.quantities import NUMBER, TIME
from fretsolve.errors import CaseError
from fretsolve.result.layout import HISTORY

if TYPE_CHECKING:
    from fretsolve.setup.problem_setup import ProblemSetup

NAMES = tuple(
    quantity.name
    for quantity in HISTORY
    if HISTORY_DIMENSIONS.get(quantity.name, NUMBER) not in (NUMBER, TIME) and quantity.name != "work"
)
"""What can be compared; the work of one increment depends on how many there are."""

_UNITS = {quantity.name: quantity.units for quantity in HISTORY}


@dataclass(frozen=True)
class Observable:
    """A scalar of the history, by name, at the end of a stage (1-based, cycles unrolled)."""

    name: str
    stage: int

    @property
    def units(self) -> str:
        return _UNITS[self.name]

    def __str__(self) -> str:
        return f"{self.name}@{self.stage}"


MOST_STAGES = 999_999_999
"""Where it is not known how many stages there are."""


def read_observable(text: str, stages: int = MOST_STAGES) -> Observable:
    """Read ``NAME`` or ``NAME@STAGE``, the last of `stages` by default. Raises CaseError."""
    name, at, stage = (part.strip() for part in text.partition("@"))
    if name not in NAMES:
        raise _refused(f"{name!r} is not a quantity that can be compared; {nearest(name, NAMES)}", text)
    if at and not (stage.isdecimal() and len(stage) < 10 and 1 <= int(stage) <= stages):
        ends = "on" if stages == MOST_STAGES else f"to {stages}"
        raise _refused(f"there is no stage {stage!r}; one from 1 {ends} is needed", text)
    return Observable(name, int(stage) if at else stages)


def usual_observables(setup: ProblemSetup) -> tuple[Observable, ...]:
    """What the load path moves, at its end, and what the case expects; nothing that is imposed."""
    last = len(setup.load_path.last_steps)
    expected = [(expected.quantity, expected.stage or last) for expected in setup.case.expect]
    found = {Observable(*pair) for pair in ((name, last) for name in _moved(setup))} | {
        Observable(name, stage) for name, stage in expected if name in NAMES
    }
    imposed = setup.load_path.imposed
    return in_order([observable for observable in found if observable.name not in imposed[observable.stage - 1]])


def in_order(observables: Sequence[Observable]) -> tuple[Observable, ...]:
    """Each once, in the order of the history and of the stages."""
    return tuple(sorted(set(observables), key=lambda observable: (NAMES.index(observable.name), observable.stage)))


def _moved(setup: ProblemSetup) -> list[str]:
    """Of each load pair that is moved both components, and what describes the contact."""
    moved = {name for load in setup.load_path.imposed for name, value in load.items() if value}
    names = [name for pair in PAIRS for name in pair if moved & set(pair)]
    names += ["max_pressure", "contact_radius"]
    if setup.model.has_shear and (moved & TANGENTIAL or setup.model.terms.normal_tangential_coupling):
        names += ["stick_radius", "work_total"]
    return names


def _refused(message: str, text: str) -> CaseError:
    return CaseError(message, (), f"--quantity {text if text.isprintable() else repr(text)}")
