"""Say in lines of text what wear has done in a result, and find its spots of contact.

Spots are connected cells, of which a rough surface or several bodies have many.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import counted, in_small_unit, percent
from fretsolve.case.history import FEWEST_SPOT_CELLS
from fretsolve.case.keys.load_path_spec import WearJumps
from fretsolve.result import Result, layout
from fretsolve.result.state import Zone
from fretsolve.system.arrays import IndexArray


def has_wear(result: Result) -> bool:
    """Return whether the history has wear."""
    return "wear_volume" in result.history


def rows_of_wear(result: Result, ends: IndexArray) -> IndexArray:
    """Return the `ends` of stages before any wear, the ends at which the surfaces change, and the last end.

    Where the surfaces never change it is all ends.
    """
    if not result.history["jump"].any():
        return ends
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
    cycles, volume, error, depth = (
        float(history[name][-1]) for name in ("cycles", "wear_volume", "wear_error", "wear_depth_max")
    )
    unit, deepest = result.units("wear_volume"), f"{in_small_unit(depth, 4)} at the deepest place"
    if not len(changes):
        worn = f"wear {volume:.5g} {unit}, {deepest}; the surfaces have kept their shape"
        yield worn if volume > 0.0 else "nothing is worn yet"
        return
    from fretsolve.problem.setup.wear_warnings import error_by_grid  # few results have wear

    errors = {"the jumps": error or None, "the cells that stick": error_by_grid(result)}
    bars = [f"± {value:.1e} by {cause}" for cause, value in errors.items() if value is not None]
    spread = f" ({', '.join(bars)})" if bars else ""
    yield (
        f"{cycles:g} cycles, for which {counted(len(changes), 'solved cycle')} stand, wear {volume:.5g} {unit}{spread},"
        f" {deepest}"
    )
    first, last = (float(history["stick_area"][step - 1]) for step in (changes[0], changes[-1]))
    stages = result.case.stages() if result.case is not None else ()
    if first > 0.0 and len({stage.wears.key for stage in stages if stage.wears is not None}) == 1:
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


@dataclass(frozen=True)
class Spot:
    """A spot: cells that touch at sides or corners.

    area in mm^2; P, Qx, Qy in N, None where they are not stored; stick: part of its cells that stick, None likewise;
    x, y: centre of its pressure in mm.
    """

    cells: int
    area: float
    P: float
    Qx: float | None
    Qy: float | None
    stick: float | None
    x: float
    y: float


def may_have_spots(result: Result) -> bool:
    """Return whether stored pressure may show several spots: of a height map, or of several surfaces."""
    several = layout.may_have_spots(result.effective_case) and len(result.y) > 1 and len(result.x) > 1
    return several and "pressure" in result.fields and bool(result.steps)


def spots_of(result: Result, step: int = -1) -> list[Spot]:
    """Return the spots at an increment with fields (-1: the last one), in descending order of P."""
    from scipy import ndimage  # few results need it

    pressure = np.asarray(result.field("pressure", step), np.float64)
    labels, count = ndimage.label(pressure > 0.0, structure=np.ones((3, 3)))
    numbers = np.arange(1, count + 1)
    cell = float(result.x[1] - result.x[0]) * float(result.y[1] - result.y[0])
    x, y = np.meshgrid(result.x, result.y, indexing="ij")

    def sums(field: np.ndarray) -> np.ndarray:
        return np.asarray(ndimage.sum_labels(field, labels, numbers), np.float64)

    cells, load = sums(np.ones_like(pressure)), sums(pressure)
    shear = result.field("shear", step) if "shear_x" in result.fields else None
    forces = [] if shear is None else [cell * sums(np.asarray(one, np.float64)) for one in shear]
    stick = sums(result.field("zone", step) == Zone.STICK) / cells if "zone" in result.fields else None
    places = sums(x * pressure) / load, sums(y * pressure) / load
    found = [
        Spot(
            int(cells[n]),
            float(cells[n]) * cell,
            float(load[n]) * cell,
            Qx=float(forces[0][n]) if forces else None,
            Qy=float(forces[1][n]) if forces else None,
            stick=None if stick is None else float(stick[n]),
            x=float(places[0][n]),
            y=float(places[1][n]),
        )
        for n in range(count)
    ]
    return sorted(found, key=lambda spot: -spot.P)


def spot_warnings(history: Mapping[str, NDArray[Any]]) -> list[str]:
    """Return a sentence on the increments at which the number of spots changes, and one on spots of few cells.

    None where a history does not count spots, or has one of enough cells throughout.
    """
    if "spots" not in history:
        return []
    spots, small = history["spots"], history["small_spots"]
    found = []
    # From the first contact on.
    changes = np.flatnonzero((np.diff(spots) != 0) & (np.maximum.accumulate(spots)[:-1] > 0)) + 1
    if len(changes):
        named = ", ".join(map(str, changes[:10].tolist()))
        more = f" and {len(changes) - 10} more" if len(changes) > 10 else ""
        where = f"increment{'s' * (len(changes) > 1)} {named}{more}"
        counts = np.unique(spots[np.concatenate([changes - 1, changes])])
        found.append(f"the number of spots of contact changes at {where}, between {counts[0]} and {counts[-1]}")
    largest = int(np.argmax(history["contact_cells"])) if len(spots) else 0
    if len(spots) and small[largest] > 0:
        have = "has" if small[largest] == 1 else "have"
        found.append(
            f"grid.points: {small[largest]} of {counted(int(spots[largest]), 'spot')} in the largest contact (increment"
            f" {largest}) {have} fewer than {FEWEST_SPOT_CELLS} cells, so that sizes and loads are rough there"
        )
    return found


def yield_warnings(result: Result) -> list[str]:
    """Return a line on each body that yields, as far as the history tells."""
    if not any("yield_stress" in body for body in result.effective_case.get("bodies", ())):
        return []
    from fretsolve.post.stress.yielding import yield_lines  # other results do not need it

    return list(yield_lines(result).values())
