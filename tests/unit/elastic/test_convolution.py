from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import convolve2d

from fretsolve.elastic import convolution, influence
from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.fftw import padded_length
from fretsolve.elastic.kernels import load
from fretsolve.elastic.thread_team import ThreadTeam

SHAPES = [(8, 8), (7, 12), (1, 5), (5, 1)]
PARITIES = [(False, False), (True, False), (False, True), (True, True)]


@pytest.fixture(params=["batched", "in blocks"])
def method(request, monkeypatch):
    """Both ways to convolve, on whole arrays and in blocks."""
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", np.inf if request.param == "batched" else 0)


def quadrant(shape, odd_x, odd_y, seed=1):
    """Values at offsets from 0 on; an odd function is 0 there."""
    values = np.random.default_rng(seed).normal(size=shape)
    if odd_x:
        values[0] = 0.0
    if odd_y:
        values[:, 0] = 0.0
    return values


def whole(values, odd_x, odd_y):
    """The function at all offsets from -(n-1) to n-1."""
    rows = np.concatenate([(-1 if odd_x else 1) * values[:0:-1], values])
    return np.concatenate([(-1 if odd_y else 1) * rows[:, :0:-1], rows], axis=1)


def convolve(padded, kernels, fields, turn_field=False):
    results = [np.empty(padded.shape, dtype=fields[0].dtype) for _ in kernels]
    padded.apply(kernels, fields, results, (turn_field, False))
    return results


@pytest.mark.parametrize("points", [1, 2, 3, 8, 17, 64, 100, 129, 1000])
def test_padded_length(points):
    length = padded_length(points)
    assert length >= 2 * points - 1
    assert length <= 2.83 * points + 2  # twice the area costs more than the worst of lengths
    assert points == 1 or length % 2 == 0


@pytest.mark.usefixtures("method")
@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("odd_x", "odd_y"), PARITIES)
def test_linear_convolution(shape, odd_x, odd_y, compiled):
    """Real spectra for even-even and odd-odd kernels, imaginary ones for the others, which take a turn by i."""
    padded = PaddedConvolution(shape, team=ThreadTeam(1, load(compiled)))
    values = quadrant(shape, odd_x, odd_y)
    kernel = padded.kernel_spectrum(values, odd_x, odd_y)
    field = np.random.default_rng(2).normal(size=shape)
    (found,) = convolve(padded, ((kernel,),), [field], turn_field=odd_x != odd_y)
    summed = convolve2d(field, whole(values, odd_x, odd_y))
    (nx, ny) = shape
    exact = summed[nx - 1 : 2 * nx - 1, ny - 1 : 2 * ny - 1]
    np.testing.assert_allclose(found, exact, atol=1e-13 * max(np.abs(exact).max(), 1.0))


@pytest.mark.parametrize("odd", [(False, False), (True, False), (True, True)])
def test_spectra_in_parts_are_those_of_the_whole(odd, monkeypatch):
    values = quadrant((23, 31), *odd)
    results = []
    for least in (10**9, 0):
        monkeypatch.setattr(influence, "LEAST_SHARED", least)
        results += [
            PaddedConvolution((23, 31), team=ThreadTeam(count)).kernel_spectrum(values, *odd) for count in (1, 2)
        ]
    for other in results[1:]:
        np.testing.assert_array_equal(other.values, results[0].values)


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_whole_arrays_and_blocks_give_the_same(monkeypatch, dtype, compiled):
    """All numbers of fields and displacements, with and without the factor i."""
    shape, random = (10, 7), np.random.default_rng(6)
    parities = [[(False, False), (True, False), (False, True)], [(True, False), (False, False), (True, True)]]
    parities.append([(False, True), (True, True), (False, False)])
    fields = list(random.normal(size=(3, *shape)).astype(dtype))
    for rows, columns, turned in ((1, 1, False), (2, 2, False), (3, 3, True), (1, 2, False), (2, 1, False)):
        found = []
        for most in (np.inf, 0):
            monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", most)
            padded = PaddedConvolution(shape, dtype, ThreadTeam(1, load(compiled)))

            def kernel(i, j, padded=padded):
                odd = parities[i][j]
                return padded.kernel_spectrum(quadrant(shape, *odd, seed=i + j), *odd)

            kernels = tuple(tuple(kernel(i, j) for j in range(columns)) for i in range(rows))
            results = [np.empty(shape, dtype) for _ in range(rows)]
            padded.apply(kernels, fields[:columns], results, (turned, turned))
            found.append(np.array(results))
        largest = np.abs(found[0]).max()
        np.testing.assert_allclose(found[0], found[1], atol=100 * np.finfo(dtype).eps * largest)
