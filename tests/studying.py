"""Small studies: their case, what they vary and their plan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from small_cases import LOOP, write_case

from fretsolve.sweep.study.plan import ReferenceKind, StudyPlan, StudyRequest, make_study_plan

EXPECT = "expect: [{quantity: delta_x, value: 0.863748e-3 mm, rel: 1 %, stage: 2}, {quantity: Qx, value: 0, abs: 1}]\n"
BRIEF = ("--quantity", "delta_x", "--quantity", "delta_x@2", "--quantity", "work_total")
EVERY = "stage.*.increments"


def plan_of(
    folder: Path,
    varied: Sequence[str],
    *,
    text: str = LOOP,
    quantities: Sequence[str] = (),
    kind: ReferenceKind = "finest",
) -> StudyPlan:
    """Return the plan of a study of a case."""
    case = write_case(folder, text)
    return make_study_plan(StudyRequest(case, (), varied, quantities, kind), folder / "case.study")
