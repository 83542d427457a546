"""Whether numba is to compile the pointwise kernels; loads nothing."""

from __future__ import annotations

import os
from importlib.util import find_spec


def compiler_wanted() -> bool:
    """numba is installed, and `FRETSOLVE_NUMBA=0` is not in the environment."""
    return os.environ.get("FRETSOLVE_NUMBA") != "0" and find_spec("numba") is not None
