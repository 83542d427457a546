"""Starts runs as processes of their own. `run_line` is the one place that names the command."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import fretsolve
from fretsolve.errors import FileError
from fretsolve.result import open_result


def run_line(out: Path, *flags: str, **values: float) -> list[str]:
    """Command line of a run: ``run_line(out, "--resume", increments=40)``."""
    driver = Path(__file__).with_name("driver.py")
    options = [f"--{name.replace('_', '-')}={value}" for name, value in values.items()]
    return [sys.executable, str(driver), str(out), *flags, *options]


def start(line: list[str], **options: object) -> subprocess.Popen[str]:
    """Start a command with the package under test on its path, installed or not."""
    path = os.pathsep.join(filter(None, [str(Path(fretsolve.__file__).parents[1]), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, "PYTHONPATH": path}
    pipe = subprocess.PIPE
    return subprocess.Popen(line, stdout=pipe, stderr=pipe, text=True, env=environment, **options)


def finish(line: list[str], **options: object) -> tuple[int, str, str]:
    """Exit code, output and messages of a command that ends by itself."""
    process = start(line, **options)
    output, messages = process.communicate(timeout=120)
    return process.returncode, output, messages


def reported(output: str) -> int:
    """Return how many increments a run told to be saved, those before a resume included."""
    steps = [int(line.split()[1]) for line in output.splitlines() if line.startswith("increment ")]
    return steps[-1] + 1 if steps else 0


def readable(out: Path, expected: np.ndarray) -> int:
    """Return how many increments can be read; checks that their column `P` and their fields are right."""
    try:
        result = open_result(out)
    except FileError:
        return 0
    with result:
        np.testing.assert_array_equal(result.history["P"], expected[: result.increments])
        for step in result.steps:
            for name in result.fields:
                result.field(name, step)
        return result.increments
