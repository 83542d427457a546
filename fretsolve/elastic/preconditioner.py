"""Preconditioner of the contact's linear equations: the inverse of the half-space's symbol on a periodic grid.

In an unbounded half-space a traction of wave vector k meets the compliance A/k if it is normal, A/k if it is a shear
along k and (A + B)/k if it is a shear across k (T8 of docs/theory.md). The inverse of this symbol acts over a few cells
only: its kernel falls like 1/r^3. So the contact needs no zero-padding, single precision is enough, and an application
costs a small part of one of the elastic operator. The spectra of the elastic operator would not do: they ripple about
the symbol, down to negative values if dx and dy differ.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fretsolve.elastic.convolution import PaddedConvolution
from fretsolve.elastic.fftw import fast_length
from fretsolve.elastic.kernel_spectrum import Influence, KernelSpectrum
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.model.materials import Compliances
from fretsolve.model.required_terms import Terms
from fretsolve.system.arrays import FloatArray


class Preconditioner:
    """Computes tractions (MPa) from displacements (mm), times `factor`, in the precision `dtype`."""

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        compliances: Compliances,
        terms: Terms,
        factor: float,
        team: ThreadTeam | None = None,
        dtype: type[np.floating] = np.float64,
    ):
        self._convolution = self._convolution_on(shape, dtype, team or ThreadTeam())
        self._in_plane = terms.in_plane_coupling
        size = mx, my = self._convolution.padded
        # FFTW leaves the factor 1/(mx my) out of inverse transforms.
        self._spectra: dict[Influence, KernelSpectrum] = {
            name: KernelSpectrum(values, odd_x=name == "xy").scaled(factor / (mx * my), dtype)
            for name, values in _inverse_symbol(self._convolution.shape, size, spacing, compliances, terms).items()
        }

    def _convolution_on(self, shape: tuple[int, int], dtype: type[np.floating], team: ThreadTeam) -> Any:
        """Return the convolution of this preconditioner's fields.

        No padding: no contact reaches the edges of its grid, so there are zeros between one period and the next. With
        two cells more, 512 x 512 points would take half as long again, as lengths above 512 are worse.
        """
        return PaddedConvolution(shape, dtype, team, (fast_length(shape[0]), fast_length(shape[1])))

    def normal(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (1, nx, ny) from displacement (1, nx, ny)."""
        self._convolution.apply(((self._spectra["zz"],),), displacement, traction)

    def tangential(self, displacement: FloatArray, traction: FloatArray) -> None:
        """Compute ``traction`` (2, nx, ny) from displacement (2, nx, ny)."""
        self._convolution.apply_in_plane(self._spectra, self._in_plane, displacement, traction)


def _inverse_symbol(
    shape: tuple[int, int], size: tuple[int, int], spacing: tuple[float, float], compliances: Compliances, terms: Terms
) -> dict[Influence, FloatArray]:
    """Return the inverse of the symbol, (my//2 + 1, mx//2 + 1), of each component that `terms` keep.

    zz: from uz to p; xx: from ux to qx; yy: from uy to qy; xy: from each of the two to the other.
    """
    kx, ky = (2.0 * math.pi * np.fft.rfftfreq(count, side) for count, side in zip(size, spacing, strict=True))
    kx, ky = kx[None, :], ky[:, None]
    shortest = math.pi / max(count * side for count, side in zip(shape, spacing, strict=True))
    inverse = 1.0 / (compliances.A * _mean_symbol(kx, ky, spacing, shortest))
    if not terms.tangential:
        return {"zz": inverse}
    # the inverse of the symmetric 2 x 2 symbol of shear
    share = compliances.B / compliances.A
    length = np.hypot(kx, ky)
    length[0, 0] = 1.0
    along_x, along_y = kx / length, ky / length
    if not terms.in_plane_coupling:
        return {"zz": inverse, "xx": inverse / (1.0 + share * along_y**2), "yy": inverse / (1.0 + share * along_x**2)}
    in_plane = inverse / (1.0 + share)
    ux_to_qx, uy_to_qy = in_plane * (1.0 + share * along_x**2), in_plane * (1.0 + share * along_y**2)
    in_plane *= share * along_x * along_y
    # The highest wave number of an even period stands for both signs; the odd function is 0 there.
    if size[0] % 2 == 0:
        in_plane[:, -1] = 0.0
    if size[1] % 2 == 0:
        in_plane[-1] = 0.0
    return {"zz": inverse, "xx": ux_to_qx, "yy": uy_to_qy, "xy": in_plane}


def _mean_symbol(kx: FloatArray, ky: FloatArray, spacing: tuple[float, float], shortest: float) -> FloatArray:
    """Return 1/k times the spectrum of a cell, summed over the nearest aliases, at wave numbers (1, n) and (m, 1).

    A wave longer than the grid counts as one of its length, the wave number `shortest`, because 1/k is infinite at 0.
    """
    dx, dy = spacing
    total = np.zeros((ky.size, kx.size))
    for shifted_x in (kx, kx - 2 * math.pi / dx):
        for shifted_y in (ky, ky - 2 * math.pi / dy):
            length = np.hypot(shifted_x, shifted_y)
            np.maximum(length, shortest, out=length)
            total += np.sinc(shifted_x * dx / (2 * math.pi)) * np.sinc(shifted_y * dy / (2 * math.pi)) / length
    return total
