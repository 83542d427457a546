"""Units of text for people."""

from __future__ import annotations

import math

import pytest

from fretsolve.case.dimensions import in_small_unit, percent, smaller_unit
from fretsolve.case.history import moment_sign


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.00906654, "9.06654 um"),
        (-1.5e-3, "-1.5 um"),
        (0.25, "0.25 mm"),
        (2.5e-5, "25 nm"),
        (1e-9, "0.001 nm"),
        (0.0, "0 mm"),
    ],
)
def test_small_displacements_have_a_smaller_unit(value: float, text: str) -> None:
    assert in_small_unit(value) == text


def test_other_units_have_none_that_is_smaller() -> None:
    assert smaller_unit("N mm", 1e-6) == ("N mm", 1.0)
    assert smaller_unit("mJ/mm", 2e-3) == ("uJ/mm", 1e3)


def test_signs_of_moments_are_told() -> None:
    assert moment_sign(["My"]) == "My > 0 is more pressure at x > 0"
    assert moment_sign(["Mx", "My"]) == "Mx, My > 0 is more pressure at y, x > 0"


def test_shares_in_per_cent() -> None:
    shares = {0.025: "2.5 %", 1e-3: "0.1 %", 0.0: "0 %", 5.34: "530 %", 12.0: "1200 %", math.inf: "inf %"}
    assert {share: percent(share) for share in shares} == shares
    assert percent(0.99123, 3) == "99.1 %"
