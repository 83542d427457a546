"""Tells at the end of a test run how many random cases were driven, and how they ended."""

from __future__ import annotations

from collections import Counter

import pytest

RANDOM_CASES = "random cases"


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """A line with the sums over all tests that tell their random cases."""
    ended: Counter[str] = Counter()
    seconds = 0.0
    for report in (*terminalreporter.stats.get("passed", ()), *terminalreporter.stats.get("failed", ())):
        counts = dict(report.user_properties).get(RANDOM_CASES)
        if counts and report.when == "call":
            ended.update(counts)
            seconds += report.duration
    if ended:
        increments = ended.pop("increments", 0)
        counts = ", ".join(f"{count} {how}" for how, count in ended.most_common())
        terminalreporter.write_line(
            f"{RANDOM_CASES}: {ended.total()} with {increments} increments in {seconds:.0f} s: {counts}"
        )
