"""Damaged and hostile inputs end in a documented exit code within seconds, and never in another number.

Some hundred inputs by default; FRETSOLVE_DAMAGED_INPUTS=3000 tries so many of each kind.
"""

from __future__ import annotations

import os
import random
import resource
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import PATIENCE, invoke
from damage import damaged, restructured
from fake_states import fake_header, fake_states, write_fake
from pebble import ProcessPool
from small_cases import CASE, SPHERE, write_case
from sweeping import manifest_of, write_sweep

from fretsolve.errors import FretsolveError
from fretsolve.result import HistoryWriter, writer
from fretsolve.result.parts import parts_folder
from fretsolve.sweep.outcome import read_outcome
from fretsolve.sweep.plan import make_sweep_plan
from fretsolve.sweep.quantity import read_quantity
from fretsolve.system.arrays import DoubleArray

COUNT = int(os.environ.get("FRETSOLVE_DAMAGED_INPUTS", "40"))
FEW = int(os.environ.get("FRETSOLVE_DAMAGED_INPUTS", "8"))
"""Inputs of kinds that take long, or that are read by what reads others as well."""
LONGEST = 20.0
"""Seconds of processor time for an input; one that hangs is given up after `PATIENCE`."""
MOST_MEMORY = 2**31
SEED = int(os.environ.get("FRETSOLVE_SEED", "1"))

Attempt = Callable[[Path, random.Random], None]
"""Damages a copy of the sample in a folder, reads it, and asserts that it is read right or refused."""


def outcome(*words: object) -> tuple[int, str]:
    """Exit code and output of a command, which is a documented code; refusals are short lines without control codes."""
    result = invoke(*words)
    assert result.exit_code in (0, 2, 3, 4), f"{words}: exit code {result.exit_code}: {result.output}"
    assert "Traceback" not in result.output
    if result.exit_code:
        assert 0 < len(result.stderr.splitlines()) <= 12, result.stderr
        assert max(map(len, result.stderr.splitlines())) < 1000, result.stderr
        assert all(character.isprintable() or character == "\n" for character in result.stderr), repr(result.stderr)
    return result.exit_code, result.stdout


def readings(out: Path) -> tuple[str, bytes, dict[str, Any]]:
    """All that show and export say of a result; AssertionError unless they work."""
    code, shown = outcome("show", out, "--all")
    assert code == 0
    for ending in ("csv", "npz"):
        assert outcome("export", out, "--to", ending, "--overwrite", "-o", out.parent / f"t.{ending}")[0] == 0
    with np.load(out.parent / "t.npz") as arrays:
        return shown, (out.parent / "t.csv").read_bytes(), dict(arrays)


def assert_same_or_refused(out: Path, before: tuple[str, bytes, dict[str, Any]]) -> None:
    shown, table, arrays = before
    code, found = outcome("show", out, "--all")
    assert code == 4 or (code == 0 and found == shown), found
    target = out.parent / "t.csv"
    code, _ = outcome("export", out, "--to", "csv", "--overwrite", "-o", target)
    assert code == 4 or (code == 0 and target.read_bytes() == table)
    assert outcome("export", out, "--to", "vtk", "--overwrite", "-o", out.parent / "t.pvd")[0] in (0, 4)
    target = out.parent / "t.npz"
    code, _ = outcome("export", out, "--to", "npz", "--overwrite", "-o", target)
    if code == 0:
        with np.load(target) as found_arrays:
            assert set(found_arrays) <= set(arrays)
            for name in found_arrays:
                np.testing.assert_array_equal(found_arrays[name], arrays[name], err_msg=name)
    else:
        assert code == 4


SHAPE = (7, 6)


def finish(out: Path, **options: bool) -> None:
    """Run to the end, as the command `run` does."""
    header = fake_header(SHAPE, increments=6, errors=True)
    with HistoryWriter.open(out, header, **options) as run:
        if not run.complete:
            for state in fake_states(6, run.last_state, shape=SHAPE, errors=True):
                run.append(state)
            run.finish("complete")


