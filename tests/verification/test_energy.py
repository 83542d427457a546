"""Work done on the contact against elastic energy and dissipation.

By the trapezoidal rule the external work of an increment is exactly (all symmetric operators):

    sum of mean load times rigid displacement increment
        = change of (1/2) t.K t  +  sum over cells of mean shear . slip increment  -  (1/2) (p0 g1 - p1 g0),

with t = (p, qx, qy), K the block operator, and 0 and 1 the increment's start and end. So the loop's area by trapezoids
is the work of the mean shear, not of the shear that slips, |q| = mu p at the end: it falls short of the dissipation
where cells begin to slip within the increment, by O(n^-2) over a stage of n increments.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from solving import DISSIMILAR, LOAD, SIMILAR, build, solve

from fretsolve.elastic.operator import ElasticOperator
from fretsolve.simulation.simulation import set_up

LOADS = ("P", "Mx", "My", "Qx", "Qy", "Mz")
MOTIONS = ("delta_z", "phi_x", "phi_y", "delta_x", "delta_y", "phi_z")


def vector(state, names):
    return np.array([getattr(state.summary, name) for name in names])


def external_works(states):
    """Trapezoidal work of the loads per increment, from the second on."""
    loads = np.array([vector(state, LOADS) for state in states])
    motions = np.array([vector(state, MOTIONS) for state in states])
    return np.sum(0.5 * (loads[1:] + loads[:-1]) * np.diff(motions, axis=0), axis=1)


def loop(force, increments, cycles=1):
    stage = {"increments": increments}
    path = [{"P": LOAD, "increments": 1}, {"Qx": force, **stage}]
    return path + cycles * [{"Qx": 0.0, **stage}, {"Qx": -force, **stage}, {"Qx": 0.0, **stage}, {"Qx": force, **stage}]


@pytest.mark.parametrize("bodies", [SIMILAR, DISSIMILAR], ids=["similar", "dissimilar"])
def test_every_increment_balances(bodies):
    """The identity above along a path that moves every component; to the tolerance of the contact conditions."""
    path = [
        {"P": LOAD, "increments": 3},
        {"Qx": 20.0, "Mz": 2.0, "increments": 2},
        {"P": 0.7 * LOAD, "My": 4.0, "Qy": 5.0, "increments": 2},
        {"delta_x": -0.4e-3, "Mx": -3.0, "increments": 2},
    ]
    parts = {"bodies": bodies, "grid": {"points": [30, 34], "size": [0.8, 0.9]}, "load_path": path}
    parts["solver"] = {"tolerance": 1e-9}
    setup = set_up(build(**parts))
    grid, states = setup.grid, solve(**parts)
    operator = ElasticOperator(grid.shape, (grid.dx, grid.dy), setup.model.compliances, setup.model.terms)

    def energy(state):
        uz, displacement = np.zeros(grid.shape), np.zeros((2, *grid.shape))
        operator.all(state.fields.pressure, state.fields.shear, uz, displacement)
        return 0.5 * (np.vdot(state.fields.pressure, uz) + np.vdot(state.fields.shear, displacement))

    spent = []
    for before, after in pairwise(states):
        old, new = before.fields, after.fields
        sheared = np.vdot(0.5 * (old.shear + new.shear), relative_motion(before, after, grid))
        opened = -0.5 * (np.vdot(old.pressure, new.gap) - np.vdot(new.pressure, old.gap))
        spent.append((energy(after) - energy(before) + sheared + opened) * grid.cell_area)
    done = external_works(states)
    assert done == pytest.approx(spent, abs=1e-6 * np.abs(done).max())


def relative_motion(before, after, grid):
    """Of the surfaces over the whole increment; the recorded slip is that of the time in contact."""
    dx, dy, turn = vector(after, MOTIONS[3:]) - vector(before, MOTIONS[3:])
    motion = np.empty_like(after.fields.slip)
    motion[0], motion[1] = dx - turn * grid.y[None, :], dy + turn * grid.x[:, None]
    return motion + before.displacement - after.displacement


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


def test_the_second_cycle_of_dissimilar_bodies_loses_what_its_loop_encloses():
    """Once ratcheting has nearly ceased the elastic energy returns, and the area of the loop is the dissipation."""
    states = solve(bodies=DISSIMILAR, grid={"points": 24}, load_path=loop(30.0, 12, cycles=3))
    cycle = 4 * 12
    dissipated = states[-1].summary.work_total - states[-1 - cycle].summary.work_total
    area = external_works(states)[-cycle:].sum()
    assert area == pytest.approx(dissipated, rel=0.02)


def test_work_is_the_sum_of_its_density():
    states = solve(bodies=DISSIMILAR, grid={"points": 24, "size": 0.72}, load_path=loop(30.0, 3))
    cell = (0.72 / 24) ** 2
    for before, after in pairwise(states):
        assert after.summary.work_total == pytest.approx(after.fields.work_density.sum() * cell, rel=1e-12)
        assert after.summary.work_total - before.summary.work_total == pytest.approx(after.summary.work, abs=1e-15)
        assert (after.fields.work_density >= before.fields.work_density).all()


def test_pressing_and_parting_dissipate_what_the_load_does_not_get_back():
    """Where edges pass over cells within increments; a path without friction has the trapezoids' own error."""
    misses = []
    for count in (10, 20):
        path = [{"P": LOAD, "increments": count}, {"P": LOAD / count, "increments": count - 1}]
        parts = {"grid": {"points": 32}, "load_path": [{**stage, "spacing": "equal"} for stage in path]}
        elastic = solve(bodies=DISSIMILAR, coupling="none", **parts)
        states = solve(bodies=DISSIMILAR, **parts)
        lost = external_works(states).sum() - external_works(elastic).sum()
        misses.append(abs(states[-1].summary.work_total / lost - 1.0))
    assert misses[1] < 0.5 * misses[0]
    assert misses[1] < 0.04
