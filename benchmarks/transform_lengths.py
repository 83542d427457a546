"""Measure how long FFTW takes for lines of different lengths, for `fretsolve.elastic.fftw.TIME_BY_TWOS`.

    python benchmarks/transform_lengths.py            # lengths of 64 to 1024, about a minute
    python benchmarks/transform_lengths.py 64 400

For each power of 2 in the length, the median over all lengths that are products of 2, 3 and 5 of the time per point
and per doubling of the length, relative to those with 16 or more: complex lines in a block of the size of a cache,
transformed in place by a measured plan. The last columns: one complex line against two real ones of the same length.
"""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator

import numpy as np
import pyfftw
from scipy.fft import next_fast_len

from fretsolve.elastic.convolution import CACHE_BYTES
from fretsolve.elastic.fftw import TIME_BY_TWOS

REPETITIONS = 30


def lengths(least: int, most: int) -> Iterator[int]:
    """Return products of 2, 3 and 5."""
    length = next_fast_len(least, real=True)
    while length <= most:
        yield length
        length = next_fast_len(length + 1, real=True)


def seconds(call: Callable[[], object]) -> float:
    """Return the time within which a fifth of some calls end."""
    found = []
    for _ in range(REPETITIONS):
        began = time.perf_counter()
        call()
        found.append(time.perf_counter() - began)
    return float(np.quantile(found, 0.2))


def times(length: int, dtype: type[np.complexfloating]) -> tuple[float, float]:
    """Return the times of a complex line and of two real ones (s)."""
    lines = max(1, CACHE_BYTES // (length * np.dtype(dtype).itemsize))
    complex_lines = pyfftw.zeros_aligned((lines, length), dtype)
    real_lines = pyfftw.zeros_aligned((lines, length), complex_lines.real.dtype)
    spectra = pyfftw.zeros_aligned((lines, length // 2 + 1), dtype)
    flags = ("FFTW_MEASURE",)
    packed = pyfftw.FFTW(complex_lines, complex_lines, axes=(1,), flags=flags)
    single = pyfftw.FFTW(real_lines, spectra, axes=(1,), flags=flags)
    complex_lines[:], real_lines[:] = 0.0, 0.0
    return seconds(packed.execute) / lines, 2.0 * seconds(single.execute) / lines


def print_table(shortest: int = 64, longest: int = 1024) -> None:
    """Print medians by the powers of 2 in a length."""
    by_twos: dict[tuple[int, type], list[tuple[float, float]]] = defaultdict(list)
    for length in lengths(shortest, longest):
        twos = min((length & -length).bit_length(), len(TIME_BY_TWOS)) - 1
        for dtype in (np.complex64, np.complex128):
            one, two = times(length, dtype)
            by_twos[twos, dtype].append((one / (length * np.log2(length)), one / two))
    print("| 2 divides the length | single | double | taken as | one complex : two real, single | double |")
    print("| --- | --- | --- | --- | --- | --- |")
    most = len(TIME_BY_TWOS) - 1
    best = {dtype: np.median(by_twos[most, dtype], axis=0)[0] for dtype in (np.complex64, np.complex128)}
    for twos, taken in enumerate(TIME_BY_TWOS):
        single, double = (np.median(by_twos[twos, dtype], axis=0) for dtype in (np.complex64, np.complex128))
        count = f"{twos} times" if twos < most else f"{twos} times or more"
        print(
            f"| {count} | {single[0] / best[np.complex64]:.2f} | {double[0] / best[np.complex128]:.2f} | {taken:.1f}"
            f" | {single[1]:.2f} | {double[1]:.2f} |"
        )


if __name__ == "__main__":
    print_table(*(int(argument) for argument in sys.argv[1:]))
