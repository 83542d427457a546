"""Pointwise kernels of the solvers: arrays come in and are overwritten, a sum or a largest value goes out.

There are two forms of them. `NUMPY` runs everywhere. The other one is compiled by numba (extra `fast`), and reads and
writes each array once; loading it takes a second. Both give the same results up to the order of sums. A run chooses
one of them and binds it to its grids, for example ``kernels = load(compiled=True).on(grid.shape)``,
``kernels.cg.add(pressure, correction, factor)``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any

from fretsolve.kernels import cg_numpy, friction_numpy, normal_numpy, slots_numpy, spectral_numpy
from fretsolve.kernels.on_grid import Share, Steps, in_parts, parts_of, whole


@dataclass(frozen=True)
class GridKernels:
    """Kernels for fields on one grid: steps of the conjugate gradients, passes of slip law and normal problem."""

    cg: Any
    friction: Any
    normal: Any


ON_ANY_GRID = GridKernels(Steps(cg_numpy), friction_numpy, normal_numpy)
"""Kernels in NumPy, which take all rows of any grid at once."""


@dataclass(frozen=True)
class Kernels:
    """One form of the kernels: a module for each of its parts.

    zones: None without numba, where `fretsolve.simulation.zones` measures zones itself;
    compiled: by numba; why_not: numba's message, where it was asked for and cannot be used.
    """

    cg: ModuleType = cg_numpy
    friction: ModuleType = friction_numpy
    normal: ModuleType = normal_numpy
    spectral: ModuleType = spectral_numpy
    slots: ModuleType = slots_numpy
    zones: ModuleType | None = None
    compiled: bool = False
    why_not: str = ""

    def on(self, shape: tuple[int, int], share: Share | None = None) -> GridKernels:
        """Return the kernels for fields (nx, ny); on a large grid they `share` parts of it out among threads."""
        parts = parts_of(shape)
        modules = {"cg": self.cg, "friction": self.friction, "normal": self.normal}
        if share is not None and len(parts) > 1:
            return GridKernels(
                **{kind: in_parts(module, kind, self.compiled, parts, share) for kind, module in modules.items()}
            )
        if not self.compiled:
            return ON_ANY_GRID
        return GridKernels(**{kind: whole(module, kind, shape[0]) for kind, module in modules.items()})


NUMPY = Kernels()


@cache
def load(compiled: bool) -> Kernels:
    """Return the kernels, compiled by numba if that is asked for and possible."""
    if not compiled:
        return NUMPY
    try:
        from fretsolve.kernels import cg_numba, friction_numba, normal_numba, slots_numba, spectral_numba, zones_numba
    except Exception as error:  # numba may refuse NumPy's version, or find no place for its cache
        return Kernels(why_not=f"{type(error).__name__}: {error}")
    modules = cg_numba, friction_numba, normal_numba, spectral_numba, slots_numba, zones_numba
    return Kernels(*modules, compiled=True)


def when_compiling(tell: Callable[[], None]) -> None:
    """Call `tell` when a kernel has to be compiled, before the wait: once, and never without compiled kernels."""
    options = sys.modules.get("fretsolve.kernels.numba_options")  # loaded with the compiled kernels, if at all
    if options is not None:
        options.when_compiling(tell)


def compile_seconds() -> float:
    """Return the wall-clock time (s) of compiling kernels in this process; 0 if all of them were on disk."""
    return _clock("compile_seconds")


def readying_seconds() -> float:
    """Return the same with the time of reading them from disk. It is no part of the time of an increment."""
    return _clock("readying_seconds")


def _clock(name: str) -> float:
    options = sys.modules.get("fretsolve.kernels.numba_options")  # loaded with the compiled kernels, if at all
    return float(getattr(options, name)()) if options is not None else 0.0


__all__ = [
    "NUMPY",
    "ON_ANY_GRID",
    "GridKernels",
    "Kernels",
    "compile_seconds",
    "load",
    "readying_seconds",
    "when_compiling",
]
