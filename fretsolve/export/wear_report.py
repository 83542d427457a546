"""Say in lines of text what wear has done in a result."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from fretsolve.case.dimensions import counted, in_small_unit, percent
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.result import Result
from fretsolve.system.arrays import IndexArray


def has_wear(result: Result) -> bool:
    """Return whether the history has wear."""
    return "wear_volume" in result.history


def rows_of_wear(result: Result, ends: IndexArray) -> IndexArray:
    """Return of the `ends` of stages those before any wear, those at which the surfaces change, and the last one."""
    shown = (result.history["cycles"][ends] == 0.0) | (result.history["jump"][ends] > 0.0)
    shown[-1:] = True
    chosen: IndexArray = ends[shown]
    return chosen


def about_rows(result: Result) -> Iterator[str]:
    """Yield a line on what the rows of the table are in which the surfaces change."""
    if has_wear(result) and result.history["jump"].any():
        yield "rows with a jump: the surfaces change after a solved cycle, at whose end the stick zone is given"


def wear_totals(result: Result) -> Iterator[str]:
    """Yield lines on the cycles that were solved and represented, on volume and depth, and on the stick area."""
    if not has_wear(result) or not result.increments:
        return
    history = result.history
    changes = np.flatnonzero(history["jump"] > 0.0)
    if not len(changes):
        yield "nothing is worn yet"
        return
    cycles, volume, error, depth = (
        float(history[name][-1]) for name in ("cycles", "wear_volume", "wear_error", "wear_depth_max")
    )
    from fretsolve.setup.worn_volume import error_by_grid  # few results have wear

    errors = {"the jumps": error or None, "the cells that stick": error_by_grid(result)}
    bars = [f"± {value:.1e} by {cause}" for cause, value in errors.items() if value is not None]
    spread = f" ({', '.join(bars)})" if bars else ""
    unit = result.units("wear_volume")
    yield (
        f"{cycles:g} cycles, for which {counted(len(changes), 'solved cycle')} stand, wear {volume:.5g} {unit}{spread},"
        f" {in_small_unit(depth, 4)} at the deepest place"
    )
    first, last = (float(history["stick_area"][step - 1]) for step in (changes[0], changes[-1]))
    if first > 0.0 and _cycles_that_wear(result) == 1:
        change = float(f"{100.0 * (last / first - 1.0):.2g}")
        # between unlike bodies each jump may take some of the stick zone
        unknown = "; its error is not estimated: compare a smaller tolerance" if result.coupling == "full" else ""
        yield (
            f"stick area at the end of the first solved cycle {first:.4g}, of the last one {last:.4g}"
            f" {result.units('stick_area')} ({change:+g} %){unknown}"
        )


def warning_of_wear(result: Result, jumps: Collection[WearJumps]) -> str | None:
    """Return a warning if the error by the jumps is larger than the tolerance, None otherwise.

    jumps: of the cycles of the case that stand for others.
    """
    if not has_wear(result) or not result.increments or not jumps:
        return None
    volume, error = (float(result.history[name][-1]) for name in ("wear_volume", "wear_error"))
    tolerance = max(one.tolerance for one in jumps)
    if error <= tolerance * volume:
        return None
    given = any(one.jump is not None for one in jumps)
    advice = "give a smaller jump, or jump: auto" if given else f"set tolerance: {percent(0.5 * tolerance)}, or a jump"
    return (
        f"wear: the jumps may have changed wear_volume by {percent(error / volume, 3)} (wear_error), more than the"
        f" tolerance of {percent(tolerance)}; to come within it, {advice}"
    )


def _cycles_that_wear(result: Result) -> int:
    """Return how many cycles of the load path stand for others; 0 if the case is not known."""
    stages = result.case.stages() if result.case is not None else ()
    return len({stage.wears.key for stage in stages if stage.wears is not None})
