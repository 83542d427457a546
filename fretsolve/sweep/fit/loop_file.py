"""Read the force and the motion of a measured loop from a CSV file, whose headings hold the units."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fretsolve.case.dimensions import Dimension
from fretsolve.case.other_names import nearest
from fretsolve.case.quantities import QuantityError, shown, to_internal
from fretsolve.errors import CaseError
from fretsolve.system.arrays import DoubleArray
from fretsolve.system.files import read_bytes, reported

FEWEST_POINTS = 10
"""Points of a loop below which nothing can be said of its shape and of its noise."""

MOST_LINES_ABOVE = 50
"""Lines among which headings are looked for that do not stand in the first one."""

_LARGEST_FILE = 2**26
_HEADING = re.compile(r"(.+?)\s*[(\[](.+)[)\]]\s*$")
_COMMA_NUMBER = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")


def read_loop_file(
    path: Path, names: tuple[str, str], dimensions: tuple[Dimension, Dimension]
) -> tuple[DoubleArray, DoubleArray]:
    """Return force and motion ``(n,)`` in internal units (N, mm, rad) in the order of the rows.

    names: of the two columns, with or without their units; dimensions: of the two. Cells are separated by commas, or by
    semicolons or tabs, with which numbers may have decimal commas. Raises CaseError with the line, FileError.
    """
    lines = _lines(path)
    delimiter = next((one for one in "\t;" if one in lines[0][1]), ",")
    (first, headings), *rows = [(number, _cells(line, delimiter)) for number, line in lines]
    example = f"'{names[0]} (N)' and '{names[1]} (um)'"
    if len(headings) < 2:
        raise CaseError(f"has one column; two, such as {example}, are needed", (), path, first)
    if all(_number(cell) is not None for cell in headings):
        raise CaseError(f"the first line holds numbers; headings such as {example} are needed", (), path, first)
    for number, cells in rows[:MOST_LINES_ABOVE]:
        if set(names) <= {bare_name(cell) for cell in cells}:
            raise CaseError(
                f"line {number} has the headings; remove the lines above it, or begin them with #", (), path
            )
    columns = [_column(headings, name, path, first) for name in names]
    if columns[0] == columns[1]:
        raise CaseError(f"{names[0]} and {names[1]} are one column; two are needed", (), path, first)
    units = [_unit(headings[c], d, path, first) for c, d in zip(columns, dimensions, strict=True)]
    _require_one_decimal_sign([row[c] for _, row in rows for c in columns if c < len(row)], path)
    read = [[_value(row, column, headings, path, number) for column in columns] for number, row in rows]
    values = np.array(read).reshape(-1, 2)
    if len(values) < FEWEST_POINTS:
        raise CaseError(f"has {len(values)} points; at least {FEWEST_POINTS} are needed", (), path)
    for column, one in zip(columns, values.T, strict=True):
        if np.ptp(one) == 0.0:
            raise CaseError(f"the column {headings[column]!r} is constant; a loop moves force and motion", (), path)
    return values[:, 0] * units[0], values[:, 1] * units[1]


def _lines(path: Path) -> list[tuple[int, str]]:
    """Return the lines that hold something, with their numbers from 1. Raises CaseError, FileError."""
    with reported("cannot be read", path):
        content = read_bytes(path, _LARGEST_FILE)
    of_windows = content.startswith((b"\xff\xfe", b"\xfe\xff"))  # marks of UTF-16
    try:
        text = content.decode("utf-16" if of_windows else "utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise CaseError(
            f"byte 0x{content[error.start]:02x} is not UTF-8 text; save the file as UTF-8", (), path, line
        ) from None
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    if not lines:
        raise CaseError("is empty; a CSV with headings is needed", (), path)
    return lines


def _cells(line: str, delimiter: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]


def bare_name(heading: str) -> str:
    """Return a heading without its unit."""
    match = _HEADING.match(heading)
    return match[1] if match else heading


def _column(headings: Sequence[str], name: str, path: Path, line: int) -> int:
    """Return the number of the column with this heading, whose unit may be left out."""
    bare = list(map(bare_name, headings))
    for candidates in (headings, bare):
        found = [index for index, one in enumerate(candidates) if one == name]
        if len(found) > 1:
            raise CaseError(f"the column {name!r} is there {len(found)} times; one is needed", (), path, line)
        if found:
            return found[0]
    message = f"no column {name!r}; {nearest(name, bare)} (--columns FORCE,MOTION takes other names)"
    raise CaseError(message, (), path, line)


def _unit(heading: str, dimension: Dimension, path: Path, line: int) -> float:
    """Return one unit of a column in the internal unit."""
    match = _HEADING.match(heading)
    if match is None:
        needed = f"{heading} ({'um' if dimension.unit == 'mm' else dimension.unit})"
        raise CaseError(f"the heading {heading!r} has no unit; one such as {needed!r} is needed", (), path, line)
    try:
        return to_internal(match[2], dimension, bare_unit=True)
    except QuantityError as error:
        raise CaseError(f"the heading {heading!r}: {error}", (), path, line) from None


def _require_one_decimal_sign(cells: Sequence[str], path: Path) -> None:
    if any(_COMMA_NUMBER.fullmatch(cell) for cell in cells) and any("." in cell for cell in cells):
        raise CaseError("mixes decimal points and decimal commas; one of the two is needed", (), path)


def _number(cell: str) -> float | None:
    """Return the number in a cell, None without one."""
    try:
        return float(cell.replace(",", ".") if _COMMA_NUMBER.fullmatch(cell) else cell)
    except ValueError:
        return None


def _value(row: Sequence[str], column: int, headings: Sequence[str], path: Path, line: int) -> float:
    text = row[column] if column < len(row) else ""
    number = _number(text)
    if number is None or not math.isfinite(number):
        kind = "is no number" if number is None else "is not finite"
        message = f"{shown(text)} in the column {headings[column]!r} {kind}; a number such as 12.5 is needed"
        raise CaseError(message, (), path, line)
    return number
