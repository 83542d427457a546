"""pyFFTW without what its wrappers import, which nothing here uses.

SciPy's transforms take a tenth of a second of every process, Dask, where it is installed (the extra `scale`), 0.6 s and
90 MB. So both count as absent while pyFFTW is imported.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _without(module: str) -> Iterator[None]:
    """Have `module` count as absent, unless it is imported already."""
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
