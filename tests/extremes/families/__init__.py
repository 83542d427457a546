"""All families of extreme cases."""

from __future__ import annotations

from . import friction, grids, loads, materials, shapes, shear, steps

FAMILIES = (
    *friction.FAMILIES,
    *shear.FAMILIES,
    *steps.FAMILIES,
    *materials.FAMILIES,
    *shapes.FAMILIES,
    *grids.FAMILIES,
    *loads.FAMILIES,
)
