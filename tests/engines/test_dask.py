"""``fretsolve sweep run --on dask:ADDRESS`` on a real cluster: a worker that is killed costs nothing."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from command_line import PATIENCE, finish, start, start_python, wait_for
from small_cases import SWEPT
from sweeping import assert_as_serial, many_cases, workers, write_sweep

pytest.importorskip("distributed", reason="needs Dask: pip install '.[scale]'")

CASES = int(os.environ.get("FRETSOLVE_SWEEP_CASES", "8"))
SWEEP = many_cases(CASES)
CLUSTER = """\
import os, sys
from distributed import Client, LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, memory_limit=0) as cluster:
        with Client(cluster) as client:
            print(cluster.scheduler_address, *client.run(os.getpid).values(), flush=True)
        sys.stdin.read()
"""


@contextmanager
def cluster_in(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str, list[int]]]:
    """The process of a scheduler, its address, and the processes of its two workers."""
    script = folder / "cluster.py"
    script.write_text(CLUSTER)
    options = {"stdin": subprocess.PIPE, "stderr": subprocess.DEVNULL, "cwd": folder}
    with start_python(script, **options) as process:
        assert process.stdout is not None
        address, *pids = process.stdout.readline().split()
        yield process, address, [int(pid) for pid in pids]
        process.communicate()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, list[int]]]:
    with cluster_in(tmp_path_factory.mktemp("dask")) as (_, address, pids):
        yield address, pids


def wait_for_results(folder: Path, count: int, process: subprocess.Popen[str]) -> None:
    wait_for(lambda: len(list((folder / "results").glob("*.h5"))) >= count, process)


@pytest.mark.slow
def test_killed_worker(cluster: tuple[str, list[int]], tmp_path: Path) -> None:
    address, (victim, _) = cluster
    path = write_sweep(tmp_path, SWEEP, SWEPT.replace("increments: 2", "increments: 30"))
    folder = tmp_path / "sweep.sweep"
    with start("sweep", "run", path, "--on", f"dask:{address}") as process:
        wait_for_results(folder, 1, process)
        os.kill(victim, signal.SIGKILL)
        output, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, messages
    assert f"{CASES} cases: {CASES} complete" in output
    assert assert_as_serial(folder, tmp_path / "case.yaml") == CASES


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_tasks_end_with_the_command_that_gave_them_out(
    cluster: tuple[str, list[int]], tmp_path: Path, number: signal.Signals
) -> None:
    path = write_sweep(tmp_path, SWEEP, SWEPT.replace("increments: 2", "increments: 100"))
    folder = tmp_path / "sweep.sweep"
    with start("sweep", "run", path, "--on", f"dask:{cluster[0]}") as process:
        wait_for_results(folder, 1, process)
        process.send_signal(number)
        _, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode == (75 if number == signal.SIGTERM else -number), messages
    wait_for(lambda: not workers(folder))
    assert len(list((folder / "results").glob("*.h5"))) < CASES


@pytest.mark.skipif("FRETSOLVE_SWEEP_CASES" not in os.environ, reason="waits for the scheduler in vain; for long runs")
def test_scheduler_that_goes_away(tmp_path: Path) -> None:
    case = SWEPT.replace("increments: 2", "increments: 100").replace("points: 12", "points: 48")
    path, folder = write_sweep(tmp_path, SWEEP, case), tmp_path / "sweep.sweep"
    with (
        cluster_in(tmp_path) as (scheduler, address, _),
        start("sweep", "run", path, "--on", f"dask:{address}") as process,
    ):
        wait_for_results(folder, 1, process)
        scheduler.kill()
        _, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode == 4
    gone = "the scheduler has stopped answering; finished cases stay, and the same command goes on"
    assert messages.endswith(f"--on dask:{address}: {gone}\n")
    wait_for(lambda: not workers(folder))


def test_no_scheduler(tmp_path: Path) -> None:
    path = write_sweep(tmp_path, "case: case.yaml\naxes: [friction: [0.1]]\n")
    code, _, messages = finish("sweep", "run", path, "--on", "dask:nonsense://x")
    assert code == 2
    assert "--on dask:nonsense://x: no Dask scheduler answers" in messages
    assert "Traceback" not in messages
