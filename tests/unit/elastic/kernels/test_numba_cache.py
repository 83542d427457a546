"""Damage in the cache of compiled kernels costs a compilation, never a run or a number."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

import pytest

from fretsolve.elastic import kernels

numba = pytest.importorskip("numba")
numba_compiler = pytest.importorskip("fretsolve.elastic.kernels.numba_compiler")


def threefold(value: float) -> float:
    """Return three times the number."""
    return 3.0 * value


@pytest.fixture()
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def taken_from_disk() -> bool:
    """Call a kernel as a new process does, and return whether it was taken from the cache."""
    compiled = numba_compiler.compiled_form(threefold, {})
    assert compiled(2.0) == 6.0
    return sum(compiled.stats.cache_hits.values()) == 1


def spoil(path: Path, how: str) -> None:
    content = bytearray(path.read_bytes())
    path.unlink()
    match how:
        case "bit":
            content[random.Random(1).randrange(len(content))] ^= 4
            path.write_bytes(content)
        case "cut":
            path.write_bytes(content[: len(content) // 10])
        case "pipe":
            os.mkfifo(path)
        case "folder":
            path.mkdir()


@pytest.mark.parametrize("how", ["bit", "cut", "pipe", "folder", "gone"])
@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_damage_costs_a_compilation(folder: Path, ending: str, how: str) -> None:
    assert not taken_from_disk()
    assert taken_from_disk()
    (path,) = folder.rglob(f"*.{ending}")
    spoil(path, how)
    assert not taken_from_disk()
    assert taken_from_disk() is (how != "folder")  # which cannot be replaced


def test_a_cache_that_cannot_be_written_any_more(folder: Path) -> None:
    compiled = numba_compiler.compiled_form(threefold, {})
    for path in folder.iterdir():
        shutil.rmtree(path)
        path.write_text("in the way")
    assert compiled(2.0) == 6.0


def test_a_cache_as_numba_writes_it_is_not_trusted(folder: Path) -> None:
    numba.njit(cache=True)(threefold)(2.0)
    assert not taken_from_disk()
    assert taken_from_disk()


def test_kernels_are_compiled_again_when_a_module_has_changed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kernel holds the constants of other modules."""
    assert not taken_from_disk()
    assert taken_from_disk()
    stamp = numba_compiler._stamp_of_kernels()
    assert {"cg.py", "compiling.py"} <= {name for name, *_ in stamp}
    monkeypatch.setattr(numba_compiler, "_stamp_of_kernels", lambda: stamp[1:])
    assert not taken_from_disk()


def test_a_compilation_is_told_once_and_none_from_disk(folder: Path) -> None:
    told: list[str] = []
    kernels.when_compiling(lambda: told.append("compiling"))
    assert not taken_from_disk()
    assert told == ["compiling"]
    kernels.when_compiling(lambda: told.append("again"))
    assert taken_from_disk()
    assert told == ["compiling"]
