"""Series along y against the Fourier series of the whole field."""

from __future__ import annotations

import numpy as np
import pytest

from fretsolve.elastic.mirrored.half_transform import FastTransform, MatrixTransform
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.kernels import load


def transforms(shape, slots, compiled):
    dtype = np.dtype(np.float64)
    return (MatrixTransform(shape[1], slots, dtype), FastTransform(shape, slots, dtype, ThreadTeam(1, load(compiled))))


def series(field, slots, odd):
    """The coefficients of the whole field, (slots, nx), by NumPy: F_s, or i G_s with the last one first."""
    nx, columns = field.shape
    padded = np.zeros((nx, 2 * slots))
    padded[:, :columns] = field
    padded[:, 2 * slots - columns :] = (-field if odd else field)[:, ::-1]
    spectrum = np.fft.fft(padded, axis=1) * np.exp(-0.5j * np.pi / slots * np.arange(2 * slots))
    if not odd:
        return spectrum[:, :slots].real.T
    found = -spectrum[:, : slots + 1].imag.T
    return np.concatenate([found[-1:], found[1:-1]])


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("odd", [False, True], ids=["even", "odd"])
@pytest.mark.parametrize(
    ("shape", "slots"), [((7, 6), 12), ((8, 5), 15), ((1, 3), 3), ((9, 1), 2), ((20, 8), 9)], ids=str
)
def test_series(shape, slots, odd, compiled):
    field = np.random.default_rng(0).normal(size=shape)
    for transform in transforms(shape, slots, compiled):
        found, back = np.empty((slots, shape[0])), np.empty(shape)
        transform.forward([field], [odd], [found])
        assert found == pytest.approx(series(field, slots, odd), abs=1e-12)
        transform.backward([found], [odd], [back])
        assert back == pytest.approx(2 * slots * field, abs=1e-11)
