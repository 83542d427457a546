"""Each call of the operating system on a file fails once: every command ends well, or with one line and exit code 4.

No file has half a content under its name then, and what was there stays or is replaced as a whole. After exit code 4
there are no new names, so that a command of several files can be given again. An error of closing a file of HDF5 that
was only read means nothing.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import cycle, islice
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import invoke, result_of
from failing_calls import KINDS, Ended, FailingCalls
from fitting import FIT_CASE
from small_cases import CASE, SPHERE, SWEPT, write_case
from sweeping import write_sweep

from fretsolve import load_case, run
from fretsolve.result import HistoryWriter
from fretsolve.simulation.problem_setup import set_up
from fretsolve.simulation.run_to_file import run_header

ERRORS = (errno.EIO, errno.ENOSPC, errno.EACCES, errno.EROFS, errno.ENOMEM, errno.ESTALE)
MOST = int(os.environ.get("FRETSOLVE_FAILING_CALLS", "2"))
"""Failing calls of each kind and command, evenly among all; they take turns in `ERRORS`."""

WITH_SIDES = """\
bodies: [{young_modulus: 70 GPa, poisson_ratio: 0.5}, {young_modulus: 70 GPa, poisson_ratio: 0.5}]
surface: {sphere: {radius: 10 mm}}
friction: 0.3
grid: {points: 24}
load_path: [{P: 100 N}, {cycle: {amplitude: {Qx: 15 N}, times: 1, increments: 4}}]
output:
  stress: {every: 1, depths: [0]}
  fatigue: {criteria: [crossland], depths: [0], material: {tension_limit: 300 MPa, torsion_limit: 190 MPa}}
  crack: {}
"""
RECORD = (
    SPHERE.replace("16", "8")
    + "rig: {stiffness_x: 60 kN/mm}\n"
    + "load_path: [{P: 400 N}, {cycle: {amplitude: {actuator_x: 2 um}, times: 2, increments: 24}}]\n"
)
ENDS = {".png": b"IEND\xaeB`\x82", ".csv": b"\n", ".json": b"}", ".note": b"}", ".xml": b">\n"}
LIMITS = ("--material", "tension_limit=300MPa,torsion_limit=190MPa", "--criterion", "crossland", "-q", "--overwrite")


@dataclass(frozen=True)
class Command:
    """A command in a folder with what it reads. without: files and folders that are removed before."""

    words: tuple[str, ...]
    without: tuple[str, ...] = ()


COMMANDS = {
    "new run": Command(("run", "c.yaml", "-q"), ("c.h5", "c.stress.h5", "c.fatigue.h5", "c.crack.h5")),
    "overwriting run": Command(("run", "c.yaml", "-q", "--overwrite")),
    "resumed run": Command(("run", "stopped.yaml", "-q", "--resume")),
    "side outputs": Command(("run", "c.yaml", "-q", "--resume"), ("c.crack.h5", "c.fatigue.h5")),
    "show": Command(("show", "c.h5")),
    "show parts": Command(("show", "stopped.h5")),
    "csv": Command(("export", "c.h5", "--to", "csv")),
    "npz": Command(("export", "c.h5", "--to", "npz", "--overwrite")),
    "vtk": Command(("export", "c.h5", "--to", "vtk")),
    "xdmf": Command(("export", "c.h5", "--to", "xdmf")),
    "xdmf of parts": Command(("export", "stopped.h5", "--to", "xdmf")),
    "vtk of stresses": Command(("export", "c.stress.h5", "--to", "vtk")),
    "vtk of fatigue": Command(("export", "c.fatigue.h5", "--to", "vtk")),
    "plot": Command(("plot", "c.h5", "loop", "--dpi", "20", "-o", "p.png")),
    "film": Command(("plot", "c.h5", "animate", "--dpi", "20", "-o", "p.gif")),
    "all plots": Command(("plot", "c.h5", "--all", "--dpi", "20", "-o", "pictures/")),
    "stress": Command(("stress", "c.h5", "--depth", "40um", "--overwrite", "-q")),
    "fatigue": Command(("fatigue", "c.h5", *LIMITS)),
    "fatigue of stresses": Command(("fatigue", "c.stress.h5", *LIMITS, "-o", "f.h5")),
    "crack": Command(("crack", "c.h5", "-q", "--overwrite")),
    "validate": Command(("validate", "c.yaml")),
    "check": Command(("check", "checked.yaml", "--junit", "j.xml")),
    "sweep run": Command(("sweep", "run", "sweep.yaml", "-q", "-j", "1"), ("sweep.sweep",)),
    "sweep collect": Command(("sweep", "collect", "sweep.sweep")),
    "sweep plot": Command(("sweep", "plot", "sweep.sweep", "--dpi", "20")),
    "study": Command(("study", "case.yaml", "--vary", "grid.points=8,12", "-q")),
    "fit": Command(("fit", "fit.yaml", "--loop", "record.csv", "--for", "friction", "-q", "-j", "1")),
    "surface": Command(("surface", "map.txt", "--set", "spacing=1um", "--set", "unit=mm", "--plot", "m.png")),
    "new": Command(("new", "rough", "-o", "n.yaml")),
    "schema": Command(("schema", "-o", "s.json")),
}
KEPT = ("new run", "overwriting run", "resumed run", "side outputs", "all plots", "sweep run", "study", "fit", "check")
"""Commands that keep what they have finished when a later file fails; given again, they go on or replace it."""

LONG = ("all plots", "fit")
"""Commands that take seconds."""

QUICK = {"csv": ("close",), "vtk": ("close",), "xdmf": ("close",)}
"""Commands of results and kinds of calls that the quick suite tries."""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the preloaded library."""
    compiler, built = shutil.which("gcc"), tmp_path_factory.mktemp("library") / "failing_calls.so"
    if compiler is None:
        pytest.skip("there is no gcc")
    source = Path(__file__).with_name("failing_calls.c")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-Wall", "-Werror", source, "-o", built], check=True)
    return built


