"""Names of stress quantities and of their file. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

Invariant = Literal["mises", "tension", "tresca"]

INVARIANTS: tuple[Invariant, ...] = ("mises", "tension", "tresca")

OUTERMOST = "in the last cells that were looked at: it may be larger beyond; a larger --window shows"
"""What is said of a largest value at the end of the window."""

PEAK_NAMES = tuple(f"max_{name}" for name in INVARIANTS)
"""Columns with the largest stresses."""


def stress_path(result: Path) -> Path:
    """Return the name of the file of stresses beside a result."""
    return result.with_suffix(".stress.h5")
