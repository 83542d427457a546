"""Passes over all cells of the contact solvers, in NumPy and compiled by numba: ``kernels_of(operator)`` binds them."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import SimpleNamespace
from typing import Any, Protocol
from weakref import WeakKeyDictionary

import numpy as np

from fretsolve.contact.kernels import cg, cg_steps, friction, normal
from fretsolve.contact.kernels.cg_steps import Steps
from fretsolve.elastic.kernels.compiling import form_of
from fretsolve.elastic.thread_team import Share, in_order, parts_of

WHOLE = {"y", "rigid", "motions", "amplitudes"}
"""Arguments of passes that all parts take as a whole: arguments without cells, and arguments per column."""

Join = Callable[[Sequence[Any]], Any]


def add_up(results: Sequence[Any]) -> Any:
    """Return the sum of numbers or arrays, or of each entry of tuples; None of None."""
    if isinstance(results[0], tuple):
        return tuple(map(add_up, zip(*results, strict=True)))
    return None if results[0] is None else sum(results[1:], results[0])


def largest_of(results: Sequence[Any]) -> Any:
    """Return the largest number, NaN if there is one, or the largest of each entry of tuples."""
    if isinstance(results[0], tuple):
        return tuple(map(largest_of, zip(*results, strict=True)))
    return math.nan if any(value != value for value in results) else max(results)


CG: dict[str, Join] = dict.fromkeys(("constrain", "clear", "precondition", "turn", "apply", "divide", "add"), add_up)
CG |= dict.fromkeys(("advance", "largest"), largest_of)
FRICTION: dict[str, Join] = dict.fromkeys(("take_slip", "gram", "balance", "add_motion", "sum_motions"), add_up)
FRICTION |= dict.fromkeys(("scale_tangential", "return_map"), add_up)
FRICTION |= dict.fromkeys(("move", "violation", "excess"), largest_of)
NORMAL: dict[str, Join] = dict.fromkeys(("sum_gaps", "gram", "sum_modes", "stretch"), add_up)
NORMAL |= dict.fromkeys(("take_gap", "largest_change"), largest_of)
"""The passes of each module of kernels, and how to join what they return of some rows."""


@dataclass(frozen=True)
class GridKernels:
    """Kernels for fields on one grid: steps of the conjugate gradients, passes of slip law and normal problem."""

    cg: Any
    friction: Any
    normal: Any


ON_ANY_GRID = GridKernels(Steps(cg), friction, normal)
"""Kernels in NumPy, which take all rows of any grid at once."""


class OnGrid(Protocol):
    """An operator on fields of one grid with a team of threads, as an elastic operator."""

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the grid."""

    @property
    def team(self) -> Any:
        """The threads, with the form of their kernels."""


_kept: WeakKeyDictionary[OnGrid, GridKernels] = WeakKeyDictionary()


def kernels_of(operator: OnGrid) -> GridKernels:
    """Return the kernels for the fields of an operator; its team shares the parts of a large grid."""
    found = _kept.get(operator)
    if found is None:
        team = operator.team
        found = _kept[operator] = kernels_on(operator.shape, team.kernels.compiled, team.share)
    return found


def kernels_on(shape: tuple[int, int], compiled: bool, share: Share | None = None) -> GridKernels:
    """Return the kernels for fields (nx, ny), compiled or not; threads `share` the parts of a large grid."""
    parts, modules = parts_of(shape), ((cg, CG), (friction, FRICTION), (normal, NORMAL))
    forms = [(form_of(module, compiled), joins) for module, joins in modules]
    if share is not None and len(parts) > 1:
        passes, slips, gaps = (_in_parts(kernels, joins, compiled, parts, share) for kernels, joins in forms)
        return GridKernels(Steps(passes), slips, gaps)
    if not compiled:
        return ON_ANY_GRID
    passes, slips, gaps = (_whole(kernels, joins, shape[0]) for kernels, joins in forms)
    return GridKernels(SimpleNamespace(**vars(form_of(cg_steps, compiled)) | vars(passes)), slips, gaps)


def _whole(kernels: Any, joins: Mapping[str, Join], rows: int) -> SimpleNamespace:
    return SimpleNamespace(**{name: partial(getattr(kernels, name), 0, rows) for name in joins})


def _in_parts(
    kernels: Any, joins: Mapping[str, Join], compiled: bool, parts: Sequence[tuple[int, int]], share: Share
) -> SimpleNamespace:
    """Return kernels that call a module's kernels for each of the `parts`, from one row up to another."""

    def bound(name: str, join: Join) -> Callable[..., Any]:
        of_rows = getattr(kernels, name) if compiled else _of_rows(getattr(kernels, name))

        def kernel(*arguments: Any) -> Any:
            return join(in_order(share, parts, lambda first, stop: of_rows(first, stop, *arguments)))

        return kernel

    return SimpleNamespace(**{name: bound(name, join) for name, join in joins.items()})


def _of_rows(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel in NumPy with the first row and the row after the last one before its own arguments."""
    names = list(inspect.signature(function).parameters)

    def cut(name: str, value: Any, rows: slice) -> Any:
        if name in WHOLE or not isinstance(value, np.ndarray):
            return value
        return value[rows] if name == "x" else value[..., rows, :]

    def kernel(first: int, stop: int, *arguments: Any) -> Any:
        rows = slice(first, stop)
        return function(*(cut(name, value, rows) for name, value in zip(names, arguments, strict=True)))

    return kernel
