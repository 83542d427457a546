"""Names of stress quantities. Loads no NumPy."""

from __future__ import annotations

from typing import Literal

Invariant = Literal["mises", "tension", "tresca"]

INVARIANTS: tuple[Invariant, ...] = ("mises", "tension", "tresca")

PEAK_NAMES = tuple(f"max_{name}" for name in INVARIANTS)
"""Columns with the largest stresses."""
