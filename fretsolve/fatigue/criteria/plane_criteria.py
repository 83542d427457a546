"""Criteria of a critical plane: each grows with an amplitude and with the largest normal stress on the plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretsolve.case.keys.material_spec import Material
from fretsolve.fatigue.criteria.planes import in_plane_axes, traction_rows
from fretsolve.system.arrays import DoubleArray

Combine = Callable[[DoubleArray, DoubleArray], DoubleArray]
"""From amplitude and largest normal stress, both (...,), to a parameter (...,)."""

TIE_WEIGHTS = (0.03, 1e-3, 3e-5, 1e-7)
"""Shares of the normal stress by which planes of equal shear amplitude are ranked, one after the other."""


@dataclass(frozen=True)
class PlaneCriterion:
    """A parameter on the plane where it, or what ranks the planes, is largest.

    amplitude_rows: from normals (..., 3) to the rows (..., k, 6) of the components whose path has the amplitude; it is
    the radius of the smallest ball around the path in k dimensions. combine: the parameter. ranks: what the plane
    maximises, one function after the other, each from the plane that the one before found; by default the parameter.
    ties: the plane of largest amplitude counts, and among equal ones that of largest normal stress. rounds: of the
    search from the best plane of a scan; one parabola leads to the top of a smooth hill, not of one cut off at 0.
    """

    amplitude_rows: Callable[[DoubleArray], DoubleArray]
    combine: Combine
    ranks: tuple[Combine, ...]
    ties: bool = False
    rounds: int = 1

    def rows(self, normals: DoubleArray) -> DoubleArray:
        """Return rows (..., 1 + k, 6): that of the normal stress, then those of the amplitude."""
        normal = traction_rows(normals, normals)[..., None, :]
        return np.concatenate([normal, self.amplitude_rows(normals)], axis=-2)


def findley(material: Material) -> PlaneCriterion:
    """Return tau_a + k max sn (Findley 1959)."""
    k = material.findley_factor
    return _ranked_by_itself(_shear_rows, lambda amplitude, normal: amplitude + k * normal)


def mcdiarmid(material: Material) -> PlaneCriterion:
    """Return tau_a + t_AB/(2 su) max sn on the plane of largest tau_a (McDiarmid 1991); sn < 0 counts as 0."""
    k = material.mcdiarmid_factor
    ranks = tuple(_weighted(weight) for weight in TIE_WEIGHTS)
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
