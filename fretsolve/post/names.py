"""Names of stress quantities and fatigue parameters, and of their files. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, get_args

from fretsolve.case.keys.output_spec import CriterionName

CRITERIA: tuple[CriterionName, ...] = get_args(CriterionName)
"""Names of the criteria."""

SLIP_CRITERIA: tuple[CriterionName, ...] = ("ruiz-1", "ruiz-2")
"""Criteria of the surface, which need slip."""

STRESS_CRITERIA = tuple(name for name in CRITERIA if name not in SLIP_CRITERIA)
"""Criteria of stresses alone."""


def dataset_name(criterion: str) -> str:
    """Return the name of a criterion in files, such as dang_van."""
    return criterion.replace("-", "_")


LIFE_NAMES = {"swt_life": "swt", "fatemi_socie_life": "fatemi-socie"}
"""Names of the shortest lives by criteria with a life curve, which sweeps collect, with their criteria."""

CRACK_NAMES = ("crack_arrest_length", "crack_life")
"""What sweeps collect of a crack: the length (mm) at which it stops, 0 without one and inf where it goes through, and
its life in cycles."""

WORST_NAMES = {f"{dataset_name(criterion)}_max": criterion for criterion in CRITERIA}
"""Names of the largest values of the parameters, which sweeps collect, with their criteria."""


def fatigue_path(source: Path) -> Path:
    """Return the name of the file of fatigue parameters beside a result or a file of stresses."""
    return source.with_name(source.name.removesuffix(source.suffix).removesuffix(".stress") + ".fatigue.h5")


def crack_path(result: Path) -> Path:
    """Return the name of the file of a crack beside a result."""
    return result.with_suffix(".crack.h5")


Invariant = Literal["mises", "tension", "tresca"]

INVARIANTS: tuple[Invariant, ...] = ("mises", "tension", "tresca")

OUTERMOST = "in the last cells that were looked at: it may be larger beyond; a larger --window shows"
"""What is said of a largest value at the end of the window."""

PEAK_NAMES = tuple(f"max_{name}" for name in INVARIANTS)
"""Columns with the largest stresses."""


def stress_path(result: Path) -> Path:
    """Return the name of the file of stresses beside a result."""
    return result.with_suffix(".stress.h5")
