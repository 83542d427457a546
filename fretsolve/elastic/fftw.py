"""pyFFTW, fast lengths, blocks of lines, and plans. What FFTW measures for a plan, its wisdom, is kept in the user's
cache folder, in a file for each plan.

pyFFTW is imported without the packages that only its wrappers need. SciPy's transforms would take 0.1 s of every
process; Dask, if installed (the extra `scale`), 0.6 s and 90 MB. Both count as absent while pyFFTW is imported.
"""

from __future__ import annotations

import contextlib
import hashlib
import math
import os
import sys
import zlib
from functools import cache
from itertools import count
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError
from fretsolve.system import atomic_files
from fretsolve.system.files import TakenError, read_bytes

_hidden = [name for name in ("dask", "scipy.fftpack") if name not in sys.modules]
sys.modules.update(dict.fromkeys(_hidden))  # type: ignore[arg-type]
try:
    import pyfftw as pyfftw  # for other modules
finally:
    for _name in _hidden:
        del sys.modules[_name]

CACHE_BYTES = 300 * 1024
"""Size of a block of lines: three or four fit into the second-level cache of a core. With 400 KiB an increment of mode
I.3 takes 3 to 4 % longer on 512 x 512 and 1024 x 1024 points, and as long on 256 x 256 and 2048 x 2048."""

GZIP = 31
"""The format with a header and CRC-32, among those of zlib."""

LEAST_MEASURED = 2**14
"""Numbers from which plans of blocks are measured, which takes 0.1 to 0.5 s for each. Blocks of a quarter of that are
transformed in 0.5 to 1.0 of the time of estimated plans, so that measuring pays after 10^4 to 10^5 transforms."""


def padded_length(points: int) -> int:
    """Return a fast even length of at least ``2 points - 1``, to which `points` cells are padded; 1 for one cell."""
    return 1 if points == 1 else fast_length(2 * points - 1, even=True)


def fast_length(least: int, even: bool = False) -> int:
    """Return the length >= `least` on which square fields are transformed fastest: a product of 2, 3 and 5."""
    best, least_time = least, math.inf
    # time per point by the factors of 2 in the length, over the time with a factor of 16, which suits vectors
    times = (2.5, 2.0, 1.4, 1.2, 1.0)
    for length in count(least):
        if length * length >= least_time:
            break
        if pow(30, length.bit_length(), length):  # it does not divide a power of 30, so it has another prime factor
            continue
        twos = min((length & -length).bit_length(), len(times)) - 1
        time = times[twos] * length * length
        if time < least_time and (twos or not even):
            best, least_time = length, time
    return best


def estimated_plan(source: NDArray[Any], target: NDArray[Any], axis: int, back: bool = False) -> pyfftw.FFTW:
    """Make a plan along one axis without measuring it: on small grids that would take 0.3 s for each and gain a tenth.

    back: the inverse transform, which destroys its source.
    """
    direction, extra = ("FFTW_BACKWARD", ("FFTW_DESTROY_INPUT",)) if back else ("FFTW_FORWARD", ())
    return plan(source, target, axes=(axis,), direction=direction, flags=("FFTW_ESTIMATE", *extra))


class CacheBlock:
    """Two arrays of lines (r, m), between which `forward` and `backward` transform; both lose what they start from."""

    def __init__(self, shape: tuple[int, int], dtype: np.dtype[Any]):
        self.source, self.target = (pyfftw.zeros_aligned(shape, dtype) for _ in range(2))
        effort = "FFTW_MEASURE" if self.source.size >= LEAST_MEASURED else "FFTW_ESTIMATE"
        options: dict[str, Any] = {"axes": (1,), "flags": (effort, "FFTW_DESTROY_INPUT")}
        self.forward = plan(self.source, self.target, **options).execute
        self.backward = plan(self.target, self.source, direction="FFTW_BACKWARD", **options).execute


