"""Exact discrete convolution on a grid by real FFTs of a zero-padded copy (DC-FFT, Liu et al., Wear 243, 2000).

Each side is padded to at least 2n - 1 points, so that nothing wraps around. Small grids are left to
`BatchedConvolution`, whose arrays fit into the cache. On larger ones the padded two-dimensional spectrum never exists
as a whole:

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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fretsolve.elastic.fftw import estimated_plan, even_parts, fast_length, padded_length, plan, pyfftw
from fretsolve.elastic.influence import Influence, KernelMatrix, KernelSpectrum, spectrum_of
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import ComplexArray, Fields, FloatArray

MOST_BATCHED_POINTS, COMPILED = 300 * 300, 0.2
"""Largest padded grid that is transformed as a whole, by `BatchedConvolution`, and factor on it with compiled kernels.
Larger ones gain by blocks: with compiled kernels a third on 192 x 192 and 256 x 256 padded points."""


Spectra = Mapping[Influence, KernelSpectrum]


@dataclass(frozen=True)
class _Block:
    """A buffer for a block of padded lines, with the plans of their transforms in place."""

    values: ComplexArray
    forward: pyfftw.FFTW
    backward: pyfftw.FFTW


class PaddedConvolution:
    """Plans and buffers for convolutions of fields ``(nx, ny)``; both are made at the first convolution.

    periodic: a field is its own period, else it is padded so that nothing wraps around; team: the threads.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        dtype: type[np.floating] = np.float64,
        team: ThreadTeam | None = None,
        periodic: bool = False,
    ):
        self.shape = shape
        length = fast_length if periodic else padded_length
        self.padded = length(shape[0]), length(shape[1])
        self.columns = self.padded[1] // 2 + 1
        self._float = np.dtype(dtype)
        self._complex = np.dtype(np.complex64 if self._float == np.float32 else np.complex128)
        self.team = team or ThreadTeam()
        self._kernels = self.team.kernels.spectral
        mx, my = self.padded
        most = MOST_BATCHED_POINTS * (COMPILED if self.team.kernels.compiled else 1.0)
        small = mx * my <= most
        self._batched = BatchedConvolution(shape, self.padded, self._float, self._kernels) if small else None
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

        turned: whether to multiply the spectrum of the first field by i, and the spectrum of the first displacement by
        -i (see the top of this file). A displacement may be the array of a field.
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

    def normal(self, spectra: Spectra, pressure: FloatArray, uz: FloatArray) -> None:
        """Compute uz from pressure, or the reverse, (nx, ny) or (1, nx, ny)."""
        self.apply(((spectra["zz"],),), _planes(pressure), _planes(uz))

    def tangential(self, spectra: Spectra, coupling: bool, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute a tangential result (2, nx, ny) from a tangential field (2, nx, ny).

        Without `coupling` each direction is computed alone. Where it is 0, neither transform nor spectrum is needed.
        """
        if coupling:
            self.apply(((spectra["xx"], spectra["xy"]), (spectra["xy"], spectra["yy"])), shear, displacement)
            return
        directions: tuple[Influence, Influence] = ("xx", "yy")
        for direction, part, part_of_result in zip(directions, shear, displacement, strict=True):
            if part.any():
                self.apply(((spectra[direction],),), (part,), (part_of_result,))
            else:
                part_of_result[:] = 0.0

    def tangential_from_pressure(self, spectra: Spectra, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement (2, nx, ny) from pressure."""
        self.apply(((spectra["xz"],), (spectra["yz"],)), _planes(pressure), displacement, turned=(True, False))

    def normal_from_shear(self, spectra: Spectra, shear: FloatArray, uz: FloatArray) -> None:
        """Compute uz from shear (2, nx, ny)."""
        self.apply(((spectra["xz"], spectra["yz"]),), shear, _planes(uz), turned=(False, True))

    def coupled(
        self, spectra: Spectra, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray
    ) -> None:
        """Compute normal and tangential displacement from pressure and shear."""
        kernels = (
            (spectra["zz"], spectra["xz"], spectra["yz"]),
            (spectra["xz"], spectra["xx"], spectra["xy"]),
            (spectra["yz"], spectra["xy"], spectra["yy"]),
        )
        self.apply(kernels, (pressure, *shear), (uz, *displacement), turned=(True, True))

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
        """Compute the row spectra of the displacements from the row spectra of the fields, both (nx, my//2 + 1)."""

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


def _planes(field: FloatArray) -> FloatArray:
    """Return a field (nx, ny) or (1, nx, ny) as (1, nx, ny)."""
    return field if field.ndim == 3 else field[None]


class BatchedConvolution:
    """Convolution on a small grid: all fields in one plan, and the padded spectra as whole arrays.

    Where the arrays fit into the cache, a convolution costs the calls that it is made of, not its transforms. So all
    fields are transformed by one call along y and one along x, out of arrays whose padding stays zero, and one call
    computes the products. On 16, 32 and 64 cells per side, two components take 0.4, 0.7 and 1.0 of the time of blocks;
    without numba, on 32, 64 and 128, 0.2, 0.4 and 0.6. Buffers and plans are made when they are first needed.
    """

    def __init__(self, shape: tuple[int, int], padded: tuple[int, int], dtype: np.dtype[Any], kernels: Any):
        self._shape, self._padded, self._dtype, self._kernels = shape, padded, dtype, kernels
        self._forward, self._backward = cache(self._make_forward), cache(self._make_backward)
        self._convolutions: dict[tuple[KernelMatrix, tuple[bool, bool]], _Steps] = {}

    def apply(self, kernels: KernelMatrix, fields: Fields, displacements: Fields, turned: tuple[bool, bool]) -> None:
        """Compute ``displacements = kernels @ fields``; arguments as for `PaddedConvolution.apply`."""
        convolution = self._convolutions.get((kernels, turned))
        if convolution is None:
            convolution = self._convolutions[kernels, turned] = self._convolution(kernels, turned)
        convolution.apply(fields, displacements)

    def _convolution(self, kernels: KernelMatrix, turned: tuple[bool, bool]) -> _Steps:
        """Bind plans and buffers of a convolution once; a lookup costs 2 us."""
        forward, backward = self._forward(len(kernels[0])), self._backward(len(kernels))
        factors = self._factors_of(kernels, turned)
        products = factors, forward.of(factors)[0], *backward.of(factors)
        return _Steps(forward.rows, forward.plans, products, backward.plans, backward.rows, self._kernels)

    def _factors_of(self, kernels: KernelMatrix, turned: tuple[bool, bool]) -> NDArray[np.inexact]:
        """Return the kernels (m, n, mx * (my//2 + 1)) with their factors i and -i; real ones twice, for both parts."""
        values = np.array([[kernel.whole(self._padded[0]) for kernel in row] for row in kernels])
        if any(turned):
            turns = np.ones((*values.shape[:2], 1, 1), np.result_type(values, np.complex64))
            turns[:, 0] *= 1j ** turned[0]
            turns[0] *= (-1j) ** turned[1]
            found = values * turns
        else:
            found = np.repeat(values, 2, axis=-1)
        return found.reshape(*found.shape[:2], -1)

    def _make_forward(self, count: int) -> _Transforms:
        """Return the transforms of `count` fields, along y, then along x out of an array whose padding stays zero."""
        rows, half, spectrum = self._arrays(count)
        plans = estimated_plan(rows, half[:, : self._shape[0]], 2), estimated_plan(half, spectrum, 1)
        return _Transforms(rows[:, :, : self._shape[1]], spectrum, spectrum[:0], plans)

    def _make_backward(self, count: int) -> _Transforms:
        """Return the inverse transforms of `count` spectra, along x, then along y of the wanted rows."""
        rows, half, spectrum = self._arrays(count)
        plans = (
            estimated_plan(spectrum, half, 1, back=True),
            estimated_plan(half[:, : self._shape[0]], rows, 2, back=True),
        )
        return _Transforms(rows[:, :, : self._shape[1]], spectrum, half, plans)

    def _arrays(self, count: int) -> tuple[FloatArray, ComplexArray, ComplexArray]:
        """Return padded rows (count, nx, my), and twice an array for spectra (count, mx, my//2 + 1)."""
        (mx, my), complex_type = self._padded, np.result_type(self._dtype, np.complex64)
        rows = pyfftw.zeros_aligned((count, self._shape[0], my), self._dtype)
        first, second = (pyfftw.zeros_aligned((count, mx, my // 2 + 1), complex_type) for _ in range(2))
        return rows, first, second


class _Transforms:
    """Two plans that run one after the other, between `rows`, the cells' part of padded rows, and a spectrum.

    Spectra are (count, mx * (my//2 + 1)) where they are multiplied.
    """

    def __init__(
        self, rows: FloatArray, spectrum: ComplexArray, product: ComplexArray, plans: tuple[pyfftw.FFTW, pyfftw.FFTW]
    ):
        self.rows = rows
        flat = tuple(array.reshape(-1, spectrum[0].size) for array in (spectrum, product))
        self._numbers, self._parts = flat, tuple(array.view(rows.dtype) for array in flat)
        self.plans = tuple(one.execute for one in plans)

    def of(self, factors: NDArray[np.inexact]) -> tuple[NDArray[np.inexact], ...]:
        """Return the spectrum and an array of its shape for products; for real factors their parts, as neighbours."""
        return self._numbers if factors.dtype.kind == "c" else self._parts


class _Steps(NamedTuple):
    """Steps of a convolution: `rows` that receive the fields, plans, arguments of `combine`, plans, `wanted` rows.

    spectral: operations on spectra.
    """

    rows: FloatArray
    forward: tuple[Callable[[], Any], ...]
    products: tuple[NDArray[np.inexact], ...]
    backward: tuple[Callable[[], Any], ...]
    wanted: FloatArray
    spectral: Any

    def apply(self, fields: Fields, displacements: Fields) -> None:
        """Take these steps from some fields to their displacements."""
        _copy(fields, self.rows)
        for transform in self.forward:
            transform()
        self.spectral.combine(*self.products)
        for transform in self.backward:
            transform()
        _copy(self.wanted, displacements)


def _copy(source: Fields, target: Fields) -> None:
    """Copy fields, in one call where they lie in one array, as each call takes a microsecond."""
    if isinstance(source, np.ndarray) and isinstance(target, np.ndarray):
        target[...] = source
        return
    for one, other in zip(source, target, strict=True):
        other[...] = one
