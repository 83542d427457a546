"""Complete elliptic integrals of one modulus, and roots, in plain Python.

A run needs a few of them. Importing `scipy.special` takes 0.2 s of processor time and `scipy.optimize` 0.4 s, which is
more than many a small case takes to solve.
"""

from __future__ import annotations

import math
from collections.abc import Callable


def complete_integral(complement: float, cosine: float = 1.0, sine: float = 1.0) -> float:
    """Return the integral of (cosine cos^2 f + sine sin^2 f)/sqrt(1 - k^2 sin^2 f) over f from 0 to pi/2.

    complement: k' = sqrt(1 - k^2) > 0. With k^2 D = K - E and k^2 B = E - k'^2 K, (1, 1) gives K, (0, 1) D, (1, 0) B
    and (1, k'^2) E. Nothing cancels. By Landen's transformation; Bulirsch (1965), procedure cel2.
    """
    mean, before, total, rest = 1.0, cosine, cosine + sine, sine
    while True:
        rest = 2.0 * (before * complement + rest)
        before, former, mean = total, mean, complement + mean
        total += rest / mean
        if abs(former - complement) <= 1e-8 * former:  # it converges quadratically
            return 0.25 * math.pi * total / mean
        complement = 2.0 * math.sqrt(complement * former)


def modulus(ratio: float) -> float:
    """Return the modulus k with K(k)/K(k') = ratio > 0, as theta functions of the nome give it; 0 or 1 by rounding."""
    if ratio > 1.0:
        complement = modulus(1.0 / ratio)
        return math.sqrt((1.0 - complement) * (1.0 + complement))
    root = math.exp(-0.25 * math.pi / ratio)
    nome = root**4  # 0.043 at most: nome^12 and nome^16 are left out
    return (2.0 * root * (1.0 + nome**2 + nome**6) / (1.0 + 2.0 * (nome + nome**4 + nome**9))) ** 2


def growing_root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where `function`, which is not above 0 at `low` and not below 0 at `high`, grows through 0.

    Brent's method takes a sixth of the calls, which are of microseconds, but an import.
    """
    for _ in range(60):  # they leave 1e-18 of the interval
        middle = 0.5 * (low + high)
        low, high = (middle, high) if function(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)
