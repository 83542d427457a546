"""Pointwise kernels of the solvers: arrays come in and are overwritten, a sum or a largest value goes out.

They are compiled by numba where it is installed (extra `fast`), and run in NumPy elsewhere or with `FRETSOLVE_NUMBA=0`
in the environment. Compiled, each array is read and written once. Both forms give the same results up to the order of
sums. Example: ``fretsolve.kernels.cg.add(pressure, correction, factor)``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fretsolve.kernels import cg_numpy as cg
from fretsolve.kernels import friction_numpy as friction
from fretsolve.kernels import normal_numpy as normal
from fretsolve.kernels import spectral_numpy as spectral
from fretsolve.system.environment import compiler_wanted

COMPILED = False
WHY_NOT = ""
"""Numba's message if it is installed and cannot be used."""


def compile_seconds() -> float:
    """Return the wall-clock time (s) of compiling the kernels in this process; 0 if all of them were on disk."""
    return 0.0


readying_seconds = compile_seconds
"""The same with the time of reading them from disk. It is no part of the time of an increment."""


if not TYPE_CHECKING and compiler_wanted():
    try:
        from fretsolve.kernels import cg_numba, friction_numba, normal_numba, spectral_numba
    except Exception as error:  # numba may refuse NumPy's version, or find no place for its cache
        WHY_NOT = f"{type(error).__name__}: {error}"
    else:
        from fretsolve.kernels.numba_options import compile_seconds, readying_seconds

        cg, friction, normal, spectral = cg_numba, friction_numba, normal_numba, spectral_numba
        COMPILED = True

__all__ = ["COMPILED", "WHY_NOT", "cg", "compile_seconds", "friction", "normal", "readying_seconds", "spectral"]
