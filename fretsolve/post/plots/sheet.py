"""Say what a new picture looks like, without matplotlib."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Sheet:
    """A new figure.

    width: in mm; by default 90 or 190, one or two columns of a journal, as it needs. title: whether it has one.
    dpi: dots per inch of pixels; a film has a third of them.
    """

    width: float | None = None
    title: bool = True
    dpi: int = 300
