"""Read heights from text: a matrix, or points x y z of a regular grid."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TextIO

import numpy as np

from fretsolve.problem.surface.raw_map import MOST_HEIGHTS, RawMap
from fretsolve.system.arrays import DoubleArray

LONGEST_LINE = 2**24
"""Characters of a line."""


def read_text(file: Path, *, line: bool) -> RawMap:
    """Read a matrix, or points x, y, z (all in `unit`) of a regular grid."""
    try:
        with file.open(encoding="utf-8-sig") as text:
            lines = _lines_of(text)
            first = next((line for line in lines if line.split("#")[0].strip()), None)
            if first is None:
                raise ValueError("it holds no numbers")
            numbers = first.split("#")[0]
            delimiter = next((mark for mark in ",;" if mark in numbers), None)
            rows = MOST_HEIGHTS // len(numbers.split(delimiter))
            values = np.loadtxt(_at_most(rows, itertools.chain([first], lines)), delimiter=delimiter, ndmin=2)
    except UnicodeDecodeError as error:
        raise ValueError(f"{error.object[error.start : error.start + 1]!r} in it is not UTF-8 text") from None
    return _gridded(values) or RawMap(values)


def _lines_of(text: TextIO) -> Iterator[str]:
    """Yield the lines of a file. Raises ValueError at one that is too long for the memory that reading it takes."""
    while line := text.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise ValueError(f"a line of it has more than {LONGEST_LINE} characters")
        yield line


def _at_most(rows: int, lines: Iterable[str]) -> Iterator[str]:
    """Yield up to so many `lines`; raises ValueError if there are more."""
    for number, line in enumerate(lines):
        if number >= rows:
            raise ValueError(f"it has more than {MOST_HEIGHTS} heights; give a part of it")
        yield line


def _gridded(points: DoubleArray) -> RawMap | None:
    """Return the map whose points x, y, z the rows list in any order; None if they are not a regular grid."""
    if points.shape[1] != 3:
        return None
    x, column = np.unique(points[:, 0], return_inverse=True)
    y, row = np.unique(points[:, 1], return_inverse=True)
    if min(x.size, y.size) < 2 or x.size * y.size != len(points):
        return None
    values = np.full((x.size, y.size), np.inf)
    values[column, row] = points[:, 2]
    steps = [np.diff(axis) for axis in (x, y)]
    if np.isposinf(values).any() or any(np.ptp(step) > 1e-3 * step.mean() for step in steps):
        return None
    return RawMap(values, tuple(float(step.mean()) for step in steps))
