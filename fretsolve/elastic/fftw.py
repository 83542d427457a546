"""pyFFTW, imported without the packages that only its wrappers need.

SciPy's transforms would take 0.1 s of every process; Dask, if installed (the extra `scale`), 0.6 s and 90 MB. Both
count as absent while pyFFTW is imported.
"""

from __future__ import annotations

import sys

_hidden = [name for name in ("dask", "scipy.fftpack") if name not in sys.modules]
sys.modules.update(dict.fromkeys(_hidden))  # type: ignore[arg-type]
try:
    import pyfftw
finally:
    for _name in _hidden:
        del sys.modules[_name]

__all__ = ["pyfftw"]
