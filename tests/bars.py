"""The error bars of a case at the ends of its stages."""

from __future__ import annotations

from fretsolve.case.models import Case
from fretsolve.result.state import Summary, SummaryErrors
from fretsolve.simulation.error_bars.error_bars import run_with_error_bars


def ends_of_stages(case: Case) -> dict[int, tuple[Summary, SummaryErrors]]:
    """Return the summary and the error bars at the end of each stage."""
    ends: dict[int, tuple[Summary, SummaryErrors]] = {}
    for state in run_with_error_bars(case):
        assert state.errors is not None
        ends[state.summary.stage] = state.summary, state.errors
    return ends
