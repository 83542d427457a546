"""Spectra of influence functions, which a convolution multiplies with those of tractions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fretsolve.system.arrays import FloatArray

Influence = Literal["zz", "xx", "yy", "xy", "xz", "yz"]
"""A displacement and the traction that causes it: `zz` is uz from p, `xy` ux from qy and uy from qx, `xz` ux from p."""


@dataclass(frozen=True, eq=False)
class KernelSpectrum:
    """Spectrum of an influence function on the padded grid, scaled for unnormalised inverse transforms.

    values: ``(my//2 + 1, mx//2 + 1)``, real, x along the lines; odd_x: the function is odd in x.
    """

    values: FloatArray
    odd_x: bool

    def whole(self, lengths: Sequence[int]) -> FloatArray:
        """Return the values for all wave numbers in x, or in both: (mx, my//2 + 1) or (mx, my); lengths: mx, or both.

        The latter holds for spectra that are even or odd in both directions.
        """
        sign = -1 if self.odd_x else 1
        whole: FloatArray = self.values.T
        for axis, length in enumerate(lengths):
            mirrored = np.flip(whole.take(range(1, length - whole.shape[axis] + 1), axis), axis)
            whole = np.concatenate([whole, sign * mirrored], axis)
        return whole

    def scaled(self, factor: float, dtype: type[np.floating]) -> KernelSpectrum:
        """Return the spectrum times `factor`, in the precision `dtype`."""
        return KernelSpectrum((self.values * factor).astype(dtype), self.odd_x)


KernelMatrix = tuple[tuple[KernelSpectrum, ...], ...]
"""Kernels from each field (column) to each displacement (row)."""
