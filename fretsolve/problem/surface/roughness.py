"""A rough surface of a self-affine spectrum: the sum of its waves, which fit into the period `span`.

The power spectral density C(q) is C0 for wave numbers q from 2 pi/span to q_r = 2 pi/rolloff, C0 (q/q_r)^(-2-2H) up to
2 pi/cutoff, and 0 elsewhere. The exponent of a line contact, whose heights depend on x alone, is -1-2H. C0 gives the
sum of the waves the root mean square height or slope of the case. Integrals of the spectrum, (1/2 pi) int C q dq and
(1/2 pi) int C q^3 dq, are near these sums where several waves as long as the rolloff fit into the span.

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


@lru_cache(maxsize=1)
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
    waves = Waves(step * numbers, step * across, np.sqrt(density) * np.exp(2j * np.pi * phases))
    height, slope = waves.rms()
    waves.amplitudes[:] *= surface.rms_height / height if surface.rms_height else (surface.rms_slope or 0.0) / slope
    waves.amplitudes.flags.writeable = False
    return waves


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
