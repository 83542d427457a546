"""Every shipped case has certified increments and says where its expected values come from."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "cases"
NAMES = sorted(path.stem for path in FOLDER.glob("*.yaml"))


@pytest.mark.parametrize("name", NAMES)
def test_every_increment_is_certified(shipped, name):
    solved = shipped(name)
    worst = max(step.worst_residual for step in solved.history)
    assert worst <= solved.case.solver.tolerance
    assert [step.step for step in solved.history] == list(range(len(solved.history)))


@pytest.mark.parametrize("name", NAMES)
def test_the_case_says_what_it_is(name):
    text = (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
    comment = text.partition("title:")[0]
    if name.startswith(("line_", "sphere_bulk", "friction_", "wear_")):
        assert re.search(r"\((18|19|20)\d\d\)", comment), "a source with its year"
    else:
        assert "10.1016/j.wear.2009.07.019" in comment
    expected = [line for line in text.splitlines() if "{quantity:" in line]
    assert expected
    assert all("#" in line for line in expected), "each expected value says where it comes from"
