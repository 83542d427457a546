"""Names, units and words of stresses, fatigue parameters and cracks, and their files. Loads no NumPy."""

from __future__ import annotations

from pathlib import Path

from fretsolve.case.keys.quantity_names import BESIDE_DIMENSIONS, LIFE_NAMES

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


OUTERMOST = "in the last cells that were looked at: it may be larger beyond; a larger --window shows"
"""What is said of a largest value at the end of the window."""


UNITS = {
    **{name: dimension.stored for name, dimension in BESIDE_DIMENSIONS.items()},
    **dict.fromkeys((*LIFE_NAMES, "crack_life"), "cycles"),
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
