"""Processes that serve a sweep: copies of this one and new interpreters do the same."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from sweeping import write_sweep

import fretsolve
from fretsolve.sweep.manifest import write_manifest
from fretsolve.sweep.plan import make_plan

SERVING = Path(__file__).parents[2] / "serving.py"
KINDS = pytest.mark.parametrize("kind", ["copy", "new"])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    manifest = make_plan(write_sweep(tmp_path), tmp_path / "sweep.sweep").manifest
    write_manifest(manifest)
    return manifest.folder


def come_of(kind: str, action: str, folder: Path) -> tuple[list[object], str]:
    """Return what `tests/serving.py` prints, and its messages."""
    environment = os.environ | {"PYTHONPATH": str(Path(fretsolve.__file__).parents[1])}
    line = [sys.executable, str(SERVING), kind, action, str(folder)]
    done = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


@KINDS
def test_it_works_on_orders_until_they_end(kind: str, folder: Path) -> None:
    assert come_of(kind, "work", folder) == ([0, 0], "")
    assert len(list((folder / "results").glob("*.h5"))) == 1


@KINDS
def test_its_end_by_a_signal_is_told(kind: str, folder: Path) -> None:
    assert come_of(kind, "kill", folder)[0] == [0, "", -signal.SIGKILL]


@KINDS
def test_asked_to_stop_between_orders_it_has_been_stopped(kind: str, folder: Path) -> None:
    assert come_of(kind, "terminate", folder)[0] == [0, "", 75]


@KINDS
def test_one_whose_end_nobody_can_be_asked_for(kind: str, folder: Path) -> None:
    assert come_of(kind, "ignored", folder)[0] == [0, 0]


def test_the_end_of_orders_reaches_each_of_several_copies(folder: Path) -> None:
    assert come_of("copy", "several", folder)[0] == [0, 0, 0, 0, 0]


@KINDS
def test_what_is_wrong_is_told_and_nothing_else_done(kind: str, folder: Path) -> None:
    (folder / "manifest.json").unlink()
    (codes, messages) = come_of(kind, "missing manifest", folder)
    assert codes == [4]
    assert "manifest.json: cannot be read: No such file or directory" in messages
    assert "Traceback" not in messages


def test_a_process_with_several_threads_is_not_copied(folder: Path) -> None:
    linux = sys.platform == "linux"
    assert come_of("copy", "choose", folder)[0] == [linux, False, linux]
