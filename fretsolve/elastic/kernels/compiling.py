"""Mark loops that numba may compile, and bind a module of kernels in one of its two forms.

A kernel has two forms, side by side: NAME in NumPy runs everywhere, and NAME_loops is for numba (extra `fast`), which
loads within a second. The loops read and write each array once. The docstring of NAME holds for both forms, whose
results are equal up to the order of sums. Marked loops are no functions: numba is imported, and compiles them, when
`form_of` is asked for them. Python itself would take minutes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any

ENDING = "_loops"


@dataclass(frozen=True, eq=False)
class Loops:
    """A function for numba and the options with which it is compiled."""

    function: Callable[..., Any]
    options: dict[str, Any]


REORDERED = {"fastmath": {"reassoc", "contract", "nsz", "arcp"}}
"""Sums may be reordered into vector instructions. NaN and inf keep their meaning."""


def compiled(function: Any) -> Any:
    """Mark a kernel."""
    return Loops(function, REORDERED)


def exact(function: Any) -> Any:
    """Mark a kernel that rounds each product and each sum, as NumPy does.

    Then x and y can change places without a change of bits, since no product is taken up in a sum unrounded.
    """
    return Loops(function, {"fastmath": False})


def inlined(function: Any) -> Any:
    """Mark a function that kernels call, and whose code is put into each of them.

    Otherwise a process takes the code of the one that it loads first for all of them. They differ in the order of sums,
    so that a resumed run, which calls other kernels first, would give other bits.
    """
    return Loops(function, REORDERED | {"forceinline": True})


def form_of(module: ModuleType, compiled: bool) -> Any:
    """Return the kernels of a module by their names, in NumPy or compiled."""
    if not compiled:
        return module
    for names in (globals(), vars(module)):  # numba finds what loops call by its name
        names |= {name: _compiled_form(value) for name, value in names.items() if isinstance(value, Loops)}
    loops = {name.removesuffix(ENDING): value for name, value in vars(module).items() if name.endswith(ENDING)}
    return SimpleNamespace(**loops)


@cache
def _compiled_form(loops: Loops) -> Any:
    from fretsolve.elastic.kernels.numba_compiler import compiled_form

    return compiled_form(loops.function, loops.options)


@inlined
def larger(value: Any, other: Any) -> Any:
    """Return the larger of two numbers of one precision, or the one that is NaN."""
    return value if value > other or value != value else other


@inlined
def largest_of(values: Any) -> float:
    """Return the largest number of a row, or NaN if it holds one.

    Kernels first gather the largest of each column in a row: vector instructions do that, and keep NaN.
    """
    largest = values[0]
    for j in range(1, len(values)):
        largest = larger(values[j], largest)
    return float(largest)
