"""The map that a file holds, before the case has its say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

NUMPY_SUFFIXES = (".npy", ".npz")
TEXT_SUFFIXES = (".txt", ".csv", ".dat", ".asc", ".xyz")

MOST_HEIGHTS = 2**26
"""Heights of a map: 8192 x 8192."""

AGREEMENT = 0.01
"""Largest difference between two statements of the same, over one of them."""


@dataclass(frozen=True)
class RawMap:
    """The array in a file, as it is there.

    values: (mx, my), the first index along x, the second along y, upwards; (n,) of a profile along x; not finite where
    points are lost. spacing: between points along x and y, or one for both, in `xy_unit`; None unless the file has it.
    unit, xy_unit: mm of a unit of the values and of the spacing; None unless the file states them. remarks: what the
    reader found and did, such as how many points are missing, for `validate`. doubts: of what
    the values mean, to be warned of. stated, xy_stated: what the file states instead of these units, if that is no
    length.
    """

    values: NDArray[Any]
    spacing: tuple[float, ...] | None = None
    unit: float | None = None
    xy_unit: float | None = None
    remarks: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    stated: str = ""
    xy_stated: str = ""