class Samples:
    """Undamaged files, made once in each process that tries damage."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.made: dict[str, Any] = {}
        self.computed_files: list[Path] = []

    def result(self, end: str) -> tuple[Path, Any]:
        if end not in self.made:
            folder = self.folder / end
            folder.mkdir()
            out = write_fake(folder / "out.h5", end, shape=SHAPE, errors=True, increments=6)
            self.made[end] = out, readings(out)
        return self.made[end]

    def computed(self) -> dict[str, Any]:
        """All that is read of the stresses and fatigue parameters of a run, whose files lie in `computed_files`."""
        if "computed" not in self.made:
            folder = self.folder / "computed"
            folder.mkdir()
            assert outcome("run", write_case(folder, CYCLE.replace("KEYS", GIVEN)), "-q")[0] == 0
            self.computed_files = sorted(folder.glob("*.h5"))
            self.made["computed"] = computed_readings(folder)
            assert all(self.made["computed"].values())
        return self.made["computed"]


_samples: list[Samples] = []


def begin(folder: Path) -> None:
    own = folder / str(os.getpid())
    own.mkdir()
    writer.STATES_KEPT = 2
    _samples.append(Samples(own))


def resumed(out: Path, codes: tuple[int, ...]) -> Path | None:
    """Resume the run at `out`. Return a whole result to compare with, None if it is refused with one of `codes`."""
    whole = _samples[0].folder / "whole.h5"
    if not whole.exists():
        finish(whole)
    try:
        finish(out, resume=True)
    except FretsolveError as error:
        assert error.exit_code in codes, error
        assert "\n" not in str(error)
        return None
    return whole


def damage_result(folder: Path, chance: random.Random) -> None:
    sample, before = _samples[0].result(chance.choice(["complete", "failed"]))
    out = folder / "out.h5"
    if chance.random() < 0.4:
        shutil.copy(sample, out)
        restructured(out, chance)
    else:
        out.write_bytes(damaged(sample.read_bytes(), chance))
    assert_same_or_refused(out, before)
    if whole := resumed(out, codes=(4,)):
        assert_same_or_refused(out, readings(whole) if sample.parent.name == "failed" else before)


def damage_parts(folder: Path, chance: random.Random) -> None:
    sample, before = _samples[0].result("stopped")
    out = folder / "out.h5"
    shutil.copytree(parts_folder(sample), parts_folder(out))
    path = chance.choice(sorted(parts_folder(out).iterdir()))
    if path.suffix == ".h5" and chance.random() < 0.4:
        restructured(path, chance)
    elif path.stat().st_size:
        path.write_bytes(damaged(path.read_bytes(), chance))
    assert_same_or_refused(out, before)
    if whole := resumed(out, codes=(2, 4)):
        assert out.read_bytes() == whole.read_bytes()


def write_map(path: Path, kind: str, heights: DoubleArray) -> None:
    match kind:
        case "npy":
            np.save(path, heights)
        case "npz":
            np.savez_compressed(path, z=heights)
        case "h5" | "old.h5":
            import h5py

            with h5py.File(path, "w", libver=("v110", "v110") if kind == "h5" else "earliest") as file:
                file["z"] = heights
                file["z"].attrs.update({"spacing": [0.001, 0.001], "units": "um"})
                file["more/t"] = np.arange(3)
        case _:
            np.savetxt(path, heights, delimiter=",")


def damaged_map(folder: Path, chance: random.Random, heights: DoubleArray) -> Path:
    """Return a damaged map of `heights` in one of the formats."""
    kind = chance.choice(["npy", "npz", "h5", "old.h5", "csv"])
    path = folder / f"map.{kind}"
    write_map(path, kind, heights)
    if path.suffix == ".h5" and chance.random() < 0.4:
        restructured(path, chance)
    else:
        path.write_bytes(damaged(path.read_bytes(), chance))
    return path


def damage_map(folder: Path, chance: random.Random) -> None:
    path = damaged_map(folder, chance, np.random.default_rng(1).normal(size=(12, 9)))
    spec = f"{{file: {path.name}, unit: um, spacing: 1 um{', dataset: z' if path.suffix == '.h5' else ''}}}"
    case = CASE.replace("{sphere: {radius: 10 mm}}", f"[{{sphere: {{radius: 10 mm}}}}, {{heights: {spec}}}]")
    outcome("validate", write_case(folder, case.replace("points: 16", "points: 16, size: 0.4 mm")))


def damaged_text(text: str, chance: random.Random) -> bytes:
    """Return the bytes of a text after damage, or after words of YAML have got into it."""
    if chance.random() < 0.5:
        return damaged(text.encode(), chance)
    for _ in range(chance.randint(1, 4)):
        at, size = chance.randrange(len(text)), chance.choice((0, 1, 3, 12))
        text = text[:at] + chance.choice(FRAGMENTS) + text[at + size :]
    return text.encode()


FRAGMENTS = (
    "{}",
    "[]",
    "~",
    ": ",
    "- ",
    "\n",
    "&a [*a]",
    "!!python/object:os.system ",
    "1" + "0" * 400,
    "-1",
    ".nan",
    "1e308",
)
FRAGMENTS += (
    "*",
    "auto",
    "\x00",
    "\x1b[2J",
    "\u202e",
    "'",
    '"',
    "|",
    "1_000",
    "0x10",
    "1e-300",
    "[[[[[[",
    "../../../etc/passwd",
)


def damage_case(folder: Path, chance: random.Random) -> None:
    (folder / "case.yaml").write_bytes(damaged_text(CASE, chance))
    outcome("validate", folder / "case.yaml")


def damage_friction_map(folder: Path, chance: random.Random) -> None:
    path = damaged_map(folder, chance, np.random.default_rng(1).uniform(0.1, 0.3, (16, 16)))
    spec = f"{{map: {path.name}, spacing: 25 um{', dataset: z' if path.suffix == '.h5' else ''}}}"
    case = CASE.replace("friction: 0.1", f"friction: {spec}").replace("points: 16", "points: 16, size: 0.4 mm")
    outcome("validate", write_case(folder, case))


def damage_material(folder: Path, chance: random.Random) -> None:
    (folder / "steel.yaml").write_bytes(damaged_text(STEEL, chance))
    outcome("validate", write_case(folder, CYCLE.replace("KEYS", "criteria: [crossland, swt], material: steel.yaml")))


STEEL = """\
name: steel
sources: [a handbook]
tension_limit: 300 MPa
torsion_limit: 190 MPa
strain_life: {strength: 1000 MPa, strength_exponent: -0.1, ductility: 0.5}
"""
GIVEN = "criteria: [crossland, swt], material: {tension_limit: 300 MPa, torsion_limit: 190 MPa}, depths: [0 mm, 20 um]"
CYCLE = f"""\
{SPHERE.replace("16", "12")}load_path:
  - {{P: 400 N}}
  - cycle: {{times: 2, stages: [{{Qx: 20 N, increments: 1}}, {{Qx: -20 N, increments: 1}}]}}
