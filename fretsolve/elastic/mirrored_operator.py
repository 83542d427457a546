"""The elastic operator on one half of fields that are mirror images of themselves about y = 0.

Of each field the half y > 0 is given and computed; the other half acts, too. A field that is even in y, as p, qx, ux
and uz are, has a cosine series along y, and an odd one, as qy and uy are, a sine series. So half of the cells have half
of the wave numbers, and a convolution takes half of the work:

1. Each field is transformed along y into the coefficients of its series (`fretsolve.elastic.cosine_series`).
2. Coefficients are padded and transformed along x, two at a time, as the real and the imaginary part of one line: of
   qx and qy with one number, or two of p. Lines are multiplied with the kernels and transformed back. Blocks of lines
   fit into a core's cache.
3. The coefficients are transformed back.

The kernels have the spectra of the whole grid (`fretsolve.elastic.convolution`). Between even and odd fields the
spectra change by the factors 1 and -i of the cosine and the sine series.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fretsolve.elastic.convolution import Spectra
from fretsolve.elastic.cosine_series import MOST_PRODUCTS, TANGENTIAL, FastTransform, MatrixTransform
from fretsolve.elastic.fftw import CacheBlock, even_parts, fast_length, padded_length
from fretsolve.elastic.influence import Influence, KernelSpectrum, spectrum_of
from fretsolve.elastic.operator import ElasticOperator, Preconditioner
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import Fields, FloatArray

Pairs = list[tuple[FloatArray, FloatArray]]
"""Coefficients, (n, nx), of the real and of the imaginary part of lines; the latter may have fewer."""

Name = tuple[str, KernelSpectrum]
"""Of a convolution: what it computes, and one of its kernels, which identifies the material."""


class Lines(NamedTuple):
    """Lines along x, and how they are multiplied.

    multiply: takes the `kernels` and the spectra of as many lines, which it changes in place.
    """

    multiply: Callable[..., None]
    kernels: tuple[FloatArray, ...]
    sources: Pairs
    targets: Pairs


class Task(NamedTuple):
    """A convolution: from which fields to which, odd ones or even ones, and the lines of their coefficients.

    lines_of: takes the coefficients, as many as there are fields or results at most.
    """

    name: Name
    odd_fields: tuple[bool, ...]
    odd_results: tuple[bool, ...]
    lines_of: Callable[[Fields], Lines]


class MirroredConvolution:
    """Convolutions of fields (nx, ny), the half y > 0 of fields that are even or odd about y = 0.

    periodic: the whole field is its own period, else it is padded so that nothing wraps around. Blocks and plans are
    made when they are first needed.
    """

    def __init__(self, shape: tuple[int, int], dtype: type[np.floating], team: ThreadTeam, periodic: bool = False):
        nx, ny = self._half = shape
        self.shape = nx, 2 * ny  # of the whole field, whose offsets the kernels have
        self.team, self._kernels, self._spectral = team, team.kernels.cosine_coefficients, team.kernels.spectral
        self._float, self._complex = np.dtype(dtype), np.result_type(dtype, np.complex64)
        least = ny if periodic else 2 * ny
        self._by_matrices = least * ny * nx <= MOST_PRODUCTS
        self._count = least if self._by_matrices else fast_length(least)
        self.padded = fast_length(nx) if periodic else padded_length(nx), 2 * self._count
        self._kept: dict[Name, tuple[Fields, Callable[[], None]]] = {}
        self._blocks: dict[tuple[int, int], list[CacheBlock]] = {}

    def kernel_spectrum(self, quadrant: FloatArray, odd_x: bool, odd_y: bool) -> KernelSpectrum:
        """Return the spectrum of an influence function from its values at offsets 0..nx-1, 0..2ny-1."""
        return spectrum_of(quadrant, self.padded, self._float, odd_x, odd_y, self.team)

    def normal(self, spectra: Spectra, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute uz from pressure, or the reverse, (nx, ny) or (1, nx, ny)."""
        self._scalar(spectra["zz"], False, plane(pressure), plane(uz))

    def _scalar(self, kernel: KernelSpectrum, odd: bool, field: FloatArray, result: FloatArray) -> None:
        """Compute `result` from one `field`, both (nx, ny); odd: both are odd in y, as qy and uy are."""

        def lines(coefficients: Fields) -> Lines:
            pairs, values = (self._count + 1) // 2, self._values(kernel, odd)
            both = [(coefficients[0][:pairs], coefficients[0][pairs:])]
            return Lines(self._kernels.multiply_even, (values[:pairs], values[pairs:]), both, both)

        self._apply(Task(("scalar", kernel), (odd,), (odd,), lines), (field,), (result,))

    def tangential(self, spectra: Spectra, coupling: bool, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute a tangential result (2, nx, ny) from a tangential field (2, nx, ny).

        Without `coupling` each direction is computed alone. Where it is 0, neither transform nor spectrum is needed.
        """
        if not coupling:
            directions: tuple[Influence, Influence] = "xx", "yy"
            for name, odd, field, result in zip(directions, TANGENTIAL, shear, displacement, strict=True):
                if field.any():
                    self._scalar(spectra[name], odd, field, result)
                else:
                    result[:] = 0.0
            return

        def lines(coefficients: Fields) -> Lines:
            kernels = self._values(spectra["xx"]), self._values(spectra["yy"], True), self._values(spectra["xy"])
            both = [(coefficients[0], coefficients[1])]
            return Lines(self._kernels.multiply_in_plane, kernels, both, both)

        self._apply(Task(("in plane", spectra["xx"]), TANGENTIAL, TANGENTIAL, lines), shear, displacement)

    def tangential_from_pressure(self, spectra: Spectra, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement (2, nx, ny) from pressure (nx, ny)."""

        def lines(coefficients: Fields) -> Lines:
            x, y = coefficients
            kernels = self._values(spectra["xz"]), self._values(spectra["yz"])
            return Lines(self._kernels.tangential_from_pressure, kernels, [(x, x[:0])], [(x, y)])

        task = Task(("tangential from pressure", spectra["xz"]), (False,), TANGENTIAL, lines)
        self._apply(task, (plane(pressure),), displacement)

    def normal_from_shear(self, spectra: Spectra, shear: FloatArray, uz: FloatArray) -> None:
        """Compute uz (nx, ny) from shear (2, nx, ny)."""

        def lines(coefficients: Fields) -> Lines:
            x, y = coefficients
            kernels = self._values(spectra["xz"]), self._values(spectra["yz"])
            return Lines(self._kernels.normal_from_shear, kernels, [(x, y)], [(x, x[:0])])

        self._apply(Task(("normal from shear", spectra["xz"]), TANGENTIAL, (False,), lines), shear, (plane(uz),))

    def coupled(
        self, spectra: Spectra, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray
    ) -> None:
        """Compute normal and tangential displacement from pressure and shear."""

        def lines(coefficients: Fields) -> Lines:
            z, x, y = coefficients
            names: tuple[Influence, ...] = "zz", "xx", "yy", "xy", "xz", "yz"
            kernels = tuple(self._values(spectra[name], name == "yy") for name in names)
            both = [(z, z[:0]), (x, y)]
            return Lines(self._kernels.multiply_coupled, kernels, both, both)

        task = Task(("coupled", spectra["zz"]), (False, *TANGENTIAL), (False, *TANGENTIAL), lines)
        self._apply(task, (plane(pressure), *shear), (plane(uz), *displacement))

    def _apply(self, task: Task, fields: Fields, results: Fields) -> None:
        coefficients, along_x = self._kept.get(task.name) or self._coefficients_and_steps(task)
        self._transform.forward(fields, task.odd_fields, coefficients)
        along_x()
        self._transform.backward(coefficients, task.odd_results, results)

    def _coefficients_and_steps(self, task: Task) -> tuple[Fields, Callable[[], None]]:
        """Return arrays for the coefficients of a task, and what convolves their lines along x.

        On small grids both are kept, as making them would take 10 us of each convolution.
        """
        count, size = max(len(task.odd_fields), len(task.odd_results)), (self._count, self._half[0])
        bytes_per_line = self.padded[0] * self._complex.itemsize
        if len(even_parts(self._count, bytes_per_line)) == 1:
            coefficients: Fields = np.zeros((count, *size), self._float)
            lines = task.lines_of(coefficients)
            rows = slice(0, len(lines.sources[0][0]))
            self._kept[task.name] = coefficients, self._steps(lines, rows, self._blocks_of(0, rows.stop, lines))
            return self._kept[task.name]
        coefficients = self.team.arrays(count, size, self._float)
        lines = task.lines_of(coefficients)
        parts = even_parts(len(lines.sources[0][0]), bytes_per_line)
        blocks = [self._blocks_of(member, parts[0].stop, lines) for member in self.team.members(parts)]
        return coefficients, lambda: self.team.share(
            lambda member, part: self._steps(lines, part, blocks[member])(), parts
        )

    def _steps(self, lines: Lines, part: slice, blocks: list[CacheBlock]) -> Callable[[], None]:
        join, split, multiply = self._spectral.join_rows, self._spectral.split_rows, lines.multiply
        count = part.stop - part.start
        joined = [
            (real[part], imaginary[part], block.source[:count], block.forward)
            for (real, imaginary), block in zip(lines.sources, blocks, strict=True)
        ]
        parted = [
            (block.backward, block.source[:count], real[part], imaginary[part])
            for (real, imaginary), block in zip(lines.targets, blocks, strict=True)
        ]
        spectra = [kernel[part] for kernel in lines.kernels] + [block.target[:count] for block in blocks]

        def convolve() -> None:
            for real, imaginary, source, forward in joined:
                join(real, imaginary, source)
                forward()
            multiply(*spectra)
            for backward, source, real, imaginary in parted:
                backward()
                split(source, real, imaginary)

        return convolve

    def _blocks_of(self, member: int, rows: int, lines: Lines) -> list[CacheBlock]:
        own, most = self._blocks.setdefault((member, rows), []), len(lines.sources)
        own.extend(CacheBlock((rows, self.padded[0]), self._complex) for _ in range(most - len(own)))
        return own[:most]

    @cached_property
    def _transform(self) -> MatrixTransform | FastTransform:
        if self._by_matrices:
            return MatrixTransform(self._half[1], self._count, self._float)
        return FastTransform(self._half, self._count, self._float, self.team)

    def _values(self, kernel: KernelSpectrum, odd: bool = False) -> FloatArray:
        """Return the kernel of each coefficient, (n, mx//2 + 1); odd: it is from odd fields to odd ones alone.

        Coefficient 0 of odd fields has the highest wave number. Its kernel takes the place of the kernel of the wave
        number 0, which odd fields do not have.
        """
        if odd:
            kernel.values[0] = kernel.values[-1]
        return kernel.values[: self._count]


def plane(field: FloatArray) -> FloatArray:
    """Return a field (nx, ny) or (1, nx, ny) as (nx, ny)."""
    return field if field.ndim == 2 else field[0]


class MirroredPreconditioner(Preconditioner):
    """Computes tractions from displacements, roughly, on the half y > 0 of a grid; ``shape``: of this half."""

    _convolution_type = MirroredConvolution


class MirroredOperator(ElasticOperator):
    """Applies the influence coefficients on the half y > 0 of a grid; ``shape``: of this half."""

    _convolution_type = MirroredConvolution
    _preconditioner = MirroredPreconditioner
