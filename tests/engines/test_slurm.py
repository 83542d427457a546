"""``fretsolve sweep run --on slurm`` on a real Slurm: whatever befalls its tasks, the same command completes the sweep.

``FRETSOLVE_SWEEP_CASES=40`` runs more cases, and lets the disk be full and a task meet its time limit as well.
"""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from command_line import environment
from one_node_slurm import running_slurm, why_not
from pages import ROOT, blocks
from small_cases import SWEPT
from sweeping import assert_as_serial, many_cases, rows_of, workers, write_sweep

from fretsolve import open_result
from fretsolve.sweep.manifest import read_manifest
from fretsolve.sweep.slurm import job_name

CASES = int(os.environ.get("FRETSOLVE_SWEEP_CASES", "8"))
WHOLE = CASES >= 40
INCREMENTS = 30 if WHOLE else 500
"""They take a task long enough to be met at work."""
SWEEP = many_cases(CASES)
TASKS = "slurm: {cases_per_task: 4, memory: 400M, time: 5, warning: 30}\n"
SHARES = (1, 3, 4)
"""Cases per task in the sweeps of these tests."""

PATIENCE = 300.0
"""Seconds without any news, however long the whole takes on a machine that does other things as well."""

LONGER_THAN_A_TASK = 75.0
"""Seconds of the case that meets the time limit, whose tasks work for 25 s."""

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())


@pytest.fixture(scope="module")
def slurm() -> Iterator[dict[str, str]]:
    """The environment in which the commands of a running Slurm are found."""
    with ExitStack() as stack:
        folder = stack.enter_context(TemporaryDirectory(prefix="slurm-"))  # munge's user cannot enter pytest's own
        try:
            slurm = stack.enter_context(running_slurm(Path(folder)))
        except (RuntimeError, LookupError, OSError) as error:
            print(error)  # with all that its programs logged
            pytest.skip(f"Slurm does not start on this machine: {str(error).splitlines()[0]}")
        yield slurm | {"PYTHONPATH": environment()["PYTHONPATH"]}


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a file system of its own of 1 MiB, for the whole of the test."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if not WHOLE:
        yield folder
        return
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)], check=True)
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True)


