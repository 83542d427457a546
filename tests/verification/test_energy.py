"""Area of the loop against its dissipation.

The balance of each increment is checked in `tests/extremes/test_random_cases.py`. By trapezoids the loop's area is the
work of the mean shear, not of the shear that slips, |q| = mu p at the end: it falls short of the dissipation where
cells begin to slip within the increment, by O(n^-2) over a stage of n increments.
"""

from __future__ import annotations

import numpy as np
import pytest
from solving import LOAD, LOADS, MOTIONS, solve


def vector(state, names):
    return np.array([getattr(state.summary, name) for name in names])


def external_works(states):
    """Trapezoidal work of the loads per increment, from the second on."""
    loads = np.array([vector(state, LOADS) for state in states])
    motions = np.array([vector(state, MOTIONS) for state in states])
    return np.sum(0.5 * (loads[1:] + loads[:-1]) * np.diff(motions, axis=0), axis=1)


def loop(force, increments):
    stage = {"increments": increments}
    path = [{"P": LOAD, "increments": 1}, {"Qx": force, **stage}]
    return [*path, {"Qx": 0.0, **stage}, {"Qx": -force, **stage}, {"Qx": 0.0, **stage}, {"Qx": force, **stage}]


def test_area_of_the_loop_approaches_the_dissipation():
    """Below it, by an error of second order in the increments; the dissipation itself hardly depends on them."""
    counts, misses, works = (2, 4, 8, 16), [], []
    for count in counts:
        states = solve(grid={"points": 32}, coupling="none", load_path=loop(36.0, count), solver={"tolerance": 1e-8})
        start = count
        dissipated = states[-1].summary.work_total - states[start].summary.work_total
        area = external_works(states)[start:].sum()
        misses.append((dissipated - area) / dissipated)
        works.append(dissipated)
    assert min(misses) > 0.0
    assert -np.polyfit(np.log(counts), np.log(misses), 1)[0] > 1.7
    assert misses[-1] < 0.01
    assert works == pytest.approx([works[-1]] * len(works), rel=1e-5)
