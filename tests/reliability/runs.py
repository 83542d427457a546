"""Runs of `driver.py`, which stands in for ``fretsolve run``, as processes of their own."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from command_line import ended, start_python

from fretsolve.errors import FileError
from fretsolve.result import open_result


def start(out: Path, *flags: str, **values: float) -> subprocess.Popen[str]:
    """Start a run: ``start(out, "--resume", increments=40)``."""
    options = [f"--{name.replace('_', '-')}={value}" for name, value in values.items()]
    return start_python(Path(__file__).with_name("driver.py"), out, *flags, *options)


def finish(out: Path, *flags: str, **values: Any) -> tuple[int, str, str]:
    """Exit code, output and messages of a run that ends by itself."""
    return ended(start(out, *flags, **values))


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
