"""The numbers of increments of the coarse runs, and where they matter."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import accumulate, compress
from operator import or_
from typing import NamedTuple

from fretsolve.case.history import SHEARING
from fretsolve.problem.setup.problem import ProblemSetup

MANY = 4
"""Increments of each stage that slips, at least, from which a half and a quarter of them show what more would change:
they take two thirds of the time of all and half of them, with corrected values as good."""

FEW = 3
"""Increments of a stage from which on its half, rounded up, and twice that are taken where another stage has less than
MANY. Stages of less have all and twice as many."""


class CoarseCounts(NamedTuple):
    """Increments per stage of the coarse runs: on a third of the points, on the same ones to compare, and on half.

    other: None where the number of increments does not matter.
    """

    third: tuple[int, ...]
    other: tuple[int, ...] | None
    half: tuple[int, ...]


def coarse_counts(setup: ProblemSetup, slips: tuple[bool, ...]) -> CoarseCounts:
    """Return the increments of the coarse runs; slips: of each stage, whether something may slip in it.

    Their number matters where the slip depends on the path, and where it turns. The errors of all stages grow by one
    factor where all have the same share of the run's increments.
    """
    counts = setup.load_path.counts
    unslipping_third, unslipping_half = unslipping_counts(counts)
    if not any(slips) or not (setup.load_path.path_dependent or setup.model.terms.in_plane_coupling):
        return CoarseCounts(unslipping_third, None, unslipping_half)
    if min(compress(counts, slips)) >= MANY:
        other = half = tuple(-(-count // 4) for count in counts)
        third = tuple(2 * count for count in other)
    else:
        fewer = not _keeps_errors_of_pressing(setup)  # which want the same share in all stages
        third = half = tuple(-(-count // 2) if fewer and count >= FEW else count for count in counts)
        other = tuple(2 * count for count in third)
    # until something slips, one increment leads to the same state as many
    third, half = where(slips, third, unslipping_third), where(slips, half, unslipping_half)
    return CoarseCounts(third, where(slips, other, [1] * len(other)), half)


def unslipping_counts(counts: tuple[int, ...]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the increments on a third and on half of the points of stages in which nothing depends on their number."""
    third = tuple(count if count % 4 else count // 2 for count in counts)
    return third, tuple(count if count % 2 else count // 2 for count in third)


def where(slips: Iterable[bool], here: Iterable[int], there: Iterable[int]) -> tuple[int, ...]:
    """Return the numbers of `here` for stages that slip, and those of `there` for the others."""
    return tuple(one if slipping else other for slipping, one, other in zip(slips, here, there, strict=True))


def slipping_stages(setup: ProblemSetup) -> tuple[bool, ...]:
    """Return for each stage whether something may slip in it: all between dissimilar bodies, or once one is sheared."""
    moved = (any(name in SHEARING and value for name, value in stage.targets) for stage in setup.case.stages())
    return tuple(setup.model.coupled or sheared for sheared in accumulate(moved, or_))


def _keeps_errors_of_pressing(setup: ProblemSetup) -> bool:
    """Return whether errors of pressing unlike bodies stay: after few increments, and where the bodies tilt."""
    if not setup.model.coupled:
        return False
    stages = [
        (dict(stage.targets), count) for stage, count in zip(setup.case.stages(), setup.load_path.counts, strict=True)
    ]
    presses = any(count < MANY and {"P", "delta_z"} & targets.keys() for targets, count in stages)
    return presses or any(targets.get(name) for targets, _ in stages for name in ("Mx", "My", "phi_x", "phi_y"))
