"""Pointwise kernels: compiled by numba where it is installed (extra `fast`), in NumPy elsewhere.

`FRETSOLVE_NUMBA=0` in the environment chooses NumPy. Both give the same results, up to the order in which sums are
rounded. Compiled, each array is read and written once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fretsolve.compiler import compiler_wanted
from fretsolve.pointwise import cg_plain as cg
from fretsolve.pointwise import friction_plain as friction
from fretsolve.pointwise import normal_plain as normal
from fretsolve.pointwise import spectral_plain as spectral

COMPILED = False
WHY_NOT = ""
"""What numba says where it is installed and cannot be used."""


def compile_seconds() -> float:
    """Wall-clock time (s) that compiling the kernels has taken in this process."""
    return 0.0


def readying_seconds() -> float:
    """The same with reading them from disk, which is no part of any increment's time."""
    return 0.0


if not TYPE_CHECKING and compiler_wanted():
    try:
        from fretsolve.pointwise import cg_compiled, friction_compiled, normal_compiled, spectral_compiled
    except Exception as error:  # numba may refuse NumPy's version, or find no place for its cache
        WHY_NOT = f"{type(error).__name__}: {error}"
    else:
        from fretsolve.pointwise.compiling import compile_seconds, readying_seconds

        cg, friction, normal, spectral = cg_compiled, friction_compiled, normal_compiled, spectral_compiled
        COMPILED = True

__all__ = ["COMPILED", "WHY_NOT", "cg", "compile_seconds", "friction", "normal", "readying_seconds", "spectral"]
