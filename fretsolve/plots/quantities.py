"""Names, symbols and readable units on axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fretsolve.result.layout import FIELDS, HISTORY, X, Y

if TYPE_CHECKING:
    from fretsolve.result import Result

LEAST = 0.1
"""A unit is used where the largest value is at least this much of it."""

_SMALLER = {
    "mm": (("mm", 1.0), ("µm", 1e3), ("nm", 1e6)),
    "mJ": (("mJ", 1.0), ("µJ", 1e3), ("nJ", 1e6)),
    "mJ/mm^2": (("mJ/mm²", 1.0), ("µJ/mm²", 1e3), ("nJ/mm²", 1e6)),
    "rad": (("rad", 1.0), ("mrad", 1e3), ("µrad", 1e6)),
}

_SYMBOLS = {
    "P": "P",
    "Mx": "M_x",
    "My": "M_y",
    "Qx": "Q_x",
    "Qy": "Q_y",
    "Mz": "M_z",
    "delta_z": r"\delta_z",
    "delta_x": r"\delta_x",
    "delta_y": r"\delta_y",
    "phi_x": r"\varphi_x",
    "phi_y": r"\varphi_y",
    "phi_z": r"\varphi_z",
}

_LONG_NAMES = {quantity.name: quantity.long_name for quantity in (*HISTORY, *FIELDS, X, Y)}


@dataclass(frozen=True)
class Unit:
    """A unit as printed, and the factor that converts to it from the result's own."""

    text: str
    factor: float


def readable(unit: str, values: ArrayLike) -> Unit:
    """The unit of `unit`'s kind in which the largest of `values` has few zeros."""
    choices = _SMALLER.get(unit)
    if choices is None:
        return Unit(unit.replace("N mm", "N·mm").replace("^2", "²"), 1.0)
    finite = np.abs(np.asarray(values, dtype=float))
    largest = float(np.max(finite, where=np.isfinite(finite), initial=0.0))
    fitting = [Unit(*choice) for choice in choices if largest * choice[1] >= LEAST]
    return fitting[0] if fitting else Unit(*choices[-1 if largest else 0])


def symbol(name: str) -> str:
    """The symbol of a load component, for a label."""
    return f"${_SYMBOLS[name]}$"


def unit_of(result: Result, name: str) -> Unit:
    """The readable unit of a column of the history."""
    return readable(result.units(name), result.history[name])


def axis_label(name: str, unit: Unit) -> str:
    """Meaning, symbol and unit of a load component."""
    return f"{_LONG_NAMES[name]} {symbol(name)} ({unit.text})"


def short_number(value: float, scale: float) -> str:
    """`value` in four digits, 0 where it is round-off of `scale`."""
    return f"{value:.4g}" if abs(value) > 1e-9 * scale else "0"
