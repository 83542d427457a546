"""How numba compiles the pointwise kernels."""

from __future__ import annotations

import numba

kernel = numba.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "nsz", "arcp"}, error_model="numpy")
"""Compiled at the first call, kept on disk. Sums may be reordered into vector instructions; NaN and inf are minded."""
