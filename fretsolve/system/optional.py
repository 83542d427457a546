"""Optional packages: whether numba is to be used, and how to install what is missing. Loads none of them."""

from __future__ import annotations

import os
from importlib.util import find_spec


def compiler_wanted() -> bool:
    """Return whether numba is installed and not switched off by `FRETSOLVE_NUMBA=0` in the environment."""
    return os.environ.get("FRETSOLVE_NUMBA") != "0" and find_spec("numba") is not None


def how_to_install(extra: str) -> str:
    """Return the command that installs an extra; fretsolve is installed from its sources."""
    return f"pip install '.[{extra}]' in a clone of fretsolve"
