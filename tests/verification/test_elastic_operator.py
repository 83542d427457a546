"""The elastic operator against summation cell by cell, against point loads far away, and its structure."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fretsolve.elastic import influence
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

FULL = Terms(True, True, True)
MATERIAL = Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6)
"""1/MPa; any C within |C| <= A occurs."""

GRIDS = [
    ((12, 12), (0.1, 0.1)),
    ((7, 10), (0.3, 0.11)),
    ((9, 5), (0.02, 0.05)),
    ((1, 6), (1.0, 1.0)),
    ((1, 1), (2.0, 1.0)),
]


def operator(shape, spacing, terms=FULL, material=MATERIAL):
    return ElasticOperator(shape, spacing, material, terms)


def apply(elastic, tractions):
    """Displacements (3, nx, ny) of (uz, ux, uy) from tractions (3, nx, ny) of (p, qx, qy)."""
    displacements = np.empty_like(tractions)
    elastic.all(tractions[0], tractions[1:], displacements[0], displacements[1:])
    return displacements


def random_tractions(shape, seed=0):
    return np.random.default_rng(seed).normal(size=(3, *shape))


def dense(shape, spacing, material=MATERIAL):
    """The block operator as a matrix (3n, 3n), put together from the influence functions pair by pair."""
    (nx, ny), (dx, dy) = shape, spacing
    x, y = np.arange(nx) * dx, np.arange(ny) * dy
    quadrants = {
        name: getattr(influence, name)(x, y, dx, dy)
        for name in ("inverse_distance", "along_x", "along_y", "across", "radial_x", "radial_y")
    }
    i, j = (index.ravel() for index in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    step_x, step_y = i[:, None] - i[None, :], j[:, None] - j[None, :]
    between = {name: values[abs(step_x), abs(step_y)] for name, values in quadrants.items()}
    sign_x, sign_y = np.sign(step_x), np.sign(step_y)
    A, B, C = material.A, material.B, material.C
    zz = A / 2 * between["inverse_distance"] / math.pi
    xx = (A * between["inverse_distance"] + B * between["along_x"]) / (2 * math.pi)
    yy = (A * between["inverse_distance"] + B * between["along_y"]) / (2 * math.pi)
    xy = B * sign_x * sign_y * between["across"] / (2 * math.pi)
    xz = C * sign_x * between["radial_x"] / (4 * math.pi)
    yz = C * sign_y * between["radial_y"] / (4 * math.pi)
    return np.block([[zz, -xz, -yz], [xz, xx, xy], [yz, xy, yy]])


@pytest.mark.parametrize(("shape", "spacing"), GRIDS)
def test_direct_summation(shape, spacing):
    tractions = random_tractions(shape)
    found = apply(operator(shape, spacing), tractions)
    summed = (dense(shape, spacing) @ tractions.ravel()).reshape(found.shape)
    assert np.abs(found - summed).max() <= 1e-12 * np.abs(summed).max()


@pytest.mark.parametrize(("shape", "spacing"), GRIDS)
def test_parts_agree_with_the_whole(shape, spacing):
    elastic, tractions = operator(shape, spacing), random_tractions(shape)
    pressure, shear = tractions[0], tractions[1:]
    normal, opened, both = np.empty(shape), np.empty(shape), np.empty((2, *shape))
    sideways = np.empty((2, *shape))
    elastic.normal(pressure, normal)
    elastic.normal_from_shear(shear, opened)
    elastic.tangential(shear, both)
    elastic.tangential_from_pressure(pressure, sideways)
    whole = apply(elastic, tractions)
    assert np.abs(normal + opened - whole[0]).max() <= 1e-12 * np.abs(whole).max()
    assert np.abs(both + sideways - whole[1:]).max() <= 1e-12 * np.abs(whole).max()


@pytest.mark.parametrize(("shape", "spacing"), GRIDS)
def test_symmetric_and_positive_definite(shape, spacing):
    elastic = operator(shape, spacing)
    count = 3 * shape[0] * shape[1]
    columns = [apply(elastic, unit.reshape(3, *shape)).ravel() for unit in np.eye(count)]
    matrix = np.array(columns).T
    assert np.abs(matrix - matrix.T).max() <= 1e-13 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(matrix).min() > 0.0


def test_positive_definite_for_the_strongest_coupling():
    """|Dundurs' constant| = 1/2: a rigid body on one of Poisson's ratio 0."""
    matrix = dense((6, 5), (0.2, 0.3), Compliances(A=1.0, B=0.0, C=1.0))
    assert np.linalg.eigvalsh(matrix).min() > 0.0


class TestPointLoads:
    """A loaded cell seen from 60 cells away is a point load; what is left of the cell's extent is O((h/r)^2)."""

    SIDE = 0.05
    COUNT = 61

    def far(self, component):
        shape = (self.COUNT, self.COUNT)
        tractions = np.zeros((3, *shape))
        tractions[component, 0, 0] = 1.0
        displaced = apply(operator(shape, (self.SIDE, self.SIDE)), tractions)
        offsets = np.arange(self.COUNT) * self.SIDE
        x, y = offsets[:, None], offsets[None, :]
        far = np.hypot(x, y) > 40 * self.SIDE
        force = self.SIDE**2
        return displaced, np.where(far, x, np.nan), np.where(far, y, np.nan), far, force

    def check(self, found, exact, far, scale):
        assert np.abs(found - exact)[far].max() <= 1e-3 * np.abs(scale)[far].max()

    def test_boussinesq(self):
        (uz, ux, uy), x, y, far, force = self.far(0)
        r = np.hypot(x, y)
        contact_modulus = MATERIAL.contact_modulus
        self.check(uz, force / (np.pi * contact_modulus * r), far, uz)
        self.check(ux, force * MATERIAL.C * x / (4 * np.pi * r**2), far, ux)
        self.check(uy, force * MATERIAL.C * y / (4 * np.pi * r**2), far, uy)

    @pytest.mark.parametrize("component", [1, 2])
    def test_cerruti(self, component):
        displaced, x, y, far, force = self.far(component)
        along, across = (x, y) if component == 1 else (y, x)
        r = np.hypot(x, y)
        ahead = force / (2 * np.pi) * (MATERIAL.A / r + MATERIAL.B * along**2 / r**3)
        sideways = force / (2 * np.pi) * MATERIAL.B * along * across / r**3
        self.check(displaced[component], ahead, far, ahead)
        self.check(displaced[3 - component], sideways, far, ahead)
        self.check(displaced[0], -force * MATERIAL.C * along / (4 * np.pi * r**2), far, displaced[0])


def test_nothing_wraps_around():
    """The padding is no period: a load at one corner is not seen from beyond the other."""
    shape = (16, 15)
    tractions = np.zeros((3, *shape))
    tractions[0, 0, 0] = 1.0
    uz = apply(operator(shape, (1.0, 1.0)), tractions)[0]
    assert (np.diff(uz, axis=0) < 0.0).all()
    assert (np.diff(uz, axis=1) < 0.0).all()
