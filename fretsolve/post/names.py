"""Names of stress quantities and fatigue parameters, and of their files. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path

from fretsolve.case.keys.quantity_names import CRACK_NAMES as CRACK_NAMES
from fretsolve.case.keys.quantity_names import CRITERIA as CRITERIA
from fretsolve.case.keys.quantity_names import INVARIANTS as INVARIANTS
from fretsolve.case.keys.quantity_names import LIFE_NAMES as LIFE_NAMES
from fretsolve.case.keys.quantity_names import PEAK_NAMES as PEAK_NAMES
from fretsolve.case.keys.quantity_names import WORST_NAMES as WORST_NAMES
from fretsolve.case.keys.quantity_names import Invariant as Invariant
from fretsolve.case.keys.quantity_names import dataset_name as dataset_name


def fatigue_path(source: Path) -> Path:
    """Return the name of the file of fatigue parameters beside a result or a file of stresses."""
    return source.with_name(source.name.removesuffix(source.suffix).removesuffix(".stress") + ".fatigue.h5")


def crack_path(result: Path) -> Path:
    """Return the name of the file of a crack beside a result."""
    return result.with_suffix(".crack.h5")


OUTERMOST = "in the last cells that were looked at: it may be larger beyond; a larger --window shows"
"""What is said of a largest value at the end of the window."""


def stress_path(result: Path) -> Path:
    """Return the name of the file of stresses beside a result."""
    return result.with_suffix(".stress.h5")
