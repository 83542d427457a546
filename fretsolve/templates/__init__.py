"""Cases to start from, as `fretsolve new` writes them."""

from __future__ import annotations

TEMPLATES = ("hertz", "mode1", "mode2", "mode3", "gross-slip", "rough")
"""Their names, as the command line has them."""
