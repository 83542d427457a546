"""Warn of numbers without a unit that are most likely meant in another one than the internal one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from fretsolve.case.quantities import QuantityError, split_quantity
from fretsolve.errors import KeyPath, dotted
from fretsolve.setup.problem_setup import ProblemSetup

SOFTEST = 1000.0
"""Young's modulus in MPa below which a bare number is most likely in GPa: metals and ceramics have more, and the number
of GPa is less."""


def _of_modulus(value: float) -> str | None:
    return f"{value:g} MPa; is GPa meant?" if value < SOFTEST else None


def _of_wear(value: float) -> str | None:
    return f"{value:g} mm^3/(N mm), {1e3 * value:g} mm^3/J; write which unit is meant"


def _of_angle(value: float) -> str | None:
    turns = abs(value) > 2.0 * math.pi
    return f"{value:g} rad, {math.degrees(value):.4g} deg; is '{value:g} deg' meant?" if turns else None


DOUBTS: dict[str, Callable[[float], str | None]] = {
    "young_modulus": _of_modulus,
    "alpha": _of_wear,
    "k": _of_wear,
    **dict.fromkeys(("angle", "axis", "phi_x", "phi_y", "phi_z"), _of_angle),
}
"""By the name of a key: what a bare number is, and the question, if there is one."""


def about_bare_numbers(setup: ProblemSetup) -> Iterator[str]:
    """Warn of bare numbers whose unit is most likely another one."""
    source = setup.case.source
    for key, value, doubt in _bare_numbers(source.data, ()):
        if (said := doubt(value)) is not None:
            yield f"{dotted(source.typed(key))}: {value:g} without a unit is {said}"


def _bare_numbers(value: Any, key: KeyPath) -> Iterator[tuple[KeyPath, float, Callable[[float], str | None]]]:
    """Yield the numbers without a unit of which there may be a doubt."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for part, inner in items:
        yield from _bare_numbers(inner, (*key, part))
    if key and (doubt := DOUBTS.get(str(key[-1]))) is not None:
        try:
            number, unit = split_quantity(value)
        except QuantityError:  # a word, as of an axis
            return
        if not unit:
            yield key, number, doubt