@pytest.fixture(scope="module")
def failing(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[FailingCalls]:
    with FailingCalls(library, tmp_path_factory.mktemp("scratch")) as calls:
        yield calls


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with what the commands of `QUICK` read."""
    folder = tmp_path_factory.mktemp("result")
    result_of(write_case(folder, WITH_SIDES, "c.yaml"))
    return folder


@pytest.fixture(scope="module")
def everything(result: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with what the commands of `COMMANDS` read."""
    folder = Path(shutil.copytree(result, tmp_path_factory.mktemp("everything") / "made"))
    case = load_case(write_case(folder, WITH_SIDES, "stopped.yaml"))
    with HistoryWriter.open(folder / "stopped.h5", run_header(set_up(case), 1, ())) as writer:
        for state in islice(run(case), 2):
            writer.append(state)
    path = write_sweep(folder, "case: case.yaml\naxes: [friction: [0.1, 0.12]]\n", SWEPT.replace("12", "8"))
    assert invoke("sweep", "run", path, "-q", "-j", 1).exit_code == 0
    fitted = FIT_CASE.replace("points: 24", "points: 8").replace("increments: 20", "increments: 4")
    write_case(folder, fitted, "fit.yaml")
    invoke("export", result_of(write_case(folder, RECORD, "record.yaml")), "--to", "csv")
    write_case(folder, CASE, "checked.yaml")
    np.savetxt(folder / "map.txt", np.add.outer(*(np.linspace(-1.0, 1.0, 9) ** 2,) * 2) * 1e-3)
    return folder


def prepared(made: Path, folder: Path, command: Command) -> Path:
    """Copy what a command reads to `folder`, and return that."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(made, folder)
    for name in command.without:
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    return folder


def final_names(folder: Path) -> set[str]:
    """Return the final names of files and folders; those of parts and temporary ones are none."""
    names = {str(path.relative_to(folder)) for path in folder.rglob("*")}
    return {name for name in names if not re.search(r"\.parts[/.]|\.tmp\b", name)}


def contents(folder: Path) -> dict[str, bytes]:
    """Return the files that have their final names, by these."""
    return {name: (folder / name).read_bytes() for name in final_names(folder) if (folder / name).is_file()}


def assert_whole(folder: Path, before: Mapping[str, bytes], after: Mapping[str, bytes]) -> None:
    """Each file has its content before the command or after it, or, where that tells times or failures, its end."""
    for name, content in contents(folder).items():
        if content not in (before.get(name), after.get(name)):
            path = folder / name
            if path.suffix != ".h5":
                assert content.endswith(ENDS[path.suffix]), name
            else:
                with h5py.File(path) as file:
                    assert sum(node[()].size for node in nodes_of(file)), name


def nodes_of(file: h5py.File) -> list[h5py.Dataset]:
    """Return the datasets of a file."""
    found: list[h5py.Dataset] = []
    file.visititems(lambda _, node: found.append(node) if isinstance(node, h5py.Dataset) else None)
    return found


def assert_ended_well(ended: Ended) -> None:
    """A command that met a failing call has ended with 0, or with 4 and a line that names a file or folder.

    A file that a key of a case names is a mistake of the case (2).
    """
    lines = [line for line in ended.messages.splitlines() if "warning: " not in line]
    assert "Traceback" not in ended.messages, ended
    assert len(lines) <= 1, ended
    said = lines[0] if lines else ended.output
    assert ended.code in (0, 4) or (ended.code == 2 and re.match(r"\w+\.yaml:\d+: ", said)), ended
    if ended.code:
        assert re.search(r"\w\.[a-z]\w*\b|pictures", said), ended


def numbers(count: int, most: int) -> list[int]:
    """Return at most so many numbers below `count`, evenly, the first and the last one among them."""
    return sorted(set(np.linspace(0, count - 1, min(count, most)).round().astype(int).tolist()))


def cases() -> list[object]:
    """Commands and kinds of calls; the quick suite has `QUICK`."""
    every = [(name, kind) for name in COMMANDS for kind in KINDS]
    return [
        pytest.param(name, kind, marks=[] if kind in QUICK.get(name, ()) else [pytest.mark.slow])
        for name, kind in every
    ]


@pytest.fixture(scope="module")
def counted() -> dict[str, tuple[Ended, Mapping[str, bytes]]]:
    """Return how commands that met no failing call have ended, and their files. The tests fill it."""
    return {}


@pytest.mark.parametrize(("name", "kind"), cases())
def test_each_call_fails_once(
    name: str,
    kind: str,
    failing: FailingCalls,
    counted: dict[str, tuple[Ended, Mapping[str, bytes]]],
    request: pytest.FixtureRequest,
) -> None:
    command, made = COMMANDS[name], request.getfixturevalue("result" if name in QUICK else "everything")
    folder = made.with_name("c")  # always the same, since manifests name it
    before = contents(prepared(made, folder, command))
    names = final_names(folder)
    if name not in counted:
        ended = failing.run(folder, *command.words)
        counted[name] = ended, contents(folder)
    ended, after = counted[name]
    assert ended.code == 0, ended
    errors = islice(cycle(ERRORS), KINDS.index(kind), None)
    for number in numbers(ended.calls[kind], 1 if name in LONG else MOST):
        prepared(made, folder, command)
        met = failing.run(folder, *command.words, kind=kind, number=number, error=next(errors))
        assert met.calls[kind] or kind in ("rename", "truncate")  # a fast run saves nothing under way
        assert_ended_well(met)
        assert_whole(folder, before, after)
        assert met.code != 4 or name in KEPT or final_names(folder) == names, met
