"""Convolution of a tangential field on a small grid: its components are one complex field.

With z = qx + i qy and Z its spectrum, that of ux + i uy is

    (Kxx + Kyy)/2 Z(k) + ((Kxx - Kyy)/2 + i Kxy) conj(Z(-k)),

since the spectra Kxx, Kyy, Kxy of the kernels are real and even. In single precision FFTW needs half as long for the
complex field as for two real ones on 32 x 32, 48 x 48, 64 x 64 and 96 x 96 padded points, and as long on some others.
A convolution takes 0.7 of the time on 32 x 32 and 48 x 48 cells; with NumPy's kernels it takes longer.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from fretsolve.elastic.fftw import estimated_plan, pyfftw
from fretsolve.elastic.kernel_spectrum import KernelMatrix
from fretsolve.system.arrays import Fields


class InPlaneConvolution:
    """Buffers and plans for fields (2, nx, ny) on the grid `padded`; kernels: a symmetric matrix of two rows.

    spectral: operations on spectra, compiled.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        padded: tuple[int, int],
        dtype: np.dtype[Any],
        kernels: KernelMatrix,
        spectral: ModuleType,
    ):
        nx, complex_type = shape[0], np.result_type(dtype, np.complex64)
        (xx, xy), (_, yy) = ((kernel.whole(padded) for kernel in row) for row in kernels)
        self._mean, self._rest = 0.5 * (xx + yy), (0.5 * (xx - yy) + 1j * xy).astype(complex_type)
        self._spectral = spectral
        self._rows, self._wanted = (pyfftw.zeros_aligned((nx, padded[1]), complex_type) for _ in range(2))
        # along x out of an array whose padding stays zero, and back into another one
        first, self._spectrum, self._product, last = (pyfftw.zeros_aligned(padded, complex_type) for _ in range(4))
        self._forward = (
            estimated_plan(self._rows, first[:nx], 1).execute,
            estimated_plan(first, self._spectrum, 0).execute,
        )
        back = estimated_plan(self._product, last, 0, back=True), estimated_plan(last[:nx], self._wanted, 1, back=True)
        self._backward = back[0].execute, back[1].execute

    def apply(self, fields: Fields, displacements: Fields) -> None:
        """Compute ``displacements = kernels @ fields``, both (2, nx, ny)."""
        self._spectral.join_rows(fields[0], fields[1], self._rows)
        for transform in self._forward:
            transform()
        self._spectral.combine_mirrored(self._mean, self._rest, self._spectrum, self._product)
        for transform in self._backward:
            transform()
        self._spectral.split_rows(self._wanted, displacements[0], displacements[1])
