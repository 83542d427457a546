"""Pairs of bodies at the ends of what elasticity allows."""

from __future__ import annotations

from typing import Any

from solving import DISSIMILAR, NO_POISSON, RIGID, SIMILAR

Body = dict[str, float] | str


def elastic(poisson_ratio: float, young_modulus: float = 200e3) -> dict[str, float]:
    """A body."""
    return {"young_modulus": young_modulus, "poisson_ratio": poisson_ratio}


FLAT_RIGID: tuple[Any, Any] = RIGID
"""Dundurs' constant -0.5, the end for nu >= 0."""

PLAIN = NO_POISSON
"""Equal bodies of nu = 0, where shear and pressure have the same influence coefficients."""

BONDED: dict[str, tuple[Any, Any]] = {
    "unlike": DISSIMILAR,
    "rigid on nu 0.3": ("rigid", elastic(0.3)),
    "rigid on nu 0": FLAT_RIGID,
    "nu 0 on rigid": FLAT_RIGID[::-1],
}

BODIES = {"equal": SIMILAR, "unlike": DISSIMILAR}
