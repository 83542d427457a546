"""Read heights from text as instruments write it: a matrix, points x y z of a grid, or a profile.

A line of a matrix holds the heights along x at one y; the first line is the top, where y is largest.
"""

from __future__ import annotations

import codecs
import itertools
import math
import re
from array import array
from collections.abc import Generator, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import counted, in_small_unit
from fretsolve.case.quantities import shown
from fretsolve.problem.surface.files.point_lists import evened, gridded
from fretsolve.problem.surface.files.raw_map import AGREEMENT, MOST_HEIGHTS, RawMap
from fretsolve.problem.surface.files.text_doubts import comma_doubt, label_doubt, require_no_points
from fretsolve.problem.surface.files.text_header import Header, lost_number, read_header, unquoted
from fretsolve.system.arrays import DoubleArray

LONGEST_LINE = 2**24
"""Characters of a line."""

MOST_HEADER_LINES = 1000

LOST = "nan, Bad, void, invalid, missing, null, none, NA, N/A, #N/A, No Data, ***, ---"
"""Words for a lost point, as messages give them."""

_LOST = re.compile(
    r"[+-]?(?:nan(?:\(\w*\))?|inf(?:inity)?|1\.#\w+)|bad|void|invalid|missing|null|none|#?n/?a|no\s?data|\*+|-{1,3}",
    re.IGNORECASE,
)
_NO_DATA = re.compile(r"\bno\s+data\b", re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
_COMMA_NUMBER = re.compile(r"[+-]?\d+(?:,\d+)?(?:[eE][+-]?\d+)?", re.ASCII)
_COMMENT = re.compile(r"(?:^|(?<=[\s;,]))#(?!n/?a\b).*", re.IGNORECASE | re.DOTALL)
_LINE_END = "\r\n\x1a"
"""The last sign ends files of DOS."""


@dataclass(frozen=True)
class Layout:
    """The layout of a file. header: its first lines, without numbers. separator: of numbers, None for blanks."""

    header: tuple[str, ...]
    separator: str | None
    columns: int


def read_text(file: Path, *, line: bool) -> RawMap:
    """Read a map, or with `line` a profile, as `Layout` tells. Raises ValueError with the line at fault."""
    encoding = _encoding(file)
    try:
        with closing(_lines_of(file, encoding)) as text:
            layout = _layout(text)
        with closing(_lines_of(file, encoding)) as text:
            table, lines, commas = _table(text, layout)
    except UnicodeDecodeError:
        raise ValueError(f"it is cut short, or no {encoding} text") from None
    if (lost := lost_number(layout.header)) is not None:
        heights = table[:, -1:] if table.shape[1] == (2 if line else 3) else table  # coordinates may have that value
        heights[heights == lost] = np.nan
    raw = _profile(table, lines, layout) if line and table.shape[1] <= 2 else _map(table, lines, layout, line=line)
    first = len(layout.header)
    with closing(_lines_of(file, encoding)) as text:
        some = itertools.islice(enumerate(text, 1), first, first + MOST_HEADER_LINES)
        doubt = comma_doubt(some, layout.separator)
    doubts = raw.doubts if doubt is None else (*raw.doubts, doubt)
    return replace(raw, remarks=(*raw.remarks, *(["decimal commas"] if commas else [])), doubts=doubts)


def _map(table: DoubleArray, lines: NDArray[np.intc], layout: Layout, *, line: bool) -> RawMap:
    """Return the map of a matrix, or of points x y z."""
    remark: str | None
    of_points, start, doubts = None, (0.0, 0.0), []
    if table.shape[1] == 2:
        raise ValueError("its 2 columns are x and z of a profile, for plane: strain; a map has more columns, or x y z")
    if table.shape[1] == 3 and not line:
        values, of_points, start, remark = gridded(table, lines)
    else:
        require_no_points(table, lines)
        doubts.append(label_doubt(table))
        values = table[::-1].T
        lost = int(np.count_nonzero(~np.isfinite(values)))
        remark = f"{lost} of {values.size} points are lost: holes" if lost else None
    shape = (values.shape[0], values.shape[1])
    header = read_header(layout.header, shape, table.shape[1], listed=of_points is not None)
    spacing = header.spacing(shape, of_points)
    x, y = spacing if spacing is not None and of_points is None and len(spacing) == 2 else (1.0, 1.0)
    if not math.isclose(x, y, rel_tol=AGREEMENT):
        doubts.append(f"the points of the header lie {x:g} apart along x, {y:g} along y; is the file cut short?")
    raw = _with_header(values, header, spacing, remark, _start(start, of_points, header.xy_unit))
    return replace(raw, doubts=tuple(doubt for doubt in doubts if doubt is not None))


def _profile(table: DoubleArray, lines: NDArray[np.intc], layout: Layout) -> RawMap:
    """Return the profile of a column z, or of columns x and z."""
    of_points, start, remark = None, 0.0, None
    if table.shape[1] == 2:
        values, step, remark = evened(table, lines)
        start = float(np.nanmin(table[:, 0]))
        of_points = (step,)
    else:
        values = table[:, 0]
    lost = int(np.count_nonzero(~np.isfinite(table[:, -1])))
    remarks = [remark, f"{lost} of {len(table)} points are lost: holes" if lost else None]
    header = read_header(layout.header, (len(values), 1), table.shape[1], listed=of_points is not None)
    remarks.append(_start((start,), of_points, header.xy_unit))
    return _with_header(values, header, header.spacing((len(values), 1), of_points), *remarks)


def _start(start: tuple[float, ...], steps: tuple[float, ...] | None, unit: float | None) -> str | None:
    """Return a remark on the first x and y of points, in `unit` (mm), unless that is 0: the place is not kept."""
    if steps is None or all(abs(first) < step / 2 for first, step in zip(start, steps, strict=True)):
        return None
    places = [f"{first:.6g}" if unit is None else in_small_unit(first * unit) for first in start]
    named = ", ".join(f"{axis} = {place}" for axis, place in zip("xy", places, strict=False))
    return f"its points begin at {named}, from which crop counts"


def _with_header(
    values: DoubleArray, header: Header, spacing: tuple[float, ...] | None, *remarks: str | None
) -> RawMap:
    """Return the map with what the header says of it, and remarks on that."""
    said = [] if header.unit is None else [f"heights in units of {_unit_text(header.unit)}"]
    if spacing is not None and header.xy_unit is not None:
        said += [f"spacing {' x '.join(in_small_unit(header.xy_unit * step) for step in spacing)}"]
    words = f"the file says: {', '.join(said)}" if said else None
    told = tuple(remark for remark in (words, *header.remarks, *remarks) if remark is not None)
    unknown = header.stated, header.xy_stated
    return RawMap(values, spacing, header.unit, header.xy_unit, told, (), *unknown)


def _unit_text(unit: float) -> str:
    return f"{1e-3 * unit:g} m" if unit >= 1e3 else in_small_unit(unit)


def _encoding(file: Path) -> str:
    """Return the encoding of a file; raises ValueError if it is no text."""
    with file.open("rb") as stream:
        head = stream.read(2**12)
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if head.startswith(codecs.BOM_UTF8):
        return "utf-8-sig"
    if 0 not in head:
        return "utf-8"
    even, odd = (head[start::2].count(0) for start in (0, 1))
    if min(even, odd) > 0 or 4 * max(even, odd) < len(head):
        raise ValueError("it is not text")
    return "utf-16-be" if even else "utf-16-le"


def _lines_of(file: Path, encoding: str) -> Generator[str, None, None]:
    """Yield the lines of a file. Raises ValueError at one that is too long for the memory that reading it takes.

    A line that is not UTF-8 is read in the code page of Windows, whose programs write the micro sign so.
    """
    with file.open(encoding=encoding, errors="surrogateescape" if encoding.startswith("utf-8") else "strict") as text:
        while line := text.readline(LONGEST_LINE + 1):
            if len(line) > LONGEST_LINE:
                raise ValueError(f"a line of it has more than {LONGEST_LINE} characters")
            if not line.isascii() and any("\udc80" <= sign <= "\udcff" for sign in line):
                line = line.encode("utf-8", "surrogateescape").decode("cp1252", "replace")
            yield line


def _layout(lines: Iterator[str]) -> Layout:
    """Return how a file is written, from its lines up to the first ones with numbers."""
    header: list[str] = []
    for line in lines:
        text = _plain(line)
        separator = _separator(text)
        fields = _fields(text, separator)
        numbers = sum(_is_number(field) for field in fields)
        if numbers and all(_is_number(field) or _is_lost(field) for field in fields):
            break
        if len(header) == MOST_HEADER_LINES:
            raise ValueError(f"its first {MOST_HEADER_LINES} lines hold no numbers")
        header.append(line[:1000])
    else:
        raise ValueError("it holds no numbers")
    if separator == "," and len(fields) == 2 and _COMMA_NUMBER.fullmatch(text.strip()):
        separator = _meaning_of_comma(text, lines, len(header) + 1)
        fields = _fields(text, separator)
    # Lines of lost points alone, right above, belong to the map; a line with a fault must not pass for a header.
    while header and (above := _fields(_plain(header[-1]), separator)) and all(map(_is_lost, above)):
        if len(above) != len(fields):
            break
        header.pop()
    for number, line in enumerate(header, 1):
        above = _fields(_plain(line), separator)
        count = sum(map(_is_number, above))
        if len(above) == len(fields) > 1 and (2 * count > len(above) or _is_number(above[0])):
            wrong = next(field for field in above if not _is_number(field) and not _is_lost(field))
            raise _not_a_number(wrong, number)
    return Layout(tuple(header), separator, len(fields))


def _separator(text: str) -> str | None:
    """Return what separates the numbers of a line; None for blanks, between which a comma is a decimal mark."""
    if ";" in text:
        return ";"
    if "\t" in text and not any(re.search(r"\S\s+\S", field) for field in text.split("\t")):
        return "\t"
    words = text.split()
    decimal = all(_COMMA_NUMBER.fullmatch(word) or _is_lost(word) for word in words)
    return "," if "," in text and not (decimal and len(words) > 1) else None


def _meaning_of_comma(text: str, lines: Iterator[str], number: int) -> str | None:
    """Return the separator of a file whose first line of numbers, of this line number, is of the form `1,5`."""
    for line in lines:
        plain = _plain(line).strip()
        if "." in plain or (plain and _separator(plain) == "," and not _COMMA_NUMBER.fullmatch(plain)):
            return ","
        if plain and "," not in plain:
            return None
    raise ValueError(
        f"{shown(text.strip())} in line {number} may be one number or two; write decimal points, or separate numbers by"
        " semicolons"
    )


def _plain(line: str) -> str:
    """Return a line without comment, quotation marks and line end."""
    if "#" in line:
        line = _COMMENT.sub("", line)
    return unquoted(line).rstrip(_LINE_END)


def _fields(text: str, separator: str | None) -> list[str]:
    """Return the fields of a line without comment, decimal commas as points; none of a blank line."""
    if separator != ",":
        text = text.replace(",", ".")
    if separator is None:
        return (_NO_DATA.sub("nan", text) if "o" in text or "O" in text else text).split()
    return text.split(separator) if text.strip() or (separator == "\t" and "\t" in text) else []


def _is_number(field: str) -> bool:
    return _NUMBER.fullmatch(field.strip()) is not None


def _is_lost(field: str) -> bool:
    return not field.strip() or _LOST.fullmatch(field.strip()) is not None


def _not_a_number(field: str, line: int) -> ValueError:
    return ValueError(f"line {line} holds {shown(field.strip())}, which is no number; a lost point is empty or {LOST}")


def _table(lines: Iterator[str], layout: Layout) -> tuple[DoubleArray, NDArray[np.intc], bool]:
    """Return the numbers (rows, columns), NaN for lost points, their lines (rows,), and whether commas are decimal."""
    heights, places, columns, separator = array("d"), array("i"), layout.columns, layout.separator
    most = MOST_HEIGHTS // columns * columns
    commas, points, used = False, False, 0
    for number, line in enumerate(itertools.islice(lines, len(layout.header), None), len(layout.header) + 1):
        text = _plain(line) if "#" in line or '"' in line else line.rstrip(_LINE_END)
        fields = _fields(text, separator)
        if not fields:
            continue
        if separator is not None and len(fields) == columns + 1 and not fields[-1].strip():
            fields.pop()
        if len(fields) != columns:
            raise ValueError(
                f"line {number} has {counted(len(fields), 'column')}, the lines above have {columns}; all need as many"
            )
        if len(heights) >= most:
            raise ValueError(f"it has more than {MOST_HEIGHTS} heights; give a part of it")
        places.append(number)
        heights.extend(_numbers(fields, number, plain="_" not in text))
        used = max(used, next((n for n in range(columns, used, -1) if fields[n - 1].strip()), 0))
        commas, points = commas or (separator != "," and "," in text), points or "." in text
        if commas and points and separator != ",":
            raise ValueError(f"line {number}: it has decimal commas as well as points; write one of the two")
    table = np.frombuffer(heights).reshape(-1, columns)
    # One separator may end the lines of a matrix, several those of a list; more empty columns are lost points.
    kept = table[:, : used if used <= 3 else max(used, columns - 1)]
    return kept, np.frombuffer(places, np.intc), commas


def _numbers(fields: list[str], line: int, *, plain: bool) -> list[float]:
    """Return the numbers of a line, NaN for lost points; plain: whether no field has the underscores of Python."""
    try:
        numbers = [float(field) for field in fields]
        if plain and math.inf not in numbers and -math.inf not in numbers:
            return numbers
    except ValueError:
        pass
    wrong = next((field for field in fields if not _is_number(field) and not _is_lost(field)), None)
    if wrong is not None:
        raise _not_a_number(wrong, line)
    numbers = [float(field) if _is_number(field) else math.nan for field in fields]
    if math.inf in map(abs, numbers):
        raise ValueError(f"line {line} holds a number of no possible height")
    return numbers
