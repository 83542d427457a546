"""Series along y against the Fourier series of the whole field."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.cosine_series import FastTransform, MatrixTransform
from fretsolve.elastic.kernels import load
from fretsolve.elastic.thread_team import ThreadTeam


def transforms(shape, count, compiled):
    dtype = np.dtype(np.float64)
    return (MatrixTransform(shape[1], count, dtype), FastTransform(shape, count, dtype, ThreadTeam(1, load(compiled))))


def series(field, count, odd):
    """The coefficients of the whole field, (count, nx), by NumPy: F_s, or i G_s with the last one first."""
    nx, columns = field.shape
    padded = np.zeros((nx, 2 * count))
    padded[:, :columns] = field
    padded[:, 2 * count - columns :] = (-field if odd else field)[:, ::-1]
    spectrum = np.fft.fft(padded, axis=1) * np.exp(-0.5j * np.pi / count * np.arange(2 * count))
    if not odd:
        return spectrum[:, :count].real.T
    found = -spectrum[:, : count + 1].imag.T
    return np.concatenate([found[-1:], found[1:-1]])


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("odd", [False, True], ids=["even", "odd"])
@pytest.mark.parametrize(
    ("shape", "count"), [((7, 6), 12), ((8, 5), 15), ((1, 3), 3), ((9, 1), 2), ((20, 8), 9)], ids=str
)
def test_series(shape, count, odd, compiled):
    field = np.random.default_rng(0).normal(size=shape)
    for transform in transforms(shape, count, compiled):
        found, back = np.empty((count, shape[0])), np.empty(shape)
        transform.forward([field], [odd], [found])
        assert found == pytest.approx(series(field, count, odd), abs=1e-12)
        transform.backward([found], [odd], [back])
        assert back == pytest.approx(2 * count * field, abs=1e-11)
