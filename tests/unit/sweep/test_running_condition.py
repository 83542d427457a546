"""The running condition of a result: of its full cycles, or of all increments."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fretsolve.errors import SlidingError
from fretsolve.sweep.outcome import running_condition_of


def result(sticking: list[int], ends: list[tuple[int, int]], **attributes: str) -> Any:
    """A result of ten cells in contact with these sticking, and with cycles from and to these increments."""
    count = len(sticking)
    history = {"contact_cells": np.full(count, 10), "stick_cells": np.array(sticking), "max_shear": np.ones(count)}
    columns = {name: np.array([end[k] for end in ends]) for k, name in enumerate(("first_step", "last_step"))}

    class Cycles:
        def __init__(self) -> None:
            self.columns = columns

        def __len__(self) -> int:
            return len(ends)

    return SimpleNamespace(history=history, increments=count, attributes=attributes, cycles=Cycles() if ends else None)


@pytest.mark.parametrize(
    ("sticking", "ends", "condition"),
    [
        ([10, 10], [], "stick"),
        ([10, 4, 0, 3], [], "gross slip"),
        ([0, 4, 10, 3], [(0, 3)], "partial slip"),  # the first loading slid as a whole, the cycle does not
        ([10, 0, 10, 3, 5, 10], [(-1, 2), (2, 5)], "mixed"),
        ([10, 0, 10, 0], [(-1, 1), (1, 3)], "gross slip"),
        ([10, 10, 10, 3], [(-1, 1), (1, 3)], "partial slip"),
    ],
)
def test_condition_of_full_cycles(sticking: list[int], ends: list[tuple[int, int]], condition: str) -> None:
    assert running_condition_of(result(sticking, ends)) == condition


def test_force_beyond_friction_is_gross_slip() -> None:
    assert running_condition_of(result([5], [], failure_kind=SlidingError.kind)) == "gross slip"
