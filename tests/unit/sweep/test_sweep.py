"""``fretsolve sweep``: the points of a sweep file, what is wrong with one, and running it on this machine."""

from __future__ import annotations

import csv
import os
import signal
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from command_line import PATIENCE, file_size_limit, finish, invoke, refused, start, wait_for
from small_cases import SWEPT
from sweeping import SWEEP, assert_as_serial, rows_of, workers, write_sweep

from fretsolve.result import open_result
from fretsolve.result.lock import RunLock
from fretsolve.result.parts import parts_folder
from fretsolve.sweep import slurm, worker_pool
from fretsolve.sweep.manifest import read_manifest, write_manifest
from fretsolve.sweep.plan import make_sweep_plan
from fretsolve.sweep.slurm import job_name
from fretsolve.sweep.table import collect

# Points


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sweep of six cases, of which one has no solution."""
    path = write_sweep(tmp_path_factory.mktemp("swept"), SWEEP + "quantities: [delta_x, P@1]\n")
    first = invoke("sweep", "run", path, "-j", 2)
    assert (first.exit_code, first.stderr) == (0, "")
    assert "6 cases of friction, load_path.0.P" in first.stdout
    assert first.stdout.splitlines()[-1] == "6 cases: 5 complete, 1 no solution"
    return path.with_name("sweep.sweep")


def test_sweep_is_run_once(swept: Path) -> None:
    assert assert_as_serial(swept, swept.with_name("case.yaml")) == 6
    before = {file: file.stat().st_mtime_ns for file in (swept / "results").iterdir()}
    again = invoke("sweep", "run", swept.with_name("sweep.yaml"))
    assert again.exit_code == 0
    assert "6 done already" in again.stdout
    assert {file: file.stat().st_mtime_ns for file in (swept / "results").iterdir()} == before
    told = invoke("sweep", "status", swept).stdout
    assert told.startswith("friction and load: 6 cases: 5 complete, 1 no solution\n0: friction=0.08, load_path.0.P=4")
    assert "gross slip" in told
    assert "--array" not in told


def test_what_a_sweep_cannot_collect_or_draw(swept: Path) -> None:
    before = set(swept.iterdir())
    told = refused(2, "sweep", "plot", swept, "--over", "energy_ratio@1")
    assert "no case has a value of energy_ratio@1" in told  # nor a cycle
    told = refused(2, "sweep", "plot", swept, "--over", "title")
    assert "--over title: neither a varied key (friction, load_path.0.P) nor a quantity" in told
    told = refused(2, "sweep", "plot", swept, "running-condition", "--quantity", "delta_x")
    assert told == f"{swept}: --quantity has no effect on running-condition; leave it out\n"
    told = refused(2, "sweep", "collect", swept, "-o", swept / "table.xls")
    assert "a name ending in .csv, .h5 or .parquet is needed" in told
    told = refused(2, "sweep", "collect", swept, "--quantity", "P@x")
    assert "there is no stage 'x'; one from 1 on is needed" in told
    for cases in ("6-7", "3,99", "3-99"):
        told = refused(2, "sweep", "work", swept, "--cases", cases)
        assert told == f"{swept}: --cases {cases}: there are the cases 0 to 5\n"
    for command in ("collect", "plot"):
        told = refused(2, "sweep", command, swept, "--quantity", "P@9")
        assert told == "--quantity P@9: there is no stage 9; the cases have stages 1 to 2\n"
    assert set(swept.iterdir()) == before


def test_pictures_of_a_sweep_are_named_after_their_quantity(swept: Path) -> None:
    outcome = invoke("sweep", "plot", swept)
    assert (outcome.exit_code, outcome.stdout) == (0, f"{swept / 'delta_x.png'}\n")
    outcome = invoke("sweep", "plot", swept, "--quantity", "P@1", "--over", "friction")
    assert (outcome.exit_code, outcome.stdout) == (0, f"{swept / 'P@1.png'}\n")


def test_sweep_is_collected(swept: Path, tmp_path: Path) -> None:
    (swept / "table.csv.0123456789abcdef.tmp").touch()  # as a kill leaves it
    assert invoke("sweep", "collect", swept, "--fields").exit_code == 0
    mine = tmp_path / "mine.csv"
    mine.write_text("mine")
    told = refused(2, "sweep", "collect", swept, "-o", mine)
    assert told == f"{mine}: exists: --overwrite replaces it, or give another name with -o\n"
    assert mine.read_text() == "mine"
    assert invoke("sweep", "collect", swept, "-o", mine, "--overwrite").exit_code == 0
    assert mine.read_text() == (swept / "table.csv").read_text()
    with (swept / "table.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["status"] for row in rows] == ["no solution"] + 5 * ["complete"]
    assert [row["running_condition"] for row in rows] == ["gross slip"] + 5 * ["partial slip"]
    assert [row["load_path.0.P (N)"] for row in rows] == 3 * ["400", "500"]
    assert rows[0]["delta_x (mm)"] == "" and float(rows[0]["P@1 (N)"]) == pytest.approx(400.0)
    with h5py.File(swept / "table.h5") as file:
        displacement = file["values/delta_x"][:]
        assert file["values/delta_x"].attrs["units"] == "mm"
        np.testing.assert_array_equal(file["settings/friction"][:], np.repeat([0.08, 0.1, 0.12], 2))
        assert np.isnan(displacement[0]) and (displacement[1:] > 0.0).all()
        last = file[f"results/{rows[5]['id']}"]
        assert last["history/delta_x"][-1] == displacement[5]
        assert last["fields/pressure"].shape == (3, 12, 12)


@pytest.mark.slow
def test_equal_cases_are_run_once(tmp_path: Path) -> None:
    path = write_sweep(tmp_path, "case: case.yaml\naxes:\n  - title: [a, b, c]\n  - grid.points: [8, '8']\n")
    assert invoke("sweep", "run", path).exit_code == 2  # text is no number of points
    path.write_text("case: case.yaml\naxes:\n  - title: [a, b, c]\n  - grid.points: [8, [8, 8]]\n")
    assert "6 cases of title, grid.points, 1 of them different" in invoke("sweep", "run", path).stdout
    assert len(list((tmp_path / "sweep.sweep" / "results").iterdir())) == 1


@pytest.mark.slow
def test_error_bars_corrected_values_and_common_settings(tmp_path: Path) -> None:
    sweep = """\
