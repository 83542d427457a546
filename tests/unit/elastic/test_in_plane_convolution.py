"""Convolution of a tangential field as one complex field, against that of its two components."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.batched_convolution import BatchedConvolution
from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.in_plane_convolution import InPlaneConvolution
from fretsolve.elastic.influence import InfluenceSpectra, ScaledSpectra
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.kernels import load
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms

MATERIAL = Compliances(A=1.1e-5, B=3.4e-6, C=-4.0e-6)
SHAPES = [(5, 4), (8, 8), (7, 12), (1, 6), (6, 1)]
SPACING = (0.1, 0.12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", SHAPES)
def test_displacements_are_those_of_two_real_fields(shape, dtype):
    padded = PaddedConvolution(shape)
    spectra = ScaledSpectra(InfluenceSpectra(padded, SPACING, MATERIAL), 1e6, dtype)
    kernels = (spectra["xx"], spectra["xy"]), (spectra["xy"], spectra["yy"])
    shear = np.random.default_rng(0).normal(size=(2, *shape)).astype(dtype)
    expected, found = np.empty_like(shear), np.empty_like(shear)
    options = shape, padded.padded, np.dtype(dtype)
    BatchedConvolution(*options, load(False).spectral).apply(kernels, shear, expected, (False, False))
    convolution = InPlaneConvolution(*options, kernels, load(True).spectral)
    for _ in range(2):  # its padding is still zero at the second time
        convolution.apply(shear, found)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4 * np.finfo(dtype).eps * np.abs(expected).max())


@pytest.mark.parametrize("shape", [(8, 8), (9, 7)])
def test_the_inner_operator_and_its_preconditioner_are_the_same_with_both_kernels(shape):
    shear = np.random.default_rng(1).normal(size=(2, *shape)).astype(np.float32)
    found = []
    for compiled in (False, True):
        team, terms = ThreadTeam(1, load(compiled)), Terms(True, True, False)
        operator = ElasticOperator(shape, SPACING, MATERIAL, terms, team)
        displacement, traction = np.empty_like(shear), np.empty_like(shear)
        operator.inner.tangential(shear, displacement)
        operator.preconditioner.tangential(shear, traction)
        found.append((displacement, traction))
    for plain, compiled in zip(*found, strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-6 * np.abs(plain).max())
