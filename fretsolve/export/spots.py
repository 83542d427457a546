"""Spots of contact: connected cells, of which a rough surface or several bodies have many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretsolve.result import Result
from fretsolve.result.state import Zone

FEWEST_CELLS = 10
"""Cells of a spot below which its area and loads are rough."""


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
    surfaces = result.effective_case.get("surface", [])
    several = len(surfaces) > 1 or any("heights" in one for one in surfaces)
    return several and "pressure" in result.fields and len(result.y) > 1 and len(result.x) > 1 and bool(result.steps)


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
