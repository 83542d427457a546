"""Convolution of fields that are their own mirror images about y = 0, of which the half y > 0 is known.

A field that is even in y, as p, qx, ux and uz are, has a cosine series along y, and an odd one, as qy and uy, a sine
series. So half of the cells have half of the wave numbers, and a convolution takes half of the work:

1. Each field is transformed along y into the slots of its series (`fretsolve.elastic.half_transform`).
2. Slots are padded and transformed along x, two at a time, as the real and the imaginary part of one line: those of qx
   and qy with the same number, or two of p. Lines are multiplied with the kernels and transformed back. Blocks of
   lines fit into a core's cache.
3. The slots are transformed back.

The spectra of the kernels are those of the whole grid (`fretsolve.elastic.convolution`). Between even and odd fields
they change by the factors 1 and -i of the cosine and the sine series.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

import numpy as np

from fretsolve.elastic.fftw import fast_length, padded_length
from fretsolve.elastic.half_transform import MOST_PRODUCTS, FastTransform, MatrixTransform
from fretsolve.elastic.kernel_spectrum import Influence, KernelSpectrum, spectrum_of
from fretsolve.elastic.line_buffer import LineBuffer, even_parts
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.system.arrays import Fields, FloatArray

Spectra = Mapping[Influence, KernelSpectrum]

Pairs = Sequence[tuple[FloatArray, FloatArray]]
"""Slots, (n, nx), of the real and of the imaginary part of lines; the latter may have fewer."""


class MirroredConvolution:
    """Convolutions of fields (nx, ny), the half y > 0 of fields that are even or odd about y = 0.

    periodic: the whole field is its own period, else it is padded so that nothing wraps around; shape: of the whole
    field. Buffers and plans are made when they are first needed.
    """

    def __init__(self, shape: tuple[int, int], dtype: type[np.floating], team: ThreadTeam, periodic: bool = False):
        nx, ny = self._half = shape
        self.shape, self.team, self._kernels = (nx, 2 * ny), team, team.kernels.spectral
        self._float, self._complex = np.dtype(dtype), np.result_type(dtype, np.complex64)
        least = ny if periodic else 2 * ny
        self._by_matrices = least * ny * nx <= MOST_PRODUCTS
        self._count = least if self._by_matrices else fast_length(least)
        self.padded = fast_length(nx) if periodic else padded_length(nx), 2 * self._count
        self._buffers: dict[tuple[int, int], list[LineBuffer]] = {}
        self._rolled: dict[KernelSpectrum, FloatArray] = {}

    def kernel_spectrum(self, quadrant: FloatArray, odd_x: bool, odd_y: bool) -> KernelSpectrum:
        """Return the spectrum of an influence function from its values at offsets 0..nx-1, 0..2ny-1."""
        return spectrum_of(quadrant, self.padded, self._float, odd_x, odd_y)

    def scalar(self, kernel: KernelSpectrum, odd: bool, field: FloatArray, result: FloatArray) -> None:
        """Compute `result` from one `field`, both (nx, ny); odd: both are odd in y, as qy and uy are."""
        (slots,) = self._slots((field,), (odd,))
        pairs, values = (self._count + 1) // 2, self._values(kernel, odd)
        both = [(slots[:pairs], slots[pairs:])]
        self._along_x(self._kernels.multiply_slots, (values[:pairs], values[pairs:]), both, both)
        self._fields((slots,), (odd,), (result,))

    def in_plane(self, spectra: Spectra, coupling: bool, shear: FloatArray, displacement: FloatArray) -> None:
        """Compute a tangential result (2, nx, ny) from a tangential field (2, nx, ny).

        Without `coupling` each direction is computed alone. Where it is 0, neither transform nor spectrum is needed.
        """
        if not coupling:
            directions: tuple[Influence, Influence] = "xx", "yy"
            for name, odd, field, result in zip(directions, (False, True), shear, displacement, strict=True):
                if field.any():
                    self.scalar(spectra[name], odd, field, result)
                else:
                    result[:] = 0.0
            return
        x, y = self._slots(shear, (False, True))
        kernels = self._values(spectra["xx"]), self._values(spectra["yy"], True), self._values(spectra["xy"])
        self._along_x(self._kernels.multiply_in_plane, kernels, [(x, y)], [(x, y)])
        self._fields((x, y), (False, True), displacement)

    def sideways(self, spectra: Spectra, pressure: FloatArray, displacement: FloatArray) -> None:
        """Compute the tangential displacement (2, nx, ny) from pressure (nx, ny)."""
        x, y = self._slots((pressure,), (False,), spare=1)
        kernels = self._values(spectra["xz"]), self._values(spectra["yz"])
        self._along_x(self._kernels.turn_sideways, kernels, [(x, x[:0])], [(x, y)])
        self._fields((x, y), (False, True), displacement)

    def upright(self, spectra: Spectra, shear: FloatArray, uz: FloatArray) -> None:
        """Compute uz (nx, ny) from shear (2, nx, ny)."""
        x, y = self._slots(shear, (False, True))
        kernels = self._values(spectra["xz"]), self._values(spectra["yz"])
        self._along_x(self._kernels.turn_upright, kernels, [(x, y)], [(x, x[:0])])
        self._fields((x,), (False,), (uz,))

    def coupled(
        self, spectra: Spectra, pressure: FloatArray, shear: FloatArray, uz: FloatArray, displacement: FloatArray
    ) -> None:
        """Compute normal and tangential displacement from pressure and shear."""
        z, x, y = slots = self._slots((pressure, *shear), (False, False, True))
        names: tuple[Influence, ...] = "zz", "xx", "yy", "xy", "xz", "yz"
        kernels = tuple(self._values(spectra[name], name == "yy") for name in names)
        lines = [(z, z[:0]), (x, y)]
        self._along_x(self._kernels.multiply_coupled, kernels, lines, lines)
        self._fields(slots, (False, False, True), (uz, *displacement))

    def _along_x(
        self, multiply: Callable[..., None], kernels: tuple[FloatArray, ...], sources: Pairs, targets: Pairs
    ) -> None:
        """Convolve along x the lines whose real and imaginary parts are the rows of `sources`, into those of `targets`.

        multiply: takes rows of the `kernels` and the spectra of as many lines, which it changes in place.
        """

        def convolve(member: int, part: slice) -> None:
            """Convolve some lines."""
            buffers, count = self._buffers[member, parts[0].stop][:most], part.stop - part.start
            for buffer, (real, imaginary) in zip(buffers, sources, strict=True):
                self._kernels.join_rows(real[part], imaginary[part], buffer.source[:count])
                buffer.forward()
            multiply(*(kernel[part] for kernel in kernels), *(buffer.target[:count] for buffer in buffers))
            for buffer, (real, imaginary) in zip(buffers, targets, strict=True):
                buffer.backward()
                self._kernels.split_rows(buffer.source[:count], real[part], imaginary[part])

        parts, most = even_parts(len(sources[0][0]), self.padded[0] * self._complex.itemsize), len(sources)
        for member in self.team.members(parts):
            own = self._buffers.setdefault((member, parts[0].stop), [])
            own.extend(LineBuffer((parts[0].stop, self.padded[0]), self._complex) for _ in range(most - len(own)))
        self.team.share(convolve, parts)

    @cached_property
    def _transform(self) -> MatrixTransform | FastTransform:
        if self._by_matrices:
            return MatrixTransform(self._half[1], self._count, self._float)
        return FastTransform(self._half, self._count, self._float, self.team)

    def _slots(self, fields: Fields, odd: Sequence[bool], spare: int = 0) -> list[FloatArray]:
        """Return the slots of fields, (slots, nx), and `spare` arrays more; they are valid until the next call."""
        found = self.team.arrays(len(fields) + spare, (self._count, self._half[0]), self._float)
        for field, is_odd, slots in zip(fields, odd, found, strict=False):
            self._transform.forward(field, is_odd, slots)
        return found

    def _fields(self, slots: Sequence[FloatArray], odd: Sequence[bool], fields: Fields) -> None:
        """Write the fields of these slots."""
        for one, is_odd, field in zip(slots, odd, fields, strict=True):
            self._transform.backward(one, is_odd, field)

    def _values(self, kernel: KernelSpectrum, odd: bool = False) -> FloatArray:
        """Return the kernel of each slot, (slots, mx//2 + 1); odd: from an odd field to an odd one."""
        if not odd:
            return kernel.values[: self._count]
        if kernel not in self._rolled:
            self._rolled[kernel] = np.concatenate([kernel.values[-1:], kernel.values[1:-1]])
        return self._rolled[kernel]
