"""The fatigue criteria by their names, each with its limit or life curve."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.fatigue.criteria import ball_criteria, plane_criteria
from fretsolve.fatigue.criteria.critical_plane import search
from fretsolve.fatigue.criteria.life import shear_strain_lives, swt_lives
from fretsolve.fatigue.criteria.plane_criteria import PlaneCriterion
from fretsolve.system.arrays import BoolArray, DoubleArray

POINTS_AT_ONCE = 2**18
"""States times points of the criteria without a plane that are computed at once, about 80 MB of arrays."""


@dataclass(frozen=True)
class FatigueField:
    """A fatigue parameter at each point.

    value: (points,), in `units`; limit: the value that is endured, None without one; normal: (3, points) of the
    critical plane, towards z >= 0, None for criteria without a plane; refined: (points,), False where the plane is
    that of a scan, since the point cannot be the worst; life: (points,) cycles to a crack, inf where there are
    endlessly many, None without a curve.
    """

    criterion: str
    units: str
    value: DoubleArray
    limit: float | None = None
    normal: DoubleArray | None = None
    refined: BoolArray | None = None
    life: DoubleArray | None = None

    @property
    def utilisation(self) -> DoubleArray | None:
        """Parameter over limit, (points,); cracks are expected above 1. None without a limit."""
        return None if self.limit is None else self.value / self.limit

    @property
    def worst(self) -> int:
        """Index of the point with the largest value."""
        return int(self.value.argmax())


@dataclass(frozen=True)
class _Criterion:
    """The functions that compute a criterion. They take the material; that of a ball takes the stresses as well."""

    units: str
    plane: Callable[[Material], PlaneCriterion] | None = None
    ball: Callable[[Material, DoubleArray], DoubleArray] | None = None
    limit: Callable[[Material], float] = lambda material: material.needed("torsion_limit")
    lives: Callable[[Material, DoubleArray], DoubleArray | None] | None = None


_CRITERIA: dict[str, _Criterion] = {
    "crossland": _Criterion("MPa", ball=ball_criteria.crossland),
    "dang-van": _Criterion("MPa", ball=ball_criteria.dang_van),
    "findley": _Criterion("MPa", plane_criteria.findley, limit=lambda material: material.findley_limit),
    "mcdiarmid": _Criterion("MPa", plane_criteria.mcdiarmid, limit=lambda material: material.mcdiarmid_shear_limit),
    "fatemi-socie": _Criterion("1", plane_criteria.fatemi_socie, lives=shear_strain_lives),
    "swt": _Criterion("MPa", plane_criteria.swt, lives=swt_lives),
}


def fatigue_field(name: str, material: Material, stress: DoubleArray, **search_options: Any) -> FatigueField:
    """Return the parameter of a criterion; stress: (steps, 6, points) in MPa over one closed cycle.

    search_options: those of `critical_plane.search`. Raises CaseError for a constant that is missing or out of range;
    its key is that of the material.
    """
    criterion = _CRITERIA[name]
    limit = criterion.limit(material) if criterion.lives is None else None
    if criterion.plane is None:
        assert criterion.ball is not None
        count = max(1, POINTS_AT_ONCE // len(stress))
        blocks = [stress[:, :, begin : begin + count] for begin in range(0, stress.shape[2], count)]
        value = np.concatenate([criterion.ball(material, block) for block in blocks])
        return FatigueField(name, criterion.units, value, limit)
    found = search(criterion.plane(material), stress, **search_options)
    life = criterion.lives(material, found.value) if criterion.lives is not None else None
    return FatigueField(name, criterion.units, found.value, limit, found.normal, found.refined, life)


def require_constants(names: tuple[str, ...], material: Material) -> None:
    """Raise CaseError if a criterion lacks a constant of the material, or has one out of range."""
    nothing = np.zeros((1, 6, 1))
    for name in names:
        fatigue_field(name, material, nothing)
