"""Increments where the slip depends on the path: how fast their error falls, and what automatic ones leave of it."""

from __future__ import annotations

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, solve

POINTS = 32
GRADED = {"spacing": "graded"}


def pressed(friction, points=POINTS, **stage):
    """A sphere pressed on a flat of another Poisson's ratio: mode II."""
    path = [{"P": LOAD, **stage}]
    return solve(
        bodies=DISSIMILAR, friction=friction, grid={"points": points}, load_path=path, solver={"tolerance": 1e-5}
    )


@pytest.fixture(scope="module")
def converged():
    """At a friction of 0.1; twice as many increments change the work by 0.02 %."""
    return pressed(0.1, increments=120, **GRADED)[-1].summary


def test_automatic_increments_of_mode_2(converged):
    states = pressed(0.1)
    found = states[-1].summary
    assert len(states) <= 25
    assert found.work_total == pytest.approx(converged.work_total, rel=0.02)
    assert found.stick_radius == pytest.approx(converged.stick_radius, rel=0.03)
    assert found.max_pressure == pytest.approx(converged.max_pressure, rel=1e-3)


def test_order_of_the_work(converged):
    """Above 3/2, the order that the slip of cells not yet in contact would leave."""
    counts = (6, 12, 24)
    works = [pressed(0.1, increments=count, **GRADED)[-1].summary.work_total for count in counts]
    errors = np.abs(np.array(works) / converged.work_total - 1.0)
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] > 1.6


def test_shear_has_no_waves_under_strong_friction():
    """Edges of the contact leave waves in the stick zone, of a quarter of the largest shear with ten equal steps."""

    def shear(**stage):
        return pressed(0.25, 40, **stage)[-1].fields.shear[0]

    smooth = shear(increments=100, **GRADED)
    waves = {
        count: np.abs(shear(**stage) - smooth).max() / np.abs(smooth).max()
        for count, stage in ((10, {"increments": 10}), ("auto", {}))
    }
    assert waves["auto"] < 0.06
    assert waves[10] > 0.2


def test_unloading_between_unlike_bodies_converges():
    """Cells that part in an increment slip until then."""
    path = [{"P": LOAD, "increments": 12, **GRADED}, {"P": 0.3 * LOAD}]
    works = []
    for count in (5, 10, 60):
        stages = [path[0], {**path[1], "increments": count, **GRADED}]
        states = solve(bodies=DISSIMILAR, grid={"points": 28}, load_path=stages, solver={"tolerance": 1e-5})
        works.append(states[-1].summary.work_total - states[11].summary.work_total)
    five, ten, many = works
    assert abs(ten - many) < 0.6 * abs(five - many)
    assert ten == pytest.approx(many, rel=0.1)
