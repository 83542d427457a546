"""The tables of `calibrate_error_bars.py`."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence

from calibration_rows import QUANTITIES, Cost, Row
from random_scenes import scene_of

from fretsolve.result.state import CORRECTED_SUFFIX


def share(rows: Sequence[bool]) -> str:
    """Return how many of them, in per cent."""
    return f"{sum(rows)} of {len(rows)} ({100.0 * sum(rows) / len(rows):.0f} %)"


def report_lines(rows: Mapping[str, Sequence[Row]], costs: Sequence[Cost], unsolved: Sequence[str]) -> Iterator[str]:
    """Yield the lines of the page: shares by group, a table by quantity, and the values outside of their bars."""
    yield "| | " + " | ".join(rows) + " |"
    yield "| --- " * (1 + len(rows)) + "|"
    ends = {group: [row for row in part if row.end] for group, part in rows.items()}
    for kind in (False, True):
        for label, value in SHARES.items():
            of_kind = [[row for row in part if row.corrected == kind] for part in ends.values()]
            yield f"| {label}{', corrected values' if kind else ''} | " + " | ".join(map(value, of_kind)) + " |"
    label, value = next(iter(SHARES.items()))
    yield f"| {label}, all increments | " + " | ".join(value(part) for part in rows.values()) + " |"
    for what, spent in spent_on(costs).items():
        yield from ("", f"Share of the coarse runs in all {what}: {spent}.")
    if unsolved:
        yield from ("", "Not compared, since a run has no solution:", "", *(f"- {line}" for line in unsolved))
    *_, (group, last) = ends.items()
    yield from ("", f"By scene, {group}, corrected values in brackets:", "", *by_scene(last, costs))
    yield from ("", f"By quantity, {group}:", "", *by_quantity(last))
    together = [row for part in ends.values() for row in part]
    yield from ("", "Values outside of their bars:", "", *outside(together))


def percent(part: float) -> str:
    """Return a share in whole per cent."""
    return f"{100.0 * part:.0f} %"


def whole_cases(rows: Sequence[Row]) -> str:
    """Return how many cases have every value inside its bar."""
    names = dict.fromkeys(row.case for row in rows)
    return share([all(row.inside for row in rows if row.case == name) for name in names])


SHARES: dict[str, Callable[[Sequence[Row]], str]] = {
    "true error inside the bar": lambda rows: share([row.inside for row in rows]),
    "bar within a factor of ten of the true error": lambda rows: share([row.near for row in rows]),
    "cases with every value inside its bar": whole_cases,
    "largest true error over its bar": lambda rows: f"{max(1.0 / row.ratio for row in rows):.2g}",
    "median of bar over true error": lambda rows: f"{statistics.median(row.ratio for row in rows):.2g}",
}


OF_SCENES = (
    "true error inside the bar",
    "cases with every value inside its bar",
    "largest true error over its bar",
    "median of bar over true error",
)
"""Shares that the table by scene has, in its order."""


def spent_on(costs: Sequence[Cost]) -> dict[str, str]:
    """Return the shares of the coarse runs in operator applications and time."""
    kinds = {"operator applications": [one.applications for one in costs], "time": [one.time for one in costs]}
    return {
        what: f"{percent(statistics.median(spent))} in the median case, {percent(max(spent))} at most"
        for what, spent in kinds.items()
    }


def by_scene(rows: Sequence[Row], costs: Sequence[Cost]) -> Iterator[str]:
    """Return a table with a row per kind of scene, and what its coarse runs take."""
    yield "| scene | inside | cases with every value inside | largest error over bar | median of bar over error |"
    yield "| --- | --- | --- | --- | --- |"
    scenes = sorted({scene_of(row.case) for row in rows})
    spent = {}
    for scene in scenes:
        of_scene = [row for row in rows if scene_of(row.case) == scene]
        cases = {row.case for row in of_scene}
        spent[scene] = spent_on([one for one in costs if one.case in cases])
        kinds = [[row for row in of_scene if row.corrected == kind] for kind in (False, True)]
        if not all(kinds):
            continue
        columns = (SHARES[label] for label in OF_SCENES)
        yield f"| {scene} | " + " | ".join(f"{value(kinds[0])} ({value(kinds[1])})" for value in columns) + " |"
    yield from ("", "Shares of their coarse runs:", "", "| scene | in all operator applications | in all time |")
    yield "| --- | --- | --- |"
    yield from (f"| {scene} | " + " | ".join(shares.values()) + " |" for scene, shares in spent.items())


def by_quantity(rows: Sequence[Row]) -> Iterator[str]:
    """Return a table with a row per quantity."""
    yield "| quantity | comparisons | inside | within a factor of ten | median of bar over error |"
    yield "| --- | --- | --- | --- | --- |"
    for name in [*QUANTITIES, *(name + CORRECTED_SUFFIX for name in QUANTITIES)]:
        its = [row for row in rows if row.quantity == name]
        if its:
            ratio = statistics.median(row.ratio for row in its)
            inside, near = (sum(kind) / len(its) for kind in ([r.inside for r in its], [r.near for r in its]))
            yield f"| {name} | {len(its)} | {percent(inside)} | {percent(near)} | {ratio:.2g} |"


def outside(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a table of the values whose true error is larger than their bar."""
    yield "| case | stage | quantity | found | true error | bar |"
    yield "| --- | --- | --- | --- | --- | --- |"
    yield from (row.line() for row in rows if not row.inside)
