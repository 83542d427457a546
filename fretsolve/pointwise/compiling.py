"""How numba compiles the pointwise kernels."""

from __future__ import annotations

from typing import Any

import numba


def kernel(function: Any) -> Any:
    """Compiled at the first call, and kept on disk where there is a place for it.

    Sums may be reordered into vector instructions; NaN and inf are minded.
    """
    fast = {"reassoc", "contract", "nsz", "arcp"}
    options: dict[str, Any] = {"nogil": True, "fastmath": fast, "error_model": "numpy"}
    try:
        return numba.njit(cache=True, **options)(function)
    except RuntimeError:  # neither the package's folder nor the user's cache can be written
        return numba.njit(**options)(function)
