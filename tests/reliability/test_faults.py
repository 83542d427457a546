"""Every change on disk fails once, or is the last before a kill or a power cut: nothing reported is lost."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import invoke
from fake_states import fake_header, fake_states
from faulty_os import FaultyOs, SimulatedKillError

from fretsolve.errors import FileError
from fretsolve.result import HistoryWriter, open_result, writer
from fretsolve.result.state import State
from fretsolve.system import atomic_files

INCREMENTS = 4
BEFORE = 3
"""Increments of the result that is there before, where there is one."""
STORED = ("pressure", "zone")
EVERY = 2
ALL = bool(os.environ.get("FRETSOLVE_ALL_FAULTS"))
"""Meet every change of every scenario with every kind of fault: some 5000 faults, six minutes.

By default, of the writes inside one HDF5 file, whose effects are alike, only the first is met; of the other
changes all in a new run, and every third where there is something before.
"""


def run(out: Path, reported: list[int], *, fail_at: int = -1, **options: bool) -> None:
    """Return what the command `run` does, noting in `reported` what it would tell its user."""
    header = fake_header(stored=STORED, every=EVERY, increments=INCREMENTS)
    with HistoryWriter.open(out, header, **options) as result:
        if result.complete:
            return
        for state in fake_states(INCREMENTS, result.last_state):
            if state.summary.step == fail_at:
                result.finish("failed", "made to fail")
                return
            result.append(state)
            reported.append(state.summary.step)
        result.finish("complete")


@pytest.fixture(scope="module")
def expected() -> list[State]:
    return list(fake_states(INCREMENTS))


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    out = tmp_path_factory.mktemp("reference") / "out.h5"
    run(out, [])
    return out.read_bytes()


@pytest.fixture(autouse=True)
def keep_few_states(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "STATES_KEPT", 2)


ANOTHER = "another case"
OPTIONS = {
    "new": {},
    "stopped, resumed": {"resume": True},
    "failed, resumed": {"resume": True},
    "complete, overwritten": {"overwrite": True},
    "another case, overwritten": {"overwrite": True},
}


def open_title(out: Path) -> str:
    """The title of the case whose parts are there, empty where there are none."""
    try:
        with open_result(out) as result:
            return str(result.effective_case["title"])
    except FileError:
        return ""


@pytest.fixture(scope="module")
def starting_points(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """For each scenario a folder with what its run finds."""
    root = tmp_path_factory.mktemp("starting_points")
    for scenario in OPTIONS:
        (root / scenario).mkdir()
    run(root / "complete, overwritten" / "out.h5", [])
    run(root / "failed, resumed" / "out.h5", [], fail_at=BEFORE)
    header = fake_header(stored=STORED, every=EVERY, increments=INCREMENTS)
    with HistoryWriter.open(root / "stopped, resumed" / "out.h5", header) as result:
        for state in fake_states(BEFORE):
            result.append(state)
    other = replace(header, effective_case=json.dumps({"title": ANOTHER}))
    with HistoryWriter.open(root / "another case, overwritten" / "out.h5", other) as result:
        for state in fake_states(BEFORE):
            result.append(replace(state, summary=replace(state.summary, P=-1.0)))
    return root


def faults(out: Path, options: dict[str, bool], patch: pytest.MonkeyPatch) -> Iterator[int]:
    """Numbers of the changes to meet with a fault."""
    counter = FaultyOs()
    with patch.context() as context:
        context.setattr(atomic_files, "os", counter)
        run(out, [], **options)
    previous = ""
    for number, call in enumerate(counter.calls):
        first = call != "write" or previous != "write"
        if ALL or (first and (not options or number % 3 == 0)):
            yield number
        previous = call


def check_readable(out: Path, reported: list[int], expected: list[State]) -> None:
    """All that was reported is there and right, and so is what may be there besides."""
    if open_title(out) in ("", ANOTHER):
        assert not reported
        return
    with open_result(out) as result:
        count = result.increments
        assert len(reported) <= count
        np.testing.assert_array_equal(result.history["P"], [state.summary.P for state in expected[:count]])
        for step in result.steps:
            np.testing.assert_array_equal(result.field("pressure", step), expected[step].fields.pressure)
        assert set(result.steps) >= {step for step in reported if (step + 1) % EVERY == 0}
        if result.status == "complete":
            assert count == INCREMENTS


def cases() -> list[Any]:
    """Scenarios and kinds of fault: by default, a kill only as the power cut that is worse."""
    kinds = ("error", "kill", "power cut")
    every = [(scenario, kind) for scenario in OPTIONS for kind in kinds]
    chosen = [case for case in every if ALL or case[1] == "power cut" or case == ("new", "error")]
    quick = (("stopped, resumed", "power cut"),)
    return [pytest.param(*case, marks=[] if case in quick else [pytest.mark.slow]) for case in chosen]


@pytest.mark.parametrize(("scenario", "kind"), cases())
def test_fault_at_every_change_loses_nothing(
    scenario: str,
    kind: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    expected: list[State],
    uninterrupted: bytes,
    starting_points: Path,
) -> None:
    met = 0
    options = OPTIONS[scenario]
    shutil.copytree(starting_points / scenario, tmp_path / "count")
    for number in faults(tmp_path / "count" / "out.h5", options, monkeypatch):
        out = tmp_path / str(number) / "out.h5"
        shutil.copytree(starting_points / scenario, out.parent)
        faulty = FaultyOs(number, kind)
        reported = list(range(BEFORE)) if "resume" in options else []
        with monkeypatch.context() as context:
            context.setattr(atomic_files, "os", faulty)
            try:
                run(out, reported, **options)
            except FileError as error:
                met += 1
                assert "\n" not in str(error)
                assert isinstance(error.__cause__, SimulatedKillError) == (kind != "error")
        assert len(faulty.calls) > number, "the fault was not met"
        check_readable(out, reported, expected)
        untouched = open_title(out) == ANOTHER
        run(out, [], resume=not untouched, overwrite=untouched)
        assert out.read_bytes() == uninterrupted
        assert [path.name for path in out.parent.iterdir()] == ["out.h5"]
    assert met > 10


@pytest.mark.parametrize(
    "kind", [pytest.param(one, marks=pytest.mark.slow) for one in ("error", "kill")] + ["power cut"]
)
@pytest.mark.parametrize("file_format", ["csv", "npz", "xdmf", "vtk"])
def test_fault_at_every_change_of_an_export_leaves_whole_files(
    file_format: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each file has its old content or its new one; the result stays as it is."""
    out, target = tmp_path / "out.h5", tmp_path / f"t.{ {'vtk': 'pvd'}.get(file_format, file_format) }"
    words = ("export", out, "--to", file_format, "-o", target, "--overwrite")

    def written() -> dict[Path, bytes]:
        return {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file() and path.suffix != ".tmp"}

    contents = []
    for increments in (3, INCREMENTS):
        with HistoryWriter.open(out, fake_header(increments=increments), overwrite=True) as result:
            for state in fake_states(increments):
                result.append(state)
            result.finish("complete")
        assert invoke(*words).exit_code == 0
        contents.append(written())
    old, new = contents
    counter = FaultyOs()
    with monkeypatch.context() as patch:
        patch.setattr(atomic_files, "os", counter)
        assert invoke(*words).exit_code == 0
    for number in range(0, len(counter.calls), 1 if ALL else 4):
        for path, content in old.items():
            if path != out:
                path.write_bytes(content)
        with monkeypatch.context() as patch:
            patch.setattr(atomic_files, "os", FaultyOs(number, kind))
            result = invoke(*words)
        assert result.exit_code in (0, 4), result.output
        found = written()
        assert found[out] == new[out]
        if kind != "power cut" or file_format == "csv":  # the others are not synced: they can be made again
            assert all(content in (old.get(path), new.get(path)) for path, content in found.items())
        for path in tmp_path.rglob("*.tmp"):
            path.unlink()
