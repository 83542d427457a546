"""Kernels bound to a grid: on a large one in parts of its rows, which the threads of a team share.

The size of a part is fixed, and what the parts return is joined in their order. So no bit of a result depends on the
number of threads. With kernels in NumPy no temporary array is larger than a part, which also saves memory.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from functools import partial
from types import ModuleType, SimpleNamespace
from typing import Any, TypeVar

import numpy as np

from fretsolve.system.arrays import BoolArray, DoubleArray, FloatArray

PART_CELLS = 2**16
"""Cells of a part, about. With half of it calls take 2 % of an increment of mode I.3 on 1024 x 1024 points."""

WHOLE = {"y", "rigid", "motions", "amplitudes"}
"""Arguments of passes that all parts take as a whole: those without cells, and what belongs to columns."""

Found = TypeVar("Found")

Pass = Callable[..., Any]
Share = Callable[[Callable[[int, int], None], Sequence[int]], None]
"""Calls its first argument for a thread and each of some numbers, as `fretsolve.elastic.thread_team.ThreadTeam`."""


def add_up(results: Sequence[Any]) -> Any:
    """Return the sum of numbers or arrays, or of each entry of tuples."""
    if isinstance(results[0], tuple):
        return tuple(map(add_up, zip(*results, strict=True)))
    return sum(results[1:], results[0])


def largest_of(results: Sequence[Any]) -> Any:
    """Return the largest number, NaN if there is one, or the largest of each entry of tuples."""
    if isinstance(results[0], tuple):
        return tuple(map(largest_of, zip(*results, strict=True)))
    return math.nan if any(value != value for value in results) else max(results)


def nothing(results: Sequence[Any]) -> None:
    """Return nothing, as the parts did."""


PASSES: dict[str, dict[str, Callable[[Sequence[Any]], Any]]] = {
    "cg": {
        "constrain": add_up,
        "clear": nothing,
        "precondition": add_up,
        "turn": nothing,
        "apply": add_up,
        "advance": largest_of,
        "divide": add_up,
        "add": nothing,
        "largest": largest_of,
    },
    "friction": {
        "take_slip": add_up,
        "move": largest_of,
        "gram": add_up,
        "balance": add_up,
        "add_motion": nothing,
        "sum_motions": add_up,
        "violation": largest_of,
        "scale_tangential": nothing,
        "return_to_circle": nothing,
        "excess": largest_of,
    },
    "normal": {
        "sum_gaps": add_up,
        "take_gap": largest_of,
        "largest_change": largest_of,
        "gram": add_up,
        "sum_modes": add_up,
        "stretch": nothing,
    },
}
"""The passes of each module of kernels, and how to join what they return of some rows."""


class Steps:
    """Steps of the conjugate gradients on one grid, each made of `passes`; arguments as in `cg_numpy`.

    inverse_gram: (c' W c)^-1, (m, m).
    """

    def __init__(self, passes: Any):
        self._passes = passes
        self.constrain, self.add, self.largest = passes.constrain, passes.add, passes.largest

    def start(
        self,
        solution: FloatArray,
        displacement: FloatArray,
        direction: FloatArray,
        residual: FloatArray,
        image: FloatArray,
        stiffness: FloatArray,
        normal: FloatArray,
        zone: BoolArray,
        weight: FloatArray,
        constraints: FloatArray,
        inverse_gram: DoubleArray,
    ) -> float:
        """Begin at 0: set three fields to it, compute ``residual = P T residual`` (T9) and ``image = V residual``.

        Return the largest length of the residual in a cell (CG1).
        """
        self._passes.clear(solution, displacement, direction, image)
        _, moments = self._passes.apply(residual, residual, direction, stiffness, normal, zone, weight, constraints)
        amplitudes = -(inverse_gram @ moments)
        found: float = self._passes.advance(solution, residual, direction, image, weight, constraints, amplitudes, 1.0)
        return found

    def search(
        self,
        image: FloatArray,
        direction: FloatArray,
        residual: FloatArray,
        weight: FloatArray,
        normal: FloatArray,
        constraints: FloatArray,
        inverse_gram: DoubleArray,
        rho_before: float,
    ) -> float:
        """Compute z (T7) from the image and ``direction = P' z + (rho / rho_before) direction``.

        Return rho, the product of z with `residual` (CG2, CG3). If that is not positive, the direction stays. The image
        is overwritten.
        """
        rho, moments = self._passes.precondition(image, residual, weight, normal, constraints)
        if rho > 0.0:
            self._passes.turn(direction, image, weight, constraints, inverse_gram @ moments, rho / rho_before)
        return float(rho)

    def step(
        self,
        solution: FloatArray,
        displacement: FloatArray,
        residual: FloatArray,
        direction: FloatArray,
        moved: FloatArray,
        image: FloatArray,
        stiffness: FloatArray,
        normal: FloatArray,
        zone: BoolArray,
        weight: FloatArray,
        constraints: FloatArray,
        inverse_gram: DoubleArray,
        rho: float,
    ) -> tuple[float, float]:
        """Compute ``w = T (moved + S direction)`` in the zone, and step along the direction (CG4, CG5).

        moved: B times the direction. ``solution += alpha direction``, ``displacement += alpha moved`` and
        ``residual -= alpha P w`` (T9), with ``alpha = rho / kappa`` and kappa the product of direction and w; then
        ``image = V residual``. Return kappa and the largest length of the residual in a cell. If kappa is not positive,
        solution, displacement and residual stay.
        """
        kappa, moments = self._passes.apply(moved, image, direction, stiffness, normal, zone, weight, constraints)
        if not kappa > 0.0:
            return kappa, math.inf
        amplitudes, length = inverse_gram @ moments, rho / kappa
        self._passes.add(displacement, moved, length)
        return kappa, self._passes.advance(
            solution, residual, direction, image, weight, constraints, amplitudes, length
        )

    def normalise(self, field: FloatArray, result: FloatArray) -> tuple[float, float]:
        """Compute ``result = field / size``, in its precision, with the field's largest absolute value for the size.

        Return the size and the sum of the result's absolute values. If the size is 0, the result is not written.
        """
        size: float = self._passes.largest(field)
        return size, float(self._passes.divide(field, size, result)) if size else 0.0


def whole(module: ModuleType, kind: str, rows: int) -> Any:
    """Return compiled kernels that take all of `rows` in one call: whole steps of the conjugate gradients, too."""
    bound = {name: partial(getattr(module, name), 0, rows) for name in PASSES[kind]}
    if kind == "cg":
        bound |= {name: getattr(module, name) for name in ("start", "search", "step", "normalise")}
    return SimpleNamespace(**bound)


def in_parts(module: ModuleType, kind: str, compiled: bool, parts: Sequence[tuple[int, int]], share: Share) -> Any:
    """Return kernels that call those of `module` for each of the `parts`, from one row up to another."""

    def bound(name: str, join: Callable[[Sequence[Any]], Any]) -> Pass:
        """Return the kernel `name` over all parts; join: what the parts return, in their order."""
        of_rows = getattr(module, name) if compiled else _of_rows(getattr(module, name))

        def kernel(*arguments: Any) -> Any:
            return join(in_order(share, parts, lambda first, stop: of_rows(first, stop, *arguments)))

        return kernel

    passes = SimpleNamespace(**{name: bound(name, join) for name, join in PASSES[kind].items()})
    return Steps(passes) if kind == "cg" else passes


def in_order(share: Share, parts: Sequence[tuple[int, int]], compute: Callable[[int, int], Found]) -> list[Found]:
    """Return what ``compute(first, stop)`` returns for each of the `parts`, which are shared, in their order."""
    results: list[Any] = [None] * len(parts)

    def keep(member: int, number: int) -> None:
        results[number] = compute(*parts[number])

    share(keep, range(len(parts)))
    return results


def parts_of(shape: tuple[int, int]) -> list[tuple[int, int]]:
    """Cut the rows of a grid into parts of about equal size near PART_CELLS: one, or an even number for two threads."""
    rows, columns = shape
    parts = rows * columns / PART_CELLS
    size = -(-rows // (1 if parts < 1.5 else 2 * round(0.5 * parts)))
    return [(first, min(first + size, rows)) for first in range(0, rows, size)]


def _of_rows(function: Pass) -> Pass:
    """Return a kernel in NumPy with the first row and that after the last one before its own arguments."""
    names = list(inspect.signature(function).parameters)

    def cut(name: str, value: Any, rows: slice) -> Any:
        if name in WHOLE or not isinstance(value, np.ndarray):
            return value
        return value[rows] if name == "x" else value[..., rows, :]

    def kernel(first: int, stop: int, *arguments: Any) -> Any:
        rows = slice(first, stop)
        return function(*(cut(name, value, rows) for name, value in zip(names, arguments, strict=True)))

    return kernel
