"""Pointwise kernels: compiled by numba where it is installed (extra `fast`), in NumPy elsewhere.

`FRETSOLVE_NUMBA=0` in the environment chooses NumPy. Both give the same results, up to the order in which sums are
rounded. Compiled, each array is read and written once.
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import TYPE_CHECKING

COMPILED = os.environ.get("FRETSOLVE_NUMBA") != "0" and find_spec("numba") is not None

if TYPE_CHECKING or not COMPILED:
    from fretsolve.pointwise import cg_plain as cg
    from fretsolve.pointwise import friction_plain as friction
    from fretsolve.pointwise import spectral_plain as spectral
else:
    from fretsolve.pointwise import cg_compiled as cg
    from fretsolve.pointwise import friction_compiled as friction
    from fretsolve.pointwise import spectral_compiled as spectral

__all__ = ["COMPILED", "cg", "friction", "spectral"]
