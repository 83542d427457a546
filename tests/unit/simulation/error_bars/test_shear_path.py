"""The path of the shear, over what friction carries."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import pytest

from fretsolve.simulation.error_bars.floors import ShearPath


def path_of(*forces: tuple[float, float], count: int = 1) -> ShearPath:
    """Return the path through shear forces (N), of which friction carries 40 N."""
    path = ShearPath()
    for Qx, Qy in forces:
        path = path.after(cast(Any, SimpleNamespace(Qx=Qx, Qy=Qy, Mz=0.0, contact_radius=0.3)), 40.0, count)
    return path


def test_a_reversal_goes_twice_the_way_and_keeps_the_largest_share() -> None:
    path = path_of((30.0, 0.0), (-30.0, 0.0))
    assert (path.length, path.largest, path.left) == pytest.approx((2.25, 0.75, 0.25))
    assert path.turned == 0.0


def test_increments_along_a_line_have_no_turn_and_one_across_has_the_more_the_fewer_they_are() -> None:
    assert path_of((10.0, 10.0), (20.0, 20.0)).turned == pytest.approx(0.0, abs=1e-7)
    once, often = (path_of((20.0, 0.0), (20.0, 20.0), count=count).turned for count in (1, 10))
    assert once == pytest.approx(0.5 / 3.0)
    assert often < 0.3 * once


def test_the_shear_moves_on_until_it_is_held_or_goes_back() -> None:
    assert path_of((10.0, 0.0), (20.0, 0.0)).moves_on
    assert not path_of((20.0, 0.0), (20.0, 0.0)).moves_on
    assert not path_of((20.0, 0.0), (10.0, 0.0)).moves_on


def test_sliding_leaves_nothing_and_an_opened_contact_starts_anew() -> None:
    slid = path_of((40.0, 0.0))
    assert slid.left == 0.0
    opened = slid.after(cast(Any, SimpleNamespace()), 0.0, 1)
    assert (opened.at, opened.largest, opened.length) == ((0.0, 0.0, 0.0), 1.0, 1.0)
    assert math.isclose(opened.left, 1.0)
