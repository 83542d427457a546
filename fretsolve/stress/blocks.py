"""Fields averaged over blocks of cells, as if the cells were larger."""

from __future__ import annotations

import numpy as np

from fretsolve.stress.halfspace.layers import Window
from fretsolve.system.arrays import DoubleArray


def in_blocks(
    field: DoubleArray, sides: tuple[int, int], shift: tuple[int, int], shape: tuple[int, int]
) -> DoubleArray:
    """Return means of a field over blocks of `sides` cells, ``shape``, the first of which begins `shift` before it."""
    whole = np.zeros((shape[0] * sides[0], shape[1] * sides[1]))
    whole[shift[0] : shift[0] + field.shape[0], shift[1] : shift[1] + field.shape[1]] = field
    means: DoubleArray = whole.reshape(shape[0], sides[0], shape[1], sides[1]).mean(axis=(1, 3))
    return means


def merged(window: Window, sides: tuple[int, int]) -> Window:
    """Return the blocks of `sides` cells that cover a window."""
    first, second = (slice(one.start // side, -(-one.stop // side)) for one, side in zip(window, sides, strict=True))
    return first, second
