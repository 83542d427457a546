from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pyfftw
import pytest
from solving import build

from fretsolve import run
from fretsolve.elastic import convolution
from fretsolve.elastic import fftw as wisdom
from fretsolve.elastic.fftw import has_unsaved_wisdom, load_wisdom, save_wisdom, wisdom_file
from fretsolve.errors import GridEdgeError


@pytest.fixture
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("FRETSOLVE_CACHE", str(folder))
    return folder


@pytest.fixture
def no_wisdom():
    pyfftw.forget_wisdom()
    wisdom._known = None  # so that it is read again


def are_plans_measured(points: int) -> bool:
    """Return whether plans of a grid have to be measured."""
    wisdom._unsaved, padded = False, convolution.PaddedConvolution((points, points))
    field = np.ones(padded.shape)
    padded.apply(((padded.kernel_spectrum(field, False, False),),), [field], [field])
    return has_unsaved_wisdom()


@pytest.mark.usefixtures("no_wisdom")
def test_plans_are_measured_once():
    """So a run saves nothing where nothing is new: a long file would take as long as some increments."""
    assert are_plans_measured(160)
    assert not are_plans_measured(160)


@pytest.mark.usefixtures("no_wisdom")
def test_plans_of_a_run_that_failed_are_saved_with_the_next_state(cache):
    """Else a resumed run in another process would transform by other plans."""
    parts = {"grid": {"points": 130, "size": 0.4}, "load_path": [{"P": 400.0}]}
    with pytest.raises(GridEdgeError):
        list(run(build(**parts)))
    assert not wisdom_file().exists()
    next(run(build(**parts | {"load_path": [{"P": 1.0}]})))
    assert tuple(wisdom_file().read_bytes().split(b"\0")) == pyfftw.export_wisdom()
    wisdom_file().unlink()  # another process clears the cache
    next(run(build(**parts | {"load_path": [{"P": 1.0}]})))
    assert wisdom_file().exists()


def test_where_the_wisdom_is_kept(monkeypatch, tmp_path):
    monkeypatch.setenv("FRETSOLVE_CACHE", "/some/where")
    assert wisdom_file().parent == Path("/some/where")
    monkeypatch.delenv("FRETSOLVE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert wisdom_file().parent == tmp_path / "fretsolve"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", "/home/someone")
    assert wisdom_file().parent == Path("/home/someone/.cache/fretsolve")
    assert pyfftw.__version__ in wisdom_file().name


def test_there_and_back(cache):
    assert not load_wisdom()
    pyfftw.builders.fft(pyfftw.zeros_aligned(7 * 11 * 13, dtype="complex128"), planner_effort="FFTW_MEASURE")
    save_wisdom()
    assert [path.name for path in cache.iterdir()] == [wisdom_file().name]
    assert load_wisdom()


@pytest.mark.parametrize("content", [b"", b"\0\0", b"no wisdom at all", b"a\0b\0c", b"\xff\xfe\0(\0)", b"x" * 100_000])
def test_a_corrupt_file_is_harmless(cache, content):
    cache.mkdir()
    wisdom_file().write_bytes(content)
    load_wisdom()
    save_wisdom()
    assert wisdom_file().read_bytes() != content
    assert load_wisdom()


def test_a_folder_in_its_place_is_harmless(cache):
    wisdom_file().mkdir(parents=True)
    assert not load_wisdom()
    save_wisdom()
    assert wisdom_file().is_dir()
    assert [path for path in cache.iterdir() if path != wisdom_file()] == []


def test_a_cache_that_cannot_be_made_is_harmless(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("FRETSOLVE_CACHE", str(tmp_path / "file" / "cache"))
    assert not load_wisdom()
    save_wisdom()


def test_home_unknown(monkeypatch):
    """As for a service without a home: no cache, and no error."""
    monkeypatch.delenv("FRETSOLVE_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)

    def unknown():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(wisdom.Path, "home", unknown)
    assert not load_wisdom()
    save_wisdom()


def test_all_plans_are_kept_before_an_increment_is_given_out(cache, monkeypatch):
    """A resumed run must transform by the same plans, those too that were not needed until a later increment."""
    monkeypatch.setattr(convolution, "MOST_BATCHED_POINTS", 0)
    monkeypatch.setattr(wisdom, "LEAST_MEASURED", 0)
    path = [{"P": 400}, {"Qx": 30, "increments": 1}, {"P": 404, "increments": 1}]
    sizes = []
    for _ in run(build(grid={"points": 80, "size": 0.9}, load_path=path)):
        kept = tuple(wisdom_file().read_bytes().split(b"\0"))
        assert kept == pyfftw.export_wisdom()
        sizes.append(sum(map(len, kept)))
    assert sizes[0] < sizes[1]


def test_what_another_process_saved_meanwhile_is_kept(cache):
    """Its run may be resumed, and must then transform by the same plans."""
    plan = "import numpy, pyfftw; from fretsolve.elastic.fftw import load_wisdom, save_wisdom; load_wisdom();"
    plan += "pyfftw.FFTW(*2 * (pyfftw.zeros_aligned({0}, 'complex128'),), flags=('FFTW_MEASURE',));"
    first = subprocess.Popen([sys.executable, "-c", plan.format(7 * 11 * 13) + "input(); save_wisdom()"], stdin=-1)
    subprocess.run([sys.executable, "-c", plan.format(7 * 13 * 17) + "save_wisdom()"], check=True)
    other = wisdom_file().read_bytes()
    first.communicate(b"\n")
    both = wisdom_file().read_bytes()
    assert first.returncode == 0
    assert set(other.splitlines()) < set(both.splitlines())
