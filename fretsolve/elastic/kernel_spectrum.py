"""Spectra of influence functions, which a convolution multiplies with those of tractions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fretsolve.elastic.fftw import plan
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import FloatArray

Influence = Literal["zz", "xx", "yy", "xy", "xz", "yz"]
"""A displacement and the traction that causes it: `zz` is uz from p, `xy` ux from qy and uy from qx, `xz` ux from p."""

PARTS, LEAST_SHARED = 4, 2**17
"""Parts of a large transform that threads share, and the numbers from which it is large. Two threads gain 1 % of an
increment on 1024 x 1024 points by it; each part takes a plan of its own, some 0.1 ms."""


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


def spectrum_of(
    quadrant: FloatArray, padded: tuple[int, int], dtype: np.dtype[Any], odd_x: bool, odd_y: bool, team: ThreadTeam
) -> KernelSpectrum:
    """Return the spectrum of an influence function on the grid `padded`, in the precision `dtype`.

    quadrant: its values at offsets 0..nx-1, 0..ny-1, (nx, ny); team: shares a large grid.
    """
    mx, my = padded
    values = np.zeros((my // 2 + 1, mx // 2 + 1))
    values[: quadrant.shape[1], : quadrant.shape[0]] = quadrant.T
    values /= mx * my
    for axis, odd in enumerate((odd_y, odd_x)):
        _transform_half(values, odd, axis, team)
    if odd_x or odd_y:
        np.negative(values, out=values)  # -i of one sine transform, (-i)^2 of two
    return KernelSpectrum(values.astype(dtype, copy=False), odd_x)


def _transform_half(values: FloatArray, odd: bool, axis: int, team: ThreadTeam) -> None:
    """Transform along `axis`, in place, the even or odd function given at offsets 0..m/2 of its period m.

    The spectrum of an odd function is its sine transform, without the factor -i.
    """
    lines = values.T if axis == 0 else values
    inner, direction = (lines[:, 1:-1], "FFTW_RODFT00") if odd else (lines, "FFTW_REDFT00")
    if inner.shape[1] > 1 or (odd and inner.size):
        size = -(-len(inner) // (PARTS if inner.size >= LEAST_SHARED else 1))
        parts = (inner[first : first + size] for first in range(0, len(inner), size))
        # planned here, because FFTW makes one plan at a time
        plans = [plan(part, part, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE",)) for part in parts]
        team.share(lambda member, one: one.execute(), plans)
    if odd:
        lines[:, 0] = 0.0
        lines[:, -1] = 0.0
