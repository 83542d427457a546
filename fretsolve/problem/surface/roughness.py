"""A rough surface of a self-affine spectrum: the sum of its waves, which fit into the period `span`.

The power spectral density C(q) is C0 for wave numbers q from 2 pi/span to q_r = 2 pi/rolloff, C0 (q/q_r)^(-2-2H) up to
2 pi/cutoff, and 0 elsewhere. The exponent of a line contact, whose heights depend on x alone, is -1-2H. C0 gives the
root mean square height h or slope g of the case by the integrals

    h^2 = (1/2 pi) int C q dq,  g^2 = (1/2 pi) int C q^3 dq;  on a line (1/pi) int C dq, (1/pi) int C q^2 dq.

The waves of the period are a sum in place of the integral. The heights differ where few waves are as long as the
rolloff: by 0.8 % where five of them fit into the span, by 32 % where one does (H = 0.8, a cutoff of a tenth).

Each wave has the amplitude sqrt(C)/span (on a line sqrt(C/span)), and a random phase. Phases are drawn from long to
short waves, so that a shorter cutoff adds waves and keeps the others. Heights are evaluated from the waves at each
point, so that all grids see the same surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fretsolve.case.keys.body_specs import RoughnessSurface
from fretsolve.system.arrays import ComplexArray, DoubleArray

ROUNDING = 1e-9
"""Slack of a ratio of lengths that is to be a whole number of waves."""


@dataclass(frozen=True)
class Waves:
    """Half of the waves of a surface, whose mirror images q -> -q have the conjugate amplitudes.

    qx (mx,), qy (my,): wave numbers in rad/mm; amplitudes: (mx, my) in mm, complex.
    """

    qx: DoubleArray
    qy: DoubleArray
    amplitudes: ComplexArray

    def heights(self, x: DoubleArray, y: DoubleArray) -> DoubleArray:
        """Return the heights (nx, ny) in mm at `x` (nx,), `y` (ny,) in mm."""
        along_x, along_y = np.exp(1j * np.outer(x, self.qx)), np.exp(1j * np.outer(self.qy, y))
        summed: DoubleArray = np.linalg.multi_dot([along_x, self.amplitudes, along_y]).real
        summed *= 2.0
        return summed

    def rms(self) -> tuple[float, float]:
        """Return the root mean square height (mm) and slope over the period."""
        power = np.abs(self.amplitudes) ** 2
        along_x, along_y = self.qx**2 @ power.sum(axis=1), power.sum(axis=0) @ self.qy**2
        return math.sqrt(2.0 * power.sum()), math.sqrt(2.0 * (along_x + along_y))


def rms_of_spectrum(surface: RoughnessSurface) -> tuple[float, float]:
    """Return the root mean square height (mm) and slope by the integrals of the spectrum."""
    height, slope = _unscaled(surface)
    scale = _scale(surface)
    return scale * height, scale * slope


def spectrum_constant(surface: RoughnessSurface) -> float:
    """Return C0 in mm^4, in mm^3 for a line contact."""
    return _scale(surface) ** 2


@lru_cache(maxsize=4)
def waves_of(surface: RoughnessSurface) -> Waves:
    """Return the waves of a surface. A run needs them several times."""
    shortest = math.floor(surface.period / surface.cutoff * (1.0 + ROUNDING))  # its number on the period
    step, random = 2.0 * math.pi / surface.period, np.random.default_rng(surface.seed)
    if surface.of_line:
        numbers, across = np.arange(1.0, shortest + 1), np.zeros(1)
        phases = random.random((shortest, 1))
    else:
        numbers, across = np.arange(-shortest, shortest + 1.0), np.arange(shortest + 1.0)
        phases = _phases_by_rings(shortest, random)
    number = np.hypot(numbers[:, None], across)
    density = np.zeros(number.shape)
    there = (number > 0.0) & (number <= surface.period / surface.cutoff * (1.0 + ROUNDING))
    density[there] = _density(surface, number[there])
    if not surface.of_line:
        density[: shortest + 1, 0] = 0.0  # mirror images of waves with qx > 0
    amplitude = np.sqrt(density) * (_scale(surface) / surface.period ** (0.5 * surface.directions))
    amplitudes = amplitude * np.exp(2j * np.pi * phases)
    amplitudes.flags.writeable = False
    return Waves(step * numbers, step * across, amplitudes)


def _phases_by_rings(largest: int, random: np.random.Generator) -> DoubleArray:
    """Return a phase over 2 pi for each wave of the half plane, drawn in square rings from the longest waves on."""
    phases = np.zeros((2 * largest + 1, largest + 1))
    for ring in range(1, largest + 1):
        first, last = largest - ring, largest + ring
        top, left, right = np.split(random.random(4 * ring), [2 * ring + 1, 3 * ring])
        phases[first : last + 1, ring] = top
        phases[first, 1:ring] = left
        phases[last, :ring] = right
    return phases


def _density(surface: RoughnessSurface, number: DoubleArray) -> DoubleArray:
    """Return C/C0 of waves of which `number` fit into the period."""
    density: DoubleArray = np.maximum(number * (surface.longest / surface.period), 1.0) ** surface.exponent
    return density


def _scale(surface: RoughnessSurface) -> float:
    """Return the root of C0, from the height or the slope that the case gives."""
    height, slope = _unscaled(surface)
    return surface.rms_height / height if surface.rms_height is not None else (surface.rms_slope or 0.0) / slope


def _unscaled(surface: RoughnessSurface) -> tuple[float, float]:
    """Return the root mean square height and slope by the integrals for C0 = 1."""
    first, rolloff, last = (2.0 * math.pi / wave for wave in (surface.period, surface.longest, surface.cutoff))
    power, factor = surface.directions, 1.0 / math.pi / surface.directions

    def integral(power: int) -> float:
        """Return the integral of C q^(power - 1) dq."""
        falling = power + surface.exponent  # not 0, since the Hurst exponent is between 0 and 1
        level = (rolloff**power - first**power) / power
        return level + rolloff**power * (math.pow(last / rolloff, falling) - 1.0) / falling

    return math.sqrt(factor * integral(power)), math.sqrt(factor * integral(power + 2))
