"""A disk that is full: exit code 4 and one line, no crash, and the run goes on once there is room."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
from pathlib import Path

import pytest
from runs import finish, readable, reported, run_line

from fretsolve.result import open_result

RUN = {"increments": 12, "points": 40}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("reference") / "out.h5"
    assert finish(run_line(out, **RUN))[0] == 0
    return out


def limit_file_size(size: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.parametrize(
    ("share", "saved"), [(0.02, 0), (0.5, 12)], ids=["at the first increment", "at the result file"]
)
def test_limited_file_size(share: float, saved: int, uninterrupted: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.h5"
    size = int(share * uninterrupted.stat().st_size)
    code, output, messages = finish(run_line(out, **RUN), preexec_fn=lambda: limit_file_size(size))
    assert code == 4
    assert messages.count("\n") == 1
    assert messages.endswith("File too large; the increments so far are kept, --resume goes on\n")
    assert reported(output) == saved
    assert not out.exists()
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
    assert out.read_bytes() == uninterrupted.read_bytes()


@pytest.fixture()
def small_disk(tmp_path: Path) -> Path:
    """A folder on a file system of its own of 1 MiB, where the machine lets one mount it."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = shutil.which("mount")
    if mount is None or os.geteuid() != 0:
        pytest.skip("needs the right to mount a tmpfs")
    line = [mount, "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    if subprocess.run(line, capture_output=True, check=False).returncode != 0:
        pytest.skip("this machine lets no tmpfs be mounted")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_full_tmpfs(small_disk: Path, uninterrupted: Path) -> None:
    with open_result(uninterrupted) as result:
        expected = result.history["P"]
    out = small_disk / "out.h5"
    ballast = small_disk / "ballast"
    ballast.write_bytes(bytes(400_000))
    code, output, messages = finish(run_line(out, **RUN))
    assert code == 4
    assert messages.count("\n") == 1
    assert "No space left on device" in messages
    assert 0 < reported(output) <= readable(out, expected) < RUN["increments"]
    ballast.unlink()
    subprocess.run(["mount", "-o", "remount,size=8m", str(small_disk)], check=True)
    assert finish(run_line(out, "--resume", **RUN))[0] == 0
    assert out.read_bytes() == uninterrupted.read_bytes()
