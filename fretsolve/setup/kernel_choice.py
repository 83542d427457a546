"""Choose between kernels compiled by numba and those in NumPy.

The compiled ones are faster, but a process that uses them first loads numba, which takes longer than most runs on small
grids. So they are chosen where the whole path saves more than that. The choice depends on the case alone, so that a
resumed run gives the same bits.
"""

from __future__ import annotations

from fretsolve.model.required_terms import Model
from fretsolve.system.environment import compiler_asked, compiler_installed

LOAD_SECONDS = 0.8
"""Processor time of loading numba and the compiled kernels from disk."""

NORMAL, TANGENTIAL, COUPLED = (1e-3, 0.25e-6), (2e-3, 0.6e-6), (2e-3, 0.35e-6)
"""Seconds that the compiled kernels save per increment, and per increment and cell: in the normal problem, with the
tangential one as well, and where both are solved in turns. From 32 x 32 to 256 x 256 points the sum is right within a
third (`python benchmarks/bench_path.py`)."""


def seconds_saved(model: Model, cells: float, increments: int) -> float:
    """Return how many seconds the compiled kernels save in the increments of a run; cells: that are solved in each."""
    coupled = model.has_shear and model.terms.normal_tangential_coupling
    parts = [NORMAL, *[TANGENTIAL] * model.has_shear, *[COUPLED] * coupled]
    return increments * sum(per_call + per_cell * cells for per_call, per_cell in parts)


def compiling_pays(saved: float) -> bool:
    """Return whether to use the compiled kernels where they save `saved` seconds; the environment may decide it."""
    asked = compiler_asked()
    return compiler_installed() and (saved > LOAD_SECONDS if asked is None else asked)
