from __future__ import annotations

import errno
import os
import subprocess
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from solving import build

from fretsolve import run
from fretsolve.elastic import convolution, fftw
from fretsolve.elastic.fftw import CacheBlock, cache_folder, plan, pyfftw
from fretsolve.system.files import read_bytes

LINES = (2, 6)


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("FRETSOLVE_CACHE", str(folder))
    monkeypatch.setattr(fftw, "_known", {})
    return folder


class Process:
    """Plans as another process makes them, which knows nothing but the cache."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch):
        self.measured = 0
        self._monkeypatch, self._make = monkeypatch, pyfftw.FFTW
        monkeypatch.setattr(pyfftw, "FFTW", self._count)

    def _count(self, *arguments: Any, **options: Any) -> pyfftw.FFTW:
        made = self._make(*arguments, **options)
        self.measured += {"FFTW_MEASURE", "FFTW_WISDOM_ONLY"} & {*options["flags"]} == {"FFTW_MEASURE"}
        return made

    def measures(self, lines: tuple[int, int] = LINES) -> int:
        """Return how many plans the process measures for a transform; its values are checked."""
        self._monkeypatch.setattr(fftw, "_known", {})
        self.measured = 0
        check_transform(lines)
        return self.measured


@pytest.fixture
def process(cache: Path, monkeypatch: pytest.MonkeyPatch) -> Process:
    return Process(monkeypatch)


def check_transform(lines: tuple[int, int] = LINES) -> None:
    """Check a measured transform in place by its definition."""
    values = pyfftw.zeros_aligned(lines, np.complex128)
    made = plan(values, values, axes=(1,), flags=("FFTW_MEASURE",))
    values[:] = np.arange(values.size).reshape(lines) ** 2 + 3j
    numbers = np.arange(lines[1])
    wanted = values @ np.exp(-2j * np.pi * np.outer(numbers, numbers) / lines[1])
    made.execute()
    np.testing.assert_allclose(values, wanted, atol=1e-9)


def the_file(cache: Path) -> Path:
    (file,) = cache.iterdir()
    return file


def test_a_plan_is_measured_once(process: Process, cache: Path) -> None:
    """And whoever needs another plan does not read it."""
    assert [process.measures(), process.measures()] == [1, 0]
    wisdom = zlib.decompress(the_file(cache).read_bytes(), wbits=31)
    assert wisdom.startswith(b"(fftw-3")
    assert wisdom.count(b"codelet") >= 1
    assert process.measures((2, 10)) == 1
    assert len(list(cache.iterdir())) == 2
    assert (process.measures(), process.measures((2, 10))) == (0, 0)


def test_estimated_plans_neither_read_nor_write(cache: Path) -> None:
    block = CacheBlock((4, 8), np.dtype(np.complex128))
    block.source[:] = 1.0
    block.forward()
    assert block.target[0, 0] == 8.0
    assert not cache.exists()


def test_estimated_plans_do_not_depend_on_measured_ones(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Such as another run of the process has made: they would be taken for estimated ones."""
    shape, kind = (32, 192), np.dtype(np.complex128)
    values = np.exp(1j * np.arange(32 * 192.0)).reshape(shape)

    def transformed() -> bytes:
        block = CacheBlock(shape, kind)
        block.source[:] = values
        block.forward()
        return bytes(block.target.tobytes())

    before = transformed()
    with monkeypatch.context() as measuring:
        measuring.setattr(fftw, "LEAST_MEASURED", 0)
        transformed()
    assert len(list(cache.iterdir())) == 2
    assert transformed() == before


