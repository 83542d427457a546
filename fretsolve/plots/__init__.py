"""Pictures of results, for the command line and for notebooks; matplotlib (the extra `plot`) is needed.

Each function takes what `fretsolve.open_result` gives and returns the matplotlib `Figure`; `animation` returns a
`FuncAnimation`. Given `ax`, one Axes or several, it draws its panels there, one on each as far as they reach, in the
style that they have. Without, it makes a figure of its own. Neither pyplot nor its settings are touched. A picture
that the result cannot give is a `PictureError`. The kind `map` of the command line is `contact_map` here.
"""

from __future__ import annotations

import importlib
from typing import Any

from fretsolve.errors import PictureError

KINDS = (
    "loop",
    "profiles",
    "map",
    "streamlines",
    "slip-angle",
    "stick-history",
    "convergence",
    "animate",
)
"""The kinds of pictures, as the command line has them."""

_PUBLIC = {
    "loop": "loops",
    "profiles": "profiles",
    "contact_map": "maps",
    "streamlines": "stream",
    "slip_angle": "angles",
    "stick_history": "stick",
    "convergence": "residuals",
    "animation": "animation",
}
__all__ = [
    "KINDS",
    "PictureError",
    "animation",
    "contact_map",
    "convergence",
    "loop",
    "profiles",
    "slip_angle",
    "stick_history",
    "streamlines",
]


def __getattr__(name: str) -> Any:
    """Import the public functions on first use, so that the command line knows `KINDS` without matplotlib."""
    if name in _PUBLIC:
        return getattr(importlib.import_module(f"fretsolve.plots.{_PUBLIC[name]}"), name)
    raise AttributeError(f"module 'fretsolve.plots' has no attribute {name!r}")
