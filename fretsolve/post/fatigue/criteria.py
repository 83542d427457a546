"""The fatigue criteria by their names. In come stresses over a closed cycle, out comes a parameter at each point.

Stresses are (steps, 6, points) in MPa, in the order xx, yy, zz, xy, xz, yz. Criteria of a plane grow with an amplitude
and with the largest normal stress on the plane; criteria of a ball follow from the smallest ball around the path of the
deviator. Each has a limit or a life curve. The criteria know nothing of contact or files. For example::

    field = fatigue_field("findley", material, stresses)
    field.value.max(), field.normal[:, field.worst]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.post.fatigue.critical_plane import search
from fretsolve.post.fatigue.planes import Combine, PlaneCriterion, in_plane_axes, smallest_ball, traction_rows
from fretsolve.system.arrays import BoolArray, DoubleArray


@dataclass(frozen=True)
class FatigueField:
    """A fatigue parameter at each point.

    value: (points,), in `units`; limit: the value that is endured, None without one; normal: (3, points) of the
    critical plane, towards z >= 0, None for criteria without a plane; refined: (points,), False where the plane comes
    from a scan, since the point cannot be the worst; life: (points,) cycles to a crack, inf where there are endlessly
    many, None without a curve.
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


def hydrostatic(stress: DoubleArray) -> DoubleArray:
    """Return sH = tr/3, (steps, points)."""
    return np.asarray((stress[:, 0] + stress[:, 1] + stress[:, 2]) / 3.0)


def deviator_vectors(stress: DoubleArray) -> DoubleArray:
    """Return the deviators as vectors (steps, 5, points) of length sqrt(J2)."""
    mean = hydrostatic(stress)
    along_x, along_y = stress[:, 0] - mean, stress[:, 1] - mean
    first, second = 0.5 * math.sqrt(3.0) * along_x, 0.5 * along_x + along_y
    return np.stack([first, second, stress[:, 3], stress[:, 4], stress[:, 5]], axis=1)


def extreme_deviators(vectors: DoubleArray) -> tuple[DoubleArray, DoubleArray]:
    """Return the largest and the smallest principal value of deviators given as vectors (..., 5, points).

    They are 2 sqrt(J2/3) cos(a) and 2 sqrt(J2/3) cos(a + 2 pi/3), with cos(3a) = (3 sqrt(3)/2) J3/J2^(3/2).
    """
    first, second, xy, xz, yz = np.moveaxis(vectors, -2, 0)
    xx = (2.0 / math.sqrt(3.0)) * first
    yy = second - 0.5 * xx
    zz = -xx - yy
    J2 = np.square(vectors).sum(axis=-2)
    J3 = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    size = 2.0 * np.sqrt(J2 / 3.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(J2 > 0.0, 4.0 * J3 / size**3, 1.0)
    angle = np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0
    return size * np.cos(angle), size * np.cos(angle + 2.0 * math.pi / 3.0)


def crossland(material: Material, stress: DoubleArray) -> DoubleArray:
    """Return sqrt(J2a) + aC max sH (Crossland 1956), (points,), of stresses (steps, 6, points).

    sqrt(J2a) is the radius of the smallest ball around the deviator's path.
    """
    amplitude, _ = smallest_ball(deviator_vectors(stress))
    return np.asarray(amplitude + material.crossland_factor * hydrostatic(stress).max(axis=0))


def dang_van(material: Material, stress: DoubleArray) -> DoubleArray:
    """Return max [Tresca(s_dev - s*) + aD sH] (Dang Van 1993), (points,), of stresses (steps, 6, points).

    s* is the centre of the smallest ball around the deviator's path; Tresca is half of sI - sIII.
    """
    path = deviator_vectors(stress)
    _, center = smallest_ball(path)
    largest, smallest = extreme_deviators(path - center)
    return np.asarray((0.5 * (largest - smallest) + material.dang_van_factor * hydrostatic(stress)).max(axis=0))


def findley(material: Material) -> PlaneCriterion:
    """Return tau_a + k max sn (Findley 1959)."""
    k = material.findley_factor
    return _ranked_by_itself(_shear_rows, lambda amplitude, normal: amplitude + k * normal)


def mcdiarmid(material: Material) -> PlaneCriterion:
    """Return tau_a + t_AB/(2 su) max sn on the plane of largest tau_a (McDiarmid 1991); sn < 0 counts as 0."""
    k = material.mcdiarmid_factor
    # shares of the normal stress by which planes of equal shear amplitude are ranked, one after the other
    ranks = tuple(_weighted(weight) for weight in (0.03, 1e-3, 3e-5, 1e-7))
    return PlaneCriterion(_shear_rows, lambda amplitude, normal: amplitude + k * _tension(normal), ranks, ties=True)


def fatemi_socie(material: Material) -> PlaneCriterion:
    """Return (tau_a/G) (1 + k max sn/sy) (Fatemi & Socie 1988), elastic; sn < 0 counts as 0."""
    G, k = material.shear_modulus, material.fatemi_socie_factor / material.needed("yield_stress")

    def combine(amplitude: DoubleArray, normal: DoubleArray) -> DoubleArray:
        return amplitude / G * (1.0 + k * _tension(normal))

    return _ranked_by_itself(_shear_rows, combine)


def swt(material: Material) -> PlaneCriterion:
    """Return max sn times the amplitude of the normal strain (Smith, Watson & Topper 1970); sn < 0 counts as 0."""
    E, nu = material.needed("young_modulus"), material.needed("poisson_ratio")
    trace = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])

    def strain_rows(normals: DoubleArray) -> DoubleArray:
        return ((1.0 + nu) * traction_rows(normals, normals) - nu * trace)[..., None, :] / E

    def rank(amplitude: DoubleArray, normal: DoubleArray) -> DoubleArray:
        """Rank planes without tension by their normal stress: tension may lie between them."""
        return np.where(normal > 0.0, normal * amplitude, normal)

    return PlaneCriterion(strain_rows, lambda amplitude, normal: _tension(normal) * amplitude, (rank,), rounds=10)


