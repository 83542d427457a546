"""The judge of the families itself: it has to see what is wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from families.driving import Findings, OutOfTimeError, Probe, judge, solve_parts, time_limit

from fretsolve.errors import CaseError, GridEdgeError, SlidingError

GRID = {"points": 12}
SLIDING = {"grid": GRID, "load_path": [{"P": 400.0}, {"Qx": 50.0, "increments": 1}]}


@pytest.mark.parametrize(
    ("probe", "problem"),
    [
        (Probe("near", {"grid": GRID}, lambda run: 0.1, 0.2), ""),
        (Probe("far", {"grid": GRID}, lambda run: 0.3, 0.2), "0.3 from the limit of theory, 0.2 is allowed"),
        (Probe("NaN", {"grid": GRID}, lambda run: float("nan"), 0.2), "nan from the limit of theory"),
        (Probe("solved", {"grid": GRID}, refused=SlidingError), "solved, where SlidingError is right"),
        (Probe("either", {"grid": GRID}, refused=SlidingError, may_solve=True), ""),
        (Probe("refused", SLIDING, refused=SlidingError, says="mu P = 40 N"), ""),
        (Probe("not refused", SLIDING), "a certified result is right, not SlidingError"),
        (Probe("other error", SLIDING, refused=GridEdgeError), "GridEdgeError is right, not SlidingError"),
        (Probe("other words", SLIDING, refused=SlidingError, says="hello"), "does not say 'hello'"),
        (Probe("two lines", {"grid": {"points": 0}, "friction": -1}, refused=CaseError), "not one line to a person"),
        (Probe("bug", {"grid": GRID}, lambda run: 1.0 / 0.0), "ZeroDivisionError"),
        (Probe("warning", {"grid": GRID}, lambda run: np.float64(1.0) / np.float64(0.0)), "RuntimeWarning"),
        (
            Probe("slow", {"grid": GRID, "load_path": [{"P": 400.0, "increments": 100_000}]}, seconds=0.2),
            "not done after",
        ),
    ],
    ids=lambda value: value.label if isinstance(value, Probe) else "",
)
def test_problems_are_named(probe: Probe, problem: str, tmp_path: Path) -> None:
    found = judge(probe, tmp_path).problem
    assert problem in found
    assert bool(problem) == bool(found)


@pytest.mark.parametrize(
    ("summary", "fields", "wrong"),
    [
        ({}, {}, ""),
        ({"delta_z": float("inf")}, {}, "a scalar is not finite"),
        ({"contact_center_x": float("nan")}, {}, "a scalar is not finite"),
        ({"residual_slip": 2e-6}, {}, "a residual is 2e-06, beyond the tolerance"),
        ({"residual_gap": float("nan")}, {}, "beyond the tolerance"),
        ({"work": -1e-9}, {}, "the work is negative"),
        ({}, {"pressure": np.full((12, 12), -1.0)}, "a pressure is negative"),
        ({}, {"shear": np.full((2, 12, 12), np.nan)}, "a field is not finite"),
        ({}, {"gap": np.full((12, 12), np.nan)}, "the gap is NaN"),
    ],
)
def test_unlawful_increments_are_seen(
    summary: dict[str, Any], fields: dict[str, Any], wrong: str, tmp_path: Path
) -> None:
    state = solve_parts({"grid": GRID}, tmp_path).last
    altered = replace(state, summary=replace(state.summary, **summary), fields=replace(state.fields, **fields))
    findings = Findings()
    findings.examine(altered, 1e-6)
    assert wrong in "; ".join(findings.wrong)
    assert bool(findings.wrong) == bool(wrong)


def test_time_limit() -> None:
    with pytest.raises(OutOfTimeError), time_limit(0.05):
        while True:
            pass
