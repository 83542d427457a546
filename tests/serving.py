"""Has processes serve a sweep and prints what came of it, for tests: ``python serving.py KIND ACTION FOLDER``.

A process of its own, since a copy may be made of one thread alone and pytest's workers have several.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from pathlib import Path

from fretsolve.sweep import process
from fretsolve.sweep.manifest import Manifest, read_manifest
from fretsolve.sweep.process import ServingProcess


def order(serving: ServingProcess, manifest: Manifest, index: int) -> int:
    """The exit code in the report on a case."""
    serving.orders.write(f"{index} {manifest.rows[index].id}\n")
    serving.orders.flush()
    return int(json.loads(serving.reports.readline())["code"])


def end(serving: ServingProcess) -> int:
    serving.orders.close()
    serving.reports.close()
    return serving.wait()


def started(kind: str, folder: Path, *others: ServingProcess) -> ServingProcess:
    return process.copy(folder, others) if kind == "copy" else process.new(folder)


def pid_of(manifest: Manifest, index: int) -> int:
    """The process that has worked on a case whose lock something keeps from being removed."""
    lock = manifest.result(manifest.rows[index]).with_name(manifest.rows[index].id + ".h5.parts") / "lock"
    return int(lock.read_text().split()[1])


def keep_lock(manifest: Manifest, index: int) -> None:
    """Of a case, after its end."""
    folder = manifest.result(manifest.rows[index]).with_name(manifest.rows[index].id + ".h5.parts")
    folder.mkdir()
    (folder / "kept").touch()


def act(kind: str, action: str, folder: Path) -> list[object]:
    if action == "missing manifest":
        return [end(started(kind, folder))]
    manifest = read_manifest(folder)
    if action == "choose":
        found = [process.is_alone()]
        gate = threading.Event()
        other = threading.Thread(target=gate.wait)
        other.start()
        found.append(process.is_alone())
        gate.set()
        other.join()
        return [*found, process.is_alone()]
    serving = started(kind, folder)
    if action == "work":
        return [order(serving, manifest, 2), end(serving)]
    if action == "ignored":
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)
        return [order(serving, manifest, 2), end(serving)]
    if action == "several":
        second = started(kind, folder, serving)
        codes = [order(serving, manifest, 2), order(second, manifest, 3), end(serving)]  # would wait if second held it
        third = started(kind, folder, serving, second)
        return [*codes, end(second), end(third)]
    keep_lock(manifest, 3)
    code = order(serving, manifest, 3)
    os.kill(pid_of(manifest, 3), signal.SIGKILL if action == "kill" else signal.SIGTERM)
    return [code, serving.reports.readline(), end(serving)]


if __name__ == "__main__":
    print(json.dumps(act(sys.argv[1], sys.argv[2], Path(sys.argv[3]))))