def _shear_rows(normals: DoubleArray) -> DoubleArray:
    """Return the rows (..., 2, 6) of the shear stresses along two axes in the plane."""
    return np.stack([traction_rows(axis, normals) for axis in in_plane_axes(normals)], axis=-2)


def _ranked_by_itself(rows: Callable[[DoubleArray], DoubleArray], combine: Combine) -> PlaneCriterion:
    return PlaneCriterion(rows, combine, (combine,))


def _weighted(weight: float) -> Combine:
    return lambda amplitude, normal: amplitude + weight * _tension(normal)


def _tension(normal: DoubleArray) -> DoubleArray:
    return np.maximum(normal, 0.0)


LONGEST = 1e12
"""Cycles beyond which a life counts as endless."""


def shear_strain_lives(material: Material, value: DoubleArray) -> DoubleArray | None:
    """Return N of Fatemi and Socie's parameter: (tf'/G) (2N)^b + gf' (2N)^c = value. None without a curve."""
    curve = material.shear_strain_life
    if curve is None:
        return None
    strength = curve.strength / material.shear_modulus
    return lives(value, [(strength, curve.strength_exponent), (curve.ductility, curve.ductility_exponent)])


def swt_lives(material: Material, value: DoubleArray) -> DoubleArray | None:
    """Return N of Smith, Watson and Topper's parameter: (sf'^2/E) (2N)^2b + sf' ef' (2N)^(b+c) = value.

    None without a curve.
    """
    curve = material.strain_life
    if curve is None:
        return None
    b, c = curve.strength_exponent, curve.ductility_exponent
    elastic = curve.strength**2 / material.needed("young_modulus")
    return lives(value, [(elastic, 2.0 * b), (curve.strength * curve.ductility, b + c)])


def lives(value: DoubleArray, terms: Sequence[tuple[float, float]]) -> DoubleArray:
    """Return N with sum of factor (2N)^exponent = value, from `terms` (factor >= 0, exponent < 0).

    inf where N would be above `LONGEST`, 0 where it would be below half a cycle.
    """
    low, high = np.zeros(len(value)), np.full(len(value), np.log(2.0 * LONGEST))
    # Bisect ln(2N), over which the sum falls; 60 halvings reach rounding.
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = sum(factor * np.exp(exponent * middle) for factor, exponent in terms) > value
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    found: DoubleArray = 0.5 * np.exp(0.5 * (low + high))
    found[high >= np.log(2.0 * LONGEST)] = np.inf
    found[low <= 0.0] = 0.0
    return found


@dataclass(frozen=True)
class _Criterion:
    """The functions that compute a criterion. All take the material; the function `ball` takes the stresses as well."""

    units: str
    plane: Callable[[Material], PlaneCriterion] | None = None
    ball: Callable[[Material, DoubleArray], DoubleArray] | None = None
    limit: Callable[[Material], float] = lambda material: material.needed("torsion_limit")
    lives: Callable[[Material, DoubleArray], DoubleArray | None] | None = None


_CRITERIA: dict[str, _Criterion] = {
    "crossland": _Criterion("MPa", ball=crossland),
    "dang-van": _Criterion("MPa", ball=dang_van),
    "findley": _Criterion("MPa", findley, limit=lambda material: material.findley_limit),
    "mcdiarmid": _Criterion("MPa", mcdiarmid, limit=lambda material: material.mcdiarmid_shear_limit),
    "fatemi-socie": _Criterion("1", fatemi_socie, lives=shear_strain_lives),
    "swt": _Criterion("MPa", swt, lives=swt_lives),
}


def fatigue_field(name: str, material: Material, stress: DoubleArray, **search_options: Any) -> FatigueField:
    """Return the parameter of a criterion; stress: (steps, 6, points) in MPa over one closed cycle.

    search_options: of `critical_plane.search`. Raises CaseError for a constant that is missing or out of range;
    its key is a key of the material.
    """
    criterion = _CRITERIA[name]
    limit = criterion.limit(material) if criterion.lives is None else None
    if criterion.plane is None:
        assert criterion.ball is not None
        # about 80 MB of arrays at once
        count = max(1, 2**18 // len(stress))
        blocks = [stress[:, :, begin : begin + count] for begin in range(0, stress.shape[2], count)]
        value = np.concatenate([criterion.ball(material, block) for block in blocks])
        return FatigueField(name, criterion.units, value, limit)
    found = search(criterion.plane(material), stress, **search_options)
    life = lives_of(name, material, found.value)
    return FatigueField(name, criterion.units, found.value, limit, found.normal, found.refined, life)


def lives_of(name: str, material: Material, value: DoubleArray) -> DoubleArray | None:
    """Return the cycles to a crack at values of a criterion, (points,). None without a curve."""
    criterion = _CRITERIA.get(name)
    return None if criterion is None or criterion.lives is None else criterion.lives(material, value)


def require_constants(names: tuple[str, ...], material: Material) -> None:
    """Raise CaseError if a criterion lacks a constant of the material, or has one out of range."""
    nothing = np.zeros((1, 6, 1))
    for name in names:
        if name in _CRITERIA:
            fatigue_field(name, material, nothing)
