"""Pointwise kernels of the solvers: arrays come in and are overwritten, a sum or a largest value goes out.

There are two forms of each, in NumPy and compiled by numba, side by side in a module (`compiling`). A run
chooses one of the forms: ``kernels = load(compiled=True)``. `spectral` and `cosine_coefficients` serve the
convolutions of the elastic operator; the kernels of contact solvers are in `fretsolve.contact.kernels`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

from fretsolve.elastic.kernels import cosine_coefficients, spectral
from fretsolve.elastic.kernels.compiling import form_of

COMPILER = "fretsolve.elastic.kernels.numba_compiler"


@dataclass(frozen=True)
class Kernels:
    """One form of the kernels, and the kernels of convolutions in it.

    compiled: by numba; why_not: numba's message, where it was asked for and cannot be used.
    """

    spectral: Any = spectral
    cosine_coefficients: Any = cosine_coefficients
    compiled: bool = False
    why_not: str = ""


NUMPY = Kernels()


@cache
def load(compiled: bool) -> Kernels:
    """Return the kernels, compiled by numba if that is asked for and possible."""
    if not compiled:
        return NUMPY
    try:
        return Kernels(form_of(spectral, True), form_of(cosine_coefficients, True), compiled=True)
    except Exception as error:  # numba may refuse NumPy's version, or find no place for its cache
        return Kernels(why_not=f"{type(error).__name__}: {error}")


def when_compiling(tell: Callable[[], None]) -> None:
    """Call `tell` when a kernel has to be compiled, before the wait: once, and never without compiled kernels."""
    if compiler := sys.modules.get(COMPILER):  # loaded with the compiled kernels, if at all
        compiler.when_compiling(tell)


def compile_seconds() -> float:
    """Return the wall-clock time (s) of compiling kernels in this process; 0 if all of them were on disk."""
    return _clock("compile_seconds")


def readying_seconds() -> float:
    """Return the time (s) of compiling kernels and of reading them from disk, which is no part of an increment."""
    return _clock("readying_seconds")


def _clock(name: str) -> float:
    compiler = sys.modules.get(COMPILER)
    return float(getattr(compiler, name)()) if compiler else 0.0


__all__ = ["NUMPY", "Kernels", "compile_seconds", "load", "readying_seconds", "when_compiling"]
