"""Find where a crack stops, and in how many cycles it grows, from its range of stress intensity over its length.

Thresholds are those of Kitagawa & Takahashi (1976) with El Haddad, Smith & Topper (1979): a crack of length b grows
where its range is at least K_0 sqrt(b/(b + b_0)), with b_0 = (K_0/(f S_0))^2/pi. Growth in a cycle is Paris's.

Lengths are in mm and ascend, stress intensities are in MPa m^0.5, lives in cycles. `inf` stands for no end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from fretsolve.case.keys.material_spec import Material, ParisLaw
from fretsolve.post.crack.stress_intensity import METRES
from fretsolve.system.arrays import BoolArray, DoubleArray

Threshold = Callable[[DoubleArray], DoubleArray]

GAUSS = 4
"""Nodes of the quadrature of growth between two lengths."""


def stress_range(intensities: DoubleArray, exponent: float = 1.0) -> DoubleArray:
    """Return the range of K over the states of a cycle, (..., states, lengths) without the states.

    It is K_max (1 - R)^g with R = K_min/K_max, where a closed crack counts as 0; g = 1: K_max - K_min.
    """
    most, least = (np.maximum(values, 0.0) for values in (intensities.max(axis=-2), intensities.min(axis=-2)))
    open_share = np.divide(most - least, most, out=np.zeros_like(most), where=most > 0.0)
    return np.asarray(most * open_share**exponent)


def intrinsic_length(material: Material) -> float | None:
    """Return El Haddad's length b_0 (mm), None where the material lacks a constant for it."""
    if material.threshold_range is None or material.fatigue_range is None:
        return None
    ratio = material.threshold_range / (material.surface_factor * material.fatigue_range)
    return ratio**2 / (math.pi * METRES)


def threshold_of(material: Material) -> Threshold | None:
    """Return the range below which a crack of some lengths does not grow, None where the material lacks a constant."""
    short, long = intrinsic_length(material), material.threshold_range
    if short is None or long is None:
        return None
    return lambda lengths: long * np.sqrt(lengths / (lengths + short))


def arrest_length(lengths: DoubleArray, ranges: DoubleArray, threshold: Threshold) -> float:
    """Return the length at which the range first falls below the threshold; 0: no crack, inf: it goes through.

    Between lengths the ratio of both is linear in the logarithm of the length.
    """
    over = ranges / threshold(lengths) - 1.0
    below = np.flatnonzero(over < 0.0)
    if not below.size:
        return math.inf
    first = int(below[0])
    if first == 0:
        return 0.0
    return _crossing(lengths, over, first)


def _crossing(lengths: DoubleArray, values: DoubleArray, index: int) -> float:
    """Return the length between `index` - 1 and `index` at which values that are linear in its logarithm are 0."""
    before, after = values[index - 1], values[index]
    ratio = lengths[index] / lengths[index - 1]
    return float(lengths[index - 1] * ratio ** (before / (before - after)))


def end_length(
    lengths: DoubleArray, largest: DoubleArray, toughness: float | None, final: float | None
) -> float | None:
    """Return the length at which life ends: `final`, or before it where the largest K reaches the toughness.

    None where neither is given, or the toughness is not reached within the lengths.
    """
    if toughness is not None:
        broken = np.flatnonzero(largest >= toughness)
        if broken.size:
            first = int(broken[0])
            excess = np.log(np.maximum(largest, 1e-9 * toughness) / toughness)
            reached = float(lengths[0]) if first == 0 else _crossing(lengths, excess, first)
            return reached if final is None else min(final, reached)
    return final


def propagation_lives(
    lengths: DoubleArray,
    ranges: DoubleArray,
    times: Sequence[float],
    law: ParisLaw,
    threshold: Threshold | None,
    end: float,
) -> DoubleArray:
    """Return the cycles in which a crack grows from each length to `end`, NaN beyond it, inf where it stops before.

    ranges: (cycles, lengths), one row for each cycle of a block that is repeated; times: how often each cycle occurs.
    In a block it grows by the sum of the growth in its cycles that exceed the threshold.
    """
    lives = np.full(len(lengths), math.nan)
    starts = np.log(lengths[lengths < end])
    if not starts.size:
        return lives
    limits = np.ones(len(lengths)) if threshold is None else threshold(lengths)
    curves = [_interpolated(lengths, row / limits) for row in ranges]
    # growth jumps where a range crosses the threshold
    jumps = np.concatenate([curve.roots(extrapolate=False) for curve in curves] if threshold else [starts])
    jumps = jumps[(jumps > starts[0]) & (jumps < math.log(end))]
    bounds = np.unique(np.concatenate([starts, jumps, [math.log(end)]]))
    widths = np.diff(bounds)
    points, weights = np.polynomial.legendre.leggauss(GAUSS)
    inside = bounds[:-1, None] + 0.5 * (points + 1.0) * widths[:, None]
    limit, least = (1.0, 0.0) if threshold is None else (threshold(np.exp(inside)), 1.0)
    growth = np.zeros_like(inside)
    for curve, row, often in zip(curves, ranges, times, strict=True):
        share = np.where(_grows(lengths, row, inside), np.exp(curve(inside)), 0.0)
        found = np.where(share >= least, share * limit, 0.0)
        growth += often * law.coefficient * found**law.exponent
    with np.errstate(divide="ignore"):
        blocks = METRES * np.exp(inside) / growth
    pieces = 0.5 * widths * (blocks @ weights)
    left = sum(times) * np.cumsum(pieces[::-1])[::-1]
    lives[: len(starts)] = left[np.searchsorted(bounds, starts)]
    return lives


