"""What mirror symmetry could save: a convolution on a quarter of the cells beside the one on all of them.

    python benchmarks/symmetry.py 128 256 512 1024
    python benchmarks/symmetry.py --into docs/scenes.md

The pressure of a sphere about the grid's middle is even in x and in y, so a quarter of it tells all: its spectrum
comes from cosine transforms (type 2) of the quarter, padded to twice its length, and is real. Both do the same
convolution, planned alike, on one thread, in double precision and in the single one of the inner iterations, which
make most of the convolutions; `mirrored` adds what it takes to write the quarter back to a field of all cells, as the
rest of the solver would need it. The quarter's result is compared with the whole's.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyfftw
from marked import parser_of, report

from fretsolve.elastic.fftw import padded_length
from fretsolve.elastic.operator import ElasticOperator
from fretsolve.model.materials import compliances
from fretsolve.model.required_terms import Terms

GRIDS = (128, 256, 512, 1024)
SIDE = 0.8
REPEATS = 15


class Steel:
    """Elastic constants."""

    young_modulus, poisson_ratio = 200e3, 0.3


class QuarterConvolution:
    """uz from a pressure even in x and y on `points` x `points` cells, both as quarters ``(points/2, points/2)``."""

    def __init__(self, points: int, spectrum: np.ndarray):
        self.half, self.length = points // 2, padded_length(points) // 2
        self.kernel = np.ascontiguousarray(spectrum[: self.length, : self.length])
        self.rows = pyfftw.zeros_aligned((self.half, self.length), spectrum.dtype)
        self.spectra = pyfftw.zeros_aligned((self.length, self.length), spectrum.dtype)
        options = {"flags": ("FFTW_MEASURE",), "threads": 1}
        plan = pyfftw.FFTW
        self.forward_rows = plan(self.rows, self.rows, axes=(1,), direction="FFTW_REDFT10", **options)
        self.backward_rows = plan(self.rows, self.rows, axes=(1,), direction="FFTW_REDFT01", **options)
        self.forward = plan(self.spectra, self.spectra, axes=(0,), direction="FFTW_REDFT10", **options)
        self.backward = plan(self.spectra, self.spectra, axes=(0,), direction="FFTW_REDFT01", **options)

    def apply(self, quarter: np.ndarray, uz: np.ndarray) -> None:
        """Compute the convolution; `uz` is overwritten."""
        half = self.half
        self.rows[:, :half] = quarter
        self.rows[:, half:] = 0.0
        self.forward_rows.execute()
        self.spectra[:half] = self.rows
        self.spectra[half:] = 0.0
        self.forward.execute()
        self.spectra *= self.kernel
        self.backward.execute()
        self.rows[:] = self.spectra[:half]
        self.backward_rows.execute()
        uz[:] = self.rows[:, :half]


def seconds(job: Callable[[], None]) -> float:
    """Return the median processor time over repeats."""
    job()
    times = []
    for _ in range(REPEATS):
        began = time.process_time()
        job()
        times.append(time.process_time() - began)
    return statistics.median(times)


@dataclass(frozen=True)
class Comparison:
    """Seconds on all cells, on a quarter, and on a quarter with mirroring; difference over the largest value."""

    whole: float
    quarter: float
    mirrored: float
    difference: float


def compared(points: int, dtype: type[np.floating]) -> Comparison:
    """Compare both convolutions of Hertz's pressure."""
    cell, shape, half = SIDE / points, (points, points), points // 2
    operator = ElasticOperator(
        shape, (cell, cell), compliances(Steel(), Steel()), Terms(False, False, False), dtype=dtype
    )
    x = (np.arange(points) - 0.5 * (points - 1)) * cell
    pressure = np.sqrt(np.maximum(1.0 - (x[:, None] ** 2 + x[None, :] ** 2) / (0.4 * SIDE) ** 2, 0.0)).astype(dtype)
    whole = np.zeros_like(pressure)
    operator.normal(pressure, whole)
    symmetric = QuarterConvolution(points, operator._spectra["zz"].values)
    quarter, part = np.ascontiguousarray(pressure[half:, half:]), np.zeros((half, half), dtype)
    symmetric.apply(quarter, part)
    difference = np.abs(part - whole[half:, half:]).max() / whole.max()

    def mirrored() -> None:
        symmetric.apply(pressure[half:, half:], part)
        whole[half:, half:] = part
        whole[:half, half:] = part[::-1]
        whole[:, :half] = whole[:, : half - 1 : -1]

    return Comparison(
        seconds(lambda: operator.normal(pressure, whole)),
        seconds(lambda: symmetric.apply(quarter, part)),
        seconds(mirrored),
        float(difference),
    )


def print_symmetry(grids: tuple[int, ...] = GRIDS) -> None:
    """Print the table."""
    print("| precision | points | all cells, ms | a quarter, ms | mirrored, ms | gain | mirrored | difference |")
    print("| --- " * 8 + "|")
    for dtype in (np.float64, np.float32):
        for points in grids:
            found = compared(points, dtype)
            times = " | ".join(f"{1e3 * time:.3g}" for time in (found.whole, found.quarter, found.mirrored))
            gains = f"{found.whole / found.quarter:.1f} | {found.whole / found.mirrored:.1f}"
            print(f"| {np.dtype(dtype).name} | {points} | {times} | {gains} | {found.difference:.0e} |")


if __name__ == "__main__":
    parser = parser_of(__doc__)
    parser.add_argument("grids", nargs="*", type=int, default=GRIDS)
    asked = parser.parse_args()
    report({"symmetry": lambda: print_symmetry(tuple(asked.grids))}, asked.into)
