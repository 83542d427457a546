"""Spectra of the influence coefficients on a padded grid, each computed when a solve first needs it."""

from __future__ import annotations

import math
from typing import Literal, Protocol

import numpy as np

from fretsolve.elastic import influence
from fretsolve.elastic.convolution import KernelSpectrum, PaddedConvolution
from fretsolve.model.materials import Compliances
from fretsolve.system.arrays import DoubleArray

Influence = Literal["zz", "xx", "yy", "xy", "xz", "yz"]
"""A displacement and the traction it comes from: `zz` is uz from p, `xy` ux from qy and uy from qx, `xz` ux from p."""


class Spectra(Protocol):
    """Gives the spectrum of an influence."""

    def __getitem__(self, name: Influence) -> KernelSpectrum: ...


class InfluenceSpectra:
    """Spectra for cells of `spacing` (mm) on the padded grid of `convolution`; mm per MPa."""

    def __init__(self, convolution: PaddedConvolution, spacing: tuple[float, float], compliances: Compliances):
        self._convolution, self._spacing, self._compliances = convolution, spacing, compliances
        self._known: dict[Influence, KernelSpectrum] = {}

    def __getitem__(self, name: Influence) -> KernelSpectrum:
        if name not in self._known:
            self._known[name] = self._turned("xx") if name == "yy" and self._square else self._computed(name)
        return self._known[name]

    @property
    def _square(self) -> bool:
        """Whether x and y can change places."""
        return self._spacing[0] == self._spacing[1] and self._convolution.shape[0] == self._convolution.shape[1]

    def _turned(self, name: Influence) -> KernelSpectrum:
        """The spectrum of an even influence with x and y changed, on a square grid."""
        return KernelSpectrum(np.ascontiguousarray(self[name].values.T), odd_x=False)

    def _computed(self, name: Influence) -> KernelSpectrum:
        odd_x, odd_y = name in ("xy", "xz"), name in ("xy", "yz")
        return self._convolution.kernel_spectrum(self._coefficients(name), odd_x, odd_y)

    def _coefficients(self, name: Influence) -> DoubleArray:
        """Influence coefficients at the offsets 0..nx-1, 0..ny-1 in cells."""
        material = self._compliances
        match name:
            case "zz":
                return self._quadrant(influence.inverse_distance, material.A / (2 * math.pi))
            case "xx":
                return self._direct(influence.along_x)
            case "yy":
                return self._direct(influence.along_y)
            case "xy":
                return self._quadrant(influence.across, material.B / (2 * math.pi))
            case "xz":
                return self._quadrant(influence.radial_x, material.C / (4 * math.pi))
            case "yz":
                return self._quadrant(influence.radial_y, material.C / (4 * math.pi))

    def _direct(self, along: influence.KernelFunction) -> DoubleArray:
        """ux from qx or uy from qy."""
        coefficients = self._quadrant(influence.inverse_distance, self._compliances.A / (2 * math.pi))
        if self._compliances.B:
            coefficients += self._quadrant(along, self._compliances.B / (2 * math.pi))
        return coefficients

    def _quadrant(self, function: influence.KernelFunction, factor: float) -> DoubleArray:
        (nx, ny), (dx, dy) = self._convolution.shape, self._spacing
        x, y = np.arange(nx, dtype=np.float64) * dx, np.arange(ny, dtype=np.float64) * dy
        values = function(x, y, dx, dy)
        values *= factor
        return values


class ScaledSpectra:
    """The spectra of `source` times a factor, in the precision `dtype`."""

    def __init__(self, source: Spectra, factor: float, dtype: type[np.floating]):
        self._source, self._factor, self._dtype = source, factor, dtype
        self._known: dict[Influence, KernelSpectrum] = {}

    def __getitem__(self, name: Influence) -> KernelSpectrum:
        if name not in self._known:
            self._known[name] = self._source[name].scaled(self._factor, self._dtype)
        return self._known[name]
