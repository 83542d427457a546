"""Units as other programs write them into their files."""

from __future__ import annotations

import re
from contextlib import suppress

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.quantities import QuantityError, to_internal

_NAMES = {"å": 1e-7, "angstrom": 1e-7, "angstroms": 1e-7, "inches": 25.4}
"""mm of names that a case does not know, in small letters."""

_TWICE = re.compile(r"([^\[(]*[^\[(\s])\s*[\[(]([^\])]+)")
"""A unit and, in brackets, its name."""


def length_unit(text: object) -> float | None:
    """Return the mm of a unit of length, such as ``um``, ``[µm]``, ``Micrometers`` or ``um (micrometers)``, else None.

    Capitals count in short units alone, where they tell prefixes apart. UTF-8 text that a program took for Latin-1
    (``Âµm``) is put right.
    """
    if not isinstance(text, str):
        return None
    name = text.strip("[](){} ")
    with suppress(UnicodeError):
        name = name.encode("latin-1").decode("utf-8")
    if (twice := _TWICE.fullmatch(name)) is not None:
        first, second = length_unit(twice[1]), length_unit(twice[2])
        return first if first == second else None
    if name.lower() in _NAMES:
        return _NAMES[name.lower()]
    if not re.search(r"[^\W\d]", name):
        return None
    with suppress(QuantityError):
        unit = to_internal(name if len(name) < 5 else name.lower(), LENGTH, bare_unit=True)
        return unit if unit > 0 else None
    return None


def decoded(text: bytes) -> str:
    """Return text as UTF-8, else as the code page of Windows, whose programs write the micro sign so."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("cp1252", "replace")
