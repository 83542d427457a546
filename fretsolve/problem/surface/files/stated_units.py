"""Units as other programs write them into their files."""

from __future__ import annotations

from contextlib import suppress

from fretsolve.case.dimensions import LENGTH
from fretsolve.case.quantities import QuantityError, split_quantity, to_internal

ANGSTROM = 1e-7
"""mm."""


def length_unit(text: object) -> float | None:
    """Return the mm of a unit of length, such as ``um``, ``µm`` or ``micrometers``; None for anything else.

    UTF-8 text that a program took for Latin-1 (``Âµm``) is put right.
    """
    if not isinstance(text, str):
        return None
    name = text.strip().strip("[]()")
    with suppress(UnicodeError):
        name = name.encode("latin-1").decode("utf-8")
    if name.lower() in ("å", "angstrom", "angstroms"):
        return ANGSTROM
    for spelled in (name, name.lower()):
        with suppress(QuantityError):
            if split_quantity(f"1 {spelled}")[1]:
                return to_internal(f"1 {spelled}", LENGTH)
    return None
