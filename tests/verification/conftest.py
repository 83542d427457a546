"""The shipped cases, each solved once for all tests that look at it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

from fretsolve import load_case, run
from fretsolve.case.models import Case
from fretsolve.problem.model.grid import Grid
from fretsolve.result.state import State, Summary
from fretsolve.simulation.simulation import set_up

CASES = Path(__file__).parents[2] / "cases"


@dataclass(frozen=True)
class ShippedRun:
    """A solved case: the summaries of all increments and the states at the ends of its stages."""

    case: Case
    grid: Grid
    history: tuple[Summary, ...]
    stage_ends: tuple[State, ...]

    def at(self, stage: int) -> State:
        """The state at the end of a stage (1-based)."""
        return self.stage_ends[stage - 1]


@cache
def _solved(name: str) -> ShippedRun:
    case = load_case(CASES / f"{name}.yaml")
    setup = set_up(case)
    history, ends = [], []
    for state in run(setup):
        history.append(state.summary)
        if state.summary.step in setup.load_path.last_steps:
            ends.append(state)
    return ShippedRun(case, setup.grid, tuple(history), tuple(ends))


@pytest.fixture(scope="session")
def shipped() -> Callable[[str], ShippedRun]:
    """``shipped(name)`` is the solved case of that name."""
    return _solved
