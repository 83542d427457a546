"""pyFFTW, fast lengths, blocks of lines with their plans, and FFTW's wisdom: the measurements of its planner, kept in
the user's cache folder.

pyFFTW is imported without the packages that only its wrappers need. SciPy's transforms would take 0.1 s of every
process; Dask, if installed (the extra `scale`), 0.6 s and 90 MB. Both count as absent while pyFFTW is imported.
"""

from __future__ import annotations

import contextlib
import math
import os
import sys
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretsolve.errors import FileError
from fretsolve.system import atomic_files
from fretsolve.system.files import read_bytes

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

LEAST_MEASURED = 2**14
"""Numbers from which plans are measured. On small grids that would take 0.3 s for each and gain a tenth."""


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


_unsaved = False  # like FFTW's wisdom, this and the next lines belong to the process
"""Whether plans may have been measured, or wisdom been read, that the file does not have."""

_known: bytes | None = None
_version: tuple[object, ...] = ()
"""What tells the file that was read from others."""


def plan(*arguments: Any, flags: tuple[str, ...], **options: Any) -> pyfftw.FFTW:
    """Make a plan of FFTW, from wisdom where there is some."""
    global _unsaved
    if "FFTW_MEASURE" in flags:
        with contextlib.suppress(RuntimeError):  # FFTW has no wisdom about this plan
            return pyfftw.FFTW(*arguments, flags=(*flags, "FFTW_WISDOM_ONLY"), **options)
        _unsaved = True
    return pyfftw.FFTW(*arguments, flags=flags, **options)


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


def has_unsaved_wisdom() -> bool:
    """Return whether this process may know plans that other processes would have to measure, and then choose others.

    Estimated plans are the same each time, with the same wisdom.
    """
    return _unsaved


def wisdom_file() -> Path:
    """Return the wisdom's file, in ``$FRETSOLVE_CACHE`` or in fretsolve's part of the user's cache folder."""
    folder: str | Path | None = os.environ.get("FRETSOLVE_CACHE")
    if folder is None:
        folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fretsolve"
    return Path(folder) / f"fftw-wisdom-{pyfftw.__version__}"


def load_wisdom() -> bool:
    """Give FFTW the measurements of earlier runs, unless it has them. Return False if none can be read."""
    global _known, _version, _unsaved
    before, _known = _known, None
    with contextlib.suppress(OSError, RuntimeError, FileError):
        path = wisdom_file()
        found = path.stat()
        version = path, found.st_ino, found.st_mtime_ns, found.st_size
        if before is not None and version == _version:
            _known = before
            return True
        # a hundred grids take some 100 kB
        _version, content = version, read_bytes(path, 2**26)
        parts = content.split(b"\0")
        if content == before or (len(parts) == 3 and all(pyfftw.import_wisdom(tuple(parts))[:2])):
            _known = content
    if _known is None:  # somebody has removed the file, or it is damaged
        _unsaved = _unsaved or before is not None
    return _known is not None


def save_wisdom() -> None:
    """Save what FFTW knows and what other processes have saved meanwhile. A cache that cannot be written is ignored."""
    global _known, _unsaved
    load_wisdom()
    _unsaved = False  # also where it cannot be written, or each increment would try again
    content = b"\0".join(pyfftw.export_wisdom())
    if content == _known:
        return
    with contextlib.suppress(OSError, RuntimeError):
        path = wisdom_file()
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_files.new_file(path, durable=False) as file:
            file.write(content)
        _known = content