def call(slurm: dict[str, str], *words: object) -> str:
    """Return what a command prints that must succeed."""
    done = subprocess.run([str(word) for word in words], env=slurm, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def sweep(slurm: dict[str, str], *words: object) -> str:
    return call(slurm, sys.executable, "-m", "fretsolve", "sweep", *words)


def running(slurm: dict[str, str], folder: Path) -> list[str]:
    """Tasks of the sweep that run, such as ``3_1``."""
    line = ("squeue", "--noheader", "--array", "--state=R", f"--name={names_of(folder)}")
    return call(slurm, *line, "--format=%F_%K").split()


def names_of(folder: Path) -> str:
    """Of the jobs of a sweep, for Slurm's ``--name``."""
    return ",".join(job_name(read_manifest(folder), count) for count in SHARES)


def wait_for(condition: Callable[[], object], news: Callable[[], object] = lambda: None) -> None:
    """Until `condition` holds; for `PATIENCE` from the start, and again from each change of `news`."""
    seen, end = news(), time.monotonic() + PATIENCE
    while not condition():
        if (found := news()) != seen:
            seen, end = found, time.monotonic() + PATIENCE
        assert time.monotonic() < end
        time.sleep(0.1)


def wait_until_empty(slurm: dict[str, str], folder: Path) -> None:
    """Until no task waits, runs or is about to run again, as long as results or increments of them are saved."""
    line = ("squeue", "--noheader", f"--name={names_of(folder)}")
    wait_for(lambda: not call(slurm, *line).strip(), lambda: sorted((folder / "results").glob("**/*.h5")))


@pytest.mark.slow
def test_tasks_cancelled_killed_and_signalled(slurm: dict[str, str], tmp_path: Path, small_disk: Path) -> None:
    case = SWEPT.replace("increments: 2", f"increments: {INCREMENTS}")
    path = write_sweep(tmp_path, SWEEP + TASKS, case)
    folder = small_disk / "sweep"

    assert "submitted job" in sweep(slurm, "run", path, "-o", folder, "--on", "slurm")
    assert "in the queue" in sweep(slurm, "run", path, "-o", folder, "--on", "slurm")
    path.write_text((SWEEP + TASKS).replace("cases_per_task: 4", "cases_per_task: 3"))
    assert "tasks that are missing are in the queue" in sweep(slurm, "run", path, "-o", folder, "--on", "slurm")
    path.write_text(SWEEP + TASKS)
    if WHOLE:
        let_the_disk_be_full(slurm, folder)
        sweep(slurm, "run", path, "-o", folder, "--on", "slurm")
    cancelled = a_task_at_work(slurm, path, folder)
    call(slurm, "scancel", cancelled)
    wait_for(lambda: cancelled not in running(slurm, folder))
    a_task_at_work(slurm, path, folder)
    os.kill(workers(folder)[0], signal.SIGKILL)
    wait_for(lambda: signalled(slurm, a_task_at_work(slurm, path, folder)))
    wait_until_empty(slurm, folder)

    for _ in range(3):
        if "missing" not in sweep(slurm, "status", folder):
            break
        sweep(slurm, "run", path, "-o", folder, "--on", "slurm")
        wait_until_empty(slurm, folder)
    assert f"{CASES} cases: {CASES} complete" in sweep(slurm, "run", path, "-o", folder)
    assert assert_as_serial(folder, tmp_path / "case.yaml") == CASES
    log = "".join(file.read_text() for file in (folder / "slurm").glob("*.log"))
    assert "Traceback" not in log
    assert "was ended by SIGKILL" in log
    assert "SIGUSR1" in log


def a_task_at_work(slurm: dict[str, str], path: Path, folder: Path) -> str:
    """A task that runs and has a process that solves; the sweep is submitted again where there is none."""

    def is_there() -> bool:
        if not running(slurm, folder):
            sweep(slurm, "run", path, "-o", folder, "--on", "slurm")
        return bool(running(slurm, folder) and workers(folder))

    wait_for(is_there)
    return running(slurm, folder)[0]


def signalled(slurm: dict[str, str], task: str) -> bool:
    """Return whether a task was there to be sent the signal that Slurm sends before the time limit."""
    line = ["scancel", "--batch", "--signal=USR1", task]
    return subprocess.run(line, env=slurm, capture_output=True, check=False).returncode == 0


def let_the_disk_be_full(slurm: dict[str, str], folder: Path) -> None:
    """Wait until all tasks have ended on it, and make room."""
    wait_for(lambda: list((folder / "results").glob("*.note")))
    wait_until_empty(slurm, folder)
    told = sweep(slurm, "status", folder)
    assert "No space left on device" in told
    assert "missing: --array=" in told
    subprocess.run(["mount", "-o", "remount,size=64m", str(folder.parent)], check=True)


@pytest.mark.skipif(not WHOLE, reason="takes a minute; FRETSOLVE_SWEEP_CASES=40 runs it")
def test_time_limit_is_met_by_a_requeue(slurm: dict[str, str], tmp_path: Path) -> None:
    limit = "slurm: {cases_per_task: 1, memory: 400M, time: 1, warning: 35}\naxes: [friction: [0.1]]\n"
    case = SWEPT.replace("points: 12", "points: 96")
    path = write_sweep(tmp_path, f"case: case.yaml\n{limit}", case)
    probe = ("run", tmp_path / "case.yaml", "--set", "load_path.1.increments=41", "-o", tmp_path / "probe.h5")
    call(slurm, sys.executable, "-m", "fretsolve", *probe)
    with open_result(tmp_path / "probe.h5") as result:
        seconds = float(result.history["wall_time"][1:].mean())
    increments = math.ceil(LONGER_THAN_A_TASK / seconds)
    (tmp_path / "case.yaml").write_text(case.replace("increments: 2", f"increments: {increments}"))
    folder = tmp_path / "sweep.sweep"
    for _ in range(10):  # a task that is too slow to save an increment in its time is not requeued
        sweep(slurm, "run", path, "--on", "slurm")
        wait_until_empty(slurm, folder)
        if "1 complete" in sweep(slurm, "status", folder):
            break
    assert "1 complete" in sweep(slurm, "status", folder)
    assert "SIGUSR1" in "".join(log.read_text() for log in (folder / "slurm").glob("*.log"))
    assert len(rows_of(folder)) == 1


@pytest.mark.skipif(not WHOLE, reason="FRETSOLVE_SWEEP_CASES=40 runs it")
def test_page_on_clusters_does_what_it_says(slurm: dict[str, str], tmp_path: Path) -> None:
    page = {block.file: block.text for block in blocks(ROOT / "docs" / "howto" / "clusters.md") if block.file}
    script = next(block.text for block in blocks(ROOT / "docs" / "howto" / "clusters.md") if "# job.sh" in block.text)
    (tmp_path / "press.yaml").write_text(SWEPT.replace("increments: 2", "increments: 200").replace(": 12", ": 48"))
    (tmp_path / "slurm_sweep.yaml").write_text(page["slurm_sweep.yaml"])
    (tmp_path / "job.sh").write_text(script)
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "fretsolve").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m fretsolve "$@"\n')
    (programs / "fretsolve").chmod(0o755)
    here = {**slurm, "PATH": f"{programs}:{slurm['PATH']}"}
    line = ["sbatch", "--parsable", f"--chdir={tmp_path}", f"--output={tmp_path}/log", str(tmp_path / "job.sh")]
    job = call(here, *line).strip()
    wait_for(lambda: list(tmp_path.glob("press.h5.parts/0*.h5")))
    call(here, "scancel", "--signal=USR1", job)
    wait_for(lambda: not call(here, "squeue", "--noheader", f"--jobs={job}").strip())
    assert "--resume" in (tmp_path / "log").read_text()
    told = call(here, "scontrol", "show", "job", job)
    assert "Restarts=1" in told
    assert "JobState=COMPLETED" in told
    with open_result(tmp_path / "press.h5") as result:
        assert (result.status, result.increments) == ("complete", 201)
