"""Processes that serve a sweep: copies of this one and new interpreters do the same."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
from pathlib import Path

import pytest
from sweeping import write_sweep

from fretsolve.sweep import process
from fretsolve.sweep.manifest import Manifest, write_manifest
from fretsolve.sweep.plan import make_plan
from fretsolve.sweep.process import ServingProcess


@pytest.fixture
def manifest(tmp_path: Path) -> Manifest:
    found = make_plan(write_sweep(tmp_path), tmp_path / "sweep.sweep").manifest
    write_manifest(found)
    return found


def started(manifest: Manifest, kind: str, *others: ServingProcess) -> ServingProcess:
    if kind == "copy":
        return process._copy(manifest.folder, others)
    return process._new(manifest.folder)


def order(serving: ServingProcess, manifest: Manifest, index: int) -> dict[str, object]:
    serving.orders.write(f"{index} {manifest.rows[index].id}\n")
    serving.orders.flush()
    return json.loads(serving.reports.readline())


def end(serving: ServingProcess) -> int:
    serving.orders.close()
    serving.reports.close()
    return serving.wait()


@pytest.mark.parametrize("kind", ["copy", "new"])
def test_it_works_on_orders_until_they_end(manifest: Manifest, kind: str) -> None:
    serving = started(manifest, kind)
    report = order(serving, manifest, 2)
    assert (report["index"], report["code"], report["increments"]) == (2, 0, 3)
    assert manifest.result(manifest.rows[2]).exists()
    assert end(serving) == 0


@pytest.mark.parametrize("kind", ["copy", "new"])
def test_its_end_is_told(manifest: Manifest, kind: str) -> None:
    serving = started(manifest, kind)
    number = int(order_for_its_number(serving, manifest))
    os.kill(number, signal.SIGKILL)
    assert serving.reports.readline() == ""
    assert end(serving) == -signal.SIGKILL


def order_for_its_number(serving: ServingProcess, manifest: Manifest) -> str:
    """The number of the process, from the lock that it holds while it works."""
    lock = manifest.result(manifest.rows[3]).with_name(manifest.rows[3].id + ".h5.parts") / "lock"
    lock.parent.mkdir()
    os.mkfifo(lock.with_name("gate"))  # keeps the folder, so that its lock stays to be read
    order(serving, manifest, 3)
    return lock.read_text().split()[1]


def test_the_end_of_orders_reaches_each_of_several_copies(manifest: Manifest) -> None:
    first = started(manifest, "copy")
    second = started(manifest, "copy", first)
    assert order(first, manifest, 2)["code"] == order(second, manifest, 3)["code"] == 0
    assert end(first) == 0  # it would wait for ever if the second held its orders open
    third = started(manifest, "copy", first, second)
    assert end(second) == end(third) == 0


def test_a_copy_says_what_is_wrong_and_does_not_go_on_as_its_parent(
    manifest: Manifest, capfd: pytest.CaptureFixture[str]
) -> None:
    (manifest.folder / "manifest.json").unlink()
    assert end(started(manifest, "copy")) == 4
    assert "manifest.json: cannot be read: No such file or directory" in capfd.readouterr().err


def test_a_copy_is_made_only_where_it_is_safe(manifest: Manifest, monkeypatch: pytest.MonkeyPatch) -> None:
    lines: list[list[str]] = []

    class Started(subprocess.Popen[str]):
        def __init__(self, line: list[str], **options: object) -> None:
            lines.append(line)
            super().__init__(["true"], **options)  # type: ignore[call-overload]

    monkeypatch.setattr(subprocess, "Popen", Started)
    gate = threading.Event()
    other = threading.Thread(target=gate.wait)
    other.start()
    try:
        assert end(process.start(manifest.folder, [])) == 0
    finally:
        gate.set()
        other.join()
    assert [line[-2:] for line in lines] == [["serve", str(manifest.folder)]]
    if process.sys.platform == "linux" and threading.active_count() == 1:
        assert end(process.start(manifest.folder, [])) == 0
        assert len(lines) == 1
