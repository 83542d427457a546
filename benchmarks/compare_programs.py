"""fretsolve beside other open programs on the same case: one Markdown table of cost and error.

    python benchmarks/compare_programs.py             # 256 and 512 points per side
    python benchmarks/compare_programs.py 128 256 --environments /tmp/programs --limit 60

The base case: a sphere of 10 mm on a flat, E = 200 GPa and nu = 0.3 both, P = 400 N, mu = 0.1, on a square area of
0.9 mm. Each program is installed from PyPI into a virtual environment of its own, kept for the next time, and runs
there on one thread (benchmarks/programs/). One that cannot be installed, fails or exceeds the limit is left out, with a
line that says why.

Jobs: `normal`, contact under the load; `mode1`, then an imposed tangential displacement, Mindlin's at Qx = 0.9 mu P, in
one increment, with shear in x acting on displacement in x alone, as slippy has it (fretsolve: `coupling: none`). Tamaas
has friction on periodic bodies only, ContactMechanics none. All discretise alike: uniform tractions on the cells of
a free half-space by zero-padded convolution (Tamaas: `registerNonPeriodic`; ContactMechanics: FreeFFTElasticHalfSpace;
slippy: spatial influence coefficients). So the errors against the closed forms are the grid's: where they agree, the
same problem was solved.

Seconds are of the solve alone, the median of `--repeats`, without imports, influence coefficients and FFT plans;
slippy's are of its solver functions, without what its steps add, fretsolve's those of the increment as its history
gives them, with its certificate. x is the multiple of fretsolve's.
An application is one convolution; "-" is what a program does not tell. `residual` is by each program's own convolution:
of `normal` the largest |gap| in contact or penetration outside over delta_z, of `mode1` the largest |slip| in the stick
zone over delta_x.

The tolerance, 1e-6, is met by what each program itself measures, so look at `residual` as well:
fretsolve: the certificate, as `residual` and the direction and bound of shear;
Tamaas: pressure times gap, summed up, relative to the load and the heights' rms;
ContactMechanics: penetration and change of displacement in the last iteration over delta_z (other limits: defaults);
slippy: change of pressure in the last iteration over the load; `mode1`: rms change of shear over its rms.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from programs.task import Answer, Task

from fretsolve.reference.hertz import hertz_sphere
from fretsolve.reference.tangential import cattaneo_mindlin

WORKERS = Path(__file__).resolve().parent / "programs"
GRIDS = (256, 512)
SHEAR_FORCE = 36.0
COMPLETE = "complete.json"
"""Written into an environment once everything is installed; says what."""

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


class UnusableError(Exception):
    """A program cannot be installed or run; the text says why, in one line."""


@dataclass(frozen=True)
class Program:
    """A program to compare. installs: arguments of pip, call by call; without any it runs where this script does."""

    name: str
    worker: Path
    jobs: tuple[str, ...]
    installs: tuple[tuple[str, ...], ...] = ()


FRETSOLVE = Program("fretsolve", WORKERS / "fretsolve_worker.py", ("normal", "mode1"))
PROGRAMS = (
    FRETSOLVE,
    Program("Tamaas", WORKERS / "tamaas_worker.py", ("normal",), (("tamaas==2.9.0",),)),
    Program("ContactMechanics", WORKERS / "contactmechanics_worker.py", ("normal",), (("ContactMechanics==1.8.3",),)),
    # slippy asks for a NumPy below 1.21, of which there is none for today's Python; its core runs with newer ones.
    Program(
        "slippy",
        WORKERS / "slippy_worker.py",
        ("normal", "mode1"),
        (("numpy", "numba", "pyfftw", "tinydb"), ("--no-deps", "slippy==0.5.2")),
    ),
)


@dataclass(frozen=True)
class Row:
    """What a program made of a job on a grid."""

    program: str
    job: str
    points: int
    answer: Answer


@dataclass(frozen=True)
class Reference:
    """Closed forms of what an Answer has: rigid, peak, radius."""

    rigid: float
    peak: float
    radius: float


def base_case(tolerance: float = 1e-6, repeats: int = 5) -> tuple[Task, dict[str, Reference]]:
    """Return the case without job and grid, and by job the closed forms of Hertz, and of Cattaneo and Mindlin."""
    radius, young_modulus, poisson_ratio, load, friction = 10.0, 200e3, 0.3, 400.0, 0.1
    shear_modulus = young_modulus / (2.0 * (1.0 + poisson_ratio))
    hertz = hertz_sphere(load, radius, 0.5 * young_modulus / (1.0 - poisson_ratio**2))
    mindlin = cattaneo_mindlin(hertz, friction, SHEAR_FORCE, 2.0 * (2.0 - poisson_ratio) / shear_modulus)
    stick = mindlin.stick_radius / hertz.contact_radius
    most_shear = friction * hertz.max_pressure * math.sqrt(1.0 - stick**2)
    task = Task(
        job="",
        points=0,
        size=0.9,
        radius=radius,
        young_modulus=young_modulus,
        poisson_ratio=poisson_ratio,
        load=load,
        friction=friction,
        delta_x=mindlin.delta_x,
        delta_z=hertz.delta_z,
        tolerance=tolerance,
        repeats=repeats,
    )
    return task, {
        "normal": Reference(hertz.delta_z, hertz.max_pressure, hertz.contact_radius),
        "mode1": Reference(SHEAR_FORCE, most_shear, mindlin.stick_radius),
    }


def tell(message: str) -> None:
    """Print a line beside the table."""
    print(message, file=sys.stderr, flush=True)


def default_environments() -> Path:
    """Return the folder of the programs' environments, in the user's cache folder."""
    cache = os.environ.get("XDG_CACHE_HOME")
    return (Path(cache) if cache else Path.home() / ".cache") / "fretsolve-compare"


def interpreter(program: Program, environments: Path) -> Path:
    """Return the Python that runs the program's worker; its environment is made first, unless it is there.

    Raises UnusableError where it cannot be made.
    """
    if not program.installs:
        return Path(sys.executable)
    folder = environments / program.name.lower()
    python, complete = folder / "bin" / "python", folder / COMPLETE
    wanted = json.dumps(program.installs)
    if complete.is_file() and complete.read_text() == wanted:
        return python
    tell(f"{program.name}: installing into {folder}")
    shutil.rmtree(folder, ignore_errors=True)
    _output([sys.executable, "-m", "venv", str(folder)], "cannot make its environment")
    for arguments in program.installs:
        _output([str(python), "-m", "pip", "install", "--quiet", *arguments], "cannot be installed")
    complete.write_text(wanted)
    return python


def answer(program: Program, python: Path, task: Task, limit: float) -> Answer:
    """Return what the program's worker finds for the task within `limit` seconds. Raises UnusableError."""
    job = f"{task.job} on {task.points} x {task.points}"
    output = _output([str(python), str(program.worker), json.dumps(asdict(task))], f"{job} failed", limit, python)
    line = _last_line(output)
    try:
        found = Answer(**json.loads(line))
    except (ValueError, TypeError):
        raise UnusableError(f"{job}: its worker gave no answer but {line[:60]!r}") from None
    wrong = [field.name for field in fields(found) if not _is_sound(field.name, getattr(found, field.name))]
    if wrong:
        raise UnusableError(f"{job}: its worker gave {wrong[0]} as {getattr(found, wrong[0])!r}")
    return found


