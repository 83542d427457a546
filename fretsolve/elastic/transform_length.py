"""Lengths that FFTW transforms fast."""

from __future__ import annotations

import math
from itertools import count

TIME_BY_TWOS = (2.5, 2.0, 1.4, 1.2, 1.0)
"""Time per point of a transform whose length holds the factor 2 that many times, over that of lengths with a factor of
16, which suit vector instructions best. Measured by `benchmarks/transform_lengths.py`."""


def padded_length(points: int) -> int:
    """Return a fast even length of at least ``2 points - 1``, to which `points` cells are padded; 1 for one cell."""
    return 1 if points == 1 else fast_length(2 * points - 1, even=True)


def fast_length(least: int, even: bool = False) -> int:
    """Return the length >= `least` on which square fields are transformed fastest: a product of 2, 3 and 5."""
    best, least_time = least, math.inf
    for length in count(least):
        if length * length >= least_time:
            break
        if pow(30, length.bit_length(), length):  # it does not divide a power of 30, so it has another prime factor
            continue
        twos = min((length & -length).bit_length(), len(TIME_BY_TWOS)) - 1
        time = TIME_BY_TWOS[twos] * length * length
        if time < least_time and (twos or not even):
            best, least_time = length, time
    return best
