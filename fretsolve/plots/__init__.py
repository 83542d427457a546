"""Draw results with matplotlib (the extra `plot`): a result comes in, a figure goes out.

One call is ``fretsolve.plots.loop(fretsolve.open_result("case.h5"))``. Each function returns the matplotlib `Figure`;
`animation` returns a `FuncAnimation`. Given `ax`, one Axes or several, it draws one panel on each of them, as far as
they reach, in the style that they have. Neither pyplot nor its settings are touched. If the result cannot give the
picture, a `PictureError` says why. The kind `map` of the command line is `contact_map` here.
"""

from __future__ import annotations

import importlib
from typing import Any

from fretsolve.errors import PictureError

KINDS = ("loop", "profiles", "map", "streamlines", "slip-angle", "stick-history", "convergence", "animate")
"""The kinds of pictures, by their names on the command line."""

# No module is called as a function is, which it would hide once it is imported.
_MODULES = {
    "loop": "histories",
    "profiles": "line_profiles",
    "contact_map": "maps",
    "streamlines": "directions",
    "slip_angle": "directions",
    "stick_history": "histories",
    "convergence": "histories",
    "animation": "animate",
}
__all__ = ["KINDS", "PictureError", *_MODULES]


def __getattr__(name: str) -> Any:
    """Import a public function on first use, so that the command line knows `KINDS` without matplotlib."""
    if name in _MODULES:
        return getattr(importlib.import_module(f"fretsolve.plots.{_MODULES[name]}"), name)
    raise AttributeError(f"module 'fretsolve.plots' has no attribute {name!r}")
