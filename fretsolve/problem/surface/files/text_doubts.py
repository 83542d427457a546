"""Tell where the numbers of a text may mean something else: commas, labels of axes, columns beside points x y z."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from fretsolve.problem.surface.files.point_lists import gridded
from fretsolve.system.arrays import DoubleArray

EVEN = 1e-3
"""Largest difference of the steps of an axis, over the step: labels are rounded."""

_LEADING_ZERO = re.compile(r"[+-]?0\d+", re.ASCII)
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}", re.ASCII)


def comma_doubt(lines: Iterable[tuple[int, str]], separator: str | None) -> str | None:
    """Return what decimal commas are read as where they may part thousands, None where there is no doubt.

    lines: some lines of numbers with their places in the file. Raises ValueError where commas seem to separate numbers
    and to stand for decimals at once.
    """
    example = None
    for number, line in lines:
        fields = [field.strip() for field in (line.split() if separator is None else line.split(separator))]
        if separator == ",":
            if "." not in line and any(_LEADING_ZERO.fullmatch(field) for field in fields):
                raise ValueError(
                    f"line {number}: commas seem to separate numbers and to stand for decimals at once; separate the"
                    " numbers by ; or write decimal points"
                )
            continue
        found = [field for field in fields if "," in field]
        if not all(map(_THOUSANDS.fullmatch, found)):
            return None
        example = example or next(iter(found), None)
    return None if example is None else f"decimal commas: {example!r} is read as {example.replace(',', '.')}"


def label_doubt(table: DoubleArray) -> str | None:
    """Return the doubt that the first line or column of a matrix labels an axis: it alone counts evenly."""
    for name, lines in (("line", table), ("column", table.T)):
        if len(lines) < 3 or lines.shape[1] < 4:
            continue
        if _counts(lines[0, 1:]) and not _counts(lines[1, 1:]):
            first, last = lines[0, 1], lines[0, -1]
            return f"the first {name} counts evenly from {first:g} to {last:g}, as labels do; remove it if it is one"
    return None


def _counts(values: DoubleArray) -> bool:
    steps = np.diff(values)
    return bool(np.isfinite(steps).all() and steps[0] != 0.0 and np.ptp(steps) <= EVEN * abs(steps[0]))


def require_no_points(table: DoubleArray, lines: NDArray[np.intc]) -> None:
    """Raise ValueError if three of a few columns are points x y z of a grid, beside an intensity or an index."""
    rows, columns = table.shape
    if not (4 <= columns <= 6 and rows > 4 * columns):
        return
    for first in range(columns - 2):
        try:
            gridded(table[:, first : first + 3], lines)
        except ValueError:
            continue
        raise ValueError(
            f"columns {first + 1} to {first + 3} of its {columns} are points x y z of a grid; remove the others"
        )
