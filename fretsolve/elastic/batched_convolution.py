"""Convolution on a small grid: all fields in one plan, and the padded spectra as whole arrays.

Where the arrays fit into the cache, a convolution costs the calls that it is made of, not its transforms. So all fields
are transformed by one call along y and one along x, out of arrays whose padding stays zero, and one call computes the
products. On 16, 32 and 64 cells per side, two components take 0.4, 0.7 and 1.0 of the time of the blocks of
`PaddedConvolution`; without numba, on 32, 64 and 128, 0.2, 0.4 and 0.6.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.fftw import estimated_plan, pyfftw
from fretsolve.elastic.in_plane_convolution import InPlaneConvolution
from fretsolve.elastic.kernel_spectrum import KernelMatrix
from fretsolve.system.arrays import ComplexArray, Fields, FloatArray


class BatchedConvolution:
    """Buffers and plans for fields (nx, ny) on the grid `padded`, made when they are first needed.

    kernels: operations on spectra; compiled: by numba.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        padded: tuple[int, int],
        dtype: np.dtype[Any],
        kernels: ModuleType,
        compiled: bool = False,
    ):
        self._shape, self._padded, self._dtype, self._kernels = shape, padded, dtype, kernels
        self._may_be_complex = compiled and dtype == np.float32
        self._forward, self._backward = cache(self._make_forward), cache(self._make_backward)
        self._convolutions: dict[tuple[KernelMatrix, tuple[bool, bool]], _Steps | InPlaneConvolution] = {}

    def apply(self, kernels: KernelMatrix, fields: Fields, displacements: Fields, turned: tuple[bool, bool]) -> None:
        """Compute ``displacements = kernels @ fields``; arguments as for `PaddedConvolution.apply`."""
        convolution = self._convolutions.get((kernels, turned))
        if convolution is None:
            convolution = self._convolutions[kernels, turned] = self._convolution(kernels, turned)
        convolution.apply(fields, displacements)

    def _convolution(self, kernels: KernelMatrix, turned: tuple[bool, bool]) -> _Steps | InPlaneConvolution:
        """Return all that a convolution consists of, so that it looks up nothing: 2 us of each."""
        symmetric = len(kernels) == len(kernels[0]) == 2 and kernels[0][1] is kernels[1][0]
        if self._may_be_complex and symmetric and not any(turned):
            return InPlaneConvolution(self._shape, self._padded, self._dtype, kernels, self._kernels)
        forward, backward = self._forward(len(kernels[0])), self._backward(len(kernels))
        factors = self._factors_of(kernels, turned)
        products = factors, forward.of(factors)[0], *backward.of(factors)
        return _Steps(forward.rows, forward.plans, products, backward.plans, backward.rows, self._kernels)

    def _factors_of(self, kernels: KernelMatrix, turned: tuple[bool, bool]) -> NDArray[np.inexact]:
        """Return the kernels (m, n, mx * (my//2 + 1)) with their factors i and -i; real ones twice, for both parts."""
        values = np.array([[kernel.whole(self._padded[:1]) for kernel in row] for row in kernels])
        if any(turned):
            turns = np.ones((*values.shape[:2], 1, 1), np.result_type(values, np.complex64))
            turns[:, 0] *= 1j ** turned[0]
            turns[0] *= (-1j) ** turned[1]
            found = values * turns
        else:
            found = np.repeat(values, 2, axis=-1)
        return found.reshape(*found.shape[:2], -1)

    def _make_forward(self, count: int) -> _Transforms:
        """Return the transforms of `count` fields, along y, then along x out of an array whose padding stays zero."""
        rows, half, spectrum = self._arrays(count)
        plans = estimated_plan(rows, half[:, : self._shape[0]], 2), estimated_plan(half, spectrum, 1)
        return _Transforms(rows[:, :, : self._shape[1]], spectrum, spectrum[:0], plans)

    def _make_backward(self, count: int) -> _Transforms:
        """Return the inverse transforms of `count` spectra, along x, then along y of the wanted rows."""
        rows, half, spectrum = self._arrays(count)
        plans = (
            estimated_plan(spectrum, half, 1, back=True),
            estimated_plan(half[:, : self._shape[0]], rows, 2, back=True),
        )
        return _Transforms(rows[:, :, : self._shape[1]], spectrum, half, plans)

    def _arrays(self, count: int) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Return padded rows (count, nx, my), and twice an array for spectra (count, mx, my//2 + 1)."""
        (mx, my), complex_type = self._padded, np.result_type(self._dtype, np.complex64)
        rows = pyfftw.zeros_aligned((count, self._shape[0], my), self._dtype)
        first, second = (pyfftw.zeros_aligned((count, mx, my // 2 + 1), complex_type) for _ in range(2))
        return rows, first, second


class _Transforms:
    """Two plans that run one after the other, between `rows`, the cells' part of padded rows, and a spectrum.

    Spectra are (count, mx * (my//2 + 1)) where they are multiplied.
    """

    def __init__(
        self, rows: FloatArray, spectrum: ComplexArray, product: ComplexArray, plans: tuple[pyfftw.FFTW, pyfftw.FFTW]
    ):
        self.rows = rows
        flat = tuple(array.reshape(-1, spectrum[0].size) for array in (spectrum, product))
        self._numbers, self._parts = flat, tuple(array.view(rows.dtype) for array in flat)
        self.plans = tuple(one.execute for one in plans)

    def of(self, factors: NDArray[np.inexact]) -> tuple[NDArray[np.inexact], ...]:
        """Return the spectrum and an array of its shape for products; for real factors their parts, as neighbours."""
        return self._numbers if factors.dtype.kind == "c" else self._parts


class _Steps(NamedTuple):
    """Steps of a convolution: `rows` that receive the fields, plans, arguments of `combine`, plans, `wanted` rows.

    spectral: operations on spectra.
    """

    rows: FloatArray
    forward: tuple[Callable[[], Any], ...]
    products: tuple[NDArray[np.inexact], ...]
    backward: tuple[Callable[[], Any], ...]
    wanted: FloatArray
    spectral: ModuleType

    def apply(self, fields: Fields, displacements: Fields) -> None:
        """Take these steps from some fields to their displacements."""
        _copy(fields, self.rows)
        for transform in self.forward:
            transform()
        self.spectral.combine(*self.products)
        for transform in self.backward:
            transform()
        _copy(self.wanted, displacements)


def _copy(source: Fields, target: Fields) -> None:
    """Copy fields, in one call where they lie in one array, as each call takes a microsecond."""
    if isinstance(source, np.ndarray) and isinstance(target, np.ndarray):
        target[...] = source
        return
    for one, other in zip(source, target, strict=True):
        other[...] = one