def even_parts(lines: int, bytes_per_line: int) -> list[slice]:
    """Cut `lines` into one block, or an even number of equal ones near `CACHE_BYTES`.

    Two threads would need as long for three blocks as for four: at 512 x 512 points a tenth of an increment.
    """
    blocks = lines * bytes_per_line / CACHE_BYTES
    share = -(-lines // (1 if blocks < 1.0 else 2 * max(1, round(0.5 * blocks))))
    return [slice(start, min(start + share, lines)) for start in range(0, lines, share)]


_planning = Lock()

_known: dict[str, bytes | None] = {}
"""Wisdom of the measured plans of this process by their names, for where the cache cannot be read or written."""


def plan(*arrays: NDArray[Any], flags: tuple[str, ...], **options: Any) -> pyfftw.FFTW:
    """Make a plan of FFTW, which depends on nothing that this process has planned before.

    FFTW forgets the wisdom of the whole process for that. Plans of other threads wait, since FFTW's wisdom is one.
    A measured plan comes from its file in the cache. Where there is none, or a damaged one, that is written, so that a
    resumed run transforms by the same plans. Of two processes that measure a plan at once both take that of the first.
    """
    options["flags"] = flags
    with _planning:
        pyfftw.forget_wisdom()
        return _measured_plan(arrays, options) if "FFTW_MEASURE" in flags else pyfftw.FFTW(*arrays, **options)


def _measured_plan(arrays: tuple[NDArray[Any], ...], options: dict[str, Any]) -> pyfftw.FFTW:
    name = plan_name(arrays, options)
    kept = _read(name)
    made = _plan_by(kept, arrays, options)
    if made is None:
        if kept is not None:
            _remove(name)  # before the plan is measured, which another process may do meanwhile
        made = _plan_by(_known.get(name), arrays, options) or pyfftw.FFTW(*arrays, **options)
        kept = max(pyfftw.export_wisdom(), key=len)  # of the three precisions only this one has a plan
        if not _write(name, kept):
            kept = _read(name) or kept
            made = _plan_by(kept, arrays, options) or made
    _known[name] = kept
    return made


def _plan_by(wisdom: bytes | None, arrays: tuple[NDArray[Any], ...], options: dict[str, Any]) -> pyfftw.FFTW | None:
    """Return a plan that is in `wisdom`, None without one."""
    pyfftw.forget_wisdom()
    if wisdom and any(pyfftw.import_wisdom((wisdom,) * 3)):
        with contextlib.suppress(RuntimeError):  # it has no such plan
            return pyfftw.FFTW(*arrays, **options | {"flags": (*options["flags"], "FFTW_WISDOM_ONLY")})
    return None


def plan_name(arrays: tuple[NDArray[Any], ...], options: dict[str, Any]) -> str:
    """Return the name of a plan's file: a digest of what FFTW knows plans by, and of FFTW itself."""
    of_arrays = [(one.shape, one.strides, one.dtype.str, pyfftw.is_byte_aligned(one)) for one in arrays]
    in_place = arrays[0] is arrays[1]
    problem = _fftw(), of_arrays, in_place, sorted(options.items())
    return f"fftw-{hashlib.sha256(repr(problem).encode()).hexdigest()[:16]}.gz"


@cache
def _fftw() -> tuple[Any, ...]:
    """Return versions and empty wisdom, which has a digest of all algorithms that this processor can execute.

    So processors with other vector instructions have files of their own in a shared home.
    """
    pyfftw.forget_wisdom()
    return pyfftw.__version__, *pyfftw.export_wisdom()


def cache_folder() -> Path:
    """Return ``$FRETSOLVE_CACHE`` or fretsolve's part of the user's cache folder. Raises OSError without a home."""
    if (folder := os.environ.get("FRETSOLVE_CACHE")) is not None:
        return Path(folder)
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fretsolve"
    except RuntimeError as error:
        raise FileNotFoundError(*error.args) from error


def _read(name: str) -> bytes | None:
    """Return the wisdom in a file of the cache; None if none can be read now, and nothing if it is damaged."""
    try:
        # gzip's format has a checksum; a plan takes some 300 bytes
        return zlib.decompress(read_bytes(cache_folder() / name, 2**16), wbits=GZIP)
    except (FileError, PermissionError, zlib.error):
        return b""
    except OSError:  # a file that only this time cannot be read stays
        return None


def _remove(name: str) -> None:
    with contextlib.suppress(OSError):
        atomic_files.remove(cache_folder() / name, durable=False)


def _write(name: str, wisdom: bytes) -> bool:
    """Write a file of the cache. Return False if there is one. A cache that cannot be written is ignored."""
    with contextlib.suppress(OSError):
        path = cache_folder() / name
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with atomic_files.new_file(path, durable=False, exclusive=True) as file:
                file.write(zlib.compress(wisdom, wbits=GZIP))
        except TakenError:
            return False
    return True
