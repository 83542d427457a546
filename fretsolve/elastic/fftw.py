"""pyFFTW, imported without the packages that only its wrappers need.

SciPy's transforms would take 0.1 s of every process; Dask, if installed (the extra `scale`), 0.6 s and 90 MB. Both
count as absent while pyFFTW is imported.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _without(module: str) -> Iterator[None]:
    """Let `module` count as absent, unless it is already imported."""
    hidden = module not in sys.modules
    if hidden:
        sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        if hidden:
            del sys.modules[module]


with _without("dask"), _without("scipy.fftpack"):
    import pyfftw

__all__ = ["pyfftw"]