def _interpolated(lengths: DoubleArray, shares: DoubleArray) -> PchipInterpolator:
    """Return the logarithm of shares over the logarithm of the length, smooth between lengths; shares may be 0."""
    known = np.where(shares > 0.0, shares, shares[shares > 0.0].min(initial=1.0))
    return PchipInterpolator(np.log(lengths), np.log(known))


def _grows(lengths: DoubleArray, ranges: DoubleArray, logarithms: DoubleArray) -> BoolArray:
    """Return where the ranges at both lengths beside are above 0."""
    grows = ranges > 0.0
    after = np.clip(np.searchsorted(np.log(lengths), logarithms), 1, len(lengths) - 1)
    return np.asarray(grows[after - 1] & grows[after])


@dataclass(frozen=True, eq=False)
class Growth:
    """The growth of a crack; attributes are None where the material lacks a constant for them.

    arrest: length at which it stops, 0 where it does not begin, inf where it goes through; end: length at which life
    ends; propagation, total: lives (lengths,), from a crack of each length, without and with the cycles to such a
    crack; life: the least total life, endless where the crack stops; first: the length of this crack; deeper: the least
    life of cracks that begin at a depth by themselves, where the crack stops; crossing: where both parts are equal.
    """

    arrest: float | None
    end: float | None
    propagation: DoubleArray | None = None
    total: DoubleArray | None = None
    life: float | None = None
    first: float | None = None
    crossing: float | None = None
    deeper: float | None = None


@dataclass(frozen=True)
class GrowthRule:
    """The constants that growth follows from, besides stress intensities and initiation.

    times: how often each cycle occurs; judged_from: the length (mm) from which on a crack may stop; begins_below: the
    length (mm) up to which the crack of the least total life may begin.
    """

    material: Material
    times: tuple[float, ...]
    final_length: float | None = None
    judged_from: float = 0.0
    begins_below: float = math.inf

    def growth(
        self, lengths: DoubleArray, ranges: DoubleArray, largest: DoubleArray, initiation: DoubleArray | None
    ) -> Growth:
        """Return how a crack grows.

        ranges: (cycles, lengths); largest: the largest K of each length; initiation: cycles to a crack of each length.
        """
        material, threshold = self.material, threshold_of(self.material)
        judged = lengths >= self.judged_from
        most = ranges.max(axis=0)[judged]
        arrest = None if threshold is None else arrest_length(lengths[judged], most, threshold)
        end = end_length(lengths, largest, material.toughness, self.final_length)
        if arrest is not None and end is not None and arrest > end:
            arrest = math.inf
        if material.paris is None or end is None:
            return Growth(arrest, end)
        propagation = propagation_lives(lengths, ranges, self.times, material.paris, threshold, end)
        if initiation is None:
            return Growth(arrest, end, propagation)
        total = initiation + propagation
        before = int(np.count_nonzero((lengths < end) & (lengths <= self.begins_below)))
        if before == 0:  # the first crack is the end
            return Growth(arrest, end, propagation, total, float(initiation[0]), float(lengths[0]))
        first = int(total[:before].argmin())
        life = float(total[first])
        crossing = _equal_at(lengths[:before], initiation[:before], propagation[:before])
        if arrest is not None and math.isfinite(arrest):
            return Growth(arrest, end, propagation, total, math.inf, None, crossing, life)
        place = float(lengths[first]) if math.isfinite(life) else None
        return Growth(arrest, end, propagation, total, life, place, crossing)


def _equal_at(lengths: DoubleArray, initiation: DoubleArray, propagation: DoubleArray) -> float | None:
    """Return the length at which initiation first takes as long as propagation, None where it never does."""
    known = np.isfinite(initiation) & np.isfinite(propagation) & (initiation > 0.0) & (propagation > 0.0)
    ratio = np.log(np.divide(initiation, propagation, out=np.ones_like(initiation), where=known))
    for index in range(1, len(lengths)):
        if known[index - 1] and known[index] and ratio[index - 1] < 0.0 <= ratio[index]:
            return _crossing(lengths, ratio, index)
    return None


def difference(value: float, *others: float) -> float:
    """Return the largest distance of other values from a value; two endless ones have none."""
    return max(0.0 if one == value else abs(one - value) for one in others)
