"""The operator on one half of a grid against that on the whole one, under fields that are mirror images."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic import fftw
from fretsolve.elastic.kernels import load
from fretsolve.elastic.mirrored_operator import MirroredOperator
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.materials import Compliances
from fretsolve.problem.model.required_terms import Terms

MATERIAL, SPACING = Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6), (0.1, 0.12)
FULL, NO_COUPLING = Terms(True, True, True), Terms(True, False, False)


def mirrored(half, odd=False):
    """The whole of a field, of its half y > 0."""
    return np.concatenate([(-half if odd else half)[..., ::-1], half], axis=-1)


def vectors(half):
    return np.array([mirrored(half[0]), mirrored(half[1], odd=True)])


def both(shape, terms=FULL, compiled=False, dtype=np.float64, threads=1):
    """The operators on the whole grid and on its half, of ``shape`` cells."""
    team = ThreadTeam(threads, load(compiled))
    whole = ElasticOperator((shape[0], 2 * shape[1]), SPACING, MATERIAL, terms, team, dtype)
    return whole, MirroredOperator(shape, SPACING, MATERIAL, terms, team, dtype)


def displacements(elastic, pressure, shear):
    """What each method computes: uz, tangential, by each from the other, and uz and tangential of all."""
    uz, lifted, of_all = (np.empty_like(pressure) for _ in range(3))
    found, moved, along = (np.empty_like(shear) for _ in range(3))
    elastic.normal(pressure, uz)
    elastic.tangential(shear, found)
    elastic.tangential_from_pressure(pressure, moved)
    elastic.normal_from_shear(shear, lifted)
    elastic.all(pressure, shear, of_all, along)
    return uz, found, moved, lifted, of_all, along


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("shape", [(12, 5), (9, 8), (1, 1), (13, 1), (90, 47), (101, 52)], ids=str)
def test_displacements_are_those_of_the_whole_grid(shape, compiled):
    """On small grids by products with matrices, on the last two by fast transforms, with even and odd lengths."""
    random = np.random.default_rng(0)
    pressure, shear = random.normal(size=shape), random.normal(size=(2, *shape))
    whole, half = both(shape, compiled=compiled)
    wanted = displacements(whole, mirrored(pressure), vectors(shear))
    for one, other in zip(displacements(half, pressure, shear), wanted, strict=True):
        assert one == pytest.approx(other[..., shape[1] :], rel=1e-12, abs=1e-12 * np.abs(other).max())
    assert half.applications == whole.applications == 5


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
def test_blocks_of_lines_and_threads_change_no_bit(compiled, monkeypatch):
    monkeypatch.setattr(fftw, "CACHE_BYTES", 4096)
    monkeypatch.setattr("fretsolve.elastic.mirrored_operator.MOST_PRODUCTS", 0)
    random, shape = np.random.default_rng(1), (21, 13)
    pressure, shear = random.normal(size=shape), random.normal(size=(2, *shape))
    whole, half = both(shape, compiled=compiled)
    wanted = displacements(whole, mirrored(pressure), vectors(shear))
    found = displacements(half, pressure, shear)
    for one, other in zip(found, wanted, strict=True):
        assert one == pytest.approx(other[..., shape[1] :], rel=1e-12, abs=1e-12 * np.abs(other).max())
    for one, other in zip(
        displacements(both(shape, compiled=compiled, threads=3)[1], pressure, shear), found, strict=True
    ):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("shape", [(16, 8), (96, 48)], ids=str)
def test_the_preconditioner_is_that_of_the_whole_grid(shape):
    """These lengths are fast ones, so both have the same period."""
    random = np.random.default_rng(4)
    shear = random.normal(size=(2, *shape)).astype(np.float32)
    whole, half = both(shape)
    wanted, found = np.empty((2, shape[0], 2 * shape[1]), np.float32), np.empty_like(shear)
    whole.preconditioner.tangential(vectors(shear), wanted)
    half.preconditioner.tangential(shear, found)
    assert found == pytest.approx(wanted[..., shape[1] :], abs=2e-6 * float(np.abs(wanted).max()))
    whole.preconditioner.normal(mirrored(shear[:1]), wanted[:1])
    half.preconditioner.normal(shear[:1], found[:1])
    assert found[0] == pytest.approx(wanted[0, :, shape[1] :], abs=2e-6 * float(np.abs(wanted[0]).max()))
