"""What the conjugate gradients need of an elastic operator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fretsolve.system.arrays import FloatArray

Apply = Callable[[FloatArray, FloatArray], None]


@dataclass(frozen=True)
class Operators:
    """B and F on fields (c, nx, ny), as ``apply(field, out)``; `out` may be the field."""

    elastic: Apply
    inverse: Apply
