"""Every shipped case has certified increments and says where its expected values come from."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest

from fretsolve.cli.commands.check import cases_at

FOLDER = Path(__file__).parents[2] / "cases"
NAMES = [path.stem for path in cases_at(FOLDER)[0]]
PUBLISHED = sorted(f"external/{path.stem}" for path in FOLDER.glob("external/*.yaml"))
KINDS = ("closed form", "other program", "experiment", "regression")
"""Of references, as the page on verification types them."""


LONG = {"ellipsoid_oblique", "friction_cap", "mode1_dissimilar"}
"""Cases of many increments on fine grids."""


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in (*NAMES, *PUBLISHED)]
)
def test_every_increment_is_certified(shipped, name):
    solved = shipped(name)
    worst = max(step.worst_residual for step in solved.history)
    assert worst <= solved.case.solver.tolerance
    assert [step.step for step in solved.history] == list(range(len(solved.history)))


@pytest.mark.parametrize("name", NAMES)
def test_the_case_says_what_it_is(name):
    text = (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
    comment = text.partition("title:")[0]
    if name.startswith(("line_", "sphere_bulk", "friction_", "wear_", "interface_", "crack")):
        assert re.search(r"\((18|19|20)\d\d\)", comment), "a source with its year"
    else:
        assert "10.1016/j.wear.2009.07.019" in comment
    expected = [line for line in text.splitlines() if "{quantity:" in line]
    assert expected
    assert all("#" in line for line in expected), "each expected value says where it comes from"


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_value_has_its_source_and_the_kind_of_its_reference(name):
    text = (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
    source = text.partition("# Source: ")[2].partition("title:")[0]
    assert re.search(r"\((18|19|20)\d\d\)", source), "a source with its year"
    assert "olerance" in source, "the reason of each tolerance"
    with (FOLDER.parent / "docs/data/verification_published.csv").open(encoding="utf-8", newline="") as file:
        shown = [row[:3] for row in csv.reader(file)]
    expected = re.findall(r"- \{quantity: (\w+), .*\} +# (.+)", text)
    assert len(expected) == text.count("{quantity:") > 0
    for quantity, reference in expected:
        assert reference.startswith(tuple(f"{kind}: " for kind in KINDS))
        assert [Path(name).name, quantity, reference] in shown
