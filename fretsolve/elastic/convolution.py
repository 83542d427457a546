"""Exact discrete convolution on a grid by real FFTs of a zero-padded copy (DC-FFT, Liu et al., Wear 243, 2000).

Each side is padded to at least 2n - 1 points, so that nothing wraps around. Small grids are left to
`BatchedConvolution`. On larger ones the padded two-dimensional spectrum never exists as a whole:

1. Rows of the field are padded and transformed along y into a row spectrum ``(nx, my//2 + 1)``. Rows of zeros are
   skipped. Two rows are transformed at a time, as the real and the imaginary part of one, which takes FFTW half the
   time in single precision.
2. Blocks of columns of the row spectra, small enough to stay in cache, become padded lines. Each block is transformed
   along x, multiplied with the spectra of the kernels and transformed back at once.
3. The wanted rows are transformed back along y.

Kernels are even or odd in x and in y. Their spectra are therefore mirrored, and either real (even-even, odd-odd) or
imaginary (odd in one direction). They are computed by cosine and sine transforms of the quadrant of non-negative
offsets, and stored real, for the non-negative wave numbers alone. The imaginary kernels link the pressure p to a shear.
They become real if the spectra of p and uz are multiplied by i: with P = i p, i uz = Kzz P + Kzx qx and
ux = Kzx P + Kxx qx, which is one symmetric real matrix per wave vector.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretsolve.elastic.batched_convolution import BatchedConvolution
from fretsolve.elastic.cache_block import even_parts
from fretsolve.elastic.fftw import padded_length, plan, pyfftw
from fretsolve.elastic.kernel_spectrum import Influence, KernelMatrix, KernelSpectrum, spectrum_of
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import ComplexArray, Fields, FloatArray

MOST_BATCHED_POINTS, COMPILED = 300 * 300, 0.2
"""Largest padded grid that is transformed as a whole, by `BatchedConvolution`, and factor on it with compiled kernels.
Larger ones gain by blocks: with compiled kernels a third on 192 x 192 and 256 x 256 padded points."""


@dataclass(frozen=True)
class _Block:
    """A buffer for a block of padded lines, with the plans of their transforms in place."""

    values: ComplexArray
    forward: pyfftw.FFTW
    backward: pyfftw.FFTW


class PaddedConvolution:
    """Plans and buffers for convolutions of fields ``(nx, ny)``; both are made at the first convolution.

    padded: the periods, where they are not to be those in which nothing wraps around; team: the threads.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: type[np.floating] = np.float64,
        team: ThreadTeam | None = None,
        padded: tuple[int, int] | None = None,
    ):
        self.shape = shape
        self.padded = padded or (padded_length(shape[0]), padded_length(shape[1]))
        self.columns = self.padded[1] // 2 + 1
        self._float = np.dtype(dtype)
        self._complex = np.dtype(np.complex64 if self._float == np.float32 else np.complex128)
        self.team = team or ThreadTeam()
        self._kernels = self.team.kernels.spectral
        mx, my = self.padded
        most = MOST_BATCHED_POINTS * (COMPILED if self.team.kernels.compiled else 1.0)
        small = mx * my <= most
        batched = shape, self.padded, self._float, self._kernels, self.team.kernels.compiled
        self._batched = BatchedConvolution(*batched) if small else None
        size = self._complex.itemsize
        self._pairs = (shape[0] + 1) // 2
        self._row_parts = even_parts(self._pairs, size * my)
        self._column_parts = even_parts(self.columns, size * mx)
        # Each thread has blocks of its own.
        self._row_blocks: list[_Block] = []
        self._column_blocks: list[list[_Block]] = [[] for _ in self.team.members(self._column_parts)]

    def apply(
        self, kernels: KernelMatrix, fields: Fields, displacements: Fields, turned: tuple[bool, bool] = (False, False)
    ) -> None:
        """Compute ``displacements = kernels @ fields``, m fields (nx, ny) from n fields (nx, ny).

        turned: whether to multiply the spectrum of the first field by i, and that of the first displacement by -i (see
        the top of this file). A displacement may be the array of a field.
        """
        if self._batched is not None:
            self._batched.apply(kernels, fields, displacements, turned)
            return
        count = max(len(fields), len(displacements))
        self._provide_blocks(count)
        spectra = self.team.arrays(count, (self.shape[0], self.columns), self._complex)
        self._transform_rows(fields, spectra)
        self._multiply_columns(kernels, spectra[: len(fields)], spectra[: len(displacements)], turned)
        self._transform_rows(displacements, spectra, back=True)

    def apply_in_plane(
        self, spectra: Mapping[Influence, KernelSpectrum], coupling: bool, field: FloatArray, result: FloatArray
    ) -> None:
        """Compute a tangential result (2, nx, ny) from a tangential field (2, nx, ny).

        Without `coupling` each direction is computed alone. Where it is 0, neither transform nor spectrum is needed.
        """
        if coupling:
            kernels = ((spectra["xx"], spectra["xy"]), (spectra["xy"], spectra["yy"]))
            self.apply(kernels, field, result)
            return
        directions: tuple[Influence, Influence] = ("xx", "yy")
        for direction, part, part_of_result in zip(directions, field, result, strict=True):
            if part.any():
                self.apply(((spectra[direction],),), (part,), (part_of_result,))
            else:
                part_of_result[:] = 0.0

    def kernel_spectrum(self, quadrant: FloatArray, odd_x: bool, odd_y: bool) -> KernelSpectrum:
        """Return the spectrum of an influence function from its values at offsets 0..nx-1, 0..ny-1, ``(nx, ny)``."""
        return spectrum_of(quadrant, self.padded, self._float, odd_x, odd_y, self.team)

    def _transform_rows(self, fields: Fields, spectra: Sequence[ComplexArray], back: bool = False) -> None:
        """Transform each of the `fields` (nx, ny) along y into its spectrum (nx, my//2 + 1), or `back`."""

        def transform(member: int, rows: tuple[FloatArray, ComplexArray, slice]) -> None:
            """Transform the rows of a part of a field and, as their imaginary parts, as many of the lower half."""
            field, spectrum, part = rows
            block = self._row_blocks[member]
            lines = block.values[: part.stop - part.start]
            upper, lower = part, slice(self._pairs + part.start, min(self._pairs + part.stop, self.shape[0]))
            if back:
                self._kernels.join_spectra(spectrum[upper], spectrum[lower], lines)
                block.backward.execute()
                self._kernels.split_rows(lines, field[upper], field[lower])
            else:
                self._kernels.join_rows(field[upper], field[lower], lines)
                block.forward.execute()
                self._kernels.split_spectra(lines, spectrum[upper], spectrum[lower])

        # Handed out for all fields at once, which spares a sixth of all hand-outs, of 20 us each.
        pairs = list(zip(fields, spectra, strict=False))
        self.team.share(transform, [(*pair, part) for pair in pairs for part in self._row_parts])

    def _multiply_columns(
        self,
        kernels: KernelMatrix,
        fields: Sequence[ComplexArray],
        displacements: Sequence[ComplexArray],
        turned: tuple[bool, bool],
    ) -> None:
        """Compute the row spectra of the displacements from those of the fields, both (nx, my//2 + 1)."""

        def multiply(member: int, columns: slice) -> None:
            """Compute some columns of the displacements."""
            blocks = self._column_blocks[member]
            lines = [block.values[: columns.stop - columns.start] for block in blocks]
            # Transform the columns of all fields along x.
            for index, spectrum in enumerate(fields):
                self._kernels.take_columns(spectrum[:, columns], lines[index])
                if turned[0] and index == 0:
                    lines[index] *= 1j
                blocks[index].forward.execute()
            # Multiply them with the kernels, in place.
            self._multiply(kernels, lines[: len(fields)], lines[: len(displacements)], columns)
            # Transform the products back.
            for index, spectrum in enumerate(displacements):
                blocks[index].backward.execute()
                if turned[1] and index == 0:
                    lines[index] *= -1j
                self._kernels.give_columns(lines[index], spectrum[:, columns])

        self.team.share(multiply, self._column_parts)

    def _multiply(
        self, kernels: KernelMatrix, fields: Sequence[ComplexArray], results: Sequence[ComplexArray], columns: slice
    ) -> None:
        """Compute ``results = kernels @ fields`` for a block of columns; the results overwrite the fields.

        Square matrices are symmetric.
        """
        values = tuple(tuple(kernel.values[columns] for kernel in row) for row in kernels)
        odd = tuple(tuple(kernel.odd_x for kernel in row) for row in kernels)
        if len(fields) == len(results) > 1:
            self._kernels.multiply_symmetric(values, odd, (*fields,))
            return
        # One field or one result. The first result overwrites the first field, so it comes last.
        for row, odd_row, result in reversed(list(zip(values, odd, results, strict=True))):
            self._kernels.multiply(row[0], odd_row[0], fields[0], result)
            for kernel, is_odd, field in zip(row[1:], odd_row[1:], fields[1:], strict=True):
                self._kernels.multiply(kernel, is_odd, field, field)
                result += field

    def _provide_blocks(self, count: int) -> None:
        """Make a block of rows and `count` blocks of columns for each thread that is busy with so many fields."""
        if len(self._column_blocks[0]) >= count:
            return
        (mx, my), rows, columns = self.padded, self._row_parts[0].stop, self._column_parts[0].stop
        busy = self.team.members(range(count * len(self._row_parts)))
        self._row_blocks.extend(self._block(rows, my) for _ in busy[len(self._row_blocks) :])
        for own in self._column_blocks:
            own.extend(self._block(columns, mx) for _ in range(count - len(own)))

    def _block(self, lines: int, length: int) -> _Block:
        values = pyfftw.zeros_aligned((lines, length), self._complex)
        options: dict[str, Any] = {"axes": (1,), "flags": ("FFTW_MEASURE", "FFTW_DESTROY_INPUT")}
        forward = plan(values, values, **options)
        return _Block(values, forward, plan(values, values, direction="FFTW_BACKWARD", **options))
