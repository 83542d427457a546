from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import convolve2d

from fretsolve.elastic import convolution, fftw, influence
from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.fftw import padded_length
from fretsolve.elastic.thread_team import ThreadTeam

SHAPES = [(8, 8), (7, 12), (1, 5), (5, 1), (13, 6)]
PARITIES = [(False, False), (True, False), (False, True), (True, True)]


@pytest.fixture(autouse=True, params=["batched", "in blocks"])
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


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("odd_x", "odd_y"), PARITIES)
def test_linear_convolution(shape, odd_x, odd_y):
    """Real spectra for even-even and odd-odd kernels, imaginary ones for the others, which take a turn by i."""
    padded = PaddedConvolution(shape)
    values = quadrant(shape, odd_x, odd_y)
    kernel = padded.kernel_spectrum(values, odd_x, odd_y)
    field = np.random.default_rng(2).normal(size=shape)
    (found,) = convolve(padded, ((kernel,),), [field], turn_field=odd_x != odd_y)
    summed = convolve2d(field, whole(values, odd_x, odd_y))
    (nx, ny) = shape
    exact = summed[nx - 1 : 2 * nx - 1, ny - 1 : 2 * ny - 1]
    np.testing.assert_allclose(found, exact, atol=1e-13 * max(np.abs(exact).max(), 1.0))


def test_blocks_do_not_matter(monkeypatch):
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", 0)
    shape = (24, 30)
    values, field = quadrant(shape, True, True), np.random.default_rng(3).normal(size=shape)
    results = []
    for cache in (fftw.CACHE_BYTES, 3000):
        monkeypatch.setattr(fftw, "CACHE_BYTES", cache)
        padded = PaddedConvolution(shape)
        kernel = padded.kernel_spectrum(values, True, True)
        results.append(convolve(padded, ((kernel,),), [field])[0])
    np.testing.assert_allclose(results[0], results[1], atol=1e-12)


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


def test_matrix_of_kernels():
    shape = (9, 6)
    padded = PaddedConvolution(shape)
    parities = {"xx": (False, False), "xy": (True, True), "yy": (False, False)}
    values = {name: quadrant(shape, *odd, seed=index) for index, (name, odd) in enumerate(parities.items())}
    kernel = {name: padded.kernel_spectrum(values[name], *parities[name]) for name in parities}
    fields = list(np.random.default_rng(5).normal(size=(2, *shape)))
    together = convolve(padded, ((kernel["xx"], kernel["xy"]), (kernel["xy"], kernel["yy"])), fields)
    alone = convolve(padded, ((kernel["xx"],),), fields[:1])[0] + convolve(padded, ((kernel["xy"],),), fields[1:])[0]
    np.testing.assert_allclose(together[0], alone, atol=1e-12)


def test_single_precision():
    shape = (20, 16)
    values, field = quadrant(shape, False, False), np.random.default_rng(4).normal(size=shape)
    found = []
    for dtype in (np.float64, np.float32):
        padded = PaddedConvolution(shape, dtype)
        kernel = padded.kernel_spectrum(values, False, False)
        found.append(convolve(padded, ((kernel,),), [field.astype(dtype)])[0])
    assert found[1].dtype == np.float32
    np.testing.assert_allclose(found[1], found[0], atol=1e-4 * np.abs(found[0]).max())


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_whole_arrays_and_blocks_give_the_same(monkeypatch, dtype):
    """All numbers of fields and displacements, with and without the factor i."""
    shape, random = (10, 7), np.random.default_rng(6)
    parities = [[(False, False), (True, False), (False, True)], [(True, False), (False, False), (True, True)]]
    parities.append([(False, True), (True, True), (False, False)])
    fields = list(random.normal(size=(3, *shape)).astype(dtype))
    for rows, columns, turned in ((1, 1, False), (2, 2, False), (3, 3, True), (1, 2, False), (2, 1, False)):
        found = []
        for most in (np.inf, 0):
            monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", most)
            padded = PaddedConvolution(shape, dtype)

            def kernel(i, j, padded=padded):
                odd = parities[i][j]
                return padded.kernel_spectrum(quadrant(shape, *odd, seed=i + j), *odd)

            kernels = tuple(tuple(kernel(i, j) for j in range(columns)) for i in range(rows))
            results = [np.empty(shape, dtype) for _ in range(rows)]
            padded.apply(kernels, fields[:columns], results, (turned, turned))
            found.append(np.array(results))
        largest = np.abs(found[0]).max()
        np.testing.assert_allclose(found[0], found[1], atol=100 * np.finfo(dtype).eps * largest)


@pytest.mark.parametrize("lines", [3, 7, 50, 128, 170, 256, 301, 512])
def test_blocks_of_lines_are_one_or_an_even_number(lines: int) -> None:
    blocks = fftw.even_parts(lines, fftw.CACHE_BYTES // 50)
    assert [line for block in blocks for line in range(lines)[block]] == list(range(lines))
    assert len(blocks) == 1 if lines < 50 else len(blocks) % 2 == 0
