"""The running condition of a contact under shear, as fretting maps have it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from fretsolve.errors import SlidingError

if TYPE_CHECKING:
    from fretsolve.result import Result

Regime = Literal["", "stick", "partial slip", "gross slip"]


def regime(result: Result) -> Regime:
    """Whether all of the contact slips somewhere on the path, a part of it does, or none; empty without shear.

    A run that ended since a force was beyond what friction carries is one of gross slip.
    """
    history = result.history
    if result.attributes.get("failure_kind") == SlidingError.kind:
        return "gross slip"
    if not result.increments or not history["max_shear"].any():
        return ""
    touching, sticking = history["contact_cells"], history["stick_cells"]
    if ((sticking == 0) & (touching > 0) & (history["max_shear"] > 0.0)).any():
        return "gross slip"
    return "partial slip" if (sticking < touching).any() else "stick"
