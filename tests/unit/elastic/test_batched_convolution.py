"""Convolution with whole arrays, against sums over all cells."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.convolution import BatchedConvolution
from fretsolve.elastic.influence import KernelSpectrum
from fretsolve.elastic.kernels import load

SHAPE, PADDED = (5, 4), (10, 8)


def spectrum_of(offsets: np.ndarray, odd_x: bool) -> tuple[KernelSpectrum, bool]:
    """The spectrum of a function at offsets (mx, my) that is even in y; whether it is imaginary."""
    whole = np.fft.rfft2(offsets) / offsets.size  # for unnormalised inverse transforms
    values = -whole.imag if odd_x else whole.real
    return KernelSpectrum(np.ascontiguousarray(values[: PADDED[0] // 2 + 1].T), odd_x), odd_x


def offsets_of(odd_x: bool, seed: int) -> np.ndarray:
    """Values at the periodic offsets, even in y, and even or odd in x."""
    values = np.random.default_rng(seed).normal(size=PADDED)
    values = values + np.roll(values[:, ::-1], 1, axis=1)
    mirrored = np.roll(values[::-1], 1, axis=0)
    return values - mirrored if odd_x else values + mirrored


def summed(offsets: np.ndarray, field: np.ndarray) -> np.ndarray:
    result = np.zeros(SHAPE)
    for i, j in np.ndindex(*SHAPE):
        for k, m in np.ndindex(*SHAPE):
            result[i, j] += offsets[i - k, j - m] * field[k, m]
    return result


@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_two_fields_and_two_displacements(dtype, compiled):
    kernels = [[spectrum_of(offsets_of(False, 2 * row + column), False)[0] for column in (0, 1)] for row in (0, 1)]
    fields = np.random.default_rng(9).normal(size=(2, *SHAPE)).astype(dtype)
    found = np.empty_like(fields)
    convolution = BatchedConvolution(SHAPE, PADDED, np.dtype(dtype), load(compiled).spectral)
    for _ in range(2):  # its padding is still zero at the second time
        convolution.apply(tuple(map(tuple, kernels)), fields, found, (False, False))
    for row in (0, 1):
        expected = sum(summed(offsets_of(False, 2 * row + column), fields[column]) for column in (0, 1))
        np.testing.assert_allclose(found[row], expected, atol=2e-5 if dtype is np.float32 else 1e-12)


def test_an_odd_kernel_takes_its_field_times_i():
    offsets = offsets_of(True, 11)
    kernel, _ = spectrum_of(offsets, True)
    field, found = np.random.default_rng(9).normal(size=(1, *SHAPE)), np.empty((1, *SHAPE))
    convolution = BatchedConvolution(SHAPE, PADDED, np.dtype(float), load(False).spectral)
    convolution.apply(((kernel,),), field, found, (True, False))
    assert np.abs(summed(offsets, field[0])).max() > 1.0
    np.testing.assert_allclose(np.abs(found[0]), np.abs(summed(offsets, field[0])), atol=1e-12)
