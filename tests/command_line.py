"""Small cases, and the command line called on them: in this process, or as one of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner, Result

import fretsolve
from fretsolve import open_result
from fretsolve.cli.main import main

CASE = """\
title: tiny
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
  - {young_modulus: 200 GPa, poisson_ratio: 0.3}
surface: {sphere: {radius: 10 mm}}
grid: {points: 16}
friction: 0.1
load_path:
  - {P: 400 N, increments: 1}
  - {Qx: 20 N, increments: 4}
expect:
  - {quantity: delta_z, value: 9.066544 um, rel: 1 %}
  - {quantity: Qx, value: 0 N, abs: 1e-6 N, stage: 1}
"""

LONG = """\
title: long
bodies:
  - {young_modulus: 200 GPa, poisson_ratio: 0.06}
  - {young_modulus: 200 GPa, poisson_ratio: 0.42}
surface: {sphere: {radius: 10 mm}}
grid: {points: 25}
friction: 0.1
load_path:
  - {P: 400 N, increments: 10}
  - cycle: {times: 2, stages: [{Qx: 20 N, increments: 8}, {Qx: -20 N, increments: 8}]}
output: {fields: [pressure, slip, gap], every: 7}
"""
"""A case of 42 increments, each some tens of milliseconds long, which depend on all of a restart's fields."""


def write_case(folder: Path, text: str = CASE, name: str = "case.yaml") -> Path:
    """The file of a case."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def invoke(*words: object) -> Result:
    """``fretsolve WORDS...`` in this process; has `exit_code`, `stdout` and `stderr`."""
    return CliRunner().invoke(main, [str(word) for word in words], prog_name="fretsolve")


def start(*words: object, **options: Any) -> subprocess.Popen[str]:
    """``fretsolve WORDS...`` as a process."""
    line = [sys.executable, "-m", "fretsolve", *map(str, words)]
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True} | options
    return subprocess.Popen(line, env=_environment(), **options)


def finish(*words: object, **options: Any) -> tuple[int, str, str]:
    """Exit code, output and messages of ``fretsolve WORDS...``, run as a process."""
    with start(*words, **options) as process:
        output, messages = process.communicate(timeout=120)
    return process.returncode, output, messages


def python(code: str, *words: object) -> str:
    """Return what ``python -c CODE WORDS...`` prints."""
    line = [sys.executable, "-c", code, *map(str, words)]
    return subprocess.run(line, env=_environment(), capture_output=True, text=True, check=True).stdout


def _environment() -> dict[str, str]:
    """With the package under test on the path, installed or not."""
    package = str(Path(fretsolve.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [package, os.environ.get("PYTHONPATH")]))}


def saved_steps(output: str) -> list[int]:
    """The increments that the lines of progress in `output` tell of."""
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
