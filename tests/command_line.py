"""The command line, called in this process or as one of its own, and what it prints and writes."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner, Result

import fretsolve
from fretsolve import open_result
from fretsolve.cli.main import main

PATIENCE = 300.0
"""Seconds that a machine under load may take for what takes some seconds."""


def invoke(*words: object) -> Result:
    """``fretsolve WORDS...`` in this process; has `exit_code`, `stdout` and `stderr`."""
    return CliRunner().invoke(main, [str(word) for word in words], prog_name="fretsolve")


def result_of(case: Path, *words: object) -> Path:
    """Return the result of ``fretsolve run CASE -q WORDS...``, which ends well."""
    done = invoke("run", case, "-q", *words)
    assert done.exit_code == 0, done.output
    return case.with_suffix(".h5")


def refused(code: int, *words: object) -> str:
    """Return the message of ``fretsolve WORDS...``, which ends with exit code `code` and one line.

    `check`, which goes on with other cases, prints it below the name of the case.
    """
    result = invoke(*words)
    said = result.stderr
    if words[0] == "check" and not said:
        name, said, _ = result.stdout.splitlines(keepends=True)
        assert (name, said[:2]) == (f"{words[1]}\n", "  ")
        said = said[2:]
    else:
        assert result.stdout == ""
    assert (result.exit_code, said.count("\n")) == (code, 1), result.output
    return said


def start(*words: object, **options: Any) -> subprocess.Popen[str]:
    """``fretsolve WORDS...`` as a process."""
    return start_python("-m", "fretsolve", *words, **options)


def start_python(*words: object, **options: Any) -> subprocess.Popen[str]:
    """``python WORDS...`` as a process, with the package under test on its path."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment()} | options
    return subprocess.Popen([sys.executable, *map(str, words)], **options)


def finish(*words: object, **options: Any) -> tuple[int, str, str]:
    """Exit code, output and messages of ``fretsolve WORDS...``, run as a process."""
    with start(*words, **options) as process:
        return ended(process)


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Exit code, output and messages of a process that ends by itself."""
    output, messages = process.communicate(timeout=PATIENCE)
    return process.returncode, output, messages


def python(code: str, *words: object) -> str:
    """Return what ``python -c CODE WORDS...`` prints."""
    line = [sys.executable, "-c", code, *map(str, words)]
    return subprocess.run(line, env=environment(), capture_output=True, text=True, check=True).stdout


def environment() -> dict[str, str]:
    """Return the environment with the package under test on the path, installed or not."""
    package = str(Path(fretsolve.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))}


def file_size_limit(size: int) -> Callable[[], None]:
    """Return what a process calls at its start to write no file longer than `size` bytes."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def wait_for(condition: Callable[[], object], process: subprocess.Popen[str] | None = None) -> None:
    """Wait until `condition` holds, while `process` runs."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert process is None or process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def saved_steps(output: str) -> list[int]:
    """Return the increments that the lines of progress in `output` name."""
    words = [line.split() for line in output.splitlines() if line.startswith("step=")]
    return [int(word[0].removeprefix("step=")) for word in words]


def assert_same_result(one: Path, other: Path) -> None:
    """The same history and fields in every bit, but for the time that it took."""
    with open_result(one) as first, open_result(other) as second:
        assert first.status == second.status
        assert first.history.keys() == second.history.keys()
        for name in first.history.keys() - {"wall_time", "coarse_runs_wall_time"}:
            np.testing.assert_array_equal(first.history[name], second.history[name], err_msg=name)
        assert first.steps == second.steps
        for step in first.steps:
            for name in first.fields:
                np.testing.assert_array_equal(first.field(name, step), second.field(name, step), err_msg=name)
