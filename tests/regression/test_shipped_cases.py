"""Every case in ``cases/``, and of published values in ``cases/external/``, is as expected by ``fretsolve check``."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import invoke

from fretsolve.cli.commands.check import cases_at

FOLDER = Path(__file__).parents[2] / "cases"
CASES = [case for folder in (FOLDER, FOLDER / "external") for case in cases_at(folder)[0]]


def test_there_are_cases() -> None:
    assert CASES


@pytest.mark.parametrize("case", CASES, ids=lambda path: path.stem)
def test_case_is_as_expected(case: Path) -> None:
    result = invoke("check", case)
    assert result.exit_code == 0, result.output
    assert result.stdout.endswith("1 of 1 cases as expected\n")