def _is_sound(name: str, value: object) -> bool:
    if name == "version":
        return isinstance(value, str)
    if value is None:
        return name in ("iterations", "applications")
    return isinstance(value, (int, float)) and math.isfinite(value)


def _output(command: Sequence[str], failure: str, limit: float | None = None, python: Path | None = None) -> str:
    """Return what a command prints, on one thread. Raises UnusableError, which starts with `failure`."""
    surroundings = {**os.environ, **ONE_THREAD}
    if python != Path(sys.executable):
        surroundings.pop("PYTHONPATH", None)  # what it leads to is not meant for another environment
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            stdin=subprocess.DEVNULL,
            text=True,
            errors="replace",
            timeout=limit,
            env=surroundings,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise UnusableError(f"{failure}: took longer than {limit:g} s") from None
    except OSError as error:
        raise UnusableError(f"{failure}: {error}") from None
    if done.returncode:
        why = _last_line(done.stderr, "error") or _last_line(done.stdout) or f"exit status {done.returncode}"
        raise UnusableError(f"{failure}: {why}")
    return done.stdout


def _last_line(text: str, preferred: str = "") -> str:
    """Return the last line that is not blank; lines that start with `preferred`, in capitals or not, come first."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    chosen = [line for line in lines if line.lower().startswith(preferred)] or lines
    return chosen[-1] if chosen else ""


def compare(
    programs: Sequence[Program], grids: Sequence[int], task: Task, environments: Path, limit: float
) -> Iterator[Row]:
    """Run every job on every grid with each program. One that fails is told about and left out from then on."""
    pythons: dict[Program, Path] = {}
    for program in programs:
        try:
            pythons[program] = interpreter(program, environments)
        except UnusableError as error:
            tell(f"{program.name} is left out: {error}")
    for job in dict.fromkeys(job for program in programs for job in program.jobs):
        for points in grids:
            for program, python in tuple(pythons.items()):
                if job not in program.jobs:
                    continue
                try:
                    found = answer(program, python, replace(task, job=job, points=points), limit)
                except UnusableError as error:
                    tell(f"{program.name} is left out: {error}")
                    del pythons[program]
                else:
                    yield Row(program.name, job, points, found)


HEADINGS = (*("program", "job", "grid", "seconds", "x", "applications"), *("delta_z (Qx)", "max p (max q)", "residual"))


def table(rows: Sequence[Row], references: Mapping[str, Reference]) -> Iterator[str]:
    """Yield the rows in Markdown, line by line."""
    own = {(row.job, row.points): row.answer.seconds for row in rows if row.program == FRETSOLVE.name}
    yield "| " + " | ".join(HEADINGS) + " |"
    yield "| " + " | ".join("---" for _ in HEADINGS) + " |"
    for row in rows:
        found, reference = row.answer, references[row.job]
        base = own.get((row.job, row.points))
        cells = (
            f"{row.program} {found.version}",
            row.job,
            str(row.points),
            f"{found.seconds:.3g}",
            f"{found.seconds / base:.2f}" if base else "-",
            _count(found.applications),
            _deviation(found.rigid, reference.rigid),
            _deviation(found.peak, reference.peak),
            f"{found.residual:.1e}",
        )
        yield "| " + " | ".join(cells) + " |"


def _count(value: int | None) -> str:
    return "-" if value is None else f"{value:.0f}"


def _deviation(value: float, reference: float) -> str:
    return f"{100.0 * (value / reference - 1.0):+.4f} %"


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; exit status 1 where no program could be run."""
    parser = argparse.ArgumentParser(description="Compare fretsolve with other open programs on the base case.")
    parser.add_argument("points", nargs="*", type=int, help="cells per side (256 and 512)")
    parser.add_argument("--environments", type=Path, default=default_environments(), help="folder (%(default)s)")
    parser.add_argument("--limit", type=float, default=300.0, help="seconds for a worker (%(default)g)")
    parser.add_argument("--repeats", type=int, default=5, help="solves whose median counts (%(default)d)")
    options = parser.parse_args(arguments)
    task, references = base_case(repeats=options.repeats)
    grids = options.points or GRIDS
    rows = list(compare(PROGRAMS, grids, task, options.environments.absolute(), options.limit))
    if not rows:
        tell("no program could be run")
        return 1
    for line in table(rows, references):
        print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
