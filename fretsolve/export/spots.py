"""Spots of contact: connected cells, of which a rough surface or several bodies have many."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.case.dimensions import counted
from fretsolve.case.history import FEWEST_SPOT_CELLS
from fretsolve.result import Result, layout
from fretsolve.result.state import Zone

MOST_NAMED = 10
"""Increments that a sentence names."""


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
    """Return the spots at an increment with fields (-1: the last one), those with the largest P first."""
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
        named = ", ".join(map(str, changes[:MOST_NAMED].tolist()))
        more = f" and {len(changes) - MOST_NAMED} more" if len(changes) > MOST_NAMED else ""
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
