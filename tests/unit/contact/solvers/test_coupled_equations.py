"""The linear equations of one coupled Newton step, against finite differences of gap and slip."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.contact.solvers.coupled_equations import CoupledEquations
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.model.grid import Grid
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

GRID = Grid.from_size((14, 12), (0.7, 0.6))
OPERATOR = ElasticOperator(
    GRID.shape, (GRID.dx, GRID.dy), Compliances(A=1.82e-5, B=7.8e-6, C=6e-6), Terms(True, True, True)
)
FRICTION = 0.6
CONTACT = (GRID.x[:, None] ** 2 + GRID.y[None, :] ** 2) < 0.06
COUNT = int(np.count_nonzero(CONTACT))


class Zones:
    """A contact at random tractions, of which every other cell slips: the equations and what they are made of."""

    def __init__(self, seed=0):
        random = np.random.default_rng(seed)
        self.slipping = np.arange(COUNT) % 2 == 0
        self.pressure = random.uniform(100.0, 900.0, COUNT)
        angle = random.uniform(0.0, 2.0 * np.pi, COUNT)
        self.direction = np.array([np.cos(angle), np.sin(angle)])
        self.normal = self.direction * self.slipping
        inside = np.where(self.slipping, 1.0, random.uniform(0.1, 0.9, COUNT))
        self.shear = FRICTION * self.pressure * inside * self.direction
        self.slip = random.normal(scale=1e-3, size=(2, COUNT))
        self.slip *= np.where(self.slipping & (np.sum(self.slip * self.normal, axis=0) < 0.0), -1.0, 1.0)
        forward = np.sum(self.slip * self.normal, axis=0)
        self.stiffness = forward / (FRICTION * self.pressure) / OPERATOR.unit
        row, column = np.nonzero(CONTACT)
        x, y = GRID.x[row], GRID.y[column]
        self.motions = np.zeros((6, 3, COUNT))
        self.motions[:3, 0] = np.ones(COUNT), y, x
        self.motions[3:, 1] = np.ones(COUNT), np.zeros(COUNT), -y
        self.motions[3:, 2] = np.zeros(COUNT), np.ones(COUNT), x
        self.random = random
        drag = FRICTION * self.slipping
        self.equations = CoupledEquations(OPERATOR, CONTACT, self.normal, drag, self.stiffness, self.motions)

    def across(self, field):
        """The part of a field (2, n) across the shear where a cell slips, all of it where a cell sticks."""
        return field - np.sum(field * self.normal, axis=0) * self.normal

    def errors(self, unknown, amplitudes):
        """Gap, and slip across the shear, after the tractions have changed: slipping cells stay on the circle."""
        pressure = self.pressure + unknown[0]
        turned = np.array([-self.normal[1], self.normal[0]])
        angle = np.sum(unknown[1:] * turned, axis=0) / (FRICTION * self.pressure)
        direction = self.normal * np.cos(angle) + turned * np.sin(angle)
        shear = np.where(self.slipping, FRICTION * pressure * direction, self.shear + unknown[1:])
        planes = np.zeros((3, *GRID.shape))
        planes[0][CONTACT] = pressure - self.pressure
        planes[1:, CONTACT] = shear - self.shear
        moved = np.zeros_like(planes)
        OPERATOR.all(planes[0], planes[1:], moved[0], moved[1:])
        rigid = np.tensordot(amplitudes * OPERATOR.unit, self.motions, axes=1)
        slip = self.slip + rigid[1:] - moved[1:, CONTACT]
        aside = np.sum(slip * np.array([-direction[1], direction[0]]), axis=0)
        return moved[0, CONTACT] - rigid[0], np.where(self.slipping, aside * turned, slip)


@pytest.mark.parametrize("seed", range(3))
def test_the_left_side_is_the_derivative_of_gap_and_slip(seed):
    zones = Zones(seed)
    unknown, amplitudes = zones.random.normal(size=(3, COUNT)), zones.random.normal(size=6)
    unknown[1:] = zones.across(unknown[1:])
    step = 1e-3
    (gap, slip), (gap_before, slip_before) = (zones.errors(h * unknown, h * amplitudes) for h in (step, -step))
    expected = np.array([gap - gap_before, *(slip_before - slip)]) / (2.0 * step * OPERATOR.unit)
    found = zones.equations.apply(unknown, amplitudes)
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("reduction", [1e-2, 1e-8])
def test_a_solution_has_the_loads_and_meets_the_equations(reduction):
    zones = Zones()
    right, missing = zones.random.normal(size=(3, COUNT)), 10.0 * zones.random.normal(size=6)
    right[1:] = zones.across(right[1:])
    change, amplitudes, iterations = zones.equations.solve(right, missing, reduction, 100)
    np.testing.assert_allclose(np.tensordot(zones.motions, change, axes=2), missing, rtol=1e-9, atol=1e-9)
    unknown = np.array([change[0], *zones.across(change[1:] - FRICTION * change[0] * zones.normal)])
    left = zones.equations.apply(unknown, amplitudes)
    assert np.linalg.norm(right - left) <= 10.0 * reduction * np.linalg.norm(right)
    assert 1 <= iterations < 80


def test_a_cell_alone_takes_the_force_but_no_tilt():
    """The tilts of a single cell depend on its displacement; they must not spoil the solution."""
    contact = np.zeros(GRID.shape, dtype=bool)
    contact[3, 4] = True
    motions = np.zeros((3, 3, 1))
    motions[:, 0, 0] = 1.0, GRID.y[4], GRID.x[3]
    nothing = np.zeros(1)
    equations = CoupledEquations(OPERATOR, contact, np.zeros((2, 1)), nothing, nothing, motions)
    missing = 5.0 * motions[:, 0, 0]
    change, amplitudes, _ = equations.solve(np.zeros((3, 1)), missing, 1e-8, 10)
    assert change[:, 0] == pytest.approx([5.0, 0.0, 0.0], abs=1e-6)
    uz, moved, pressure = np.zeros(GRID.shape), np.zeros((2, *GRID.shape)), 5.0 * contact
    OPERATOR.all(pressure, np.zeros((2, *GRID.shape)), uz, moved)
    assert amplitudes @ motions[:, 0, 0] * OPERATOR.unit == pytest.approx(uz[3, 4], rel=1e-6)
