"""Read what the lines above the heights of a text file say: units, spacing, size, counts.

The names are those of Gwyddion's and SPIP's text exports, of Keyence's CSV exports, and of plain `name: value` lines.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from fretsolve.case.dimensions import in_small_unit
from fretsolve.case.quantities import shown
from fretsolve.problem.surface.files.raw_map import AGREEMENT
from fretsolve.problem.surface.files.stated_units import length_unit

_ALONG_X = {
    "step x": ("dx", "delta x", "x spacing", "spacing x", "x step", "step x", "x pitch", "pitch x", "pixel size x"),
    "size x": ("x length", "x size", "size x", "sizex", "x range"),
    "count x": ("x pixels", "pixels x", "pixelsx"),
}
_CALIBRATION = ("xy calibration", "xy justierung", "xy캘리브레이션")
_NAMES = {
    "step": (
        "spacing",
        "pitch",
        "pixel size",
        "pixelsize",
        "pixel spacing",
        "point spacing",
        *_CALIBRATION,
        "cellsize",
    ),
    **_ALONG_X,
    **{
        fact.replace("x", "y"): tuple(re.sub(r"(?<![a-z])(d|size|pixels)?x\b", r"\1y", name) for name in names)
        for fact, names in _ALONG_X.items()
    },
    "xy unit": ("xy unit", "xy units", "lateral unit", "lateral units", "x unit", "x units", "y unit", "y units"),
    "unit": ("unit", "units", "einheit", "einheiten"),
    "nm per count": ("bit2nm",),
    "format": ("file format",),
    "lost": ("nodata value", "nodata", "no data value", "void value", "bad value", "invalid value", "fill value"),
}
_FACTS = {name: fact for fact, names in _NAMES.items() for name in names} | {
    **dict.fromkeys(("width", "breite", "幅"), "size x"),
    **dict.fromkeys(("height", "höhe", "高さ"), "size y"),
    **dict.fromkeys(("horizontal", "horizont", "가로", "columns", "ncols"), "count x"),
    **dict.fromkeys(("vertical", "vertikal", "세로", "rows", "nrows"), "count y"),
}
_VALUE_UNIT = re.compile(
    r"(?=.*(?:unit|einheit|unidad|単位))(?=.*(?:value|wert|valeur|valor|値|height|höhe|\bz\b|\bzunit))", re.DOTALL
)
_PAIR = re.compile(r"\s*([^:=：]{1,60}?)\s*[:=：]\s*(.*)")
_NUMBER = re.compile(r"\s*([+-]?\d+(?:[.,]\d*)?(?:[eE][+-]?\d+)?)\s*(.*)")
_PER_POINT = re.compile(r"\s*(?:/|\bper\b)\s*(?:pixel|px|point)s?\b", re.IGNORECASE)
_NAMED_UNIT = re.compile(r"\s*([^\W\d_][^\[\](){}/]*?)\s*[\[(/]\s*([^\[\](){}]*?)\s*[\])]?\s*")
_LAST_WORD = re.compile(r"\s*([^\W\d_].*?)\s+([^\W\d]+)\s*")
_BRACKETED = re.compile(r"[^\[\](]+[\[(][^\])]*[\])]")
_UNIT_IN_WORDS = re.compile(r"(.*\b(?:units?|einheit(?:en)?))\s+(\S.*)", re.IGNORECASE)
_OF_UNITS = re.compile(
    r"\b(?:units?|einheit(?:en)?|(?:nano|micro|milli)?met(?:er|re)s?|microns?|angstr[oö]ms?|inch(?:es)?)\b",
    re.IGNORECASE,
)
"""Words for which a line that is not understood is told."""
_HEIGHTS = ("z", "height", "heights", "höhe", "höhen")


@dataclass(frozen=True)
class Header:
    """The facts of a header. unit, xy_unit: mm of a unit of the heights, of x and y. stated, xy_stated: what it says
    instead of these units, if that is no length.

    lengths: of "step x", "step y", "size x", "size y", each the number and mm of its unit, if it has one. counts: of
    "count x", "count y". Each comes with the line that says so, from 1. remarks: on lines about units that are not
    understood.
    """

    unit: float | None
    xy_unit: float | None
    stated: str
    xy_stated: str
    lengths: dict[str, tuple[float, float | None, int]]
    counts: dict[str, tuple[int, int]]
    remarks: tuple[str, ...]

    def spacing(self, shape: tuple[int, int], of_points: tuple[float, ...] | None = None) -> tuple[float, ...] | None:
        """Return the spacing along x and y of so many points, in `xy_unit`, or None where the header lacks it.

        of_points: the spacing that the coordinates of the points have. Raises ValueError where the header contradicts
        itself or the points.
        """
        for fact, (count, line) in self.counts.items():
            found, what = (shape[0], "columns") if fact == "count x" else (shape[1], "rows")
            if count != found and not (shape[1] == 1 and count in shape):
                raise ValueError(f"line {line} says that it has {count} {what}, it has {found}")
        if of_points is not None:
            for axis, step in zip("xy", of_points, strict=False):
                if self.xy_unit is not None:
                    self._step(axis, 0, (step, 0))
            return of_points
        steps = [self._step(axis, count) for axis, count in zip("xy", shape, strict=True)]
        if shape[1] == 1:
            steps = steps[:1]
        return tuple(step for step in steps if step is not None) if None not in steps else None

    def _step(self, axis: str, count: int, points: tuple[float, int] | None = None) -> float | None:
        """Return the spacing along an axis by the step, else by the size over the number of points."""
        found = [] if points is None else [points]
        for kind, parts in (("step", 1), ("size", count)):
            if f"{kind} {axis}" in self.lengths and parts > 0:
                number, unit, line = self.lengths[f"{kind} {axis}"]
                scale = unit / self.xy_unit if unit is not None and self.xy_unit is not None else 1.0
                found.append((number * scale / parts, line))
        if len(found) == 2 and abs(found[0][0] - found[1][0]) > AGREEMENT * abs(found[0][0]):
            who = f"line {found[0][1]} says" if found[0][1] else "its points say"
            one, other = (
                f"{step:.6g}" if self.xy_unit is None else in_small_unit(step * self.xy_unit) for step, _ in found
            )
            raise ValueError(
                f"{who} that the spacing along {axis} is {one}, line {found[1][1]} that it is {other}; remove the line"
                " that is wrong"
            )
        return found[0][0] if found else None


def read_header(lines: Sequence[str], shape: tuple[int, int], columns: int, *, listed: bool) -> Header:
    """Return what the first lines of a file say of a map of so many points along x and y.

    columns: fields of a line of numbers. listed: whether the points have coordinates, whose unit need not be the one of
    lengths in the header. Raises ValueError where lines contradict one another.
    """
    said = _said(lines, columns)
    unit, stated = _stated_unit(said, "z unit", "unit")
    if unit is None and not stated and "nm per count" in said and (scale := _NUMBER.match(said["nm per count"][0])):
        unit = _decimal(scale[1]) * 1e-6
    spip = said.get("format", ("", 0))[0].strip().lower() == "ascii"
    xy_unit, xy_stated = _stated_unit(said, "xy unit", *(["unit"] if "z unit" in said else []))
    xy_unit = xy_unit or (1e-6 if spip else None)
    counts: dict[str, tuple[int, int]] = {
        fact: (int(said[fact][0]), said[fact][1])
        for fact in ("count x", "count y")
        if fact in said and said[fact][0].strip().isdecimal()
    }
    lengths: dict[str, tuple[float, float | None, int]] = {}
    for axis, count in zip("xy", shape, strict=True):
        for kind in ("step", "size"):
            text, line = said.get(f"{kind} {axis}") or ((said.get("step") or ("", 0)) if kind == "step" else ("", 0))
            number, own = _length_of(text, axis)
            if (
                number is None
                or number <= 0
                or (kind == "size" and not own and _is_count(number, count, xy_unit, spip))
            ):
                continue
            lengths[f"{kind} {axis}"] = (number, own or xy_unit, line)
    known = xy_unit if listed else xy_unit or next((own for _, own, _ in lengths.values() if own), None)
    remarks = tuple(
        f"line {number} is not understood: {shown(line.strip())}"
        for number, line in enumerate(lines, 1)
        if _OF_UNITS.search(line) and not _pairs(line) and not _headings(line, columns)
    )
    return Header(unit, known, stated, xy_stated if known is None else "", lengths, counts, remarks)


def lost_number(lines: Sequence[str]) -> float | None:
    """Return the number that stands for lost points, if a header names one."""
    text, _ = _said(lines, 0).get("lost", ("", 0))
    found = _NUMBER.fullmatch(text)
    return None if found is None else _decimal(found[1])


def unquoted(line: str) -> str:
    """Return a line without quotation marks; commas between quoted fields become semicolons."""
    if '"' not in line:
        return line
    parts = line.split('"')
    if not any(mark in part for part in parts[::2] for mark in ";\t"):
        parts[::2] = [part.replace(",", ";") for part in parts[::2]]
    return "".join(parts)


def _is_count(number: float, count: int, xy_unit: float | None, spip: bool) -> bool:
    """Return whether a width without a unit may count points."""
    return not spip and (xy_unit is None or number == count)


def _said(lines: Sequence[str], columns: int) -> dict[str, tuple[str, int]]:
    """Return the text and the line number of each fact in the lines."""
    said: dict[str, tuple[str, int]] = {}
    for number, line in enumerate(lines, 1):
        for fact, value in [*_pairs(line), *_headings(line, columns)]:
            first = said.setdefault(fact, (value, number))
            if (length_unit(first[0]) or first[0].strip().lower()) != (length_unit(value) or value.strip().lower()):
                raise ValueError(
                    f"line {first[1]} gives {shown(first[0])} as its {fact}, line {number} {shown(value)}; remove the"
                    " wrong line"
                )
    return said


def _pairs(line: str) -> list[tuple[str, str]]:
    """Return the fact of a line of name and value, if its name is known."""
    text = unquoted(line).lstrip("#%; \t").rstrip("\r\n;,\t ")
    match = _PAIR.fullmatch(text)
    if match is not None:
        name, value = match[1], match[2]
    else:
        mark = next((mark for mark in (";", "\t", ",") if mark in text), None)
        name, *rest = text.split(mark) if text else [""]
        value = " ".join(part.strip() for part in rest[:2])
        words = _UNIT_IN_WORDS.fullmatch(text) if mark is None else None
        if words is not None and length_unit(words[2]) is not None:
            name, value = words[1], words[2]
        elif mark is None and not _NUMBER.fullmatch(value):
            return []
    own = _NAMED_UNIT.fullmatch(name)
    if own is not None and length_unit(own[2]) is not None:
        name, value = own[1], f"{value} {own[2]}"
    name = re.sub(r"[\s_.-]+", " ", name.lower()).strip()
    fact = _FACTS.get(name) or ("z unit" if _VALUE_UNIT.match(name) else None)
    return [(fact, value)] if fact is not None and value.strip() else []


def _headings(line: str, columns: int) -> list[tuple[str, str]]:
    """Return the units in the headings of the columns, `x [mm]` or `x/mm`, or alone in a line below them.

    Raises ValueError where the columns are in another order.
    """
    text = unquoted(line).lstrip("#% \t").rstrip("\r\n;,\t ")
    separated = re.split(r"[;,\t]", text) if re.search(r"[;,\t]", text) else _BRACKETED.findall(text) or text.split()
    found = [_NAMED_UNIT.fullmatch(part) or _LAST_WORD.fullmatch(part) for part in separated]
    names = [(own[1] if own else part).strip().lower() for own, part in zip(found, separated, strict=True)]
    if len(names) == 1 and names[0] in _HEIGHTS:
        facts = ["z unit"]
    elif len(names) == columns and columns in (2, 3):
        facts, wanted = ["xy unit"] * (columns - 1) + ["z unit"], ["x", "y", "z"] if columns == 3 else ["x", "z"]
        letters = [name[:1] for name in names]
        if sorted(letters) == wanted and letters != wanted:
            raise ValueError(f"its columns are {', '.join(names)}; {', '.join(wanted)} in this order are needed")
    else:
        return []
    if all(length_unit(part) is not None for part in separated):
        return list(zip(facts, separated, strict=True))
    return [(fact, own[2]) for fact, own in zip(facts, found, strict=True) if own and length_unit(own[2]) is not None]


def _length_of(text: str, axis: str) -> tuple[float | None, float | None]:
    """Return the number and the unit (mm) of a length, or of a pair `1 x 2 um` that of one axis."""
    parts = re.split(r"\s*[x×]\s*", _PER_POINT.sub("", text))
    found = [_NUMBER.fullmatch(part.strip("[]() ")) for part in parts]
    one = found[-1] if axis == "y" else found[0]
    if one is None or len(parts) > 2:
        return None, None
    word = one[2] or (found[-1][2] if found[-1] is not None else "")
    own = length_unit(word)
    return (None, None) if word and own is None else (_decimal(one[1]), own)


def _decimal(text: str) -> float:
    return float(text.replace(",", "."))


def _stated_unit(said: dict[str, tuple[str, int]], *facts: str) -> tuple[float | None, str]:
    """Return the mm of the unit that the first of these facts states, or None and what it states instead."""
    text = next((said[fact][0].strip() for fact in facts if fact in said), "")
    unit = length_unit(text)
    is_none = text.strip("[]()- 1").lower() in ("", "px", "pixel", "pixels")
    return unit, "" if unit is not None or is_none else text
