"""What the conjugate gradients need of an elastic operator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fretsolve.system.arrays import FloatArray

Apply = Callable[[FloatArray, FloatArray], None]
"""A linear map, ``apply(field, result)``; both may be the same array."""


@dataclass(frozen=True)
class Operators:
    """The elastic operator B and its preconditioner F on fields (c, nx, ny)."""

    elastic: Apply
    inverse: Apply
