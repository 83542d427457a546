"""pyFFTW without Dask.

Where Dask is installed (the extra `scale`), pyFFTW imports it for wrappers that nothing here uses: 0.6 s and 90 MB of
every process. So Dask counts as absent while pyFFTW is imported.
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


with _without("dask"):
    import pyfftw

__all__ = ["pyfftw"]
