"""``fretsolve sweep run --on dask:ADDRESS`` on a real cluster: a worker that is killed costs nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import finish, start
from small_cases import SWEPT
from sweeping import assert_as_serial, workers, write_sweep

import fretsolve

pytest.importorskip("distributed", reason="needs Dask: pip install '.[scale]'")

CASES = int(os.environ.get("FRETSOLVE_SWEEP_CASES", "8"))
SWEEP = f"""\
case: case.yaml
axes:
  - friction: {{from: 0.1, to: 0.2, count: {CASES // 4}}}
  - load_path.0.P: [390 N, 400 N, 410 N, 420 N]
"""
PATIENCE = 300.0
CLUSTER = """\
import os, sys
from distributed import Client, LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, memory_limit=0) as cluster:
        with Client(cluster) as client:
            print(cluster.scheduler_address, *client.run(os.getpid).values(), flush=True)
        sys.stdin.read()
"""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, list[int]]]:
    """The address of a scheduler, and the processes of its two workers."""
    path = tmp_path_factory.mktemp("dask") / "cluster.py"
    path.write_text(CLUSTER)
    package = str(Path(fretsolve.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))}
    pipe = subprocess.PIPE
    line = [sys.executable, str(path)]
    with subprocess.Popen(
        line, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True, env=environment, cwd=path.parent
    ) as process:
        assert process.stdout is not None
        address, *pids = process.stdout.readline().split()
        yield address, [int(pid) for pid in pids]
        process.communicate()


def wait_for_results(folder: Path, count: int, process: subprocess.Popen[str]) -> None:
    end = time.monotonic() + PATIENCE
    while len(list((folder / "results").glob("*.h5"))) < count:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.05)


def test_signal_then_killed_worker(cluster: tuple[str, list[int]], tmp_path: Path) -> None:
    address, (victim, _) = cluster
    path = write_sweep(tmp_path, SWEEP, SWEPT.replace("increments: 2", "increments: 30"))
    folder = tmp_path / "sweep.sweep"
    line = ("sweep", "run", path, "--on", f"dask:{address}")
    with start(*line) as process:
        wait_for_results(folder, 1, process)
        process.send_signal(signal.SIGTERM)
        _, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode in (0, 75), messages
    there = len(list((folder / "results").glob("*.h5")))
    with start(*line) as process:
        wait_for_results(folder, min(there + 1, CASES), process)
        os.kill(victim, signal.SIGKILL)
        output, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, messages
    assert f"{CASES} cases: {CASES} complete" in output
    assert assert_as_serial(folder, tmp_path / "case.yaml") == CASES


def test_tasks_end_with_the_command_that_gave_them_out(cluster: tuple[str, list[int]], tmp_path: Path) -> None:
    path = write_sweep(tmp_path, SWEEP, SWEPT.replace("increments: 2", "increments: 100"))
    folder = tmp_path / "sweep.sweep"
    with start("sweep", "run", path, "--on", f"dask:{cluster[0]}") as process:
        wait_for_results(folder, 1, process)
        process.kill()
        process.communicate(timeout=PATIENCE)
    end = time.monotonic() + PATIENCE
    while workers(folder):
        assert time.monotonic() < end
        time.sleep(0.1)
    assert len(list((folder / "results").glob("*.h5"))) < CASES


@pytest.mark.skipif("FRETSOLVE_SWEEP_CASES" not in os.environ, reason="waits for the scheduler in vain; for long runs")
def test_scheduler_that_goes_away(tmp_path: Path) -> None:
    case = SWEPT.replace("increments: 2", "increments: 100").replace("points: 12", "points: 48")
    path, folder = write_sweep(tmp_path, SWEEP, case), tmp_path / "sweep.sweep"
    script = tmp_path / "cluster.py"
    script.write_text(CLUSTER)
    pipe = subprocess.PIPE
    line = [sys.executable, str(script)]
    with subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True) as scheduler:
        assert scheduler.stdout is not None
        address = scheduler.stdout.readline().split()[0]
        with start("sweep", "run", path, "--on", f"dask:{address}") as process:
            wait_for_results(folder, 1, process)
            scheduler.kill()
            _, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode == 4
    gone = "the scheduler has stopped answering; finished cases stay, and the same command goes on"
    assert messages.endswith(f"--on dask:{address}: {gone}\n")
    end = time.monotonic() + PATIENCE
    while workers(folder):
        assert time.monotonic() < end
        time.sleep(0.1)


def test_no_scheduler(tmp_path: Path) -> None:
    path = write_sweep(tmp_path, "case: case.yaml\naxes: [friction: [0.1]]\n")
    code, _, messages = finish("sweep", "run", path, "--on", "dask:nonsense://x")
    assert code == 2
    assert "--on dask:nonsense://x: no Dask scheduler answers" in messages
    assert "Traceback" not in messages
