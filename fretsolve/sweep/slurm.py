"""Slurm as the engine of a sweep: a job array. Each task runs some cases, and requeues itself if a signal stops it."""

from __future__ import annotations

import hashlib
import math
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Sequence

from fretsolve.errors import CaseError
from fretsolve.sweep.manifest import Manifest, ManifestRow, index_list
from fretsolve.sweep.plan import SweepPlan
from fretsolve.sweep.sweep_file import SlurmSpec
from fretsolve.system import atomic_files
from fretsolve.system.files import writing

FOLDER_NAME = "slurm"


def submit(plan: SweepPlan, todo: Sequence[ManifestRow], at_once: int | None, *, dry: bool = False) -> str:
    """Write the job script, and submit tasks for the cases `todo` that no task in the queue has.

    dry: submit nothing and ask Slurm for nothing. Returns what was done, for people. Raises CaseError if Slurm refuses,
    FileError.
    """
    manifest, spec = plan.manifest, plan.spec.slurm
    tasks = sorted({row.index // spec.cases_per_task for row in todo})
    if not dry:
        _require_allowed(max(tasks), plan)
    script = manifest.folder / FOLDER_NAME / "job.sh"
    with writing(script):
        script.parent.mkdir(exist_ok=True)
        atomic_files.write_text(script, script_text(manifest, spec))
    given = set() if dry else queued(manifest)
    new = sorted({row.index // spec.cases_per_task for row in todo if row.index not in given})
    if not new:
        return f"all {len(tasks)} tasks that are missing are in the queue"
    limit = at_once or spec.at_once
    array = index_list(new) + (f"%{limit}" if limit else "")
    line = f"sbatch --array={array} {shlex.quote(str(script))}"
    if dry:
        return f"not submitted: {line}"
    job = _slurm(["sbatch", "--parsable", f"--array={array}", str(script)]).strip().partition(";")[0]
    there = f", {len(tasks) - len(new)} more are in the queue" if len(new) < len(tasks) else ""
    return f"submitted job {job}: {line}{there}"


def requeue() -> None:
    """Have Slurm run the task of this process again, if it is one; print the error if Slurm refuses."""
    array, task = os.environ.get("SLURM_ARRAY_JOB_ID"), os.environ.get("SLURM_ARRAY_TASK_ID")
    # SLURM_JOB_ID of a task may name the whole array.
    job = f"{array}_{task}" if array and task else os.environ.get("SLURM_JOB_ID")
    if job is None:
        return
    try:
        _slurm(["scontrol", "requeue", job])
    except CaseError as error:
        print(error, file=sys.stderr)


def job_name(manifest: Manifest, cases_per_task: int) -> str:
    """Return the name of a sweep's job arrays whose tasks have so many cases each."""
    readable = re.sub(r"[^A-Za-z0-9_.-]", "-", manifest.folder.name)
    return f"{readable}-{hashlib.sha256(str(manifest.folder).encode()).hexdigest()[:8]}-{cases_per_task}"


def script_text(manifest: Manifest, spec: SlurmSpec) -> str:
    """Return the job script: the options of a task, and one command that replaces the shell."""
    folder = manifest.folder
    # A quarter more than the estimate for the largest case, and what the process takes that watches the solving one.
    memory = spec.memory or f"{math.ceil((1.25 * manifest.memory + 150e6) / 1e6)}M"
    options = [
        f"--job-name={job_name(manifest, spec.cases_per_task)}",
        f"--output={folder / FOLDER_NAME / '%A_%a.log'}",
        "--open-mode=append",
        "--requeue",
        "--ntasks=1",
        f"--cpus-per-task={manifest.threads}",
        f"--mem={memory}",
        f"--signal=B:USR1@{spec.warning}",
        *([f"--time={spec.time}"] if spec.time is not None else []),
        *spec.options,
    ]
    command = shlex.join([sys.executable, "-m", "fretsolve", "sweep", "work", str(folder)])
    per_task, last = spec.cases_per_task, len(manifest.rows) - 1
    lines = [
        "#!/bin/bash",
        f"# Runs cases of {folder}; a task that a signal stops requeues itself and goes on.",
        *(f"#SBATCH {shlex.quote(option)}" for option in options),
        *spec.setup,
        f"first=$((SLURM_ARRAY_TASK_ID * {per_task})) last=$((first + {per_task - 1}))",
        f'exec {command} --cases "$first-$((last < {last} ? last : {last}))" --requeue',
    ]
    return "\n".join(lines) + "\n"


def _require_allowed(last: int, plan: SweepPlan) -> None:
    match = re.search(r"^MaxArraySize\s*=\s*(\d+)", _slurm(["scontrol", "show", "config"]), re.MULTILINE)
    if match and last >= int(match[1]):
        least = math.ceil(len(plan.manifest.rows) / int(match[1]))
        raise plan.source.problem(
            f"the array needs tasks up to {last}, this Slurm takes them up to {int(match[1]) - 1} (MaxArraySize);"
            f" {least} cases per task or more are needed",
            ("slurm", "cases_per_task"),
        )


def queued(manifest: Manifest) -> set[int]:
    """Return the indices of the cases of all tasks of the sweep that wait, run or are about to run again."""
    ours = job_name(manifest, 0).removesuffix("0")
    found: set[int] = set()
    for line in _slurm(["squeue", "--noheader", "--array", f"--user={os.getuid()}", "--format=%j %K"]).splitlines():
        name, _, task = line.rpartition(" ")
        size = name.removeprefix(ours)
        if name.startswith(ours) and size.isdecimal() and task.isdecimal():
            found.update(range(int(task) * int(size), (int(task) + 1) * int(size)))
    return found


def _slurm(line: Sequence[str]) -> str:
    """Return what a command of Slurm prints. Raises CaseError with its message."""
    try:
        done = subprocess.run(line, capture_output=True, text=True, check=False)
    except OSError as error:
        raise CaseError(
            f"{line[0]} cannot be called ({error.strerror}); Slurm's commands are needed here, or --dry-run"
        ) from None
    if done.returncode:
        raise CaseError(f"{line[0]}: {' '.join(done.stderr.split()) or f'exit code {done.returncode}'}")
    return done.stdout
