"""The numbers of increments of the coarse runs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import accumulate, compress
from operator import or_

from fretsolve.case.history import SHEARING
from fretsolve.setup.problem_setup import ProblemSetup

MANY = 4
"""Increments of each stage that slips, at least, from which a half and a quarter of them show what more would change.
Of less, all and twice as many do. Twice as many would halve the errors of the second order that are left, but take
three times as long. All and half of 4 to 7 increments took 0.82 of the run's time in the median of 80 random cases,
half and a quarter 0.58, with corrected values as good: errors of 1.8e-3 instead of 2.0e-3 of `delta_x`, 2.9 instead of
2.6 % of the energy. A half and a quarter of 3 would take 0.61 instead of 0.72 of it, but of 828 cases some that turn
the shear in three increments then missed by 2.5 to 3.6 bars."""


@dataclass(frozen=True)
class CoarseCounts:
    """Increments per stage of the coarse runs: on a third of the points, on the same ones to compare, and on half.

    other: None where the number of increments does not matter.
    """

    third: tuple[int, ...]
    other: tuple[int, ...] | None
    half: tuple[int, ...]


def coarse_counts(setup: ProblemSetup, slips: tuple[bool, ...]) -> CoarseCounts:
    """Return the increments of the coarse runs; slips: of each stage, whether something may slip in it.

    Their number matters where the slip depends on the path, and where it turns. All stages have the same share of the
    run's increments, but for rounding, since only so the errors of all of them grow by one factor.
    """
    counts = setup.load_path.counts
    unslipping_third, unslipping_half = unslipping_counts(counts)
    if not any(slips) or not (setup.load_path.path_dependent or setup.model.terms.in_plane_coupling):
        return CoarseCounts(unslipping_third, None, unslipping_half)
    slipping = list(compress(counts, slips))
    third = half = counts
    if min(slipping) >= MANY:
        other = half = tuple(-(-count // 4) for count in counts)
        third = tuple(2 * count for count in other)
    else:
        other = tuple(2 * count for count in counts)
        if not any(count % 2 for count in slipping):
            half = tuple(count // 2 for count in counts)
    # until something slips, one increment leads to the same state as many
    third, half = where(slips, third, unslipping_third), where(slips, half, unslipping_half)
    return CoarseCounts(third, where(slips, other, [1] * len(other)), half)


def unslipping_counts(counts: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the increments, on a third and on half of the points, of stages in which nothing depends on their number.

    Differences of grids are interpolated between the increments that all runs share.
    """
    third = tuple(count if count % 4 else count // 2 for count in counts)
    return third, tuple(count if count % 2 else count // 2 for count in third)


def where(slips: Iterable[bool], here: Iterable[int], there: Iterable[int]) -> tuple[int, ...]:
    """Return the numbers of `here` for stages that slip, and those of `there` for the others."""
    return tuple(one if slipping else other for slipping, one, other in zip(slips, here, there, strict=True))


def slipping_stages(setup: ProblemSetup) -> tuple[bool, ...]:
    """Return for each stage whether something may slip in it: all between dissimilar bodies, or once one is sheared."""
    return tuple(setup.model.coupled or sheared for sheared in sheared_stages(setup))


def sheared_stages(setup: ProblemSetup) -> tuple[bool, ...]:
    """Return for each stage whether it or one before it shears."""
    moved = (any(name in SHEARING and value for name, value in stage.targets) for stage in setup.case.stages())
    return tuple(accumulate(moved, or_))