case: case.yaml
set: {load_path.*.increments: 2, grid.points: 16}
error_bars: true
quantities: [delta_x, delta_x_corrected]
axes: [friction: [0.1]]
"""
    path = write_sweep(tmp_path, sweep)
    outcome = invoke("sweep", "run", path, "-q", "-j", 1)
    assert (outcome.exit_code, outcome.output) == (0, "")
    table = collect(read_manifest(tmp_path / "sweep.sweep"))
    assert [outcome.increments for outcome in table.outcomes] == [4]
    (result,) = (tmp_path / "sweep.sweep").glob("results/*.h5")
    with open_result(result) as found:
        expected = [found.history[name][-1] for name in ("delta_x", "delta_x_corrected")]
        bars = [found.history[f"{name}_error"][-1] for name in ("delta_x", "delta_x_corrected")]
    assert [column.values[0] for column in table.found] == expected
    assert [column.values[0] for column in table.errors] == bars
    assert min(bars) > 0.0
    path.write_text(sweep.replace("error_bars: true\n", ""))
    refusal = invoke("sweep", "run", path, "-o", tmp_path / "other")
    assert refusal.exit_code == 2
    assert "sweep.yaml:3: quantities.1: delta_x_corrected is known from runs with error bars alone" in refusal.stderr


@pytest.mark.slow
def test_whatever_befalls_a_sweep_the_same_command_goes_on(tmp_path: Path) -> None:
    path = write_sweep(tmp_path, case=SWEPT.replace("increments: 2", "increments: 30"))
    folder = tmp_path / "sweep.sweep"

    code, output, messages = finish("sweep", "run", path, preexec_fn=file_size_limit(9000))
    assert code == 4
    assert "File too large" in messages
    assert "--resume" not in messages
    assert "Traceback" not in messages
    assert output.splitlines()[-1] == "6 cases: 6 error"
    told = invoke("sweep", "status", folder).stdout
    assert "error (exit code 4)" in told
    assert told.endswith("missing: --array=0-5\n")

    # Where the signals meet the cases does not matter here: all goes on from there.
    with start("sweep", "run", path, "-j", 1) as process:
        wait_for(lambda: workers(folder), process)
        for child in workers(folder):
            with suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
        process.send_signal(signal.SIGTERM)
        _, messages = process.communicate(timeout=PATIENCE)
    assert process.returncode in (0, 75), messages
    assert ("the same command goes on" in messages) == (process.returncode == 75)

    outcome = invoke("sweep", "run", path, "-q", "-j", 1)
    assert (outcome.exit_code, outcome.output) == (0, "")
    assert assert_as_serial(folder, tmp_path / "case.yaml") == 6
    assert not list((folder / "results").glob("*.note"))
    assert not list((folder / "results").glob("*.parts"))


def missing_of(folder: Path) -> list[int]:
    """The cases without a result."""
    return [row["index"] for row in rows_of(folder) if not (folder / row["result"]).exists()]


@pytest.mark.slow
def test_work_runs_the_cases_named(tmp_path: Path) -> None:
    path, folder = write_sweep(tmp_path), tmp_path / "sweep.sweep"
    write_manifest(make_sweep_plan(path, folder).manifest)
    outcome = invoke("sweep", "work", folder, "--cases", "4-5,1")
    assert (outcome.exit_code, outcome.stderr) == (0, "")
    assert missing_of(folder) == [0, 2, 3]
    (tmp_path / "case.yaml").write_text(SWEPT.replace("36 N", "20 N"))
    outcome = invoke("sweep", "work", folder, "--cases", "2-3")
    assert (outcome.exit_code, "has changed since the sweep began" in outcome.stderr) == (2, True)
    assert missing_of(folder) == [0, 2, 3]


def test_the_folder_of_another_sweep_is_not_taken(tmp_path: Path) -> None:
    first, folder = write_sweep(tmp_path), tmp_path / "sweep.sweep"
    write_manifest(make_sweep_plan(first, folder).manifest)
    before = (folder / "manifest.json").read_text()
    second = tmp_path / "second.yaml"
    second.write_text("case: case.yaml\naxes: [grid.points: [8]]\n")
    told = f"{folder}: holds the sweep of {first}; give another folder with -o, or remove this one\n"
    assert refused(2, "sweep", "run", second, "-o", folder) == told
    assert (folder / "manifest.json").read_text() == before
    first.write_text(second.read_text())  # edited, it is the same
    assert invoke("sweep", "run", first, "-q", "-j", 1).exit_code == 0
    first.rename(second)  # as it is under another name
    assert invoke("sweep", "run", second, "-q", "-o", folder).exit_code == 0


def test_a_sweep_and_a_study_do_not_share_a_folder(tmp_path: Path) -> None:
    path, folder, study = write_sweep(tmp_path), tmp_path / "sweep.sweep", tmp_path / "case.study"
    write_manifest(make_sweep_plan(path, folder).manifest)
    varied = ("study", tmp_path / "case.yaml", "--vary", "grid.points=8", "-q")
    assert refused(2, *varied, "-o", folder) == f"{folder}: holds a sweep; give another folder with -o\n"
    invoke(*varied)
    before = sorted(study.iterdir())
    assert refused(2, "sweep", "run", path, "-o", study) == f"{study}: holds a study; give another folder with -o\n"
    assert sorted(study.iterdir()) == before


def test_what_another_process_is_writing_stays(tmp_path: Path) -> None:
    path, folder = write_sweep(tmp_path), tmp_path / "sweep.sweep"
    folder.mkdir()
    theirs = folder / "manifest.json.0123456789abcdef.tmp"
    theirs.touch()
    write_manifest(make_sweep_plan(path, folder).manifest)
    assert theirs.exists()


def test_a_signal_during_the_check_ends_at_once(tmp_path: Path) -> None:
    many = "case: case.yaml\naxes: [friction: {from: 0.1, to: 0.2, count: 100000}]\n"
    path = write_sweep(tmp_path, many)
    for number, code in ((signal.SIGINT, -signal.SIGINT), (signal.SIGTERM, 75)):  # a shell has 130 for the first
        with start("sweep", "run", path) as process:
            wait_for(lambda process=process: catches(process.pid), process)
            process.send_signal(number)
            output, messages = process.communicate(timeout=PATIENCE)
        assert process.returncode == code
        assert output == ""
        assert messages == f"fretsolve: {number.name}: ended before anything was run\n"
        assert not (tmp_path / "sweep.sweep").exists()


def test_tasks_in_the_queue_count_by_the_cases_that_they_have(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, folder = write_sweep(tmp_path, SWEEP + "slurm: {cases_per_task: 2}\n"), tmp_path / "sweep.sweep"
    plan = make_sweep_plan(path, folder)
    write_manifest(plan.manifest)
    in_queue = [f"{job_name(plan.manifest, 3)} 0", "another 1", f"{job_name(plan.manifest, 1)} N/A"]
    asked: list[list[str]] = []

    def answered(line: list[str]) -> str:
        asked.append(line)
        return {"scontrol": "MaxArraySize = 1001", "squeue": "\n".join(in_queue), "sbatch": "7"}[line[0]]

    monkeypatch.setattr(slurm, "_slurm", answered)
    told = slurm.submit(plan, plan.manifest.rows, None)
    assert asked[-1][:3] == ["sbatch", "--parsable", "--array=1-2"]  # of 2-3 and 4-5, as 0-2 are in the queue
    assert told.endswith(", 1 more are in the queue")
    in_queue.append(f"{job_name(plan.manifest, 3)} 1")
    assert slurm.submit(plan, plan.manifest.rows, None) == "all 3 tasks that are missing are in the queue"


def test_the_script_is_written_without_slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    path = write_sweep(tmp_path, SWEEP + "slurm: {cases_per_task: 2}\n")
    script = tmp_path / "sweep.sweep" / "slurm" / "job.sh"
    done = invoke("sweep", "run", path, "--on", "slurm", "--dry-run", "-q")
    assert (done.exit_code, done.stdout, done.stderr) == (0, f"not submitted: sbatch --array=0-2 {script}\n", "")
    assert f"sweep work {script.parent.parent} --cases" in script.read_text()
    told = refused(2, "sweep", "run", path, "--on", "slurm", "-q")
    assert (
        told
        == "scontrol cannot be called (No such file or directory); Slurm's commands are needed here, or --dry-run\n"
    )
    assert "--dry-run goes with --on slurm" in refused(2, "sweep", "run", path, "--dry-run")


def test_more_tasks_than_slurm_takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slurm, "_slurm", lambda line: "MaxArraySize            = 2")
    path = write_sweep(tmp_path, SWEEP + "slurm:\n  cases_per_task: 2\n")
    assert invoke("sweep", "run", path, "--on", "slurm").stderr == (
        f"{path}:7: slurm.cases_per_task: the array needs tasks up to 2, this Slurm takes them up to 1 (MaxArraySize);"
        " 3 cases per task or more are needed\n"
    )


@pytest.mark.slow
def test_quiet_sweep_tells_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, folder = write_sweep(tmp_path, "case: case.yaml\naxes: [friction: [0.1]]\n"), tmp_path / "sweep.sweep"
    manifest = make_sweep_plan(path, folder).manifest
    write_manifest(manifest)
    result = manifest.result(manifest.rows[0])
    lock = RunLock.acquire(parts_folder(result))
    sleep = worker_pool.time.sleep
    monkeypatch.setattr(worker_pool, "time", SimpleNamespace(sleep=lambda seconds: (lock.release(), sleep(seconds))))
    outcome = invoke("sweep", "run", path, "-q", "-j", 1)
    assert (outcome.exit_code, outcome.stdout) == (0, "")
    assert outcome.stderr == "cases that other processes are running: 1; waiting for them\n"
    result.unlink()
    result.write_bytes(b"half of a file")
    told = refused(4, "sweep", "run", path, "-q")
    assert told.startswith(f"case 0: {result}: ")
    assert told.endswith("; remove it to run the case again\n")
    collected = invoke("sweep", "collect", folder)
    assert (collected.exit_code, collected.stderr) == (0, told)


def catches(pid: int) -> bool:
    """Return whether the process has a handler for SIGUSR1, as it has from the start of its work."""
    (line,) = (line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith("SigCgt:"))
    return bool(int(line.split()[1], 16) & 1 << (signal.SIGUSR1 - 1))
