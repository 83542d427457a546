"""Stress in a layer below the surface, by an exact discrete convolution on a padded grid (DC-FFT).

The tractions of an increment are transformed once for all layers and bodies. A layer needs the spectra of up to 14
derivatives of the potentials (`fretsolve.post.stress.influence`), which hold no elastic constant, so that they
serve both bodies. The stress of an increment in a layer then takes one inverse transform per component.

Cells without traction are not transformed, and the padding is only as wide as the largest distance from a loaded cell
to one whose stress is wanted.

Every coefficient is even or odd in x and in y, so its spectrum is real, or i times a real one if it is odd in one of
them. With the spectra of p, i qx, i qy all factors are real: xx, yy, zz, xy are then sums of real multiples, and xz and
yz are i times such a sum.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretsolve.elastic.fftw import fast_length, plan, pyfftw
from fretsolve.elastic.influence import spectrum_of
from fretsolve.elastic.thread_team import ThreadTeam
from fretsolve.post.stress.influence import (
    COMPONENTS,
    TRACTIONS,
    Body,
    Component,
    Potential,
    Strip,
    Terms,
    Traction,
    cell_values,
    is_odd,
    stress_terms,
)
from fretsolve.system.arrays import ComplexArray, DoubleArray

Window = tuple[slice, slice]
"""Cells from start to stop along x and along y."""


@dataclass(frozen=True, eq=False)
class LayerKernels:
    """Real spectra of the coefficients of one body at one depth.

    rows: of each component, for each traction, the spectrum ``(mx//2 + 1, my + 2)``, in which every number stands
    twice, for real and imaginary part; odd: whether it changes sign for the wave numbers along x that are left out.
    """

    rows: Mapping[Component, Sequence[DoubleArray]]
    odd: Mapping[Component, Sequence[bool]]


class LayerConvolution:
    """Transforms between cells with tractions (`source`) and cells whose stress is wanted (`target`).

    spacing: sides of a cell (mm). tractions: only tractions that are not 0 in all increments. threads: of the inverse
    transforms, on whose number no result depends. measured: take a third of a second to plan faster transforms.
    plane_strain: cells are strips without end along y, in one row.
    """

    def __init__(
        self,
        spacing: tuple[float, float],
        source: Window,
        target: Window,
        tractions: Sequence[Traction] = TRACTIONS,
        threads: int = 1,
        measured: bool = False,
        plane_strain: bool = False,
    ):
        self.plane_strain = plane_strain
        self.spacing, self.source, self.target, self.tractions = spacing, source, target, tuple(tractions)
        self.reach = tuple(
            max(to.stop - 1 - of.start, of.stop - 1 - to.start, 0) for of, to in zip(source, target, strict=True)
        )
        self.padded = padded_shape(source, target)
        self._columns = self.padded[1] // 2 + 1
        # Where the cells lie on the padded grid.
        offsets = [max(0, of.start - to.start) for of, to in zip(source, target, strict=True)]
        self._placed, self._wanted = (
            tuple(
                slice(offset + one.start - of.start, offset + one.stop - of.start)
                for offset, one, of in zip(offsets, window, source, strict=True)
            )
            for window in (source, target)
        )
        self._team = ThreadTeam(threads)
        self._members = [_Buffers(self, measured) for _ in self._team.members(COMPONENTS)]

    def forward(self, tractions: Mapping[Traction, DoubleArray]) -> ComplexArray:
        """Return the spectra of p, i qx, i qy on the padded grid from the tractions (nx, ny) of the source's cells."""
        buffers, (mx, _) = self._members[0], self.padded
        spectra: ComplexArray = pyfftw.empty_aligned((len(self.tractions), mx, self._columns), np.complex128)
        for index, name in enumerate(self.tractions):
            buffers.transform(tractions[name], self._placed, spectra[index])
            if name != "p":
                spectra[index] *= 1j
        return spectra

    def potentials(self, depth: float, bodies: Mapping[Body, float]) -> dict[Potential | Strip, DoubleArray]:
        """Return the spectra of the potentials that a layer needs, ``(mx//2 + 1, my//2 + 1)``; bodies: their nu."""
        names = {
            name
            for body, nu in bodies.items()
            for component in COMPONENTS
            for traction in self.tractions
            for name in stress_terms(component, traction, depth, nu, body, plane_strain=self.plane_strain)
        }
        x, y = (np.arange(reach + 1) * side for reach, side in zip(self.reach, self.spacing, strict=True))
        found: dict[Potential | Strip, DoubleArray] = {}
        for name in names:
            values = cell_values(name, x, y, depth, *self.spacing)
            spectrum = spectrum_of(
                values, self.padded, np.dtype(float), is_odd(name, "x"), is_odd(name, "y"), self._team
            )
            found[name] = np.ascontiguousarray(spectrum.values.T, dtype=np.float64)
        return found

    def kernels(
        self, potentials: Mapping[Potential | Strip, DoubleArray], depth: float, nu: float, body: Body
    ) -> LayerKernels:
        """Return the spectra of the coefficients of a body from the spectra of the potentials."""
        known: dict[tuple[tuple[Potential | Strip, float], ...], DoubleArray] = {}
        rows: dict[Component, Sequence[DoubleArray]] = {}
        odd: dict[Component, Sequence[bool]] = {}
        for component in COMPONENTS:
            terms = [
                stress_terms(component, traction, depth, nu, body, plane_strain=self.plane_strain)
                for traction in self.tractions
            ]
            if component in ("xz", "yz"):
                # i K p + K q = i (K p - K i q)
                terms = [
                    one if name == "p" else {key: -factor for key, factor in one.items()}
                    for one, name in zip(terms, self.tractions, strict=True)
                ]
            for one in terms:
                if tuple(one.items()) not in known:
                    known[tuple(one.items())] = self._combined(potentials, one)
            rows[component] = [known[tuple(one.items())] for one in terms]
            odd[component] = [any(is_odd(name, "x") for name in one) for one in terms]
        return LayerKernels(rows, odd)

    def _combined(self, potentials: Mapping[Potential | Strip, DoubleArray], terms: Terms) -> DoubleArray:
        total = np.zeros((self.padded[0] // 2 + 1, self._columns))
        for name, factor in terms.items():
            total += factor * potentials[name]
        return np.repeat(total, 2, axis=1)

    def stress(
        self, kernels: LayerKernels, spectra: ComplexArray, components: Sequence[Component] = COMPONENTS
    ) -> DoubleArray:
        """Return stress components (MPa) of one increment in the target's cells, ``(len(components), nx, ny)``."""
        shape = tuple(one.stop - one.start for one in self.target)
        result = np.empty((len(components), *shape))

        def compute(member: int, index: int) -> None:
            """Compute one component."""
            component, buffers = components[index], self._members[member]
            turned = component in ("xz", "yz")
            _multiply(kernels.rows[component], kernels.odd[component], spectra, buffers.spectrum, turned)
            buffers.transform_back(self._wanted, result[index])

        self._team.share(compute, range(len(components)))
        return result


class _Buffers:
    """Arrays and plans of one thread."""

    def __init__(self, convolution: LayerConvolution, measured: bool):
        (mx, my), columns = convolution.padded, convolution.padded[1] // 2 + 1
        source, target = convolution._placed, convolution._wanted
        self.rows: DoubleArray = pyfftw.zeros_aligned((source[0].stop - source[0].start, my))
        self.rows_back: DoubleArray = pyfftw.zeros_aligned((target[0].stop - target[0].start, my))
        self.spectrum: ComplexArray = pyfftw.zeros_aligned((mx, columns), np.complex128)
        flags = ("FFTW_MEASURE" if measured else "FFTW_ESTIMATE",)
        # The inverse along x is in place; the one along y destroys its input.
        self._along_x = {
            way: plan(self.spectrum, self.spectrum, axes=(0,), direction=way, flags=flags)
            for way in ("FFTW_FORWARD", "FFTW_BACKWARD")
        }
        self._along_y = plan(self.rows, self.spectrum[source[0]], axes=(1,), flags=flags)
        self._along_y_back = plan(
            self.spectrum[target[0]],
            self.rows_back,
            axes=(1,),
            direction="FFTW_BACKWARD",
            flags=(*flags, "FFTW_DESTROY_INPUT"),
        )

    def transform(self, field: DoubleArray, placed: tuple[slice, ...], spectrum: ComplexArray) -> None:
        """Transform the cells `placed` on the padded grid, which is 0 elsewhere."""
        self.rows[:, placed[1]] = field
        self.spectrum[: placed[0].start] = 0.0
        self.spectrum[placed[0].stop :] = 0.0
        self._along_y.execute()
        self._along_x["FFTW_FORWARD"].execute()
        spectrum[:] = self.spectrum

    def transform_back(self, wanted: tuple[slice, ...], field: DoubleArray) -> None:
        """Transform `spectrum` back into the cells `wanted`."""
        self._along_x["FFTW_BACKWARD"].execute()
        self._along_y_back.execute()
        field[:] = self.rows_back[:, wanted[1]]


def padded_shape(source: Window, target: Window) -> tuple[int, int]:
    """Return the periods at which no stress wraps around."""
    lengths = []
    for of, to in zip(source, target, strict=True):
        reach = max(to.stop - 1 - of.start, of.stop - 1 - to.start, 0)
        lengths.append(fast_length(2 * reach + 1, even=True) if reach else 1)
    return lengths[0], lengths[1]


def _multiply(
    kernels: Sequence[DoubleArray], odd: Sequence[bool], spectra: ComplexArray, result: ComplexArray, turned: bool
) -> None:
    """Compute the sum of `kernels` times `spectra`, with `turned` times i; kernels hold half of the rows.

    Some rows are multiplied at a time, so that they stay in cache.
    """
    parts, sums = spectra.view(np.float64), result.view(np.float64)
    length, (half, width) = sums.shape[0], kernels[0].shape
    # so much of a spectrum stays in cache
    share = max(1, 400 * 1024 // (8 * width))
    product = np.empty((min(share, half), width))
    for start in range(0, half, share):
        stop = min(start + share, half)
        places = [(slice(start, stop), slice(start, stop), False)]
        # Rows of negative wave numbers have the kernels of positive ones; 0 and the highest one stand alone.
        first, last = max(start, 1), min(stop, length - length // 2)
        if last > first:
            # Reversed kernels cost less than reversed spectra, which are read and written.
            places.append((slice(last - 1, first - 1, -1), slice(length - last + 1, length - first + 1), True))
        for of_kernel, of_spectrum, is_mirrored in places:
            target = sums[of_spectrum]
            for index, (kernel, is_odd_x) in enumerate(zip(kernels, odd, strict=True)):
                negative = is_mirrored and is_odd_x
                if index == 0:
                    np.multiply(kernel[of_kernel], parts[index, of_spectrum], out=target)
                    if negative:
                        np.negative(target, out=target)
                    continue
                term = np.multiply(kernel[of_kernel], parts[index, of_spectrum], out=product[: len(target)])
                (np.subtract if negative else np.add)(target, term, out=target)
            if turned:
                result[of_spectrum] *= 1j
