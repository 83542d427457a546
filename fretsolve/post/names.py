"""Names, units and words of stresses, fatigue parameters and cracks, and their files. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, get_args

from fretsolve.case.keys.output_spec import CriterionName

CRITERIA: tuple[CriterionName, ...] = get_args(CriterionName)
"""Names of the criteria."""


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


PARAMETERS = {
    "crossland": "Crossland parameter",
    "dang_van": "Dang Van parameter",
    "findley": "Findley parameter",
    "mcdiarmid": "McDiarmid parameter",
    "fatemi_socie": "Fatemi-Socie parameter",
    "swt": "SWT parameter",
    "ruiz_1": "Ruiz's first parameter",
    "ruiz_2": "Ruiz's second parameter",
}
"""Parameters in words, by their names in files."""


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


BESIDE = {"stress": PEAK_NAMES, "fatigue": (*WORST_NAMES, *LIFE_NAMES), "crack": CRACK_NAMES}
"""What sweeps collect from files beside a result, by the key of `output` that asks for the file."""

UNITS = {
    **dict.fromkeys((*PEAK_NAMES, *WORST_NAMES), "MPa"),
    "fatemi_socie_max": "1",
    **dict.fromkeys(("ruiz_1_max", "ruiz_2_max"), "MPa^2 mm"),
    **dict.fromkeys((*LIFE_NAMES, "crack_life"), "cycles"),
    "crack_arrest_length": "mm",
}
"""Units of what sweeps collect from files beside a result."""

IN_WORDS = {
    "max_mises": "largest von Mises stress",
    "max_tension": "largest tension",
    "max_tresca": "largest shear stress (Tresca)",
    **{f"{name}_max": f"largest {words}" for name, words in PARAMETERS.items()},
    **{f"{name}_life": f"life by {words.removesuffix(' parameter')}" for name, words in PARAMETERS.items()},
    "crack_arrest_length": "length at which the crack stops",
    "crack_life": "life of the crack",
}
"""The same quantities in words."""

ENDLESS = {**dict.fromkeys((*LIFE_NAMES, "crack_life"), "run-out"), "crack_arrest_length": "goes through"}
"""The meaning of inf among these quantities."""


def stress_path(result: Path) -> Path:
    """Return the name of the file of stresses beside a result."""
    return result.with_suffix(".stress.h5")
