"""WU, the unit of cost: one pruned, zero-padded real forward and inverse transform pair of a grid by pyFFTW.

Seconds of processor time of one thread, which other programs on the machine disturb less than those of the clock; so
are all costs that are told in WU. Float64, a measured plan, least fast padded size of at least 2n - 1; rows of zeros
are skipped in the forward pass and unwanted rows in the inverse. A scalar convolution costs about one, a tangential
application two.
"""

from __future__ import annotations

import os
import time
from typing import Any

import numpy as np
import pyfftw
from scipy.fft import next_fast_len

os.environ.setdefault("FRETSOLVE_NUMBA", "1")  # also for runs too short to pay for loading numba


def kernels_in_use() -> Any:
    """Return the kernels that the benchmarks run: compiled unless the environment says otherwise."""
    from fretsolve.kernels import load  # on demand, since older clones that are compared lack it
    from fretsolve.setup.kernel_choice import compiling_pays

    return load(compiling_pays(0.0))


def work_unit(points: int, repetitions: int = 15) -> float:
    """Return the median seconds of one WU on a grid of ``points`` by ``points``."""
    padded = next_fast_len(2 * points - 1, real=True)
    rows = pyfftw.zeros_aligned((points, padded))
    spectrum = pyfftw.zeros_aligned((padded, padded // 2 + 1), np.complex128)
    flags = ("FFTW_MEASURE",)
    plans = (
        pyfftw.FFTW(rows, spectrum[:points], axes=(1,), flags=flags),
        pyfftw.FFTW(spectrum, spectrum, axes=(0,), flags=flags),
        pyfftw.FFTW(spectrum, spectrum, axes=(0,), direction="FFTW_BACKWARD", flags=flags),
        pyfftw.FFTW(
            spectrum[:points], rows, axes=(1,), direction="FFTW_BACKWARD", flags=(*flags, "FFTW_DESTROY_INPUT")
        ),
    )
    rows[:] = 0.0
    seconds = []
    for _ in range(repetitions):
        rows[:, :points], rows[:, points:] = 1.0, 0.0
        began = time.process_time()
        plans[0].execute()
        spectrum[points:] = 0.0
        for plan in plans[1:]:
            plan.execute()
        seconds.append(time.process_time() - began)
    return float(np.median(seconds))
