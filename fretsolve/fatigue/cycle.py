"""Check that stresses are those of one closed cycle."""

from __future__ import annotations

from collections.abc import Container, Sequence

import numpy as np

from fretsolve.errors import CaseError
from fretsolve.system.arrays import DoubleArray

FEWEST_STATES = 3
CLOSED_WITHIN = 0.01
"""The share of its range by which a closed cycle may miss its beginning."""


def require_states(count: int) -> None:
    """Raise CaseError if a cycle has too few states."""
    if count < FEWEST_STATES:
        raise CaseError(f"the cycle has {count} stored states; {FEWEST_STATES} or more are needed (output.every)")


def require_reversals(ends: Sequence[int], stored: Container[int]) -> None:
    """Raise CaseError if fields are not stored at the ends of a cycle's stages, where loads turn."""
    missing = [str(step) for step in ends if step not in stored]
    if missing:
        noun = f"increment{'s' if len(missing) > 1 else ''} {', '.join(missing)}"
        raise CaseError(f"output.every leaves out {noun}, where a stage of the cycle begins or ends; 1 is needed")


def opening(first: DoubleArray, last: DoubleArray, ranges: DoubleArray) -> float:
    """Return how far a cycle misses its beginning: the largest change of a stress over the largest range of one.

    first, last: stresses (6, points) at both ends; ranges: (6, points), largest less smallest over the cycle.
    """
    largest = float(ranges.max(initial=0.0))
    return float(np.abs(last - first).max(initial=0.0)) / largest if largest > 0.0 else 0.0


def not_closed(share: float) -> str | None:
    """Return the warning of a cycle that misses its beginning by `share` of its range, None if it is closed."""
    if share <= CLOSED_WITHIN:
        return None
    return (
        f"the cycle is not closed: its last state differs from its first by {100.0 * share:.2g} % of the range"
        f" (more than {100.0 * CLOSED_WITHIN:g} %); more cycles in the load path are needed"
    )