output:
  stress: {{depths: [0 mm, 20 um], every: 1}}
  fatigue: {{KEYS}}
"""


def damage_computed(folder: Path, chance: random.Random) -> None:
    """Files of stresses and of fatigue parameters, read by all that takes them."""
    before = _samples[0].computed()
    for path in _samples[0].computed_files:
        shutil.copy(path, folder)
    kind = chance.choice(["stress", "fatigue"])
    path = folder / f"case.{kind}.h5"
    if chance.random() < 0.5:
        restructured(path, chance)
    else:
        path.write_bytes(damaged(path.read_bytes(), chance))
    for name, reading in computed_readings(folder).items():
        assert reading is None or reading == before[name], f"{name} is read in another way"


def computed_readings(folder: Path) -> dict[str, Any]:
    """All that is said of the stresses and fatigue parameters in a folder; None for what is refused."""
    found: dict[str, Any] = {}
    limits = "tension_limit=300MPa,torsion_limit=190MPa"
    words = ("--criterion", "crossland", "--material", limits, "--overwrite", "-o", folder / "new.h5")
    code, printed = outcome("fatigue", folder / "case.stress.h5", *words)
    found["parameters"] = printed.replace(str(folder), "") if code == 0 else None
    for name, quantities in {"stress": ("max_mises", "max_tension"), "fatigue": ("crossland_max", "swt_max")}.items():
        try:
            read = read_outcome(folder / "case.h5", [read_quantity(one) for one in quantities])
            found[f"largest of {name}"] = (read.values.tolist(), np.nan_to_num(read.errors).tolist())
        except FretsolveError as error:
            assert error.exit_code == 4, error
            found[f"largest of {name}"] = None
        target = folder / f"{name}.pvd"
        code, _ = outcome("export", folder / f"case.{name}.h5", "--to", "vtk", "--overwrite", "-o", target)
        files = sorted(folder.glob(f"{name}.vtk/*"))
        found[f"grids of {name}"] = [path.read_bytes() for path in files] if code == 0 else None
    return found


def damage_sweep(folder: Path, chance: random.Random) -> None:
    """A sweep is planned, and looked at; it is not run."""
    file = write_sweep(folder)
    which = chance.choice([file, file.with_name("case.yaml")])
    which.write_bytes(damaged_text(which.read_text(), chance))
    try:
        make_sweep_plan(file, folder / "sweep.sweep")
    except FretsolveError as error:
        assert error.exit_code in (2, 4), error
        assert max(map(len, str(error).splitlines())) < 1000


def damage_manifest(folder: Path, chance: random.Random) -> None:
    manifest = manifest_of(folder)
    path = manifest.folder / "manifest.json"
    (manifest.results / f"{manifest.rows[1].id}.note").write_text('{"exit_code": 4, "reason": "made up"}')
    which = chance.choice([path, path, path, manifest.note(manifest.rows[1])])
    which.write_bytes(damaged(which.read_bytes(), chance))
    before = sorted(folder.parent.rglob("*"))
    outcome("sweep", "status", manifest.folder)
    assert sorted(folder.parent.rglob("*")) == before
    outcome("sweep", "collect", manifest.folder)


KINDS: dict[str, Attempt] = {
    "result": damage_result,
    "parts": damage_parts,
    "map": damage_map,
    "case": damage_case,
    "sweep": damage_sweep,
    "manifest": damage_manifest,
    "friction map": damage_friction_map,
    "material": damage_material,
    "stresses and fatigue parameters": damage_computed,
}


TAKE_LONG = ("friction map", "material", "stresses and fatigue parameters")


def attempt(kind: str, folder: Path, seed: int) -> int:
    """Try one damaged input in a process that may hang or crash; return its largest memory so far."""
    chance, began = random.Random(seed), time.process_time()
    own = folder / f"{kind}-{seed}"
    own.mkdir()
    try:
        KINDS[kind](own, chance)
    finally:
        shutil.rmtree(own)
    assert time.process_time() - began < LONGEST
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def attempts(kind: str, folder: Path) -> Iterator[str]:
    """Yield a line for each seed whose input was not met as promised."""
    count = FEW if kind in TAKE_LONG else COUNT
    with ProcessPool(1, initializer=begin, initargs=(folder,)) as pool:
        futures = {
            seed: pool.schedule(attempt, (kind, folder, seed), timeout=PATIENCE) for seed in range(SEED, SEED + count)
        }
        for seed, future in futures.items():
            try:
                if future.result() > MOST_MEMORY:
                    yield f"{kind} {seed}: too much memory"
            except Exception as error:
                yield f"{kind} {seed}: {type(error).__name__}: {str(error)[:600]}"


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=[pytest.mark.slow] if kind in ("parts", "result") else []) for kind in KINDS]
)
def test_damaged_input_is_read_right_or_refused(kind: str, tmp_path: Path) -> None:
    failures = list(attempts(kind, tmp_path))
    assert not failures, "\n".join([f"{len(failures)} failures", *failures[:25]])
