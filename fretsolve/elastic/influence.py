"""Influence coefficients, surface displacements at a cell's centre from unit traction on another cell; their spectra.

Sources: Love (1929); Johnson, Contact Mechanics (1985), section 3. The point solutions of Boussinesq and Cerruti are
integrated over a rectangular cell. Both bodies are summed; the displacement is u2 - u1, in the direction of the
traction on body 2. With A, B, C, E* of `fretsolve.problem.model.materials` they are (T5 of docs/theory.md):

    uz from p   1/(pi E*) int 1/r
    ux from qx  1/(2 pi)  int (A/r + B x^2/r^3)        uy from qy with y^2
    ux from qy  B/(2 pi)  int x y/r^3                  = uy from qx
    ux from p   C/(4 pi)  int x/r^2                    uz from qx = -(ux from p); y alike

A layer between the bodies moves by the traction at its place alone, which adds to a cell's own coefficient.

Every integral is even or odd in x and in y, so only the quadrant of offsets x, y >= 0 is computed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any, Literal, Protocol

import numpy as np

from fretsolve.elastic.fftw import plan
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.problem.model.materials import Compliances
from fretsolve.system.arrays import DoubleArray, FloatArray

Influence = Literal["zz", "xx", "yy", "xy", "xz", "yz"]
"""A displacement and the traction that causes it: `zz` is uz from p, `xy` ux from qy and uy from qx, `xz` ux from p."""

LEAST_SHARED = 2**17
"""Numbers from which on a transform is shared among threads in four parts. Two threads gain 1 % of an
increment on 1024 x 1024 points by it; each part takes a plan of its own, some 0.1 ms."""

Function = Callable[[DoubleArray, DoubleArray], DoubleArray]
Integral = Callable[[DoubleArray, DoubleArray, float, float], DoubleArray]

QUADRATURE = ((30.0, 0), (300.0, 3), (np.inf, 2))
"""(distance r in cell sides h up to which it is used, Gauss points per side; 0 stands for corner differences).

Corner differences lose (r/h)^2 of their digits. The relative error of n Gauss points is about 3.6e-4 (h/r)^6 for n = 3
and 5.6e-3 (h/r)^4 for n = 2. On square cells all errors stay below 3e-12, on slender ones below 4e-12 times long over
short side; over the value of the cell itself they stay below 1e-12. Four points from 12 h on would be ten times as
exact, and take twice to four times as long on 16 to 64 points per side.
"""


def influence_coefficients(
    name: Influence,
    shape: tuple[int, int],
    spacing: tuple[float, float],
    compliances: Compliances,
    team: ThreadTeam | None = None,
) -> DoubleArray:
    """Return an influence (mm/MPa) at the offsets 0..nx-1, 0..ny-1 in cells of `spacing` (mm), ``(nx, ny)``.

    team: shares the parts of a large grid, which one thread computes a third faster, too, as they fit into its cache.
    """
    x, y = (np.arange(count, dtype=np.float64) * side for count, side in zip(shape, spacing, strict=True))
    a, b, c = compliances.A / (2 * math.pi), compliances.B / (2 * math.pi), compliances.C / (4 * math.pi)
    terms: dict[Influence, tuple[tuple[float, Integral], ...]] = {
        "zz": ((a, inverse_distance),),
        "xx": ((a, inverse_distance), (b, along_x)),
        "yy": ((a, inverse_distance), (b, along_y)),
        "xy": ((b, across),),
        "xz": ((c, radial_x),),
        "yz": ((c, radial_y),),
    }
    total = np.zeros(shape)

    def add(rows: slice) -> None:
        for factor, integral in terms[name]:
            if factor:
                total[rows] += factor * integral(x[rows], y, *spacing)

    (team or ThreadTeam()).of_rows(shape, add)
    total[0, 0] += compliances.of_layer(name)
    return total


def inverse_distance(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Return the integral of 1/r over cells ``dx`` by ``dy`` at offsets ``x`` (nx,), ``y`` (ny,) >= 0: (nx, ny)."""
    return _integrate(_inverse_distance_corner, lambda u, v: 1.0 / np.sqrt(u * u + v * v), x, y, dx, dy)


