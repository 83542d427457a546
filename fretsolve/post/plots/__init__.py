"""Draw results with matplotlib (the extra `plot`): a result comes in, a figure goes out.

One call is ``fretsolve.post.plots.loop(fretsolve.open_result("case.h5"))``. Each function returns the `Figure`;
`animation` returns a `FuncAnimation`. With `ax`, one Axes or several, a function draws one panel on each of them, in
their own style, until there are no more Axes; with `ax=Sheet(width=90, title=False)` the new figure is as wide, in mm,
and has no title. Neither pyplot nor its settings are touched. If the result cannot give
the picture, a `PictureError` says why. The kind `map` of the command line is `contact_map` here.
"""

from __future__ import annotations

from typing import Any

from fretsolve.errors import PictureError
from fretsolve.post.plots.kinds import KINDS
from fretsolve.post.plots.sheet import Sheet

_KIND_OF = {kind.drawn_by.partition(":")[2]: kind for kind in KINDS.values()}
__all__ = ["KINDS", "PictureError", "Sheet", *_KIND_OF]


def __getattr__(name: str) -> Any:
    """Import a public function on first use, so that the command line knows `KINDS` without matplotlib."""
    if name in _KIND_OF:
        return _KIND_OF[name].draw
    raise AttributeError(f"module 'fretsolve.post.plots' has no attribute {name!r}")