def test_every_damage_of_a_file_is_mended(process: Process, cache: Path) -> None:
    """A flipped bit in FFTW's text could end the process inside FFTW."""
    process.measures()
    file = the_file(cache)
    whole = file.read_bytes()
    for place in range(len(whole)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        file.write_bytes(damaged)
        # a few bits of the header, as the time, mean nothing, and the content is whole
        assert process.measures() == 1 or 4 <= place < 10
        assert zlib.decompress(file.read_bytes(), wbits=31).startswith(b"(fftw-3")
    for length in range(0, len(whole), 10):
        file.write_bytes(whole[:length])
        assert process.measures() == 1
        assert process.measures() == 0


def test_whole_files_of_other_content_are_replaced(process: Process, cache: Path) -> None:
    process.measures()
    file = the_file(cache)
    wisdom = zlib.decompress(file.read_bytes(), wbits=31)
    digest = wisdom.split()[2]
    other_processor = wisdom.replace(digest, digest[:-1] + (b"0" if digest[-1:] != b"0" else b"1"))
    assert process.measures((2, 15)) == 1
    (longer,) = (path for path in cache.iterdir() if path != file)
    other_plan = zlib.decompress(longer.read_bytes(), wbits=31)
    for content in (b"", b"no wisdom", b"(fftw-3.3.5 fftw_wisdom)", b"\0" * 10**6, other_processor, other_plan):
        file.write_bytes(zlib.compress(content, wbits=31))
        assert process.measures() == 1
        assert zlib.decompress(file.read_bytes(), wbits=31).startswith(wisdom.partition(b"\n")[0])
        assert process.measures() == 0


def test_what_is_no_file_is_replaced_or_left(process: Process, cache: Path) -> None:
    process.measures()
    file = the_file(cache)
    for make in (os.mkfifo, lambda path: path.symlink_to("/dev/zero"), lambda path: path.write_bytes(bytes(10**6))):
        file.unlink()
        make(file)
        assert process.measures() == 1
        assert process.measures() == 0
        assert the_file(cache) == file
        assert not file.is_symlink()
    file.unlink()
    file.mkdir()
    assert [process.measures(), process.measures()] == [1, 1]
    assert the_file(cache).is_dir()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_a_file_that_may_not_be_read_is_replaced(process: Process, cache: Path) -> None:
    process.measures()
    the_file(cache).chmod(0)
    assert [process.measures(), process.measures()] == [1, 0]


def test_a_cache_that_cannot_be_kept(process: Process, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All threads of a run share the plans in it, or its bits would depend on their number."""
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("FRETSOLVE_CACHE", str(tmp_path / "file" / "cache"))
    assert process.measures() == 1
    check_transform()
    assert process.measured == 1


def test_a_cache_that_is_cleared_is_written_anew(process: Process, cache: Path) -> None:
    """By the plans of the process, since a run of it may be resumed by another."""
    process.measures()
    whole = the_file(cache).read_bytes()
    the_file(cache).unlink()
    check_transform()
    assert process.measured == 1
    assert the_file(cache).read_bytes() == whole


def test_the_first_of_two_processes_counts(process: Process, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its run may be resumed, and so may the other one's; both must then transform by the same plan."""
    process.measures()
    first = the_file(cache).read_bytes()
    monkeypatch.setattr(fftw, "_known", {})
    found = iter([None])  # before the first process has written its file
    monkeypatch.setattr(fftw, "_read", lambda name, read=fftw._read: read(name) if next(found, True) else None)
    check_transform()
    assert the_file(cache).read_bytes() == first
    (known,) = fftw._known.values()
    assert known == zlib.decompress(first, wbits=31)


def test_where_the_cache_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("FRETSOLVE_CACHE", "/some/where")
    assert cache_folder() == Path("/some/where")
    monkeypatch.delenv("FRETSOLVE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "fretsolve"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "/home/someone")
    assert cache_folder() == Path("/home/someone/.cache/fretsolve")


def test_home_unknown(process: Process, monkeypatch: pytest.MonkeyPatch) -> None:
    """As for a service without a home: no cache, and no error."""
    monkeypatch.delenv("FRETSOLVE_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)

    def unknown() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(fftw.Path, "home", unknown)
    assert process.measures() == 1


def test_a_resumed_run_transforms_by_the_same_plans(
    process: Process, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those too that were not needed until a later increment. Before a state is given out its plans are kept."""
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", 0)
    monkeypatch.setattr(fftw, "LEAST_MEASURED", 0)
    path = [{"P": 400}, {"Qx": 30, "increments": 1}, {"P": 404, "increments": 1}]
    case = build(grid={"points": 40, "size": 0.9}, load_path=path)
    process.measured, states, kept = 0, [], []
    for state in run(case):
        states.append(state)
        kept.append(len(list(cache.iterdir())))
        assert kept[-1] == process.measured
    assert 0 < kept[0] < kept[1]
    monkeypatch.setattr(fftw, "_known", {})
    process.measured = 0
    again = list(run(case, start=states[0], history=[states[0].summary]))
    assert process.measured == 0
    for one, other in zip(states[1:], again, strict=True):
        assert one.fields.pressure.tobytes() == other.fields.pressure.tobytes()
        assert one.fields.shear.tobytes() == other.fields.shear.tobytes()


def test_threads_may_plan_at_once() -> None:
    """FFTW's wisdom is one for all threads, and its planner is not made for several."""
    code = """\
from concurrent.futures import ThreadPoolExecutor
import numpy as np
from fretsolve.elastic.fftw import CacheBlock
def transformed(size):
    block = CacheBlock((3, size), np.dtype(complex))
    block.source[:] = np.arange(3 * size).reshape(3, size)
    expected = np.fft.fft(block.source, axis=1)
    block.forward()
    return bool(np.allclose(block.target, expected))
with ThreadPoolExecutor(4) as threads:
    print(all(threads.map(transformed, [*range(20, 60)] * 6)))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "True\n"), done.stderr


@pytest.mark.parametrize("number", [errno.EMFILE, errno.EIO, errno.ESTALE])
def test_a_plan_that_cannot_be_read_this_time_stays(
    number: int, process: Process, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A resumed run must transform by the plan that the run began with, so the second try at its file counts."""
    process.measures()
    before = the_file(cache).stat()

    def fails_once(path: Path, most: int) -> bytes:
        monkeypatch.setattr(fftw, "read_bytes", read_bytes)
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(fftw, "read_bytes", fails_once)
    process.measures()
    assert the_file(cache).stat().st_ino == before.st_ino
    assert process.measures() == 0