def along_x(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Return the integral of x^2/r^3 over the cell; arguments as for `inverse_distance`."""
    return _integrate(lambda u, v: v * _log_sum(u, v, np.hypot(u, v)), lambda u, v: u * u / _cubed(u, v), x, y, dx, dy)


def along_y(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Return the integral of y^2/r^3 over the cell; arguments as for `inverse_distance`."""
    return np.ascontiguousarray(along_x(y, x, dy, dx).T)


def across(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Return the integral of x y/r^3 over the cell, odd in x and y; arguments as for `inverse_distance`."""
    return _integrate(lambda u, v: -np.hypot(u, v), lambda u, v: u * v / _cubed(u, v), x, y, dx, dy)


def radial_x(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Return the integral of x/r^2 over the cell, odd in x; arguments as for `inverse_distance`."""
    return _integrate(
        lambda u, v: v * np.log(np.hypot(u, v)) + u * np.arctan(v / u), lambda u, v: u / (u * u + v * v), x, y, dx, dy
    )


def radial_y(x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Return the integral of y/r^2 over the cell, odd in y; arguments as for `inverse_distance`."""
    return np.ascontiguousarray(radial_x(y, x, dy, dx).T)


def _integrate(
    corner: Function, integrand: Function, x: DoubleArray, y: DoubleArray, dx: float, dy: float
) -> DoubleArray:
    """Integrate over each cell: by corner differences of the antiderivative nearby, by Gauss quadrature far away."""
    side = max(dx, dy)
    result = np.empty((x.size, y.size))
    inner = (0, 0)
    for reach, points in QUADRATURE:
        outer = (int(np.searchsorted(x, reach * side)), int(np.searchsorted(y, reach * side)))
        # The ring between two boxes of the quadrant, as two rectangles.
        for rows, columns in (
            (slice(inner[0], outer[0]), slice(0, outer[1])),
            (slice(0, inner[0]), slice(inner[1], outer[1])),
        ):
            if not result[rows, columns].size:
                continue
            if points:
                result[rows, columns] = _gauss(integrand, x[rows], y[columns], dx, dy, points)
            else:
                result[rows, columns] = _corner_differences(corner, x[rows], y[columns], dx, dy)
        inner = outer
    return result


def _corner_differences(corner: Function, x: DoubleArray, y: DoubleArray, dx: float, dy: float) -> DoubleArray:
    """Sum the antiderivative at the corners of each cell with alternating signs. Digits cancel far away."""
    corners_x = np.append(x - dx / 2, x[-1] + dx / 2)[:, None]
    corners_y = np.append(y - dy / 2, y[-1] + dy / 2)[None, :]
    antiderivative = corner(corners_x, corners_y)
    return np.diff(np.diff(antiderivative, axis=0), axis=1)


def _gauss(integrand: Function, x: DoubleArray, y: DoubleArray, dx: float, dy: float, points: int) -> DoubleArray:
    """Integrate over each cell by Gauss-Legendre quadrature with `points` nodes per side."""
    total = np.zeros((x.size, y.size))
    for (node_x, weight_x), (node_y, weight_y) in product(_nodes(points), repeat=2):
        weight = 0.25 * weight_x * weight_y * dx * dy
        total += weight * integrand(x[:, None] + 0.5 * dx * node_x, y[None, :] + 0.5 * dy * node_y)
    return total


@cache
def _nodes(points: int) -> list[tuple[float, float]]:
    """Return the nodes of a Gauss-Legendre quadrature in -1..1 with their weights."""
    return list(zip(*np.polynomial.legendre.leggauss(points), strict=True))


def _cubed(u: DoubleArray, v: DoubleArray) -> DoubleArray:
    squared = u * u + v * v
    return squared * np.sqrt(squared)


def _log_sum(v: DoubleArray, u: DoubleArray, r: DoubleArray) -> DoubleArray:
    """Return ln(v + r), r = hypot(u, v), without cancellation where v < 0."""
    positive = r + np.abs(v)
    return np.where(v >= 0.0, np.log(positive), 2.0 * np.log(np.abs(u)) - np.log(positive))


def _inverse_distance_corner(u: DoubleArray, v: DoubleArray) -> DoubleArray:
    r = np.hypot(u, v)
    return u * _log_sum(v, u, r) + v * _log_sum(u, v, r)


@dataclass(frozen=True, eq=False)
class KernelSpectrum:
    """Spectrum of an influence function on the padded grid, scaled for unnormalised inverse transforms.

    values: ``(my//2 + 1, mx//2 + 1)``, real, x along the lines; odd_x: the function is odd in x.
    """

    values: FloatArray
    odd_x: bool

    def whole(self, length: int) -> FloatArray:
        """Return the values for all wave numbers in x, (mx, my//2 + 1); length: mx."""
        half = self.values.T
        mirrored = half[length - len(half) : 0 : -1]
        return np.concatenate([half, -mirrored if self.odd_x else mirrored])

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
        size = -(-len(inner) // (4 if inner.size >= LEAST_SHARED else 1))
        parts = (inner[first : first + size] for first in range(0, len(inner), size))
        # planned here, because FFTW makes one plan at a time
        plans = [plan(part, part, axes=(1,), direction=direction, flags=("FFTW_ESTIMATE",)) for part in parts]
        team.share(lambda member, one: one.execute(), plans)
    if odd:
        lines[:, 0] = 0.0
        lines[:, -1] = 0.0


SWAPPED: dict[Influence, Influence] = {"yy": "xx", "yz": "xz"}
"""Influences that are others with x and y in each other's place."""


class OfKernels(Protocol):
    """The part of a convolution that the influence coefficients need: shape and periods of its grid, and spectra."""

    shape: tuple[int, int]
    padded: tuple[int, int]
    team: ThreadTeam

    def kernel_spectrum(self, quadrant: DoubleArray, odd_x: bool, odd_y: bool) -> KernelSpectrum:
        """Return the spectrum of an influence function from its values at offsets >= 0, of the shape of the grid."""


class InfluenceSpectra(dict[Influence, KernelSpectrum]):
    """Spectra of the influence coefficients (mm/MPa) on the padded grid of `convolution`.

    Each is computed when it is first asked for. spacing: sides of a cell (mm); whole: the spectra of a grid that this
    grid is a part of. The whole grid's coefficients hold the part's, so they are kept: mode I.3 on 48 x 48 points, with
    five active regions, takes 3 % less time.
    """

    def __init__(
        self,
        convolution: OfKernels,
        spacing: tuple[float, float],
        compliances: Compliances,
        whole: InfluenceSpectra | None = None,
    ):
        super().__init__()
        self._convolution, self._spacing, self._compliances = convolution, spacing, compliances
        self._whole = whole
        self._kept: dict[Influence, DoubleArray] = {}

    def __missing__(self, name: Influence) -> KernelSpectrum:
        shape, spacing, (mx, my) = self._convolution.shape, self._spacing, self._convolution.padded
        if name in SWAPPED and shape[0] == shape[1] and spacing[0] == spacing[1] and mx == my:
            # On a square grid x and y may change places.
            self[name] = KernelSpectrum(np.ascontiguousarray(self[SWAPPED[name]].values.T), odd_x=False)
        else:
            values = self._computed(name) if self._whole is None else self._whole.kept(name)[: shape[0], : shape[1]]
            self[name] = self._convolution.kernel_spectrum(values, name in ("xy", "xz"), name in ("xy", "yz"))
        return self[name]

    def kept(self, name: Influence) -> DoubleArray:
        """Return coefficients as `influence_coefficients`, and keep them for the next part of the grid."""
        if name not in self._kept:
            self._kept[name] = self._computed(name)
        return self._kept[name]

    def _computed(self, name: Influence) -> DoubleArray:
        """Return coefficients on this grid as `influence_coefficients`, computed unless they are kept."""
        if name in self._kept:
            return self._kept[name]
        team = self._convolution.team
        return influence_coefficients(name, self._convolution.shape, self._spacing, self._compliances, team)


class ScaledSpectra(dict[Influence, KernelSpectrum]):
    """The spectra of `source` times `factor`, in the precision `dtype`, each computed when it is first asked for."""

    def __init__(self, source: dict[Influence, KernelSpectrum], factor: float, dtype: type[np.floating]):
        super().__init__()
        self._source, self._factor, self._dtype = source, factor, dtype

    def __missing__(self, name: Influence) -> KernelSpectrum:
        self[name] = self._source[name].scaled(self._factor, self._dtype)
        return self[name]
