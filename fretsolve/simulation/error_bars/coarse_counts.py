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
Twice as many would halve the errors of the second order that are left, but take three times as long. All and half of 4
to 7 increments took 0.82 of the run's time in the median of 80 random cases, half and a quarter 0.58, with corrected
values as good: errors of 1.8e-3 instead of 2.0e-3 of `delta_x`, 2.9 instead of 2.6 % of the energy."""

FEW = 3
"""Increments of a stage from which on its half, rounded up, and twice that are taken where another stage has less than
MANY. Stages of less have all and twice as many. Coarse runs so took 0.55 of the run's time in the median of the 175
random areas of seeds 78 to 80, and with all and twice as many in all stages 0.61; where stages of 1 to 3 stand beside
longer ones 0.7 instead of 0.99. The bars held as many values. Corrected `delta_x` of such cases had errors 1.4 times as
large in the mean, 1.0 times in the median."""

TILTING = ("Mx", "My", "phi_x", "phi_y")
"""Targets of a stage that tilt the bodies."""


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

    Their number matters where the slip depends on the path, and where it turns. The errors of all stages grow by one
    factor where all have the same share of the run's increments. Where short stages stand beside long ones, the share
    of the long ones is smaller, which saves time.
    """
    counts = setup.load_path.counts
    unslipping_third, unslipping_half = unslipping_counts(counts)
    if not any(slips) or not (setup.load_path.path_dependent or setup.model.terms.in_plane_coupling):
        return CoarseCounts(unslipping_third, None, unslipping_half)
    if min(compress(counts, slips)) >= MANY:
        other = half = tuple(-(-count // 4) for count in counts)
        third = tuple(2 * count for count in other)
    else:
        # Errors of pressing unlike bodies stay in later stages, and want the same share there. They are largest after
        # few increments, and where the bodies tilt.
        fewer = not (presses_unlike_bodies(setup, MANY - 1) or (setup.model.coupled and tilts(setup)))
        third = half = tuple(-(-count // 2) if fewer and count >= FEW else count for count in counts)
        other = tuple(2 * count for count in third)
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


def presses_unlike_bodies(setup: ProblemSetup, most: int) -> bool:
    """Return whether a stage presses unlike bodies in `most` increments or less."""
    stages = zip(setup.case.stages(), setup.load_path.counts, strict=True)
    return setup.model.coupled and any(
        count <= most and {"P", "delta_z"} & dict(stage.targets).keys() for stage, count in stages
    )


def tilts(setup: ProblemSetup) -> bool:
    """Return whether a stage tilts the bodies."""
    return any(name in TILTING and value for stage in setup.case.stages() for name, value in stage.targets)
