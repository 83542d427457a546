"""A small sweep and what it should come to, for the tests of its engines."""

from __future__ import annotations

import json
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from small_cases import SWEPT

from fretsolve import load_case, open_result, run
from fretsolve.errors import NoSolutionError
from fretsolve.sweep.manifest import Manifest, write_manifest
from fretsolve.sweep.plan import make_sweep_plan

SWEEP = """\
title: friction and load
case: case.yaml
axes:
  - friction: [0.08, 0.1, 0.12]
  - load_path.0.P: {from: 400 N, to: 500 N, count: 2}
"""
"""Six cases, of which the first slides."""


def many_cases(count: int) -> str:
    """A sweep of so many cases, a multiple of 4."""
    axes = f"friction: {{from: 0.1, to: 0.2, count: {count // 4}}}"
    return f"case: case.yaml\naxes:\n  - {axes}\n  - load_path.0.P: [390 N, 400 N, 410 N, 420 N]\n"


def write_sweep(folder: Path, sweep: str = SWEEP, case: str = SWEPT) -> Path:
    """The sweep file, beside its case."""
    (folder / "case.yaml").write_text(case, encoding="utf-8")
    path = folder / "sweep.yaml"
    path.write_text(sweep, encoding="utf-8")
    return path


def manifest_of(folder: Path, case: str = SWEPT) -> Manifest:
    """Return the manifest of the sweep of `case`, written to its folder."""
    found = make_sweep_plan(write_sweep(folder, case=case), folder / "sweep.sweep").manifest
    write_manifest(found)
    return found


def rows_of(folder: Path) -> list[dict[str, Any]]:
    """The cases of the manifest."""
    return json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["cases"]


def workers(folder: Path) -> list[int]:
    """Return the processes that are solving cases of the sweep in `folder`, as these tell beside their locks."""
    found: list[str] = []
    for holder in folder.glob("results/*.parts/holder"):
        with suppress(FileNotFoundError):
            found += re.findall(r"^process (\d+) ", holder.read_text(encoding="utf-8"))
    return [int(number) for number in found if Path(f"/proc/{number}").exists()]


def assert_as_serial(folder: Path, case: Path) -> int:
    """Check that every case of a sweep has the very numbers of a run in this process; how many cases there are."""
    rows = rows_of(folder)
    for row in rows:
        states, failure = [], ""
        try:
            for state in run(load_case(case, [f"{key}={value}" for key, value in row["settings"].items()])):
                states.append(state)
        except NoSolutionError as error:
            failure = error.kind
        with open_result(folder / row["result"]) as result:
            assert result.status == ("failed" if failure else "complete")
            assert result.attributes.get("failure_kind", "") == failure
            assert result.increments == len(states)
            for name in ("delta_x", "work_total", "stick_radius", "residual_slip"):
                np.testing.assert_array_equal(result.history[name], [getattr(s.summary, name) for s in states])
            if states:
                np.testing.assert_array_equal(result.field("shear"), states[-1].fields.shear)
    return len(rows)
